/* SPDX-License-Identifier: BSD-3-Clause */
/* Marching tetrahedra, and triangles in two dimensions. */
#include "sim/probes/simplex.h"
#include <math.h>

/* A corner of a simplex, or where the contour cuts an edge: inside above 0, and what counts of the contour is where `counts` is
 * above 0. */
typedef struct Point {
    double x[3], inside, counts;
} Point;

/* Part of the way from a to b, one above 0 and one not, that is on the side of a. */
static double part(double a, double b)
{
    return a / (a - b);
}

static double side(const Point *a, const Point *b)
{
    return part(a->inside, b->inside);
}

static Point cut(const Point *a, const Point *b)
{
    const double way = side(a, b);
    Point at = {.counts = a->counts + way * (b->counts - a->counts)};
    for (int d = 0; d < 3; d++) at.x[d] = a->x[d] + way * (b->x[d] - a->x[d]);
    return at;
}

/* Part of a segment or triangle in which what is linear between its n corners is above 0. */
static double part_above(int n, const double f[3])
{
    int above = 0, one = 0;
    for (int k = 0; k < n; k++) above += f[k] > 0;
    if (above == 0 || above == n) return above > 0;
    for (int k = 0; k < n; k++)
        if ((f[k] > 0) == (above == 1)) one = k;
    const double corner = part(f[one], f[(one + 1) % n]) * (n == 3 ? part(f[one], f[(one + 2) % n]) : 1);
    return above == 1 ? corner : 1 - corner;
}

static double length(const Point *a, const Point *b)
{
    double sum = 0;
    for (int d = 0; d < 3; d++) sum += (a->x[d] - b->x[d]) * (a->x[d] - b->x[d]);
    return sqrt(sum) * part_above(2, (const double[]){a->counts, b->counts, 0});
}

static double triangle(const Point *a, const Point *b, const Point *c)
{
    double u[3], v[3], twice = 0;
    for (int d = 0; d < 3; d++) {
        u[d] = b->x[d] - a->x[d];
        v[d] = c->x[d] - a->x[d];
    }
    for (int d = 0; d < 3; d++) twice += pow(u[(d + 1) % 3] * v[(d + 2) % 3] - u[(d + 2) % 3] * v[(d + 1) % 3], 2);
    return 0.5 * sqrt(twice) * part_above(3, (const double[]){a->counts, b->counts, c->counts});
}

/* The contour cuts off corner a from the dim others: its size, and the part of the simplex on the side of a. */
static double cut_corner(int dim, const Point *a, const Point *const others[], double *ret_part)
{
    Point at[3];
    *ret_part = 1;
    for (int k = 0; k < dim; k++) {
        at[k] = cut(a, others[k]);
        *ret_part *= side(a, others[k]);
    }
    return dim == 2 ? length(&at[0], &at[1]) : triangle(&at[0], &at[1], &at[2]);
}

/* The contour separates a, b from c, d. Their side is three tetrahedra. */
static double cut_edge(const Point *const c[4], double *ret_part)
{
    const double ac = side(c[0], c[2]), ad = side(c[0], c[3]), bc = side(c[1], c[2]), bd = side(c[1], c[3]);
    const Point at[4] = {cut(c[0], c[2]), cut(c[0], c[3]), cut(c[1], c[3]), cut(c[1], c[2])};
    *ret_part = ac * ad + ad * bc * (1 - ac) + bc * bd * (1 - ad);
    return triangle(&at[0], &at[1], &at[2]) + triangle(&at[0], &at[2], &at[3]);
}

/* Size of the contour in a simplex, and the part of it that is inside. */
static double cut_simplex(int dim, const Point *const corners[], double *ret_part)
{
    const Point *c[4];
    int n = 0;
    for (int k = 0; k <= dim; k++)
        if (corners[k]->inside > 0) c[n++] = corners[k];
    for (int k = 0, end = n; k <= dim; k++)
        if (!(corners[k]->inside > 0)) c[end++] = corners[k];
    *ret_part = n > dim;
    if (n == 0 || n > dim) return 0;
    if (n == 1) return cut_corner(dim, c[0], c + 1, ret_part);
    if (n == 2 && dim == 3) return cut_edge(c, ret_part);
    const double surface = cut_corner(dim, c[dim], c, ret_part);
    *ret_part = 1 - *ret_part;
    return surface;
}

/* Size of the contour in a cell, and the part of it that is inside: from a corner to the one across, along one axis after the other, and so
 * from each corner of the first half. */
static double cut_cell(int dim, const Point corner[8], double *ret_part)
{
    static const int ways[6][2] = {{1, 3}, {2, 3}, {1, 5}, {4, 5}, {2, 6}, {4, 6}};
    const int last = dim == 2 ? 3 : 7, n = dim == 2 ? 2 : 6, diagonals = dim == 2 ? 2 : 4;
    double surface = 0;
    *ret_part = 0;
    for (int k = 0; k < n * diagonals; k++) {
        const int from = k / n, *way = ways[k % n];
        double within;
        const Point *const simplex[4] = {&corner[from], &corner[way[0] ^ from],
                                         &corner[(dim == 2 ? last : way[1]) ^ from], &corner[last ^ from]};
        surface += cut_simplex(dim, simplex, &within) / diagonals;
        *ret_part += within / (n * diagonals);
    }
    return surface;
}

/* The body ends at walls too. What is free of its surface is where the fluid ends, as far as that is outside walls. */
void simplex_add_cell(int dim, double volume, const Corner corner[8], double sums[static TALLIES])
{
    Point body[8], fluid[8];
    int n_body = 0, n_fluid = 0, n_open = 0, corners = 1 << dim;
    for (int k = 0; k < corners; k++) {
        const Corner *c = &corner[k];
        fluid[k] = (Point){{c->x[0], c->x[1], c->x[2]}, c->fluid, c->open};
        body[k] = (Point){{c->x[0], c->x[1], c->x[2]}, fmin(c->fluid, c->open), 1};
        n_body += body[k].inside > 0;
        n_fluid += fluid[k].inside > 0;
        n_open += c->open > 0;
    }
    double within = n_body == corners, surface = 0;
    if (n_body > 0 && n_body < corners) surface = cut_cell(dim, body, &within);
    sums[VOLUME] += within * volume;
    sums[SURFACE] += surface;
    if (n_fluid > 0 && n_fluid < corners && n_open > 0) sums[FREE_SURFACE] += cut_cell(dim, fluid, &within);
}
