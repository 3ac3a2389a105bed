/* SPDX-License-Identifier: BSD-3-Clause */
/* Dots to pixels: each point of the page belongs to the nearest particle, so the picture of a field has neither gaps
 * nor stripes whatever the size of a pixel. */
#ifndef CLI_RENDER_RASTER_H
#define CLI_RENDER_RASTER_H

#include "client/cli/render_colour.h"
#include "client/cli/render_view.h"

enum { RASTER_FINE = 3 }; /* points per pixel and direction */

#define RASTER_NOBODY UINT32_MAX

typedef struct Span {
    size_t begin, end;
} Span;

typedef struct Raster {
    size_t width, height; /* in points, rows from the top */
    double scale;         /* points per metre */
    Span clip[2];         /* columns and rows in which dots are drawn */
    uint32_t *owner;      /* [height][width]: index of a dot, or RASTER_NOBODY */
    float *key;           /* square of its distance, or in a projection minus its height towards the eye [m^2], [m] */
} Raster;

/* width, height: in pixels; the bounds of the view fill them. */
MnsStatus raster_make(const View *view, int width, int height, Raster *ret, MnsError *error);

/* Mark the dots of a view that own no point, as others hide them, as not seen. */
MnsStatus raster_see(View *view, MnsError *error);

void raster_done(Raster *raster);

/* How bright each point of a projection is, [height][width]: light from the upper left, distance pales. */
MnsStatus raster_shade(const Raster *raster, const View *view, float **ret_shade, MnsError *error);

/* Average values [height][width] over 2 reach + 1 points each way, three times: near enough to a Gaussian. Nobody's points
 * are left out. */
MnsStatus raster_smooth(const Raster *raster, size_t reach, float *values, MnsError *error);

/* Average the points of each pixel. colours: of each dot; shade: of each point, or NULL; pixels: 0x00RRGGBB, `stride`
 * of them a row; nobody's points are white. */
void raster_resolve(const Raster *raster, const Colour *colours, const float *shade, size_t stride, uint32_t *pixels);

#endif
