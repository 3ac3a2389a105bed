/* SPDX-License-Identifier: BSD-3-Clause */
/* A handful of particles without a case. */
#include "tests/support/cloud.h"
#include "sim/terms/matrix_row.h"
#include "sim/terms/terms.h"
#include "tests/support/check.h"
#include "tests/support/draw.h"
#include <stdlib.h>
#include <string.h>

static void *must(void *p)
{
    if (!p) abort();
    return p;
}

double cloud_noise(uint64_t *seed)
{
    return draw_signed(seed);
}

static void set_model(Model *model, const CloudSetup *setup)
{
    *model = (Model){
        .dim = setup->dim,
        .level = level_in_use(),
        .dx = setup->dx,
        .cell_volume = pow(setup->dx, setup->dim),
        .kernel = kernel_make(setup->kernel, setup->dim, setup->dx * (setup->smoothing > 0 ? setup->smoothing : 1.3)),
        .skin = setup->skin * setup->dx,
        .n_phases = 2,
        .n_walls = 1,
        .phase = {{.rho0 = 1000, .c = 20, .exponent = 1, .mu = setup->viscous ? 3 : 0},
                  {.rho0 = 1, .c = 20, .exponent = 1, .mu = setup->viscous ? 0.5 : 0, .p_b = 1600, .summation = true}},
        .c_max = 20,
        .rho_max = 1000,
        .rho_min = 1,
        .projection = {.offset = 0.2},
        .differences = {.threshold = 0.01, .shifting = 0.5, .along = 1, .scale = pow(setup->dx, 2 - setup->dim)},
        .viscous = setup->viscous,
        .dt = 1e-3,
        .transport_stress = true,
        .reconstructs = setup->reconstructs,
        .viscous_scale = 1,
        .radial_scale = 100,
        .limiter = 3,
        .density_min = 0.1,
        .density_max = 10,
        .delta = 0.5,
        .dissipates_rest = true,
        .keeps_pair_volume = true,
        .repulsion = 0.08,
        .shifting = 2,
        .shifts_along_interfaces = true,
        .tense = true,
        .tension = {{0, 0.7}, {0.7, 0}},
        .tension_share = {{0, 0.35}, {0.35, 0}}};
    if (setup->flowing) model->phase[1].summation = false;
    for (int d = 0; d < setup->dim; d++) {
        model->cell[d] = setup->dx;
        model->max[d] = model->mirror_at[2 * d + 1] = setup->dx * (double)setup->n[d];
        if (!setup->periodic[d]) continue;
        model->period[d] = model->max[d];
        model->frequency[d] = 1 / model->period[d];
        model->periodic = true;
    }
    if (setup->calibrated) kernel_calibrate(&model->kernel, model->dim, model->cell);
}

static int owner_at(const CloudSetup *setup, size_t point, double x[3])
{
    for (int d = 0; d < 3; d++) {
        const size_t n = d < setup->dim ? setup->n[d] : 1;
        x[d] = d < setup->dim ? ((double)(point % n) + 0.5) * setup->dx : 0;
        point /= n;
    }
    return setup->owner ? setup->owner(x) : CLOUD_WATER;
}

static Group group_of(const CloudSetup *setup, int owner)
{
    return owner == CLOUD_AIR && setup->flowing ? GROUP_CONTINUITY : (Group)owner;
}

static void fill(Cloud *cloud, const CloudSetup *setup, size_t points)
{
    Particles *s = &cloud->s;
    size_t next[GROUPS] = {s->begin[0], s->begin[1], s->begin[2]};
    uint64_t seed = 7;
    for (size_t k = 0; k < points; k++) {
        double x[3];
        const int owner = owner_at(setup, k, x);
        if (owner == CLOUD_NOTHING) continue;
        const size_t i = next[group_of(setup, owner)]++;
        const double rho0 = cloud->model.phase[owner == CLOUD_AIR ? 1 : 0].rho0;
        s->id[i] = (uint32_t)k;
        s->phase[i] = (uint8_t)owner;
        s->rho[i] = rho0;
        s->m[i] = rho0 * cloud->model.cell_volume;
        s->shepard[i] = 1;
        for (int d = 0; d < s->dim; d++) {
            s->x[d][i] = x[d] + setup->jitter * setup->dx * cloud_noise(&seed);
            if (k % 7 == 3) s->x[d][i] += setup->outside * cloud->model.max[d] * cloud_noise(&seed);
        }
    }
}

Cloud *cloud_new(const CloudSetup *setup)
{
    Cloud *cloud = must(calloc(1, sizeof *cloud));
    cloud->threads = setup->threads > 0 ? setup->threads : 1;
    set_model(&cloud->model, setup);
    const size_t points = setup->n[0] * setup->n[1] * (setup->dim == 3 ? setup->n[2] : 1);
    size_t sizes[GROUPS + 1] = {0};
    for (size_t k = 0; k < points; k++) {
        double x[3];
        const int owner = owner_at(setup, k, x);
        sizes[owner == CLOUD_NOTHING ? GROUPS : group_of(setup, owner)]++;
    }
    const Fields instead = setup->reconstructs ? 0 : FIELD(STRAIN) | FIELD(STRAIN_OFF);
    const Fields fields = ALL_FIELDS & ~MADE_FIELDS & ~instead;
    if (particles_init(&cloud->s, setup->dim, 2, sizes, fields, 0, setup->viscous, cloud->threads, NULL, NULL)) abort();
    if (neighbours_init(&cloud->nb, cloud->s.n, cloud->s.dim, NEED_ALL, cloud->threads, NULL)) abort();
    if (!system_init(&cloud->system, cloud->s.n, particles_fluid(&cloud->s), cloud->threads)) abort();
    cloud->s.system = &cloud->system;
    cloud->s.made = FIELD(VOL) | FIELD(Z);
    fill(cloud, setup, points);
    if (cloud_build(cloud) != MNS_OK) abort();
    return cloud;
}

