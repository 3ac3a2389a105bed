/* SPDX-License-Identifier: BSD-3-Clause */
/* The interface between fluids as a line over a picture of a field: where the share of one fluid, averaged over half a
 * spacing, is one half. */
#include "client/cli/render_interface.h"
#include <math.h>
#include <stdlib.h>

/* The share of one fluid in each pixel. Pixels that are not wholly fluid belong to nobody: no line is drawn there. */
typedef struct Share {
    Raster grid;
    float *of; /* [height][width] */
} Share;

static int phase_at(const Raster *r, const View *view, const Frame *frame, size_t at)
{
    if (r->owner[at] == RASTER_NOBODY) return -1;
    const size_t i = view->dots[r->owner[at]].particle;
    return i < frame->n_fluid ? frame->phase[i] : -1;
}

static void count_pixel(const Raster *r, const View *view, const Frame *frame, int fluid, size_t px, size_t py,
                        Share *s)
{
    const size_t at = py * s->grid.width + px;
    int here = 0, nobody = 0;
    for (size_t y = py * RASTER_FINE; y < (py + 1) * RASTER_FINE; y++)
        for (size_t x = px * RASTER_FINE; x < (px + 1) * RASTER_FINE; x++) {
            const int phase = phase_at(r, view, frame, y * r->width + x);
            here += phase == fluid;
            nobody += phase < 0;
        }
    s->grid.owner[at] = nobody ? RASTER_NOBODY : 0;
    s->of[at] = (float)here / (RASTER_FINE * RASTER_FINE);
}

static void share_done(Share *s)
{
    free(s->grid.owner);
    free(s->of);
}

static MnsStatus share_make(const Raster *r, const View *view, const Frame *frame, int fluid, Share *ret,
                            MnsError *error)
{
    Share s = {.grid = {.width = r->width / RASTER_FINE, .height = r->height / RASTER_FINE}};
    const size_t n = s.grid.width * s.grid.height;
    s.grid.owner = malloc(n * sizeof *s.grid.owner);
    s.of = malloc(n * sizeof *s.of);
    MnsStatus status = s.grid.owner && s.of
                           ? MNS_OK
                           : mns_fail(error, MNS_E_MEMORY, "there is no memory for the interface in the picture");
    if (!status) {
        for (size_t y = 0; y < s.grid.height; y++)
            for (size_t x = 0; x < s.grid.width; x++) count_pixel(r, view, frame, fluid, x, y, &s);
        const double spacing = frame->spacing * r->scale / RASTER_FINE; /* [pixels] */
        status = raster_smooth(&s.grid, (size_t)lround(0.25 * spacing), s.of, error);
    }
    if (status) share_done(&s);
    else *ret = s;
    return status;
}

/* Marching squares: the ends of the line where it crosses the sides of a cell between four pixels; 0, 2 or 4. */
static int crossings(const float corner[4], double end[4][2])
{
    static const double at[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    int n = 0;
    for (int k = 0; k < 4; k++) {
        const int next = (k + 1) % 4;
        const double a = (double)corner[k] - 0.5, b = (double)corner[next] - 0.5;
        if ((a < 0) == (b < 0)) continue;
        const double share = a / (a - b);
        end[n][0] = at[k][0] + share * (at[next][0] - at[k][0]);
        end[n++][1] = at[k][1] + share * (at[next][1] - at[k][1]);
    }
    return n;
}

static void trace_cell(const Share *s, size_t column, size_t row, double x, double y, cairo_t *cr)
{
    const size_t at = row * s->grid.width + column, below = at + s->grid.width;
    const size_t corners[4] = {at, at + 1, below + 1, below};
    float corner[4];
    double end[4][2];
    for (int k = 0; k < 4; k++) {
        if (s->grid.owner[corners[k]] == RASTER_NOBODY) return;
        corner[k] = s->of[corners[k]];
    }
    const int n = crossings(corner, end);
    for (int k = 0; k + 1 < n; k += 2) {
        cairo_move_to(cr, x + (double)column + 0.5 + end[k][0], y + (double)row + 0.5 + end[k][1]);
        cairo_line_to(cr, x + (double)column + 0.5 + end[k + 1][0], y + (double)row + 0.5 + end[k + 1][1]);
    }
}

/* Row by row: cairo takes far longer for one path of a hundred thousand lines than for many of a few. */
static void stroke(const Share *s, double x, double y, cairo_t *cr)
{
    for (size_t row = 0; row + 1 < s->grid.height; row++) {
        for (size_t column = 0; column + 1 < s->grid.width; column++) trace_cell(s, column, row, x, y, cr);
        cairo_stroke(cr);
    }
}

MnsStatus interface_draw(const Raster *raster, const View *view, const Frame *frame, double x, double y, double width,
                         cairo_t *cr, MnsError *error)
{
    MnsStatus status = MNS_OK;
    cairo_save(cr);
    cairo_set_line_cap(cr, CAIRO_LINE_CAP_ROUND);
    for (int fluid = 0; !status && fluid + 1 < (int)frame->n_fluids; fluid++) {
        Share s;
        status = share_make(raster, view, frame, fluid, &s, error);
        if (status) break;
        /* White with dark edges is seen on every colour of every map. */
        cairo_set_source_rgb(cr, 0.13, 0.13, 0.13);
        cairo_set_line_width(cr, 2 * width);
        stroke(&s, x, y, cr);
        cairo_set_source_rgb(cr, 1, 1, 1);
        cairo_set_line_width(cr, width);
        stroke(&s, x, y, cr);
        share_done(&s);
    }
    cairo_restore(cr);
    return status;
}
