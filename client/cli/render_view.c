/* SPDX-License-Identifier: BSD-3-Clause */
/* From particles in space to dots on a page: which are seen, from where, within which bounds. */
#include "client/cli/render_view.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct Extent {
    double lo[3], hi[3];
} Extent;

static bool finite_place(const Frame *frame, size_t i)
{
    return isfinite(frame->x[i][0]) && isfinite(frame->x[i][1]) && isfinite(frame->x[i][2]);
}

static bool is_wall(const Frame *frame, size_t i)
{
    return i >= frame->n_fluid;
}

/* Where particles are, with the half spacing that belongs to each. */
static Extent measure(const Frame *frame, bool walls)
{
    Extent e = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    const size_t n = walls ? frame->n : frame->n_fluid;
    for (size_t i = 0; i < n; i++) {
        if (!finite_place(frame, i)) continue;
        for (int d = 0; d < 3; d++) {
            e.lo[d] = fmin(e.lo[d], frame->x[i][d] - frame->spacing / 2);
            e.hi[d] = fmax(e.hi[d], frame->x[i][d] + frame->spacing / 2);
        }
    }
    return e;
}

/* What the page shows: the domain, beyond which no tile hangs over and which is the same for all pictures of a run, and
 * the walls if they are drawn. */
static Extent whole(const Frame *frame, const Extent *measured, bool walls)
{
    Extent e = *measured;
    for (int d = 0; d < frame->dim && frame->has_domain; d++) {
        e.lo[d] = walls ? fmin(e.lo[d], frame->domain[0][d]) : frame->domain[0][d];
        e.hi[d] = walls ? fmax(e.hi[d], frame->domain[1][d]) : frame->domain[1][d];
    }
    return e;
}

static int thinnest(const Extent *e)
{
    int axis = 2;
    for (int d = 1; d >= 0; d--)
        if (e->hi[d] - e->lo[d] < (e->hi[axis] - e->lo[axis]) * (1 - 1e-9)) axis = d;
    return axis;
}

static MnsStatus find_fluid(const Frame *frame, const char *name, size_t length, uint32_t *fluids, MnsError *error)
{
    char names[512] = "";
    for (size_t k = 0; k < frame->n_fluids; k++) {
        if (strlen(frame->fluids[k]) == length && !strncmp(frame->fluids[k], name, length)) {
            *fluids |= 1U << k;
            return MNS_OK;
        }
        strncat(names, k ? ", " : "", sizeof names - strlen(names) - 1);
        strncat(names, frame->fluids[k], sizeof names - strlen(names) - 1);
    }
    return mns_fail_at(error, MNS_E_NOT_FOUND, "--fluid", "there is no fluid \"%.*s\"; there are: %s", (int)length,
                       name, names);
}

static MnsStatus choose_fluids(const Frame *frame, const char *names, View *view, MnsError *error)
{
    view->fluids = view->kind == VIEW_PROJECTION ? 1U << frame_heaviest(frame) : UINT32_MAX;
    if (!names) return MNS_OK;
    view->fluids = 0;
    for (const char *at = names;; at++) {
        const size_t length = strcspn(at, ",");
        const MnsStatus status = find_fluid(frame, at, length, &view->fluids, error);
        if (status) return status;
        at += length;
        if (!*at) return MNS_OK;
    }
}

/* Up is against gravity: y in two dimensions, and z in three unless gravity is along y. */
static bool z_is_up(const Frame *frame)
{
    return frame->dim == 3 && fabs(frame->gravity[2]) >= fabs(frame->gravity[1]);
}

/* The page is what one sees looking along the axis, with what is up in space up on the page. Onto a surface below one
 * looks from above; then the third axis points down the page, for a mirror image would be wrong. */
static void choose_page(View *view, bool up_is_z)
{
    view->axis_u = view->axis == 0 ? (up_is_z ? 1 : 2) : 0;
    view->axis_v = view->axis == 2 || view->axis < 0 || (view->axis == 0 && !up_is_z) ? 1 : 2;
    view->v_is_down = view->axis == 1 && !up_is_z;
    view->eye_is_low = view->axis == 1 ? up_is_z : view->axis == 0 && !up_is_z;
}

static MnsStatus choose_plane(const Frame *frame, const ViewOptions *o, const Extent *e, View *view, MnsError *error)
{
    if (frame->dim == 2) {
        if (o->kind != VIEW_AUTOMATIC)
            return mns_fail_at(error, MNS_E_INVALID, o->kind == VIEW_CUT ? "--cut" : "--project",
                               "this is for three dimensions, but the picture is of a two-dimensional run");
        view->kind = VIEW_CUT;
        view->axis = -1;
        return MNS_OK;
    }
    view->kind = o->kind == VIEW_AUTOMATIC ? VIEW_CUT : o->kind;
    view->axis = o->kind == VIEW_AUTOMATIC ? thinnest(e) : o->axis;
    const double lo = e->lo[view->axis], hi = e->hi[view->axis];
    view->at = o->kind == VIEW_CUT && !isnan(o->at) ? o->at : (lo + hi) / 2;
    if (view->kind == VIEW_CUT && !(view->at >= lo && view->at <= hi))
        return mns_fail_at(error, MNS_E_INVALID, "--cut",
                           "the cut %c = %g m misses the particles, which lie between %g m and %g m", "xyz"[view->axis],
                           view -> at, lo, hi);
    return MNS_OK;
}

