/* SPDX-License-Identifier: BSD-3-Clause */
/* What a plain loop over neighbour lists takes on this machine, as JSON lines: the measure for those of bench_step, which can so be
 * compared from machine to machine. Particles on a jittered lattice in the order of the solver's cells, lists of indices, a structure of
 * arrays, Wendland's kernel, a density and a momentum sum in double precision; nothing is packed, fused, marked or padded.
 *
 * usage: bench_plain */
#include "base/array.h"
#include "base/clock.h"
#include "sim/level.h"
#include "tests/support/draw.h"
#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>

enum { REPEATS = 9, NEAR_MAX = 160, ARRAYS = 8 };

static const double SUPPORT = 2.6; /* spacings: 2 h at h = 1.3 */

typedef struct Plain {
    int dim;
    size_t n, pairs;
    int side[3];
    double *array[ARRAYS]; /* x, y, z, v_x, v_y, v_z, p, V; [n] */
    double *out[4];        /* density, a_x, a_y, a_z; [n]       */
    uint32_t *list;        /* [pairs]                           */
    size_t *begin;         /* [n + 1]                           */
} Plain;

static void place(Plain *p)
{
    uint64_t seed = 7;
    size_t i = 0;
    for (int z = 0; z < p->side[2]; z++)
        for (int y = 0; y < p->side[1]; y++)
            for (int x = 0; x < p->side[0]; x++, i++) {
                const int at[3] = {x, y, z};
                for (int k = 0; k < ARRAYS; k++) p->array[k][i] = draw_share(&seed) - 0.5;
                for (int d = 0; d < 3; d++) p->array[d][i] = d < p->dim ? at[d] + 0.2 * p->array[d][i] : 0;
                p->array[7][i] = 1;
            }
}

/* Neighbours of the particle of a lattice point, or how many there are. */
static size_t near(const Plain *p, size_t i, uint32_t *ret)
{
    const int row = p->side[0], plane = row * p->side[1];
    const int at[3] = {(int)i % row, (int)i / row % p->side[1], (int)i / plane};
    int first[3], last[3];
    size_t n = 0;
    for (int d = 0; d < 3; d++) {
        first[d] = at[d] > 3 ? at[d] - 3 : 0;
        last[d] = at[d] + 3 < p->side[d] ? at[d] + 3 : p->side[d] - 1;
    }
    for (int z = first[2]; z <= last[2]; z++)
        for (int y = first[1]; y <= last[1]; y++)
            for (int x = first[0]; x <= last[0]; x++) {
                const size_t j = (size_t)(z * plane + y * row + x);
                double r2 = 0;
                for (int d = 0; d < 3; d++) r2 += (p->array[d][i] - p->array[d][j]) * (p->array[d][i] - p->array[d][j]);
                if (j != i && r2 < SUPPORT * SUPPORT && n < NEAR_MAX) ret[n++] = (uint32_t)j;
            }
    return n;
}

static void list(Plain *p)
{
    uint32_t found[NEAR_MAX];
    for (size_t i = 0; i < p->n; i++) p->begin[i + 1] = p->begin[i] + near(p, i, found);
    p->pairs = p->begin[p->n];
    p->list = array_new(p->pairs, sizeof *p->list);
    for (size_t i = 0; p->list && i < p->n; i++) near(p, i, p->list + p->begin[i]);
}

static bool make(Plain *p, int dim, int side)
{
    *p = (Plain){.dim = dim, .side = {side, side, dim == 3 ? side : 1}};
    p->n = (size_t)p->side[0] * (size_t)p->side[1] * (size_t)p->side[2];
    bool whole = (p->begin = array_new(p->n + 1, sizeof *p->begin)) != NULL;
    for (int k = 0; k < ARRAYS; k++) whole = (p->array[k] = array_new(p->n, sizeof(double))) && whole;
    for (int k = 0; k < 4; k++) whole = (p->out[k] = array_new(p->n, sizeof(double))) && whole;
    if (!whole) return false;
    p->begin[0] = 0;
    place(p);
    list(p);
    return p->list != NULL;
}

static void done(Plain *p)
{
    for (int k = 0; k < ARRAYS; k++) free(p->array[k]);
    for (int k = 0; k < 4; k++) free(p->out[k]);
    free(p->list);
    free(p->begin);
}

INLINE void sums_of(const Plain *p, size_t i)
{
    const double *restrict x = p->array[0], *restrict y = p->array[1], *restrict z = p->array[2],
                           *restrict u = p->array[3], *restrict v = p->array[4], *restrict w = p->array[5],
                           *restrict pressure = p->array[6], *restrict volume = p->array[7];
    const uint32_t *restrict j = p->list + p->begin[i];
    const size_t n = p->begin[i + 1] - p->begin[i];
    double rate = 0, ax = 0, ay = 0, az = 0;
#pragma omp simd reduction(+ : rate, ax, ay, az)
    for (size_t k = 0; k < n; k++) {
        const uint32_t b = j[k];
        const double dx = x[i] - x[b], dy = y[i] - y[b], dz = z[i] - z[b];
        const double t = 1 - sqrt(dx * dx + dy * dy + dz * dz) * (1 / SUPPORT), F = t * t * t * volume[b];
        const double push = (pressure[i] + pressure[b]) * F;
        rate += F * ((u[i] - u[b]) * dx + (v[i] - v[b]) * dy + (w[i] - w[b]) * dz);
        ax += push * dx;
        ay += push * dy;
        az += push * dz;
    }
    p->out[0][i] = rate;
    p->out[1][i] = ax;
    p->out[2][i] = ay;
    p->out[3][i] = az;
}

typedef void (*Sweep)(const Plain *p, size_t first, size_t last);

#define SWEEP(level, target)                                                                                           \
    target static void sweep_##level(const Plain *p, size_t first, size_t last)                                        \
    {                                                                                                                  \
        for (size_t i = first; i < last; i++) sums_of(p, i);                                                           \
    }
SWEEP(base, )
#if HAS_LEVELS
SWEEP(v3, FOR_V3)
SWEEP(v4, FOR_V4)
static const Sweep SWEEPS[LEVELS] = {sweep_base, sweep_v3, sweep_v4};
#else
static const Sweep SWEEPS[LEVELS] = {sweep_base};
#endif

/* The least of some sweeps [s]. */
static double measure(const Plain *p, int threads)
{
    const Sweep sweep = SWEEPS[level_in_use()];
    double least = INFINITY;
    for (int k = 0; k < REPEATS; k++) {
        const double begun = clock_now();
#pragma omp parallel for schedule(static) num_threads(threads)
        for (int part = 0; part < threads; part++)
            sweep(p, p->n * (size_t)part / (size_t)threads, p->n * (size_t)(part + 1) / (size_t)threads);
        least = fmin(least, clock_now() - begun);
    }
    return least;
}

static int bench(int dim, int side)
{
    const int threads[] = {1, omp_get_max_threads()};
    Plain p;
    const bool made = make(&p, dim, side);
    for (int k = 0; made && k < (threads[1] > 1 ? 2 : 1); k++)
        printf("{\"name\": \"plain-loop-%dd\", \"threads\": %d, \"level\": \"%s\", \"particles\": %zu, \"neighbours\": "
               "%.1f, "
               "\"ns_per_pair\": %.2f}\n",
               dim, threads[k], mns_level(), p.n, (double)p.pairs / (double)p.n,
               1e9 * measure(&p, threads[k]) / (double)p.pairs);
    if (!made) fprintf(stderr, "bench_plain: no memory\n");
    done(&p);
    return made ? 0 : 1;
}

int main(void)
{
    return bench(2, 316) || bench(3, 58);
}
