/* SPDX-License-Identifier: BSD-3-Clause */
/* Where everything goes on the page, so that nothing overlaps or is cut off whatever the size. */
#ifndef CLI_RENDER_PAGE_H
#define CLI_RENDER_PAGE_H

#include "client/cli/render_colour.h"
#include "client/cli/render_scale.h"
#include "client/cli/render_ticks.h"
#include <cairo.h>

enum { PAGE_MOST_ENTRIES = FRAME_MAX_FLUIDS + 1 };

typedef struct Rect {
    double x, y, w, h; /* pixels; y downwards */
} Rect;

/* What is on the page. */
typedef struct Page {
    int width, height; /* pixels; height 0 until page_fit_height() */
    double font;       /* size of the letters; 0: by the size of the page */
    char title[256], moment[96];
    char axis[2]; /* names of the axes to the right and up: 'x', 'y', 'z' */
    double lo[2], hi[2];
    bool v_is_down;     /* the second axis shows minus these bounds */
    const Scale *scale; /* NULL: a legend instead of a bar */
    const ColourMap *map;
    size_t n_entries;
    struct {
        char name[FRAME_NAME];
        Colour colour;
    } entries[PAGE_MOST_ENTRIES];
} Page;

/* Where it goes. */
typedef struct Layout {
    double font;              /* size of the letters */
    Rect plot;                /* whole pixels */
    Rect bar;                 /* without its points */
    Rect head;                /* title, moment, and below them the legend */
    double title_y, legend_y; /* base lines of the first rows */
    double row;               /* height of a row of the legend */
    Ticks ticks[2], bar_ticks;
    double label_x[3]; /* centre lines of the labels of: the axis to the right (y), the axis up (x), the bar (x) */
} Layout;

/* Choose the height that the plot needs at full width, so that no white is left above and below. */
void page_fit_height(Page *page, cairo_t *cr);

/* MNS_E_LIMIT if the page is too small for what it holds. */
MnsStatus page_layout(const Page *page, cairo_t *cr, Layout *ret, MnsError *error);

/* Draw everything but the particles. */
void page_draw(const Page *page, const Layout *layout, cairo_t *cr);

/* Width of a text in the font of size `font`, bold or not; selects it. */
double text_width(cairo_t *cr, double font, bool bold, const char *text);

/* "x (m)", or with a power of ten in front of the unit. */
void label_print(const char *name, int exponent, const char *unit, size_t size, char text[]);

/* Width of the legend's entry k, with the gap to the next. */
double entry_width(const Page *page, cairo_t *cr, double font, size_t k);

#endif
