/* SPDX-License-Identifier: BSD-3-Clause */
/* Shapes of a case as signed distances. */
#ifndef SIM_SHAPE_H
#define SIM_SHAPE_H

#include "sim/formula.h"
#include "sim/model.h"

typedef struct Shape {
    int dim;
    const MnsShape *shape; /* borrowed */
    Formula **formulas;    /* [shape->n], NULL where a part is no formula */
    double period[3];      /* [m] after which every bounded primitive is there again; 0: never */
} Shape;

/* Compile the formulas of a shape. On failure error->path is that of the part, below `path`. */
MnsStatus shape_init(Shape *s, const MnsShape *shape, int dim, const MnsConstant *constants, size_t n_constants,
                     const char *path, MnsError *error);
void shape_done(Shape *s);

/* Let all boxes, balls, cylinders and plates repeat themselves; one as long as a period along it has no ends. */
void shape_repeat(Shape *s, const double period[3]);

/* Distance from the surface, negative inside [m]: exact near the surface of a primitive, a lower bound of its magnitude where
 * parts are combined. A formula is only known as inside or outside: minus or plus infinity. */
double shape_distance(const Shape *s, const double x[3]);

/* Unit vector along which the distance grows fastest: away from the solid. */
void shape_normal(const Shape *s, const double x[3], double step, double normal[3]);

/* The part whose surface is the nearest. */
size_t shape_nearest_part(const Shape *s, const double x[3]);

enum { FACES_MAX = 6 }; /* of a part */

/* Flat faces of boxes, plates and half-spaces, their normals away from the solid if nothing else covers them; returns how many. ret: room for
 * FACES_MAX of each part. */
size_t shape_faces(const Shape *s, Face *ret);

#endif
