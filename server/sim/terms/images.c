/* SPDX-License-Identifier: BSD-3-Clause */
/* Flat walls are mirrors to interfaces, as a wall that is a plane of symmetry is one: what it does not show of a drop's curvature would
 * be missing. An image of a particle in reach is farther than the particle itself, so that a row has all whose images are in reach. Where
 * walls meet at right angles there are images of images.
 *   x_i - x_j' = x_ij + 2 (a - e . x_ij) e,   n_j' = n_j - 2 (e . n_j) e,   e normal of the wall, a = e . (x_i - x_wall)
 * An interface that meets a wall then does so at 90 degrees. Walls that are not flat have no images. */
#include "sim/terms/images.h"
#include "sim/mirror_planes.h"
#include <math.h>
#include <string.h>

enum { MIRRORS_MAX = 3 };

/* A plane seen from a particle: its normal, and how far away it is. */
typedef struct Mirror {
    double normal[3], away;
} Mirror;

static double dot(const double a[3], const double b[3], int dim)
{
    double sum = 0;
    for (int d = 0; d < dim; d++) sum += a[d] * b[d];
    return sum;
}

/* A face goes on beyond its edges: is there a wall particle behind where the plane is nearest? */
static bool is_wall(const Row *row, const Mirror *mirror, int dim, double dx)
{
    for (const Block *b = row->block + row->n_fluid; b < row->block + row->n; b++)
        for (int l = 0; l < LANES; l++) {
            double off2 = 0;
            for (int d = 0; d < dim; d++) {
                const double off = b->x[d][l] - (mirror->away + 0.5 * dx) * mirror->normal[d];
                off2 += off * off;
            }
            if (off2 < 1.44 * dx * dx) return true; /* lattices need not be along the wall */
        }
    return false;
}

/* Of walls that share a plane, or nearly, the nearest counts. */
static int add_mirror(Mirror *mirrors, int n, const Mirror *one, int dim)
{
    for (int k = 0; k < n; k++) {
        if (dot(mirrors[k].normal, one->normal, dim) < 0.9) continue;
        if (one->away < mirrors[k].away) mirrors[k] = *one;
        return n;
    }
    if (n < MIRRORS_MAX) mirrors[n++] = *one;
    return n;
}

static int find_mirrors(const Row *row, const Particles *s, const Model *model, Mirror *ret)
{
    const int dim = s->dim;
    int n = 0;
    for (size_t k = 0; k < model->n_faces; k++) {
        const Face *face = &model->face[k];
        Mirror mirror = {.away = 0};
        for (int d = 0; d < dim; d++) {
            const double x = s->x[d][row->i * s->x_step] - face->point[d] - model->wall[face->wall].x[d];
            mirror.normal[d] = face->normal[d];
            mirror.away += face->normal[d] * model_nearest(model, d, x);
        }
        if (mirror.away < 0 || mirror.away > model->kernel.support) continue;
        if (mirror_planes_have(model, face)) continue; /* its images are in the row */
        if (is_wall(row, &mirror, dim, model->dx)) n = add_mirror(ret, n, &mirror, dim);
    }
    return n;
}

/* Are these mirrors, a bit each, at right angles? Then it does not matter which comes first. */
static bool are_square(const Mirror *mirrors, int n, unsigned these, int dim)
{
    for (int k = 0; k < n; k++)
        for (int q = 0; q < k; q++)
            if (these >> k & these >> q & 1 && fabs(dot(mirrors[k].normal, mirrors[q].normal, dim)) > 0.1) return false;
    return true;
}

static void reflect(const Mirror *mirrors, int n, unsigned these, int dim, double x[3], double normal[3])
{
    for (int k = 0; k < n; k++) {
        if (!(these >> k & 1)) continue;
        const double *e = mirrors[k].normal;
        const double move = 2 * (mirrors[k].away - dot(e, x, dim)), turn = 2 * dot(e, normal, dim);
        for (int d = 0; d < dim; d++) {
            x[d] += move * e[d];
            normal[d] -= turn * e[d];
        }
    }
}

/* A row that grows, pair by pair. */
typedef struct Growing {
    Row *row;
    size_t n;
    double support;
    int dim;
} Growing;

/* Whose images in these mirrors are in reach, or nearly: most are not, of images of images above all. A mirror moves x by 2 (a - e . x) along e, which adds
 * 4 a (a - e . x) to x^2. */
