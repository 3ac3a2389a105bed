/* SPDX-License-Identifier: BSD-3-Clause */
/* What is fused gives the same bits as its terms one after the other, for every kernel, dimension and level of instructions. */
#include "sim/terms/terms.h"
#include "tests/support/check.h"
#include "tests/support/cloud.h"
#include <stdlib.h>
#include <string.h>

static int three_kinds(const double x[3])
{
    if (x[1] < 0.25 + 0.1 * x[0]) return CLOUD_WALL;
    return x[0] + 0.3 * x[1] < 0.5 ? CLOUD_WATER : CLOUD_AIR;
}

static Cloud *stirred(int dim, MnsKernel kernel, bool periodic)
{
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                           .dx = 0.1,
                                           .n = {11, 10, 9},
                                           .jitter = 0.4,
                                           .skin = 0.3,
                                           .periodic = {periodic, false, periodic},
                                           .kernel = kernel,
                                           .smoothing = kernel == MNS_WENDLAND_C2 ? 1.3 : 1.0,
                                           .owner = three_kinds});
    Particles *s = &cloud->s;
    uint64_t seed = 77;
    cloud_stir(cloud, 5);
    for (int d = 0; d < dim; d++)
        for (size_t i = 0; i < s->n; i++) s->b[d][i] = 800 * cloud_noise(&seed);
    for (size_t a = 0; a < 2; a++)
        for (size_t w = 0; w < s->n - particles_fluid(s); w++) s->p_wall[a][w] = 100 * cloud_noise(&seed);
    return cloud;
}

enum { ROWS = 7 };

/* What terms write, row by row: [ROWS * n], yours. */
static double *written(const Particles *s)
{
    double *all = calloc(ROWS * s->n, sizeof *all);
    assert_non_null(all);
    for (int d = 0; d < s->dim; d++) {
        memcpy(all + (size_t)d * s->n, s->a[d], s->n * sizeof *all);
        memcpy(all + (size_t)(3 + d) * s->n, s->b[d], s->n * sizeof *all);
    }
    memcpy(all + 6 * s->n, s->rate, s->n * sizeof *all);
    return all;
}

/* One pass over a new cloud: with pairs that were marked before, or with all that are listed. */
static double *result_of(const Pass *pass, int dim, MnsKernel kernel, bool periodic, bool marked, Level level,
                         size_t *ret_n)
{
    Cloud *cloud = stirred(dim, kernel, periodic);
    const Pass first = {"marks", .terms = {&riemann_momentum}};
    cloud->model.level = level;
    if (marked) pass_run(&first, &cloud->s, &cloud->nb, &cloud->model, 1);
    for (size_t i = 0; i < cloud->s.n; i++) cloud->s.rate[i] = 0;
    for (int d = 0; d < dim; d++)
        for (size_t i = 0; i < cloud->s.n; i++) cloud->s.a[d][i] = 0;
    particles_changed(&cloud->s, ON_ALL, ALL_FIELDS);
    if (marked) assert_true(cloud->nb.marked & 1u << GROUP_CONTINUITY);
    pass_run(pass, &cloud->s, &cloud->nb, &cloud->model, 1);
    double *all = written(&cloud->s);
    *ret_n = cloud->s.n;
    cloud_free(cloud);
    return all;
}

static void check(const Fusion *fusion, int dim, MnsKernel kernel, bool periodic, bool marked, Level level)
{
    Pass fused = {.name = "fused", .fusions = {fusion}}, apart = {.name = "one by one"};
    size_t n;
    memcpy(fused.terms, fusion->terms, sizeof fused.terms);
    memcpy(apart.terms, fusion->terms, sizeof apart.terms);
    double *a = result_of(&fused, dim, kernel, periodic, marked, level, &n);
    double *b = result_of(&apart, dim, kernel, periodic, marked, level, &n);
    double most = 0;
    for (size_t k = 0; k < ROWS * n; k++) {
        most = fabs(a[k]) > most ? fabs(a[k]) : most;
        if (!(a[k] == b[k]))
            fail_msg("%s: %.17g fused, %.17g one by one, row %zu of particle %zu", fusion->terms[0]->name, a[k], b[k],
                     k / n, k % n);
    }
    assert_true(most > 0);
    free(a);
    free(b);
}

static void fused_terms_have_the_bits_of_single_ones(void **state)
{
    (void)state;
    static const Fusion *const fusions[] = {&number_density_alone, &riemann_density_alone, &riemann_forces};
    static const MnsKernel kernels[] = {MNS_WENDLAND_C2, MNS_TRUNCATED_GAUSSIAN, MNS_QUINTIC_SPLINE};
    for (size_t f = 0; f < 3; f++)
        for (size_t k = 0; k < 3; k++)
            for (int way = 0; way < 8; way++)
                for (int level = 0; level <= (int)level_in_use(); level++)
                    check(fusions[f], way & 1 ? 3 : 2, kernels[k], way & 2, way & 4, (Level)level);
}

