/* SPDX-License-Identifier: BSD-3-Clause */
/* Dots to pixels: each point of the page belongs to the nearest particle, so the picture of a field has neither gaps
 * nor stripes whatever the size of a pixel. */
#include "client/cli/render_raster.h"
#include <math.h>
#include <stdlib.h>

/* Points whose centres lie within r of c, cut to the page; a dot smaller than a point still gets one. */
static Span span_of(double c, double r, size_t size)
{
    const double first = ceil(c - r - 0.5), last = floor(c + r - 0.5);
    const double lo = fmax(fmin(first, floor(c)), 0), hi = fmin(fmax(last, floor(c)), (double)size - 1);
    return hi < lo ? (Span){0, 0} : (Span){(size_t)lo, (size_t)hi + 1};
}

/* What a dot bids for a point at squared distance d2 on the page; the lowest bid wins. */
static double bid(const View *view, const Dot *dot, double d2)
{
    if (view->kind == VIEW_CUT) return d2 + dot->depth * dot->depth;
    return -(dot->depth + sqrt(fmax(view->radius * view->radius - d2, 0)));
}

static Span meet(Span a, Span b)
{
    const Span both = {a.begin > b.begin ? a.begin : b.begin, a.end < b.end ? a.end : b.end};
    return both.begin < both.end ? both : (Span){0, 0};
}

/* Points whose centres lie between two places, cut to the page. */
static Span between(double lo, double hi, size_t size)
{
    const double first = fmax(ceil(lo - 0.5), 0), last = fmin(floor(hi - 0.5), (double)size - 1);
    return last < first ? (Span){0, 0} : (Span){(size_t)first, (size_t)last + 1};
}

static void paint(const View *view, Raster *r, uint32_t k)
{
    const Dot *dot = &view->dots[k];
    const double u = (dot->u - view->lo[0]) * r->scale, v = (view->hi[1] - dot->v) * r->scale;
    const double metre = 1 / r->scale, radius = view->radius * r->scale;
    const double rim = fmax(radius * radius, 0.5); /* in points squared */
    const Span columns = meet(span_of(u, radius, r->width), r->clip[0]);
    const Span rows = meet(span_of(v, radius, r->height), r->clip[1]);
    for (size_t y = rows.begin; y < rows.end; y++) {
        const double dv = (double)y + 0.5 - v;
        for (size_t x = columns.begin; x < columns.end; x++) {
            const double du = (double)x + 0.5 - u, d2 = du * du + dv * dv;
            if (d2 > rim) continue;
            const float key = (float)bid(view, dot, d2 * metre * metre);
            const size_t at = y * r->width + x;
            if (key >= r->key[at]) continue;
            r->key[at] = key;
            r->owner[at] = k;
        }
    }
}

MnsStatus raster_make(const View *view, int width, int height, Raster *ret, MnsError *error)
{
    Raster r = {.width = (size_t)width * RASTER_FINE, .height = (size_t)height * RASTER_FINE};
    r.scale = (double)r.width / (view->hi[0] - view->lo[0]);
    r.clip[0] =
        between((view->clip_lo[0] - view->lo[0]) * r.scale, (view->clip_hi[0] - view->lo[0]) * r.scale, r.width);
    r.clip[1] =
        between((view->hi[1] - view->clip_hi[1]) * r.scale, (view->hi[1] - view->clip_lo[1]) * r.scale, r.height);
    const size_t n = r.width * r.height;
    r.owner = malloc(n * sizeof *r.owner);
    r.key = malloc(n * sizeof *r.key);
    if (!r.owner || !r.key) {
        raster_done(&r);
        return mns_fail(error, MNS_E_MEMORY, "there is no memory for a picture of %d x %d pixels", width, height);
    }
    for (size_t i = 0; i < n; i++) {
        r.owner[i] = RASTER_NOBODY;
        r.key[i] = INFINITY;
    }
    for (size_t k = 0; k < view->n; k++) paint(view, &r, (uint32_t)k);
    *ret = r;
    return MNS_OK;
}

MnsStatus raster_see(View *view, MnsError *error)
{
    static const double most = 1500; /* pixels each way are enough to tell */
    Raster r;
    const double du = view->hi[0] - view->lo[0], dv = view->hi[1] - view->lo[1], longest = fmax(du, dv);
    const double scale = fmin(most / longest, 8 / view->radius);
    const MnsStatus status =
        raster_make(view, (int)fmax(1, ceil(du * scale)), (int)fmax(1, ceil(dv * scale)), &r, error);
    if (status) return status;
    for (size_t k = 0; k < view->n; k++) view->dots[k].seen = false;
    for (size_t i = 0; i < r.width * r.height; i++)
        if (r.owner[i] != RASTER_NOBODY) view->dots[r.owner[i]].seen = true;
    raster_done(&r);
    return MNS_OK;
}

void raster_done(Raster *raster)
{
    free(raster->owner);
    free(raster->key);
    *raster = (Raster){0};
}

static uint32_t byte(double share)
{
    return (uint32_t)lround(255 * fmin(fmax(share, 0), 1));
}

static Colour lit(Colour c, float shade)
{
    return shade <= 1 ? (Colour){c.r * (double)shade, c.g * (double)shade, c.b * (double)shade}
                      : colour_mix(c, (Colour){1, 1, 1}, (double)shade - 1);
}

static uint32_t average(const Raster *r, const Colour *colours, const float *shade, size_t px, size_t py)
{
    Colour sum = {0, 0, 0};
    for (size_t y = py * RASTER_FINE; y < (py + 1) * RASTER_FINE; y++)
        for (size_t x = px * RASTER_FINE; x < (px + 1) * RASTER_FINE; x++) {
            const size_t at = y * r->width + x;
            Colour c = r->owner[at] == RASTER_NOBODY ? (Colour){1, 1, 1} : colours[r->owner[at]];
            if (shade && r->owner[at] != RASTER_NOBODY) c = lit(c, shade[at]);
            sum = (Colour){sum.r + c.r, sum.g + c.g, sum.b + c.b};
        }
    const double share = 1.0 / (RASTER_FINE * RASTER_FINE);
    return byte(sum.r * share) << 16 | byte(sum.g * share) << 8 | byte(sum.b * share);
}

void raster_resolve(const Raster *raster, const Colour *colours, const float *shade, size_t stride, uint32_t *pixels)
{
    for (size_t y = 0; y < raster->height / RASTER_FINE; y++)
        for (size_t x = 0; x < raster->width / RASTER_FINE; x++)
            pixels[y * stride + x] = average(raster, colours, shade, x, y);
}
