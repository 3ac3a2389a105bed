/* SPDX-License-Identifier: BSD-3-Clause */
/* The command line of `meniscus render`. */
#ifndef CLI_RENDER_OPTIONS_H
#define CLI_RENDER_OPTIONS_H

#include "client/cli/options.h"
#include "client/cli/render_colour.h"
#include "client/cli/render_view.h"

typedef struct RenderOptions {
    const char *snapshot;            /* NULL: a daemon */
    const char *field, *out, *title; /* title NULL: that of the case */
    const ColourMap *map;
    bool has_range;
    double range[2];
    int width, height; /* pixels; height 0: as the plot needs it */
    ViewOptions view;
} RenderOptions;

/* MNS_E_INVALID with error->path naming the option; MNS_E_LIMIT for a picture too large or too small. Text is borrowed. */
MnsStatus render_options_read(const Options *options, RenderOptions *ret, MnsError *error);

#endif
