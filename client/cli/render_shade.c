/* SPDX-License-Identifier: BSD-3-Clause */
/* The light on a projection: balls are smoothed into a surface, so that one sees waves rather than particles. */
#include "client/cli/render_raster.h"
#include <math.h>
#include <stdlib.h>

enum { SWEEPS = 3 }; /* of a box average: near enough to a Gaussian */

typedef struct Line {
    float *height; /* first point */
    const uint32_t *owner;
    size_t n, stride;
} Line;

/* Average heights over 2 reach + 1 points of a line, leaving out the points that belong to nobody. */
static void smooth(Line line, size_t reach, double *sum, double *count)
{
    sum[0] = count[0] = 0;
    for (size_t k = 0; k < line.n; k++) {
        const bool here = line.owner[k * line.stride] != RASTER_NOBODY;
        sum[k + 1] = sum[k] + (here ? (double)line.height[k * line.stride] : 0);
        count[k + 1] = count[k] + here;
    }
    for (size_t k = 0; k < line.n; k++) {
        const size_t begin = k > reach ? k - reach : 0, end = k + reach + 1 < line.n ? k + reach + 1 : line.n;
        const double m = count[end] - count[begin];
        if (m > 0) line.height[k * line.stride] = (float)((sum[end] - sum[begin]) / m);
    }
}

MnsStatus raster_smooth(const Raster *r, size_t reach, float *height, MnsError *error)
{
    const size_t longest = (r->width > r->height ? r->width : r->height) + 1;
    double *sum = malloc(2 * longest * sizeof *sum);
    if (!sum) return mns_fail(error, MNS_E_MEMORY, "there is no memory to shade the picture");
    for (int sweep = 0; sweep < SWEEPS; sweep++) {
        for (size_t y = 0; y < r->height; y++)
            smooth((Line){height + y * r->width, r->owner + y * r->width, r->width, 1}, reach, sum, sum + longest);
        for (size_t x = 0; x < r->width; x++)
            smooth((Line){height + x, r->owner + x, r->height, r->width}, reach, sum, sum + longest);
    }
    free(sum);
    return MNS_OK;
}

/* Slope of the surface between two points, if both belong to somebody. */
static double slope(const Raster *r, const float *height, size_t a, size_t b, double distance)
{
    if (r->owner[a] == RASTER_NOBODY || r->owner[b] == RASTER_NOBODY) return 0;
    return ((double)height[b] - (double)height[a]) / distance;
}

/* 1 keeps a colour, less darkens, more pales. */
static float light(const Raster *r, const View *view, const float *height, size_t x, size_t y)
{
    const size_t at = y * r->width + x;
    const size_t left = x ? at - 1 : at, right = x + 1 < r->width ? at + 1 : at;
    const size_t up = y ? at - r->width : at, down = y + 1 < r->height ? at + r->width : at;
    const double sx = slope(r, height, left, right, 2 / r->scale), sy = slope(r, height, down, up, 2 / r->scale);
    const double facing = (1 + 0.6 * sx - 0.6 * sy) / sqrt((1 + sx * sx + sy * sy) * (1 + 2 * 0.36));
    const double span = view->near - view->far, depth = span > 0 ? (view->near - (double)height[at]) / span : 0;
    const double lambert = 0.5 + 0.6 * fmax(facing, 0);
    return (float)(fmin(lambert, 1) + 0.45 * fmin(fmax(depth, 0), 1) * fmin(lambert, 1));
}

MnsStatus raster_shade(const Raster *raster, const View *view, float **ret_shade, MnsError *error)
{
    const size_t n = raster->width * raster->height;
    float *height = malloc(n * sizeof *height), *shade = malloc(n * sizeof *shade);
    MnsStatus status =
        height && shade ? MNS_OK : mns_fail(error, MNS_E_MEMORY, "there is no memory to shade the picture");
    if (!status) {
        for (size_t i = 0; i < n; i++) height[i] = -raster->key[i];
        status = raster_smooth(raster, 1 + (size_t)(view->radius * raster->scale), height, error);
    }
    if (!status) {
        for (size_t y = 0; y < raster->height; y++)
            for (size_t x = 0; x < raster->width; x++) shade[y * raster->width + x] = light(raster, view, height, x, y);
        *ret_shade = shade;
    } else {
        free(shade);
    }
    free(height);
    return status;
}
