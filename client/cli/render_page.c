/* SPDX-License-Identifier: BSD-3-Clause */
/* Axes, title, legend and colour bar. */
#include "client/cli/render_page.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

typedef enum Anchor { LEFT, CENTRE, RIGHT } Anchor;

static void ink(cairo_t *cr)
{
    cairo_set_source_rgb(cr, 0.13, 0.13, 0.13);
}

/* Text with its base line at y. */
static void put(cairo_t *cr, double font, bool bold, Anchor anchor, double x, double y, const char *text)
{
    const double w = text_width(cr, font, bold, text);
    ink(cr);
    cairo_move_to(cr, x - (anchor == CENTRE ? w / 2 : anchor == RIGHT ? w : 0), y);
    cairo_show_text(cr, text);
}

/* Text that reads upwards, its middle at (x, y). */
static void put_upwards(cairo_t *cr, double font, double x, double y, const char *text)
{
    cairo_save(cr);
    cairo_translate(cr, x, y);
    cairo_rotate(cr, -acos(-1) / 2);
    put(cr, font, false, CENTRE, 0, 0.36 * font, text);
    cairo_restore(cr);
}

static double line_width(const Layout *l)
{
    return fmax(1, round(0.075 * l->font));
}

static void stroke(cairo_t *cr, double width, double x0, double y0, double x1, double y1)
{
    cairo_set_line_width(cr, width);
    cairo_move_to(cr, x0, y0);
    cairo_line_to(cr, x1, y1);
    cairo_stroke(cr);
}

/* Lines lie on whole pixels, or they blur. */
static double crisp(double at, double width)
{
    return floor(at) + (fmod(width, 2) != 0 ? 0.5 : 0);
}

static void draw_frame(const Layout *l, cairo_t *cr)
{
    const double w = line_width(l);
    ink(cr);
    cairo_set_line_width(cr, w);
    cairo_rectangle(cr, l->plot.x - w / 2, l->plot.y - w / 2, l->plot.w + w, l->plot.h + w);
    cairo_stroke(cr);
}

static void draw_axis_right(const Page *page, const Layout *l, cairo_t *cr)
{
    const double w = line_width(l), bottom = l->plot.y + l->plot.h, f = l->font;
    char label[64];
    for (int k = 0; k < l->ticks[0].n; k++) {
        const double share = (l->ticks[0].value[k] - page->lo[0]) / (page->hi[0] - page->lo[0]);
        const double x = l->plot.x + share * l->plot.w;
        ink(cr);
        stroke(cr, w, crisp(x, w), bottom, crisp(x, w), bottom + 0.4 * f);
        put(cr, f, false, CENTRE, x, bottom + 1.5 * f, l->ticks[0].label[k]);
    }
    label_print((const char[]){page->axis[0], '\0'}, l->ticks[0].exponent, "m", sizeof label, label);
    put(cr, f, false, CENTRE, l->plot.x + l->plot.w / 2, l->label_x[0], label);
}

static void draw_axis_up(const Page *page, const Layout *l, cairo_t *cr)
{
    const double w = line_width(l), f = l->font;
    char label[64];
    for (int k = 0; k < l->ticks[1].n; k++) {
        const double v = page->v_is_down ? -l->ticks[1].value[k] : l->ticks[1].value[k];
        const double share = (v - page->lo[1]) / (page->hi[1] - page->lo[1]);
        const double y = l->plot.y + (1 - share) * l->plot.h;
        ink(cr);
        stroke(cr, w, l->plot.x - 0.4 * f, crisp(y, w), l->plot.x, crisp(y, w));
        put(cr, f, false, RIGHT, l->plot.x - 0.7 * f, y + 0.36 * f, l->ticks[1].label[k]);
    }
    label_print((const char[]){page->axis[1], '\0'}, l->ticks[1].exponent, "m", sizeof label, label);
    put_upwards(cr, f, l->label_x[1], l->plot.y + l->plot.h / 2, label);
}

/* A title that is too long ends with an ellipsis; no letter is cut in two. */
static void draw_head(const Page *page, const Layout *l, cairo_t *cr)
{
    char title[sizeof page->title + 4];
    const double f = l->font, room = l->head.w - text_width(cr, f, false, page->moment) - 1.5 * f;
    size_t length = strlen(page->title);
    snprintf(title, sizeof title, "%s", page->title);
    while (length && text_width(cr, 1.15 * f, true, title) > room) {
        do length--;
        while (length && ((unsigned char)page->title[length] & 0xC0) == 0x80);
        snprintf(title, sizeof title, "%.*s…", (int)length, page->title);
    }
    put(cr, 1.15 * f, true, LEFT, l->head.x, l->title_y, title);
    put(cr, f, false, RIGHT, l->head.x + l->head.w, l->title_y, page->moment);
}

