/* SPDX-License-Identifier: BSD-3-Clause */
/* Kernel averages at points.                                                                                    P3 eq. 21 */
#include "sim/sample.h"
#include "sim/mirrors.h"
#include "sim/shown.h"
#include "sim/solid.h"
#include <math.h>

_Static_assert(EVERY_FLUID >> (MNS_MAX_FLUIDS - 1) == 1, "a bit for each fluid");

/* What shares are made of besides: moments about the point, of W V over particles. */
typedef struct Around {
    double wall[3], spread[3][3]; /* over walls: sum of W V r, of W V r r */
    double fluid[3], one[3];      /* sum of W V r over all fluids, over those asked for */
} Around;

typedef struct Sampler {
    const MnsSim *sim;
    double x[3];    /* or its image, which sees of particles what it sees of their images */
    double turn[3]; /* -1 along directions in which that is turned round, else 1 */
    Kernel kernel;
    unsigned fluids;
    int components;
    const ShownView *f;
    int along;      /* direction of the component f of a vector; -1 of anything else */
    double sign;    /* of that, as the image has it */
    Around *around; /* NULL: nobody asks for it */
    PointSums sums;
} Sampler;

static double value_of(const Sampler *q, size_t j)
{
    if (!q->f) return 0;
    if (q->components == 1) return q->sign * shown_number(&q->f[0], j);
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

/* What a particle adds to the moments. */
static void look_around(const Sampler *q, size_t j, double weight)
{
    const Particles *s = &q->sim->s;
    const Model *model = &q->sim->model;
    Around *around = q->around;
    const bool wall = j >= particles_fluid(s), one = !wall && q->fluids >> s->phase[j] & 1;
    double r[3] = {0, 0, 0};
    for (int d = 0; d < s->dim; d++) {
        r[d] = q->turn[d] * model_nearest(model, d, s->x[d][j * s->x_step] - q->x[d]);
        (wall ? around->wall : around->fluid)[d] += weight * r[d];
        if (one) around->one[d] += weight * r[d];
    }
    if (!wall) return;
    for (int d = 0; d < s->dim; d++)
        for (int e = 0; e <= d; e++) around->spread[d][e] += weight * r[d] * r[e];
}

static void add(Sampler *q, size_t j, double W)
{
    const Particles *s = &q->sim->s;
    const double weight = W * particles_volume(s, &q->sim->model, j);
    if (mirrors_hide(&q->sim->model, s, j)) {
        q->sums.hidden += weight;
        return;
    }
    q->sums.all += weight;
    if (q->around) look_around(q, j, weight);
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
            q->sums.hidden += part[k].sums.hidden;
            q->sums.value += part[k].sums.value;
        }
    }
}

static void visit_particles(Sampler *q)
{
    const Model *model = &q->sim->model;
    if (q->kernel.support <= model->kernel.support + 0.5 * model->skin) visit_cells(q);
    else visit_all(q);
}

/* The point as these mirrors show it. */
static void reflect(Sampler *q, const double x[3], unsigned these)
{
    q->sign = 1;
    for (int d = 0; d < 3; d++) {
        const unsigned sides = these >> 2 * d & 3;
        q->turn[d] = sides ? -1 : 1;
        q->x[d] = sides ? 2 * q->sim->model.mirror_at[sides & 1 ? 2 * d : 2 * d + 1] - x[d] : x[d];
        if (d == q->along) q->sign = q->turn[d];
    }
}

/* All particles in reach of a place before mirrors, and their images in those that are near. */
static void visit_images(Sampler *q, const double x[3])
{
    const unsigned near = mirrors_near(&q->sim->model, x, q->kernel.support);
    for (unsigned these = 1; these <= near; these++) {
        if (these & ~near || !mirrors_make_image(these)) continue;
        reflect(q, x, these);
        visit_particles(q);
    }
}

/* All particles in reach, and their images; behind a mirror there are particles alone. */
static void visit_all_there_is(Sampler *q, const double x[3])
{
    reflect(q, x, 0);
    visit_particles(q);
    const double hidden = q->sums.hidden;
    if (!mirrors_near(&q->sim->model, x, 0)) visit_images(q, x);
    q->sums.hidden = hidden;
}

/* The same as fluid goes on behind mirrors, for a kernel's width: what is there is what is before them. */
static void visit_as_fluid_goes_on(Sampler *q, const double x[3])
{
    const Model *model = &q->sim->model;
    const unsigned behind = mirrors_near(model, x, 0) & ~mirrors_near(model, x, -q->kernel.support);
    visit_all_there_is(q, x);
    if (!behind) return;
    const double hidden = q->sums.hidden;
    q->sums = (PointSums){0};
    *q->around = (Around){0};
    reflect(q, x, behind);
    const double before[3] = {q->x[0], q->x[1], q->x[2]};
    visit_all_there_is(q, before);
    q->sums.hidden = hidden;
}

static PointSums sample(const MnsSim *sim, const double x[3], double radius, unsigned fluids, const ShownView *f,
                        int components, int along)
{
    const Model *model = &sim->model;
    Sampler q = {
        .sim = sim, .kernel = model->kernel, .fluids = fluids, .components = components, .f = f, .along = along};
    if (radius > 0)
        q.kernel = kernel_make(model->kernel.type, model->dim, radius * model->kernel.h / model->kernel.support);
    visit_all_there_is(&q, x);
    return q.sums;
}

PointSums sample_point(const MnsSim *sim, const double x[3], double radius, unsigned fluids, const ShownView *f,
                       int components)
{
    return sample(sim, x, radius, fluids, f, components, -1);
}