/* --- what is fused for particles among their own ------------------------------------------------------------------------ */

static int two_fluids(const double x[3])
{
    return x[0] < 0.75 ? CLOUD_WATER : CLOUD_AIR;
}

/* Two fluids without walls, with all that terms read at random. */
static Cloud *mixed(int dim, MnsKernel kernel, bool periodic, Level level)
{
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                           .dx = 0.1,
                                           .n = {16, 9, 8},
                                           .jitter = 0.3,
                                           .skin = 0.2,
                                           .periodic = {periodic, periodic, periodic},
                                           .kernel = kernel,
                                           .smoothing = 1,
                                           .viscous = true,
                                           .flowing = true,
                                           .owner = two_fluids});
    Particles *s = &cloud->s;
    uint64_t seed = 21;
    cloud_stir(cloud, 8);
    cloud->model.level = level;
    cloud->model.density_average = 0.7;
    for (size_t i = 0; i < s->n; i++) {
        s->shepard[i] = 1 + 0.1 * cloud_noise(&seed);
        s->rate[i] = 0;
        for (int d = 0; d < dim; d++) {
            s->gradient[d][i] = 500 * cloud_noise(&seed);
            s->concentration[d][i] = 3 * cloud_noise(&seed);
            s->normal[d][i] = 0;
        }
    }
    particles_changed(s, ON_ALL, ALL_FIELDS);
    return cloud;
}

/* How many particles have no neighbours of these kinds. */
static size_t without(const Cloud *cloud, unsigned kinds)
{
    size_t n = 0;
    for (size_t i = 0; i < cloud->s.n; i++) n += !(cloud->nb.has[i] & kinds);
    return n;
}

static void check_plain(const Fusion *fusion, int dim, MnsKernel kernel, bool periodic, Level level)
{
    Pass fused = {.name = "fused", .fusions = {fusion}}, apart = {.name = "one by one"};
    memcpy(fused.terms, fusion->terms, sizeof fused.terms);
    memcpy(apart.terms, fusion->terms, sizeof apart.terms);
    Cloud *a = mixed(dim, kernel, periodic, level), *b = mixed(dim, kernel, periodic, level);
    const size_t n = a->s.n;
    assert_in_range(without(a, LIST_OTHERS), 1, n - 1);
    if (periodic) assert_in_range(without(a, LIST_IMAGES), 1, n - 1);
    pass_run(&fused, &a->s, &a->nb, &a->model, 1);
    pass_run(&apart, &b->s, &b->nb, &b->model, 1);
    assert_memory_equal(a->s.rate, b->s.rate, n * sizeof *a->s.rate);
    for (int f = 0; mns_fields()[f].name; f++)
        for (int d = 0; d < 3; d++) {
            const void *x = particles_field(&a->s, f, d), *y = particles_field(&b->s, f, d);
            if (x && memcmp(x, y, n * field_size(&mns_fields()[f])) != 0)
                fail_msg("%s: another %s when fused", fusion->terms[0]->name, mns_fields()[f].name);
        }
    cloud_free(a);
    cloud_free(b);
}

static void what_is_fused_for_plain_particles_has_the_bits_of_rows(void **state)
{
    (void)state;
    static const Fusion *const fusions[] = {&dissipation_shape,         &dissipation_tense_shape,   &dissipation_rates,
                                            &dissipation_viscous_rates, &interfacial_density,       &no_interface,
                                            &interfacial_forces,        &interfacial_viscous_forces};
    static const MnsKernel kernels[] = {MNS_WENDLAND_C2, MNS_TRUNCATED_GAUSSIAN, MNS_QUINTIC_SPLINE};
    for (size_t f = 0; f < sizeof fusions / sizeof *fusions; f++)
        for (size_t k = 0; k < 3; k++)
            for (int way = 0; way < 4; way++)
                for (int level = 0; level <= (int)level_in_use(); level++) {
                    assert_true(fusions[f]->not_for & LIST_WALLS);
                    check_plain(fusions[f], way & 1 ? 3 : 2, kernels[k], way & 2, (Level)level);
                }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fused_terms_have_the_bits_of_single_ones),
        cmocka_unit_test(what_is_fused_for_plain_particles_has_the_bits_of_rows),
    };
    return cmocka_run_group_tests_name("fused", tests, NULL, NULL);
}
