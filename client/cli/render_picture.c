/* SPDX-License-Identifier: BSD-3-Clause */
/* A frame as a PNG file. */
#include "client/cli/render_picture.h"
#include "client/cli/render_interface.h"
#include "client/cli/render_page.h"
#include "client/cli/render_raster.h"
#include "client/cli/whole_file.h"
#include "common/host/text.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const Colour wall_colour = {0.60, 0.60, 0.60};

static bool draws_phases(const Frame *frame)
{
    return frame->value == NULL;
}

static void print_moment(const Frame *frame, const View *view, size_t size, char *text)
{
    char place[48] = "";
    if (view->axis >= 0 && view->kind == VIEW_CUT)
        snprintf(place, sizeof place, "%c = %.4g m,  ", "xyz"[view->axis], view -> at);
    const bool tiny = frame->time > 0 && frame->time < 0.1;
    snprintf(text, size, tiny ? "%st = %.4g s" : "%st = %.3f s", place, frame->time);
}

static void fluid_colours(const Frame *frame, Colour colours[FRAME_MAX_FLUIDS])
{
    const char *names[FRAME_MAX_FLUIDS];
    for (size_t k = 0; k < frame->n_fluids; k++) names[k] = frame->fluids[k];
    colour_fluids(frame->n_fluids, names, colours);
}

static void add_entry(Page *page, const char *name, Colour colour)
{
    snprintf(page->entries[page->n_entries].name, sizeof page->entries->name, "%s", name);
    page->entries[page->n_entries++].colour = colour;
}

static void list_fluids(const Frame *frame, const View *view, bool walls, Page *page)
{
    Colour colours[FRAME_MAX_FLUIDS];
    fluid_colours(frame, colours);
    for (size_t k = 0; k < frame->n_fluids; k++)
        if (view->fluids >> k & 1U) add_entry(page, frame->fluids[k], colours[k]);
    if (walls) add_entry(page, "walls", wall_colour);
}

static Page describe(const Frame *frame, const RenderOptions *o, const View *view, const Scale *scale)
{
    Page page = {.width = o->width, .height = o->height, .map = o->map, .scale = draws_phases(frame) ? NULL : scale};
    snprintf(page.title, sizeof page.title, "%s", text_shown(o->title ? o->title : frame->title));
    print_moment(frame, view, sizeof page.moment, page.moment);
    page.axis[0] = "xyz"[view->axis_u];
    page.axis[1] = "xyz"[view->axis_v];
    page.v_is_down = view->v_is_down;
    memcpy(page.lo, view->lo, sizeof page.lo);
    memcpy(page.hi, view->hi, sizeof page.hi);
    if (!page.scale) list_fluids(frame, view, o->view.walls, &page);
    return page;
}

static Colour *dot_colours(const Frame *frame, const View *view, const Scale *scale, const ColourMap *map)
{
    Colour fluids[FRAME_MAX_FLUIDS] = {{0}}, *colours = malloc(view->n * sizeof *colours);
    fluid_colours(frame, fluids);
    for (size_t k = 0; colours && k < view->n; k++) {
        const size_t i = view->dots[k].particle;
        if (view->dots[k].hidden) colours[k] = (Colour){1, 1, 1};
        else if (i >= frame->n_fluid) colours[k] = wall_colour;
        else if (draws_phases(frame)) colours[k] = fluids[(size_t)frame->phase[i] % FRAME_MAX_FLUIDS];
        else colours[k] = colour_at(map, (frame->value[i] - scale->lo) / (scale->hi - scale->lo));
    }
    return colours;
}

