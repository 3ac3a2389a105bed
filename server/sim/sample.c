/* SPDX-License-Identifier: BSD-3-Clause */
/* Kernel averages at points.                                                                                    P3 eq. 21 */
#include "sim/sample.h"
#include "sim/shown.h"
#include <math.h>

_Static_assert(EVERY_FLUID >> (MNS_MAX_FLUIDS - 1) == 1, "a bit for each fluid");

typedef struct Sampler {
    const MnsSim *sim;
    double x[3];
    Kernel kernel;
    unsigned fluids;
    int components;
    const ShownView *f;
    PointSums sums;
} Sampler;

static double value_of(const Sampler *q, size_t j)
{
    if (!q->f) return 0;
    if (q->components == 1) return shown_number(&q->f[0], j);
    double sum = 0;
    for (int d = 0; d < q->components; d++) sum += shown_number(&q->f[d], j) * shown_number(&q->f[d], j);
    return sqrt(sum);
}

enum { AT_ONCE = 64 }; /* particles whose distances are taken in one go */

/* r2: [n] squared distances of the particles from first on. */
static void measure(const Sampler *q, size_t first, size_t n, double *restrict r2)
{
    const Model *model = &q->sim->model;
    for (size_t k = 0; k < n; k++) r2[k] = 0;
    for (int d = 0; d < q->sim->s.dim; d++) {
        const size_t step = q->sim->s.x_step;
        const double at = q->x[d], *x = q->sim->s.x[d] + first * step;
        if (model->period[d] > 0)
            for (size_t k = 0; k < n; k++) {
                const double dx = model_nearest(model, d, at - x[k * step]);
                r2[k] += dx * dx;
            }
        else
            for (size_t k = 0; k < n; k++) r2[k] += (at - x[k * step]) * (at - x[k * step]);
    }
}

static void add(Sampler *q, size_t j, double W)
{
    const Particles *s = &q->sim->s;
    const double weight = W * particles_volume(s, &q->sim->model, j);
    q->sums.all += weight;
    if (j >= particles_fluid(s)) return;
    q->sums.fluid += weight;
    q->sums.value += weight * value_of(q, j);
    if (q->fluids >> s->phase[j] & 1) q->sums.one += weight;
}

/* Roots are taken of what is near alone: most of the cells is not. */
static void visit(Sampler *q, size_t first, size_t last)
{
    const double about = q->kernel.support * q->kernel.support * (1 + 1e-9);
    for (; first < last; first += AT_ONCE) {
        const size_t n = last - first < AT_ONCE ? last - first : AT_ONCE;
        double r[AT_ONCE], W[AT_ONCE], F[AT_ONCE];
        size_t near[AT_ONCE], n_near = 0;
        measure(q, first, n, r);
        for (size_t k = 0; k < n; k++) {
            const double r2 = r[k];
            r[n_near] = r2; /* what stood there has been looked at */
            near[n_near] = first + k;
            n_near += r2 < about;
        }
        for (size_t k = 0; k < n_near; k++) r[k] = sqrt(r[k]);
        kernel_eval(&q->kernel, n_near, r, W, F);
        for (size_t k = 0; k < n_near; k++)
            if (r[k] < q->kernel.support) add(q, near[k], W[k]);
    }
}

/* The cells of the neighbour lists hold positions that are at most half a skin old. */
static void visit_cells(Sampler *q)
{
    const Neighbours *nb = &q->sim->nb;
    Run runs[GRID_RUNS_MAX];
    const int n = grid_runs(&nb->grid, grid_cell(&nb->grid, q->x), runs);
    for (size_t g = 0; g < GROUPS; g++) {
        const uint32_t *start = neighbours_start(nb, &q->sim->s, (int)g);
        for (int k = 0; start && k < n; k++) visit(q, start[runs[k].first], start[runs[k].last + 1]);
    }
}

/* Of a kernel wider than cells are: all particles, in blocks that are added up in order whoever has worked them out. */
static void visit_all(Sampler *q)
{
    enum { BATCH = 64 };
    const size_t n = q->sim->s.n, blocks = sim_blocks(n);
    Sampler part[BATCH];
    for (size_t first = 0; first < blocks; first += BATCH) {
        const size_t here = blocks - first < BATCH ? blocks - first : BATCH;
#pragma omp parallel for schedule(dynamic) num_threads(q->sim->threads)
        for (size_t k = 0; k < here; k++) {
            const size_t from = (first + k) * SIM_BLOCK;
            part[k] = *q;
            part[k].sums = (PointSums){0};
            visit(&part[k], from, n - from < SIM_BLOCK ? n : from + SIM_BLOCK);
        }
        for (size_t k = 0; k < here; k++) {
            q->sums.fluid += part[k].sums.fluid;
            q->sums.one += part[k].sums.one;
            q->sums.all += part[k].sums.all;
            q->sums.value += part[k].sums.value;
        }
    }
}

PointSums sample_point(const MnsSim *sim, const double x[3], double radius, unsigned fluids, const ShownView *f,
                       int components)
{
    const Model *model = &sim->model;
    Sampler q = {.sim = sim,
                 .x = {x[0], x[1], x[2]},
                 .kernel = model->kernel,
                 .fluids = fluids,
                 .components = components,
                 .f = f};
    if (radius > 0)
        q.kernel = kernel_make(model->kernel.type, model->dim, radius * model->kernel.h / model->kernel.support);
    if (q.kernel.support <= model->kernel.support + 0.5 * model->skin) visit_cells(&q);
    else visit_all(&q);
    return q.sums;
}

/* Nine tenths full is full, and one tenth empty: particles are never so even that their sum is 1 everywhere. */
Share sample_share(const MnsSim *sim, const double x[3], unsigned fluids)
{
    const PointSums sums = sample_point(sim, x, 0, fluids, NULL, 0);
    const double open = 1 - (sums.all - sums.fluid), filled = sums.fluid / fmax(sums.fluid, open);
    if (!(sums.fluid > NOTHING_NEAR)) return (Share){.fluid = 0, .open = open};
    const double full = fmin(1, fmax(0, 0.5 + 1.25 * (filled - 0.5)));
    return (Share){.fluid = full * sums.one / sums.fluid, .open = open};
}

void mns_sim_sample(const MnsSim *sim, int field, int d, size_t n, const double (*points)[3], double *values)
{
    const MnsFieldInfo *info = &mns_fields()[field];
    ShownView f[3] = {0};
    const bool magnitude = d < 0 && info->components > 1;
    const bool known = info->type == MNS_F64 && d < info->components;
    if (known)
        for (int k = 0; k < sim->s.dim && k < info->components; k++)
            f[k] = shown_view(sim, field, magnitude || info->components == 1 ? k : d);
    const int components = magnitude ? sim->s.dim : 1;
#pragma omp parallel for schedule(dynamic, 16) num_threads(sim->threads)
    for (size_t k = 0; k < n; k++) {
        values[k] = NAN;
        if (!known || !f[0].first) continue;
        const PointSums sums = sample_point(sim, points[k], 0, EVERY_FLUID, f, components);
        if (sums.fluid > NOTHING_NEAR) values[k] = sums.value / sums.fluid;
    }
}