static bool may_reach(const Block *b, const Mirror *mirrors, int n, unsigned these, const Growing *to, bool ret[LANES])
{
    const double reach2 = (1 + 1e-9) * to->support * to->support;
    double r2[LANES], along[LANES], move[MIRRORS_MAX][LANES];
    bool any = false;
    for (int l = 0; l < LANES; l++) r2[l] = b->r[l] * b->r[l];
    for (int k = 0; k < n; k++) {
        if (!(these >> k & 1)) continue;
        const Mirror *m = &mirrors[k];
        for (int l = 0; l < LANES; l++) along[l] = 0;
        for (int d = 0; d < to->dim; d++)
            for (int l = 0; l < LANES; l++) along[l] += m->normal[d] * b->x[d][l];
        for (int q = 0; q < k; q++) {
            const double both = these >> q & 1 ? dot(m->normal, mirrors[q].normal, to->dim) : 0;
            for (int l = 0; both != 0 && l < LANES; l++) along[l] += both * move[q][l];
        }
        for (int l = 0; l < LANES; l++) {
            move[k][l] = 2 * (m->away - along[l]);
            r2[l] += 2 * m->away * move[k][l];
        }
    }
    for (int l = 0; l < LANES; l++) any |= ret[l] = r2[l] < reach2;
    return any;
}

/* What is out of reach is left out, and so is what a full row has no room for: more than ROW_MAX in reach is refused where they are. */
static void append(Growing *to, const double x[3], const double normal[3], double V, double other, uint32_t j)
{
    const double r = sqrt(dot(x, x, to->dim));
    if (!(r < to->support) || to->n >= ROW_MAX) return;
    Block *b = to->row->block + to->n / LANES;
    const size_t l = to->n % LANES;
    for (int d = 0; d < to->dim; d++) {
        b->x[d][l] = x[d];
        b->normal[d][l] = normal[d];
    }
    b->r[l] = r;
    b->V[l] = V;
    b->other[l] = other;
    to->row->j[to->n++] = j;
}

static void append_images(Growing *to, const Row *row, const Particles *s, const Model *model, const Mirror *mirrors,
                          int n, unsigned these)
{
    const int dim = to->dim;
    double x[3] = {0, 0, 0}, normal[3] = {0, 0, 0};
    for (int d = 0; d < dim; d++) normal[d] = s->normal[d][row->i * s->normal_step];
    reflect(mirrors, n, these, dim, x, normal);
    append(to, x, normal, particles_volume(s, model, row->i), 0, (uint32_t)row->i); /* its own */
    bool may[LANES];
    for (const Block *b = row->block; b < row->block + row->n_fluid; b++) {
        if (!may_reach(b, mirrors, n, these, to, may)) continue;
        for (int l = 0; l < LANES; l++) {
            if (!may[l] || !(b->r[l] < to->support)) continue;
            for (int d = 0; d < dim; d++) {
                x[d] = b->x[d][l];
                normal[d] = b->normal[d][l];
            }
            reflect(mirrors, n, these, dim, x, normal);
            append(to, x, normal, b->V[l], b->other[l], row_j(row, b)[l]);
        }
    }
}

/* Fill up the last block with what is out of reach, and find the kernel of all from block `first` on. */
static void finish(const Growing *g, const Model *model, size_t first)
{
    Row *row = g->row;
    row->n_fluid = row->n = row->n_own = row->n_walls = (g->n + LANES - 1) / LANES;
    for (size_t k = g->n; k < row->n * LANES; k++) {
        Block *b = row->block + k / LANES;
        const size_t l = k % LANES;
        for (int d = 0; d < g->dim; d++) b->x[d][l] = b->normal[d][l] = 0;
        b->r[l] = 2 * g->support;
        b->V[l] = b->other[l] = 0;
        row->j[k] = row->j[0];
    }
    for (Block *b = row->block + first; b < row->block + row->n; b++)
        kernel_eval(&model->kernel, LANES, b->r, b->W, b->F);
}

const Row *row_with_images(const Row *row, const Particles *s, const Model *model, Row *room)
{
    Mirror mirrors[MIRRORS_MAX];
    if (!model->tense || row->n == row->n_fluid) return row;
    const int n = find_mirrors(row, s, model, mirrors);
    if (n == 0) return row;
    Growing images = {room, row->n_fluid * LANES, model->kernel.support, s->dim};
    room->i = row->i;
    room->mixed = true;
    memcpy(room->j, row->j, images.n * sizeof *row->j);
    memcpy(room->block, row->block, row->n_fluid * sizeof *row->block);
    for (unsigned these = 1; these < 1u << n; these++)
        if (are_square(mirrors, n, these, s->dim)) append_images(&images, row, s, model, mirrors, n, these);
    finish(&images, model, row->n_fluid);
    return room;
}