double sample_cover(const MnsSim *sim, const double x[3])
{
    Sampler q = {.sim = sim, .kernel = sim->model.kernel, .fluids = EVERY_FLUID, .along = -1};
    reflect(&q, x, 0);
    visit_particles(&q);
    return q.sums.all + q.sums.hidden;
}

/* Solve A z = y, of which A's lower half is given and positive definite, by Cholesky's factors; false where it is not. */
static bool solve(int n, double A[3][3], const double y[3], double z[3])
{
    for (int d = 0; d < n; d++) {
        z[d] = y[d];
        for (int e = 0; e <= d; e++) {
            for (int k = 0; k < e; k++) A[d][e] -= A[d][k] * A[e][k];
            if (e == d && !(A[d][d] > 0)) return false;
            A[d][e] = e == d ? sqrt(A[d][d]) : A[d][e] / A[e][e];
        }
        for (int e = 0; e < d; e++) z[d] -= A[d][e] * z[e];
        z[d] /= A[d][d];
    }
    for (int d = n - 1; d >= 0; d--) {
        for (int e = d + 1; e < n; e++) z[d] -= A[e][d] * z[e];
        z[d] /= A[d][d];
    }
    return true;
}

/* What to multiply W of a particle at r from the point by, a + b . r, so that sums over what is no wall are exact for what is linear there:
 *
 *     a M + b . M_r = 1,  a M_r + b . M_rr = 0,  where M = open, M_r and M_rr are the moments of the kernel less those of walls.
 *
 * With b = 0, the middle of what is no wall counts, a spacing away from the wall, where a surface that slopes is higher or lower. A
 * tenth of the kernel's own spread is added to M_rr, so that what reaches into a wall is not extrapolated from hardly anything. */
static void correct(const Sampler *q, double open, double *ret_a, double ret_b[3])
{
    const Model *model = &q->sim->model;
    const int dim = model->dim;
    double moment[3] = {0, 0, 0}, spread[3][3], z[3] = {0, 0, 0}, least = open;
    for (int d = 0; d < dim; d++) {
        moment[d] = -q->around->wall[d];
        for (int e = 0; e <= d; e++) spread[d][e] = (d == e ? 1.1 * model->spread : 0) - q->around->spread[d][e];
    }
    const bool solved = solve(dim, spread, moment, z);
    for (int d = 0; d < dim; d++) least -= moment[d] * z[d];
    const bool good = solved && least > 0.05 * open;
    *ret_a = good ? 1 / least : 1 / open;
    for (int d = 0; d < dim; d++) ret_b[d] = good ? -z[d] / least : 0;
}

/* Nine tenths full is full, and one tenth empty: particles are never so even that their sum is 1 everywhere. */
Share sample_share(const MnsSim *sim, const double x[3], unsigned fluids)
{
    Around around = {0};
    Sampler q = {.sim = sim, .kernel = sim->model.kernel, .fluids = fluids, .around = &around, .along = -1};
    visit_as_fluid_goes_on(&q, x);
    const PointSums sums = q.sums;
    const double away = solid_distance_now(sim, x), seen = 1 - (sums.all - sums.fluid);
    Share share = {.open = seen - sums.hidden,
                   .beside = fmin(1, fmax(0, 0.5 + away / sim->model.dx)),
                   .solid = solid_covers(sim, x, away)};
    if (!(sums.fluid > NOTHING_NEAR)) return share;
    double a = 1, b[3] = {0, 0, 0}, fluid, one;
    if (seen < 1) correct(&q, fmax(seen, sums.fluid), &a, b);
    fluid = a * sums.fluid;
    one = a * sums.one;
    for (int d = 0; d < sim->s.dim; d++) {
        fluid += b[d] * around.fluid[d];
        one += b[d] * around.one[d];
    }
    if (!(fluid > NOTHING_NEAR)) return share;
    share.among = fmin(1, fmax(0, one / fluid));
    share.filled = fluid;
    share.fluid = share.among * fmin(1, fmax(0, 0.5 + 1.25 * (fmin(1, fluid) - 0.5)));
    return share;
}

/* Across the line, away from what the nearest wall is within a distance; a floor stays where it is. */
static void leave_wall(const MnsSim *sim, int up, double distance, double x[3])
{
    static const double STEEP = 0.25; /* square of the sine of 30 degrees */
    const double step = 0.01 * sim->model.dx, away = solid_distance_now(sim, x);
    double slope[3] = {0, 0, 0}, square = 0;
    if (!(away < distance)) return;
    for (int d = 0; d < sim->s.dim; d++) {
        double low[3] = {x[0], x[1], x[2]}, high[3] = {x[0], x[1], x[2]};
        if (d == up) continue;
        low[d] -= step;
        high[d] += step;
        slope[d] = (solid_distance_now(sim, high) - solid_distance_now(sim, low)) / (2 * step);
        square += slope[d] * slope[d];
    }
    if (!(square > STEEP)) return;
    for (int d = 0; d < sim->s.dim; d++) x[d] += slope[d] * (distance - away) / square;
}

Share sample_share_along(const MnsSim *sim, int up, const double x[3], unsigned fluids)
{
    const double away = solid_distance_now(sim, x), distance = 0.4 * sim->model.dx;
    double before[3] = {x[0], x[1], x[2]};
    const bool solid = solid_covers(sim, x, away);
    for (int d = 1; d < sim->s.dim && !solid; d++) leave_wall(sim, up, distance, before); /* of a corner both */
    Share share = sample_share(sim, before, fluids);
    share.solid = solid;
    return share;
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
        const PointSums sums = sample(sim, points[k], 0, EVERY_FLUID, f, components, info->components > 1 ? d : -1);
        if (sums.fluid > NOTHING_NEAR) values[k] = sums.value / sums.fluid;
    }
}
