/* SPDX-License-Identifier: BSD-3-Clause */
/* From particles in space to dots on a page: which are seen, from where, within which bounds. */
#ifndef CLI_RENDER_VIEW_H
#define CLI_RENDER_VIEW_H

#include "client/cli/render_frame.h"
#include <stdint.h>

typedef enum ViewKind { VIEW_AUTOMATIC, VIEW_CUT, VIEW_PROJECTION } ViewKind;

typedef struct ViewOptions {
    ViewKind kind;    /* automatic: the plane in 2D, a cut through the middle of the thinnest extent in 3D */
    int axis;         /* normal of the cut, or direction of the look */
    double at;        /* place of the cut [m]; NAN: the middle */
    double thickness; /* of the slab that is shown [m]; 0: the particles nearest to the plane */
    bool walls;
    bool has_box;
    double box[4];      /* u0, v0, u1, v1 on the page [m] */
    const char *fluids; /* names with commas; NULL: all, in a projection the heaviest */
} ViewOptions;

typedef struct Dot {
    double u, v;  /* on the page [m] */
    double depth; /* distance from the plane of a cut, or towards the eye in a projection [m] */
    uint32_t particle;
    bool hidden; /* of a fluid that is not shown: keeps its place, so that others do not swell into it */
    bool seen;   /* until raster_see() has looked: true */
} Dot;

typedef struct View {
    ViewKind kind; /* of a plane: a cut of axis -1 */
    int axis, axis_u, axis_v;
    double at;                     /* [m] */
    bool v_is_down;                /* then v and the bounds are minus the coordinate */
    bool eye_is_low;               /* a projection is seen from the lower end of the axis */
    double lo[2], hi[2];           /* bounds on the page [m] */
    double clip_lo[2], clip_hi[2]; /* within these, on the page, fluids are drawn [m] */
    double near, far;              /* depths of the nearest and the farthest dot of a projection [m] */
    double radius;                 /* of a dot: large enough to leave no gaps between neighbours [m] */
    uint32_t fluids;               /* bit k: fluid k is shown */
    size_t n, hidden, skipped;     /* dots; of these hidden; particles without finite position or value */
    Dot *dots;
} View;

/* MNS_E_INVALID if the options do not fit the frame, MNS_E_NOT_FOUND if nothing is left to draw or a fluid is unknown.
 * On failure *ret needs no view_done(). */
MnsStatus view_make(const Frame *frame, const ViewOptions *options, View *ret, MnsError *error);

void view_done(View *view);

#endif