/* Put the particles into the plot's rectangle of the picture, and the interface over the colours of a field. */
static MnsStatus draw_dots(const Frame *frame, const View *view, const Colour *colours, const Layout *layout,
                           cairo_t *cr, MnsError *error)
{
    const Rect plot = layout->plot;
    cairo_surface_t *surface = cairo_get_target(cr);
    Raster raster;
    float *shade = NULL;
    MnsStatus status = raster_make(view, (int)plot.w, (int)plot.h, &raster, error);
    if (status) return status;
    if (view->kind == VIEW_PROJECTION) status = raster_shade(&raster, view, &shade, error);
    if (!status) {
        cairo_surface_flush(surface);
        const size_t stride = (size_t)cairo_image_surface_get_stride(surface) / sizeof(uint32_t);
        uint32_t *pixels = (void *)cairo_image_surface_get_data(surface);
        raster_resolve(&raster, colours, shade, stride, pixels + (size_t)plot.y * stride + (size_t)plot.x);
        cairo_surface_mark_dirty(surface);
    }
    if (!status && view->kind == VIEW_CUT && !draws_phases(frame)) {
        cairo_save(cr);
        cairo_rectangle(cr, plot.x, plot.y, plot.w, plot.h);
        cairo_clip(cr);
        status = interface_draw(&raster, view, frame, plot.x, plot.y, fmax(1, 0.07 * layout->font), cr, error);
        cairo_restore(cr);
    }
    free(shade);
    raster_done(&raster);
    return status;
}

static cairo_status_t to_file(void *file, const unsigned char *data, unsigned length)
{
    return fwrite(data, 1, length, file) == length ? CAIRO_STATUS_SUCCESS : CAIRO_STATUS_WRITE_ERROR;
}

static bool write_png(FILE *file, const void *surface)
{
    return cairo_surface_write_to_png_stream((cairo_surface_t *)surface, to_file, file) == CAIRO_STATUS_SUCCESS;
}

static void fit(Page *page)
{
    cairo_surface_t *surface = cairo_image_surface_create(CAIRO_FORMAT_RGB24, 1, 1);
    cairo_t *cr = cairo_create(surface);
    page_fit_height(page, cr);
    cairo_destroy(cr);
    cairo_surface_destroy(surface);
}

static MnsStatus compose(const Frame *frame, const View *view, const Colour *colours, const Page *page,
                         const char *path, Drawn *drawn, MnsError *error)
{
    cairo_surface_t *surface = cairo_image_surface_create(CAIRO_FORMAT_RGB24, page->width, page->height);
    cairo_t *cr = cairo_create(surface);
    Layout layout;
    cairo_set_source_rgb(cr, 1, 1, 1);
    cairo_paint(cr);
    MnsStatus status = cairo_status(cr) ? mns_fail(error, MNS_E_MEMORY, "there is no memory for the picture") : MNS_OK;
    if (!status) status = page_layout(page, cr, &layout, error);
    if (!status) status = draw_dots(frame, view, colours, &layout, cr, error);
    if (!status) {
        page_draw(page, &layout, cr);
        status = whole_file_write(path, "the picture", write_png, surface, error);
        memcpy(drawn->plot, &layout.plot, sizeof drawn->plot);
    }
    cairo_destroy(cr);
    cairo_surface_destroy(surface);
    return status;
}

MnsStatus picture_write(const Frame *frame, const RenderOptions *o, Drawn *ret, MnsError *error)
{
    View view;
    Scale scale = {.lo = NAN, .hi = NAN};
    MnsStatus status = view_make(frame, &o->view, &view, error);
    if (status) return status;
    if (!draws_phases(frame) && frame->dim == 3 && (status = raster_see(&view, error))) {
        view_done(&view);
        return status;
    }
    if (!draws_phases(frame))
        scale = scale_make(frame, &view, o->has_range ? o->range : NULL, colour_map_diverges(o->map));
    Page page = describe(frame, o, &view, &scale);
    if (!page.height) fit(&page);
    Drawn drawn = {view.n - view.hidden, view.skipped, page.width, page.height, {scale.lo, scale.hi}, {0}};
    Colour *colours = dot_colours(frame, &view, &scale, o->map);
    status = colours ? compose(frame, &view, colours, &page, o->out, &drawn, error)
                     : mns_fail(error, MNS_E_MEMORY, "there is no memory to draw %zu particles", view.n);
    if (!status) *ret = drawn;
    free(colours);
    view_done(&view);
    return status;
}
