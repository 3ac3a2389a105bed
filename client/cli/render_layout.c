/* SPDX-License-Identifier: BSD-3-Clause */
/* Where everything goes on the page, so that nothing overlaps or is cut off whatever the size. */
#include "client/cli/render_page.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Room around the plot [pixels]. */
typedef struct Margins {
    double left, right, top, bottom;
} Margins;

double text_width(cairo_t *cr, double font, bool bold, const char *text)
{
    cairo_text_extents_t e;
    cairo_select_font_face(cr, "sans", CAIRO_FONT_SLANT_NORMAL,
                           bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(cr, font);
    cairo_text_extents(cr, text, &e);
    return e.x_advance;
}

void label_print(const char *name, int exponent, const char *unit, size_t size, char text[])
{
    char power[48] = "";
    if (exponent) {
        power_print(exponent, sizeof power, power);
        strncat(power, *unit ? " " : "", sizeof power - strlen(power) - 1);
    }
    if (exponent || *unit) snprintf(text, size, "%s (%s%s)", name, power, unit);
    else snprintf(text, size, "%s", name);
}

double entry_width(const Page *page, cairo_t *cr, double font, size_t k)
{
    return 1.3 * font + text_width(cr, font, false, page->entries[k].name) + 1.6 * font;
}

static int legend_rows(const Page *page, cairo_t *cr, double font, double width)
{
    int rows = page->n_entries > 0;
    double x = 0;
    for (size_t k = 0; k < page->n_entries; k++) {
        const double w = entry_width(page, cr, font, k);
        if (x > 0 && x + w > width) {
            rows++;
            x = 0;
        }
        x += w;
    }
    return rows;
}

static double widest(cairo_t *cr, double font, const Ticks *t)
{
    double w = 0;
    for (int k = 0; k < t->n; k++) w = fmax(w, text_width(cr, font, false, t->label[k]));
    return w;
}

static double base_font(const Page *page)
{
    const double usual = page->height ? page->height : page->width * 900.0 / 1600.0;
    return fmax(11, 20 * sqrt(page->width * usual / (1600.0 * 900.0)));
}

/* More labels than this would touch each other. */
static void choose_ticks(const Page *page, cairo_t *cr, Layout *l)
{
    const double lo = page->v_is_down ? -page->hi[1] : page->lo[1], hi = page->v_is_down ? -page->lo[1] : page->hi[1];
    l->ticks[1] = ticks_make(lo, hi, (int)fmin(l->plot.h / (2.6 * l->font), 9));
    double room = 4 * l->font;
    for (int attempt = 0; attempt < 3; attempt++) {
        l->ticks[0] = ticks_make(page->lo[0], page->hi[0], (int)fmin(l->plot.w / room, 13));
        room = fmax(room, widest(cr, l->font, &l->ticks[0]) + 1.2 * l->font);
    }
    if (page->scale)
        l->bar_ticks = ticks_make(page->scale->lo * page->scale->factor, page->scale->hi * page->scale->factor,
                                  (int)fmin(l->bar.h / (2.4 * l->font), 9));
}

static Margins margins(const Page *page, cairo_t *cr, const Layout *l)
{
    const double f = l->font,
                 last = text_width(cr, f, false, l->ticks[0].label[l->ticks[0].n > 0 ? l->ticks[0].n - 1 : 0]);
    const int rows = legend_rows(page, cr, f, page->width - 1.6 * f);
    Margins m = {.bottom = 4.0 * f, .top = 2.9 * f + rows * 1.7 * f, .right = fmax(1.2 * f, 0.7 * f + last / 2)};
    m.left = 0.7 * f + 1.5 * f + widest(cr, f, &l->ticks[1]) + 0.9 * f;
    if (page->scale) m.right = 1.2 * f + 1.1 * f + 0.9 * f + widest(cr, f, &l->bar_ticks) + 1.8 * f + 0.7 * f;
    return m;
}

/* The largest plot of true shape that the margins leave, in the middle of the page, on whole pixels. */
static void place_plot(const Page *page, Margins m, Layout *l)
{
    const double du = page->hi[0] - page->lo[0], dv = page->hi[1] - page->lo[1];
    const double room_w = fmax(page->width - m.left - m.right, 1), room_h = fmax(page->height - m.top - m.bottom, 1);
    const double scale = fmin(room_w / du, room_h / dv);
    l->plot.w = fmax(floor(du * scale), 1);
    l->plot.h = fmax(floor(dv * scale + 1e-6), 1);
    l->plot.x = floor(m.left + (room_w - l->plot.w) / 2);
    l->plot.y = floor(m.top + (room_h - l->plot.h) / 2);
    const double f = l->font, h = page->scale ? fmax(l->plot.h, fmin(12 * f, room_h)) : l->plot.h;
    const double y = fmin(fmax(l->plot.y + (l->plot.h - h) / 2, m.top), m.top + room_h - h);
    const double point = page->scale ? fmin(1.3 * f, h / 6) : 0;
    l->bar =
        (Rect){l->plot.x + l->plot.w + 1.2 * f, floor(y + (page->scale && page->scale->above ? point : 0)), 1.1 * f, 0};
    l->bar.h = floor(y + h - (page->scale && page->scale->below ? point : 0)) - l->bar.y;
}

/* The head is as wide as the plot and its bar, or as the page where title and moment need more. */
static void place_head(const Page *page, cairo_t *cr, Margins m, Layout *l)
{
    const double f = l->font, right = page->scale ? m.right - 0.7 * f : 0;
    const double wanted = text_width(cr, 1.15 * f, true, page->title) + text_width(cr, f, false, page->moment) + 2 * f;
    const double top = fmin(l->plot.y, page->scale ? l->bar.y - (page->scale->above ? 1.3 * f : 0) : l->plot.y);
    l->head = (Rect){l->plot.x, top - m.top + 0.6 * f, l->plot.w + right, m.top - 1.0 * f};
    double legend = 0;
    for (size_t k = 0; k < page->n_entries; k++) legend += entry_width(page, cr, f, k);
    if (fmax(wanted, legend) > l->head.w) {
        l->head.x = 0.8 * f;
        l->head.w = page->width - 1.6 * f;
    }
    l->title_y = l->head.y + 1.2 * f;
    l->legend_y = l->title_y + 1.85 * f;
    l->row = 1.7 * f;
}

static void place_labels(const Page *page, cairo_t *cr, Layout *l)
{
    const double f = l->font;
    l->label_x[0] = l->plot.y + l->plot.h + 3.0 * f;
    l->label_x[1] = l->plot.x - 0.9 * f - widest(cr, f, &l->ticks[1]) - 0.7 * f;
    if (page->scale) l->label_x[2] = l->bar.x + l->bar.w + 0.9 * f + widest(cr, f, &l->bar_ticks) + 1.1 * f;
}

/* Labels decide on the margins, these on the plot, and that on the labels: the third time nothing moves. */
static Margins settle(const Page *page, cairo_t *cr, Layout *l)
{
    l->plot = (Rect){0, 0, page->width * 0.7, page->height * 0.6};
    l->bar.h = page->height * 0.6;
    for (int round = 0; round < 3; round++) {
        choose_ticks(page, cr, l);
        place_plot(page, margins(page, cr, l), l);
    }
    return margins(page, cr, l);
}

void page_fit_height(Page *page, cairo_t *cr)
{
    Page tall = *page;
    Layout l = {.font = base_font(page)};
    tall.height = 2 * page->width;
    const Margins m = settle(&tall, cr, &l);
    const double plot = page->scale ? fmax(l.plot.h, 10 * l.font) : l.plot.h;
    page->font = l.font;
    page->height = (int)fmin(fmax(ceil(m.top + plot + m.bottom), 160), tall.height);
}

MnsStatus page_layout(const Page *page, cairo_t *cr, Layout *ret, MnsError *error)
{
    Layout l = {.font = page->font > 0 ? page->font : base_font(page)};
    const Margins m = settle(page, cr, &l);
    if (page->width - m.left - m.right < 4 * l.font || page->height - m.top - m.bottom < 2 * l.font)
        return mns_fail_at(error, MNS_E_LIMIT, "--size",
                           "a picture of %d x %d pixels leaves no room for the particles; "
                           "make it larger",
                           page->width, page->height);
    place_head(page, cr, m, &l);
    place_labels(page, cr, &l);
    *ret = l;
    return MNS_OK;
}
