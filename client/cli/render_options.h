/* SPDX-License-Identifier: BSD-3-Clause */
/* The command line of `meniscus render`. */
#ifndef CLI_RENDER_OPTIONS_H
#define CLI_RENDER_OPTIONS_H

#include "client/cli/render_colour.h"
#include "client/cli/render_view.h"

typedef struct RenderOptions {
    const char *snapshot, *daemon;   /* not both; neither: the default daemon */
    const char *field, *out, *title; /* title NULL: that of the case */
    const ColourMap *map;
    bool has_range, json, help;
    double range[2];
    int width, height; /* pixels */
    ViewOptions view;
} RenderOptions;

/* MNS_E_INVALID with error->path naming the option; MNS_E_LIMIT for a picture too large or too small. */
MnsStatus render_options_parse(int argc, char **argv, RenderOptions *ret, MnsError *error);

/* What --help prints. */
const char *render_usage(void);

#endif