static void swatch(cairo_t *cr, Colour c, Rect r)
{
    cairo_rectangle(cr, r.x, r.y, r.w, r.h);
    cairo_set_source_rgb(cr, c.r, c.g, c.b);
    cairo_fill_preserve(cr);
    cairo_set_source_rgb(cr, 0.45, 0.45, 0.45);
    cairo_set_line_width(cr, 1);
    cairo_stroke(cr);
}

static void draw_legend(const Page *page, const Layout *l, cairo_t *cr)
{
    const double f = l->font;
    double x = 0, y = l->legend_y;
    for (size_t k = 0; k < page->n_entries; k++) {
        const double w = entry_width(page, cr, f, k);
        if (x > 0 && x + w > l->head.w + 1.6 * f) {
            x = 0;
            y += l->row;
        }
        swatch(cr, page->entries[k].colour,
               (Rect){floor(l->head.x + x) + 0.5, floor(y - 0.82 * f) + 0.5, floor(0.9 * f), floor(0.9 * f)});
        put(cr, f, false, LEFT, l->head.x + x + 1.3 * f, y, page->entries[k].name);
        x += w;
    }
}

/* The outline of the bar, with a point at each end beyond which there are values. */
static void bar_path(const Page *page, const Layout *l, cairo_t *cr)
{
    const Rect b = l->bar;
    const double point = 1.1 * b.w;
    cairo_move_to(cr, b.x, b.y + b.h);
    cairo_line_to(cr, b.x, b.y);
    if (page->scale->above) cairo_line_to(cr, b.x + b.w / 2, b.y - point);
    cairo_line_to(cr, b.x + b.w, b.y);
    cairo_line_to(cr, b.x + b.w, b.y + b.h);
    if (page->scale->below) cairo_line_to(cr, b.x + b.w / 2, b.y + b.h + point);
    cairo_close_path(cr);
}

static void fill_bar(const Page *page, const Layout *l, cairo_t *cr)
{
    enum { STEPS = 128 };
    cairo_pattern_t *ramp = cairo_pattern_create_linear(0, l->bar.y + l->bar.h, 0, l->bar.y);
    for (int k = 0; k <= STEPS; k++) {
        const Colour c = colour_at(page->map, (double)k / STEPS);
        cairo_pattern_add_color_stop_rgb(ramp, (double)k / STEPS, c.r, c.g, c.b);
    }
    bar_path(page, l, cr);
    cairo_set_source(cr, ramp);
    cairo_fill_preserve(cr);
    cairo_pattern_destroy(ramp);
    ink(cr);
    cairo_set_line_width(cr, line_width(l));
    cairo_stroke(cr);
}

/* Whoever sees the points at the ends of the bar should know how much lies beyond them, where there is room to say it. */
static void label_bar(const Scale *s, const Layout *l, cairo_t *cr)
{
    char label[160], longer[200];
    label_print(s->name, l->bar_ticks.exponent, s->unit, sizeof label, label);
    snprintf(longer, sizeof longer, "%s, %.2g %% beyond", label, 100 * s->beyond);
    const bool says = s->beyond > 0 && text_width(cr, l->font, false, longer) <= l->bar.h;
    put_upwards(cr, l->font, l->label_x[2], l->bar.y + l->bar.h / 2, says ? longer : label);
}

static void draw_bar(const Page *page, const Layout *l, cairo_t *cr)
{
    const Scale *s = page->scale;
    const double f = l->font, w = line_width(l), right = l->bar.x + l->bar.w;
    fill_bar(page, l, cr);
    for (int k = 0; k < l->bar_ticks.n; k++) {
        const double share = (l->bar_ticks.value[k] / s->factor - s->lo) / (s->hi - s->lo);
        const double y = l->bar.y + (1 - share) * l->bar.h;
        ink(cr);
        stroke(cr, w, right, crisp(y, w), right + 0.35 * f, crisp(y, w));
        put(cr, f, false, LEFT, right + 0.65 * f, y + 0.36 * f, l->bar_ticks.label[k]);
    }
    label_bar(s, l, cr);
}

void page_draw(const Page *page, const Layout *layout, cairo_t *cr)
{
    draw_frame(layout, cr);
    draw_axis_right(page, layout, cr);
    draw_axis_up(page, layout, cr);
    draw_head(page, layout, cr);
    if (page->scale) draw_bar(page, layout, cr);
    else draw_legend(page, layout, cr);
}