static void choose_bounds(const ViewOptions *o, const Extent *e, View *view)
{
    const int axis[2] = {view->axis_u, view->axis_v};
    for (int d = 0; d < 2; d++) {
        view->lo[d] = o->has_box ? o->box[d] : e->lo[axis[d]];
        view->hi[d] = o->has_box ? o->box[d + 2] : e->hi[axis[d]];
    }
    if (!view->v_is_down) return;
    const double lo = view->lo[1];
    view->lo[1] = -view->hi[1];
    view->hi[1] = -lo;
}

/* Beyond the domain is no fluid: no tile may hang over. Where walls are drawn, they see to it. */
static void choose_clip(const Frame *frame, const ViewOptions *o, View *view)
{
    const int axis[2] = {view->axis_u, view->axis_v};
    for (int d = 0; d < 2; d++) {
        const bool mirrored = d == 1 && view->v_is_down, clips = frame->has_domain && !o->walls;
        const double lo = clips ? frame->domain[0][axis[d]] : (double)-INFINITY;
        const double hi = clips ? frame->domain[1][axis[d]] : (double)INFINITY;
        view->clip_lo[d] = mirrored ? -hi : lo;
        view->clip_hi[d] = mirrored ? -lo : hi;
    }
}

/* Dots reach farther than the half diagonal of a lattice cell because moving particles do not keep a lattice. */
static double choose_radius(const Frame *frame, ViewKind kind)
{
    const double spacings = kind == VIEW_CUT ? 1.25 : 0.8;
    return spacings * frame->spacing;
}

static double depth_of(const View *view, const double x[3])
{
    if (view->axis < 0) return 0;
    if (view->kind == VIEW_CUT) return x[view->axis] - view->at;
    return view->eye_is_low ? -x[view->axis] : x[view->axis];
}

static bool is_hidden(const Frame *frame, const View *view, size_t i)
{
    const int k = frame->phase[i];
    return !is_wall(frame, i) && k >= 0 && k < FRAME_MAX_FLUIDS && !(view->fluids >> k & 1U);
}

static bool on_page(const View *view, const Dot *dot)
{
    const double r = view->radius;
    return dot->u > view->lo[0] - r && dot->u < view->hi[0] + r && dot->v > view->lo[1] - r && dot->v < view->hi[1] + r;
}

static void collect(const Frame *frame, const ViewOptions *o, View *view)
{
    const double reach = o->thickness > 0 ? o->thickness / 2 : view->radius;
    view->near = -INFINITY;
    view->far = INFINITY;
    for (size_t i = 0; i < frame->n; i++) {
        const bool hidden = is_hidden(frame, view, i);
        if ((is_wall(frame, i) && !o->walls) || (hidden && view->kind == VIEW_PROJECTION)) continue;
        if (!finite_place(frame, i) || (frame->value && !is_wall(frame, i) && !isfinite(frame->value[i]))) {
            view->skipped++;
            continue;
        }
        const double *x = frame->x[i];
        const Dot dot = {x[view->axis_u],
                         view->v_is_down ? -x[view->axis_v] : x[view->axis_v],
                         depth_of(view, x),
                         (uint32_t)i,
                         hidden,
                         true};
        if (!on_page(view, &dot) || (view->kind == VIEW_CUT && fabs(dot.depth) > reach)) continue;
        view->near = fmax(view->near, dot.depth);
        view->far = fmin(view->far, dot.depth);
        view->hidden += hidden;
        view->dots[view->n++] = dot;
    }
}

MnsStatus view_make(const Frame *frame, const ViewOptions *options, View *ret, MnsError *error)
{
    View view = {0};
    const Extent measured = measure(frame, options->walls), e = whole(frame, &measured, options->walls);
    if (!(measured.lo[0] <= measured.hi[0]))
        return mns_fail(error, MNS_E_NOT_FOUND, "none of the %zu particles has a finite position", frame->n);
    MnsStatus status = choose_plane(frame, options, &e, &view, error);
    if (!status) status = choose_fluids(frame, options->fluids, &view, error);
    if (status) return status;
    choose_page(&view, z_is_up(frame));
    choose_bounds(options, &e, &view);
    choose_clip(frame, options, &view);
    view.radius = choose_radius(frame, view.kind);
    view.dots = malloc(frame->n * sizeof *view.dots);
    if (!view.dots) return mns_fail(error, MNS_E_MEMORY, "there is no memory to draw %zu particles", frame->n);
    collect(frame, options, &view);
    if (view.n > view.hidden) {
        *ret = view;
        return MNS_OK;
    }
    view_done(&view);
    return mns_fail(error, MNS_E_NOT_FOUND,
                    "there is nothing to draw: %zu particles have no finite value, the others are outside the picture",
                    view.skipped);
}

void view_done(View *view)
{
    free(view->dots);
    *view = (View){0};
}
