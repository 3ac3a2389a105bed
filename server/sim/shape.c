/* SPDX-License-Identifier: BSD-3-Clause */
/* Shapes of a case as signed distances. */
#include "sim/shape.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static const char *const XYZ[] = {"x", "y", "z", NULL};
enum { IMAGES_MAX = 100 }; /* on each side: of what is longer, nobody would see the ends */

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Distance from a box given by how far the point is outside of each pair of its faces. */
static double from_faces(const double *q, int n)
{
    double outside = 0, inside = -INFINITY;
    for (int d = 0; d < n; d++) {
        outside += q[d] > 0 ? q[d] * q[d] : 0;
        inside = fmax(inside, q[d]);
    }
    return outside > 0 ? sqrt(outside) : inside;
}

/* How far outside of a pair of faces `length` apart along a unit vector. Faces that meet their own images are none. */
static double from_pair(const Shape *s, const double axis[3], double length, double outside)
{
    for (int d = 0; d < s->dim; d++)
        if (s->period[d] > 0 && fabs(axis[d]) > 1 - 1e-9 && length > s->period[d] * (1 - 1e-9)) return -INFINITY;
    return outside;
}

static double box(const Shape *s, const MnsPart *p, const double x[3])
{
    static const double axes[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    double q[3];
    for (int d = 0; d < s->dim; d++)
        q[d] = from_pair(s, axes[d], p->b[d] - p->a[d], fmax(p->a[d] - x[d], x[d] - p->b[d]));
    return from_faces(q, s->dim);
}

static double ball(const MnsPart *p, const double x[3])
{
    const double r[3] = {x[0] - p->a[0], x[1] - p->a[1], x[2] - p->a[2]};
    return sqrt(dot(r, r)) - p->radius;
}

static double cylinder(const Shape *s, const MnsPart *p, const double x[3])
{
    double axis[3], r[3];
    for (int d = 0; d < 3; d++) {
        axis[d] = p->b[d] - p->a[d];
        r[d] = x[d] - p->a[d];
    }
    const double length = sqrt(dot(axis, axis)), along = dot(r, axis) / length;
    const double across = sqrt(fmax(dot(r, r) - along * along, 0));
    for (int d = 0; d < 3; d++) axis[d] /= length;
    const double q[2] = {across - p->radius, from_pair(s, axis, length, fmax(-along, along - length))};
    return from_faces(q, 2);
}

/* The plate's own directions: along its length, across its thickness, and in three dimensions the width between them. */
static void plate_axes(const MnsPart *p, int dim, double axes[3][3])
{
    const double length = sqrt(dot(p->b, p->b));
    double normal[3] = {-p->b[1], p->b[0], 0};
    if (dim == 3) { /* the part of `normal` that is perpendicular to `along` */
        const double along = dot(p->c, p->b) / (length * length);
        for (int d = 0; d < 3; d++) normal[d] = p->c[d] - along * p->b[d];
    }
    const double thickness = sqrt(dot(normal, normal));
    for (int d = 0; d < 3; d++) {
        axes[0][d] = p->b[d] / length;
        axes[1][d] = normal[d] / thickness;
    }
    for (int d = 0; d < 3; d++) {
        const int e = (d + 1) % 3, f = (d + 2) % 3;
        axes[2][d] = axes[0][e] * axes[1][f] - axes[0][f] * axes[1][e];
    }
}

static double plate(const Shape *s, const MnsPart *p, const double x[3])
{
    double axes[3][3];
    plate_axes(p, s->dim, axes);
    const double r[3] = {x[0] - p->a[0], x[1] - p->a[1], x[2] - p->a[2]};
    const double length[3] = {p->length, p->thickness, p->width};
    double q[3];
    for (int d = 0; d < s->dim; d++) q[d] = from_pair(s, axes[d], length[d], fabs(dot(r, axes[d])) - 0.5 * length[d]);
    return from_faces(q, s->dim);
}

static double half_space(const MnsPart *p, const double x[3])
{
    const double r[3] = {x[0] - p->a[0], x[1] - p->a[1], x[2] - p->a[2]};
    return dot(r, p->b) / sqrt(dot(p->b, p->b));
}

static double primitive(const Shape *s, size_t k, const double x[3])
{
    const MnsPart *p = &s->shape->parts[k];
    switch (p->primitive) {
    case MNS_BOX: return box(s, p, x);
    case MNS_BALL: return ball(p, x);
    case MNS_CYLINDER: return cylinder(s, p, x);
    case MNS_PLATE: return plate(s, p, x);
    case MNS_HALF_SPACE: return half_space(p, x);
    case MNS_FORMULA: return formula_eval(s->formulas[k], x) != 0 ? -INFINITY : INFINITY;
    }
    return INFINITY;
}

/* Middle of a bounded primitive, and the radius of a ball around it; false if it has none. */
static bool bounds(const MnsPart *p, int dim, double middle[3], double *radius)
{
    const bool centred = p->primitive == MNS_BALL || p->primitive == MNS_PLATE;
    double half2 = 0;
    for (int d = 0; d < dim; d++) {
        middle[d] = centred ? p->a[d] : 0.5 * (p->a[d] + p->b[d]);
        half2 += 0.25 * (p->b[d] - p->a[d]) * (p->b[d] - p->a[d]);
    }
    switch (p->primitive) {
    case MNS_BOX: *radius = sqrt(half2); return true;
    case MNS_BALL: *radius = p->radius; return true;
    case MNS_CYLINDER: *radius = sqrt(half2) + p->radius; return true;
    case MNS_PLATE:
        *radius = 0.5 * sqrt(p->length * p->length + p->thickness * p->thickness + p->width * p->width);
        return true;
    case MNS_HALF_SPACE:
    case MNS_FORMULA: return false;
    }
    return false;
}

/* Distance from the nearest image of a primitive. The image whose middle is nearest along each direction need not be it if the
 * primitive is oblique, so as many around it are looked at as the primitive reaches. */
static double nearest_image(const Shape *s, size_t k, const double x[3])
{
    double middle[3] = {0, 0, 0}, radius = 0, near[3] = {x[0], x[1], x[2]}, least = INFINITY;
    int reach[3] = {0, 0, 0};
    if (!bounds(&s->shape->parts[k], s->dim, middle, &radius)) return primitive(s, k, x);
    for (int d = 0; d < s->dim; d++) {
        const double period = s->period[d];
        if (!(period > 0)) continue;
        near[d] -= period * round((x[d] - middle[d]) / period);
        reach[d] = 1 + (int)fmin(floor(radius / period), IMAGES_MAX);
    }
    for (int a = -reach[2]; a <= reach[2]; a++)
        for (int b = -reach[1]; b <= reach[1]; b++)
            for (int c = -reach[0]; c <= reach[0]; c++) {
                const double y[3] = {near[0] + c * s->period[0], near[1] + b * s->period[1],
                                     near[2] + a * s->period[2]};
                least = fmin(least, primitive(s, k, y));
            }
    return least;
}

double shape_distance(const Shape *s, const double x[3])
{
    double distance = INFINITY;
    for (size_t k = 0; k < s->shape->n; k++) {
        const MnsPart *p = &s->shape->parts[k];
        double part = nearest_image(s, k, x);
        if (p->outside) part = -part;
        switch (p->operation) {
        case MNS_ADD: distance = fmin(distance, part); break;
        case MNS_SUBTRACT: distance = fmax(distance, -part); break;
        case MNS_INTERSECT: distance = fmax(distance, part); break;
        }
    }
    return distance;
}

size_t shape_nearest_part(const Shape *s, const double x[3])
{
    double least = INFINITY;
    size_t nearest = 0;
    for (size_t k = 0; k < s->shape->n; k++) {
        const double away = fabs(nearest_image(s, k, x));
        if (!(away < least)) continue;
        least = away;
        nearest = k;
    }
    return nearest;
}

void shape_normal(const Shape *s, const double x[3], double step, double normal[3])
{
    double length = 0;
    for (int d = 0; d < 3; d++) {
        double low[3] = {x[0], x[1], x[2]}, high[3] = {x[0], x[1], x[2]};
        low[d] -= step;
        high[d] += step;
        normal[d] = d < s->dim ? shape_distance(s, high) - shape_distance(s, low) : 0;
        length += normal[d] * normal[d];
    }
    length = sqrt(length);
    for (int d = 0; d < 3; d++) normal[d] = length > 0 ? normal[d] / length : 0;
}

/* A pair of faces, `length` apart along a unit vector, unless they meet their own images. */
static size_t face_pair(const Shape *s, const double middle[3], const double axis[3], double length, Face *ret)
{
    if (from_pair(s, axis, length, 0) < 0) return 0;
    for (int k = 0; k < 2; k++)
        for (int d = 0; d < 3; d++) {
            ret[k].normal[d] = k == 0 ? -axis[d] : axis[d];
            ret[k].point[d] = middle[d] + 0.5 * length * ret[k].normal[d];
        }
    return 2;
}

static size_t box_faces(const Shape *s, const MnsPart *p, Face *ret)
{
    static const double axes[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    double middle[3] = {0, 0, 0};
    size_t n = 0;
    for (int d = 0; d < s->dim; d++) middle[d] = 0.5 * (p->a[d] + p->b[d]);
    for (int d = 0; d < s->dim; d++) n += face_pair(s, middle, axes[d], p->b[d] - p->a[d], ret + n);
    return n;
}

static size_t plate_faces(const Shape *s, const MnsPart *p, Face *ret)
{
    const double length[3] = {p->length, p->thickness, p->width};
    double axes[3][3];
    size_t n = 0;
    plate_axes(p, s->dim, axes);
    for (int d = 0; d < s->dim; d++) n += face_pair(s, p->a, axes[d], length[d], ret + n);
    return n;
}

static size_t part_faces(const Shape *s, const MnsPart *p, Face *ret)
{
    if (p->primitive == MNS_BOX) return box_faces(s, p, ret);
    if (p->primitive == MNS_PLATE) return plate_faces(s, p, ret);
    if (p->primitive != MNS_HALF_SPACE) return 0;
    const double length = sqrt(dot(p->b, p->b));
    for (int d = 0; d < 3; d++) {
        ret->point[d] = p->a[d];
        ret->normal[d] = p->b[d] / length;
    }
    return 1;
}

size_t shape_faces(const Shape *s, Face *ret)
{
    size_t n = 0;
    for (size_t k = 0; k < s->shape->n; k++) {
        const MnsPart *p = &s->shape->parts[k];
        Face *faces = ret + n;
        const size_t more = part_faces(s, p, faces);
        const double sign = p->outside != (p->operation == MNS_SUBTRACT) ? -1 : 1;
        for (size_t q = 0; q < more; q++)
            for (int d = 0; d < 3; d++) faces[q].normal[d] *= sign;
        n += more;
    }
    return n;
}

MnsStatus shape_init(Shape *s, const MnsShape *shape, int dim, const MnsConstant *constants, size_t n_constants,
                     const char *path, MnsError *error)
{
    *s = (Shape){.dim = dim, .shape = shape, .formulas = calloc(shape->n + 1, sizeof *s->formulas)};
    if (!s->formulas) return mns_fail(error, MNS_E_MEMORY, "no memory for a shape");
    for (size_t k = 0; k < shape->n; k++) {
        if (shape->parts[k].primitive != MNS_FORMULA) continue;
        const char *text = shape->parts[k].formula;
        MnsStatus status = formula_new(text, XYZ, constants, n_constants, &s->formulas[k], error);
        if (!status && !formula_is_condition(s->formulas[k]))
            status = mns_fail(error, MNS_E_INVALID,
                              "\"%.120s\" is a number; a shape needs a condition, as in \"y < 1\"", text);
        if (status) {
            if (error) snprintf(error->path, sizeof error->path, "%s[%zu].formula", path, k);
            return status;
        }
    }
    return MNS_OK;
}

void shape_repeat(Shape *s, const double period[3])
{
    for (int d = 0; d < 3; d++) s->period[d] = d < s->dim ? period[d] : 0;
}

void shape_done(Shape *s)
{
    for (size_t k = 0; s->formulas && k < s->shape->n; k++) formula_free(s->formulas[k]);
    free(s->formulas);
    *s = (Shape){0};
}
