/* SPDX-License-Identifier: BSD-3-Clause */
/* Marching tetrahedra, and triangles in two dimensions. */
#include "sim/probes/simplex.h"
#include <math.h>

/* Part of the way from a to b that is on the side of a. */
static double part(const Corner *a, const Corner *b)
{
    return a->inside / (a->inside - b->inside);
}

static void cut(const Corner *a, const Corner *b, double ret[3])
{
    for (int d = 0; d < 3; d++) ret[d] = a->x[d] + part(a, b) * (b->x[d] - a->x[d]);
}

static double length(const double a[3], const double b[3])
{
    return sqrt(pow(b[0] - a[0], 2) + pow(b[1] - a[1], 2) + pow(b[2] - a[2], 2));
}

static double triangle(const double a[3], const double b[3], const double c[3])
{
    double u[3], v[3], twice = 0;
    for (int d = 0; d < 3; d++) {
        u[d] = b[d] - a[d];
        v[d] = c[d] - a[d];
    }
    for (int d = 0; d < 3; d++) twice += pow(u[(d + 1) % 3] * v[(d + 2) % 3] - u[(d + 2) % 3] * v[(d + 1) % 3], 2);
    return 0.5 * sqrt(twice);
}

/* The contour cuts off corner a from the dim others: its size, and the part of the simplex on the side of a. */
static double cut_corner(int dim, const Corner *a, const Corner *const others[], double *ret_part)
{
    double x[3][3];
    *ret_part = 1;
    for (int k = 0; k < dim; k++) {
        cut(a, others[k], x[k]);
        *ret_part *= part(a, others[k]);
    }
    return dim == 2 ? length(x[0], x[1]) : triangle(x[0], x[1], x[2]);
}

/* The contour separates a, b from c, d. Their side is three tetrahedra. */
static double cut_edge(const Corner *const c[4], double *ret_part)
{
    double x[4][3];
    const double ac = part(c[0], c[2]), ad = part(c[0], c[3]), bc = part(c[1], c[2]), bd = part(c[1], c[3]);
    cut(c[0], c[2], x[0]);
    cut(c[0], c[3], x[1]);
    cut(c[1], c[3], x[2]);
    cut(c[1], c[2], x[3]);
    *ret_part = ac * ad + ad * bc * (1 - ac) + bc * bd * (1 - ad);
    return triangle(x[0], x[1], x[2]) + triangle(x[0], x[2], x[3]);
}

/* Corners inside come first. */
static void add_simplex(int dim, double volume, const Corner *const corners[], double sums[static TALLIES])
{
    const Corner *c[4];
    int n = 0, walls = 0;
    double within = 1, surface = 0;
    for (int k = 0; k <= dim; k++)
        if (corners[k]->inside > 0) c[n++] = corners[k];
    for (int k = 0, end = n; k <= dim; k++) {
        walls += corners[k]->wall;
        if (!(corners[k]->inside > 0)) c[end++] = corners[k];
    }
    if (n == 0) return;
    if (n == 1) surface = cut_corner(dim, c[0], c + 1, &within);
    else if (n == dim) {
        surface = cut_corner(dim, c[dim], c, &within);
        within = 1 - within;
    } else if (n == 2) surface = cut_edge(c, &within);
    sums[VOLUME] += within * volume;
    sums[SURFACE] += surface;
    if (2 * walls <= dim + 1) sums[FREE_SURFACE] += surface;
}

/* The ways from the first corner to the last, along one axis after the other. */
void simplex_add_cell(int dim, double volume, const Corner *const corner[8], double sums[static TALLIES])
{
    static const int ways[6][2] = {{1, 3}, {2, 3}, {1, 5}, {4, 5}, {2, 6}, {4, 6}};
    const int last = dim == 2 ? 3 : 7, n = dim == 2 ? 2 : 6;
    for (int k = 0; k < n; k++) {
        const Corner *const simplex[4] = {corner[0], corner[ways[k][0]], corner[dim == 2 ? last : ways[k][1]],
                                          corner[last]};
        add_simplex(dim, volume / n, simplex, sums);
    }
}
