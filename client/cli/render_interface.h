/* SPDX-License-Identifier: BSD-3-Clause */
/* The interface between fluids as a line over a picture of a field. */
#ifndef CLI_RENDER_INTERFACE_H
#define CLI_RENDER_INTERFACE_H

#include "client/cli/render_raster.h"
#include <cairo.h>

/* Draw it `width` pixels wide into the plot whose upper left corner is at (x, y). The boundary between the tiles of two
 * fluids is smoothed over half a particle spacing, so that one sees the interface and not the tiles. */
MnsStatus interface_draw(const Raster *raster, const View *view, const Frame *frame, double x, double y, double width,
                         cairo_t *cr, MnsError *error);

#endif
