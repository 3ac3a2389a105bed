/* SPDX-License-Identifier: BSD-3-Clause */
/* A frame as a PNG file. */
#ifndef CLI_RENDER_PICTURE_H
#define CLI_RENDER_PICTURE_H

#include "client/cli/render_options.h"
#include "client/cli/render_scale.h"

/* What was drawn. */
typedef struct Drawn {
    size_t particles, skipped; /* skipped: without finite position or value */
    int width, height;         /* pixels */
    double range[2];           /* of the colour bar, in the field's unit; NAN for phases */
    double plot[4];            /* the axes' rectangle in pixels: x, y, width, height */
} Drawn;

/* Draw the frame and write options->out: a temporary file, then renamed. What was there stays whole after a failure. */
MnsStatus picture_write(const Frame *frame, const RenderOptions *options, Drawn *ret, MnsError *error);

#endif