int cloud_two_fluids(const double x[3])
{
    return x[1] < 0.5 + 0.2 * x[0] ? CLOUD_WATER : CLOUD_AIR;
}

Cloud *cloud_reconstructing(int dim, double light, int (*owner)(const double x[3]))
{
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                           .dx = 0.1,
                                           .n = {10, 11, 8},
                                           .jitter = 0.2,
                                           .skin = 0.3,
                                           .calibrated = true,
                                           .flowing = true,
                                           .reconstructs = true,
                                           .owner = owner});
    cloud->model.phase[CLOUD_AIR].rho0 = light;
    return cloud;
}

void cloud_free(Cloud *cloud)
{
    if (!cloud) return;
    system_done(&cloud->system);
    neighbours_done(&cloud->nb);
    particles_done(&cloud->s);
    free(cloud);
}

MnsStatus cloud_build(Cloud *cloud)
{
    Particles *s = &cloud->s;
    for (int d = 0; d < s->dim; d++)
        for (size_t i = 0; i < s->n; i++) s->ref[d][i] = s->x[d][i];
    const MnsStatus status = neighbours_build(&cloud->nb, s, &cloud->model, NULL);
    if (!status && !matrix_rows_lay(s, &cloud->nb)) abort();
    return status;
}

void cloud_term(Cloud *cloud, const Term *term)
{
    Particles *s = &cloud->s;
    for (size_t i = 0; i < s->n; i++) {
        s->rate[i] = 0;
        for (int d = 0; d < s->dim; d++) s->a[d][i] = 0;
    }
    particles_changed(s, ON_ALL, ALL_FIELDS);
    const Pass pass = {"alone", .terms = {term}};
    pass_run(&pass, s, &cloud->nb, &cloud->model, cloud->threads);
}

void cloud_weigh(Cloud *cloud, unsigned fluid, double density)
{
    Particles *s = &cloud->s;
    cloud->model.phase[fluid].rho0 = density;
    for (size_t i = 0; i < particles_fluid(s); i++) {
        if (s->phase[i] != fluid) continue;
        s->m[i] = density * cloud_volume(cloud, i);
        s->rho[i] = density;
    }
}

size_t cloud_index(const Cloud *cloud, uint32_t id)
{
    for (size_t i = 0; i < cloud->s.n; i++)
        if (cloud->s.id[i] == id) return i;
    abort();
}

void cloud_assert_no_force(const Cloud *cloud, double rounding)
{
    const Particles *s = &cloud->s;
    for (int d = 0; d < s->dim; d++) {
        double sum = 0, size = 0;
        for (size_t i = 0; i < particles_fluid(s); i++) {
            sum += s->m[i] * s->a[d][i];
            size += s->m[i] * fabs(s->a[d][i]);
        }
        assert_true(size > 0);
        assert_close(sum, 0, rounding * size);
    }
}

void cloud_stir(Cloud *cloud, uint64_t seed)
{
    Particles *s = &cloud->s;
    for (size_t i = 0; i < particles_fluid(s); i++) {
        const Phase *phase = &cloud->model.phase[s->phase[i]];
        s->rho[i] = phase->rho0 * (1 + 0.1 * cloud_noise(&seed));
        s->p[i] = 0.1 * phase->rho0 * phase->c * phase->c * cloud_noise(&seed);
        for (int d = 0; d < s->dim; d++) s->v[d][i] = 0.1 * phase->c * cloud_noise(&seed);
    }
}

double cloud_distance(const Cloud *cloud, size_t i, size_t j, double ret_dx[3])
{
    double r2 = 0;
    for (int d = 0; d < cloud->s.dim; d++) {
        const double period = cloud->model.period[d];
        double dx = cloud->s.x[d][i] - cloud->s.x[d][j];
        if (period > 0) dx = remainder(dx, period);
        ret_dx[d] = dx;
        r2 += dx * dx;
    }
    return sqrt(r2);
}

CloudPair cloud_pair(const Cloud *cloud, size_t i, size_t j)
{
    CloudPair pair = {0};
    pair.r = cloud_distance(cloud, i, j, pair.dx);
    kernel_eval(&cloud->model.kernel, 1, &pair.r, &pair.W, &pair.F);
    return pair;
}

bool cloud_inner(const Cloud *cloud, size_t i)
{
    const double margin = cloud->model.kernel.support + cloud->model.dx;
    for (int d = 0; d < cloud->s.dim; d++) {
        const double x = cloud->s.x[d][i];
        if (cloud->model.period[d] == 0 && (x < margin || x > cloud->model.max[d] - margin)) return false;
    }
    return true;
}

void cloud_invert(double of[3][3], int dim, double ret[3][3])
{
    double a[3][6] = {{0}};
    for (int k = 0; k < dim; k++) {
        memcpy(a[k], of[k], sizeof of[k]);
        a[k][3 + k] = 1;
    }
    for (int k = 0; k < dim; k++) {
        const double pivot = a[k][k];
        for (int c = 0; c < 6; c++) a[k][c] /= pivot;
        for (int q = 0; q < dim; q++) {
            const double factor = a[q][k];
            for (int c = 0; c < 6 && q != k; c++) a[q][c] -= factor * a[k][c];
        }
    }
    for (int k = 0; k < dim; k++) memcpy(ret[k], a[k] + 3, 3 * sizeof(double));
}
