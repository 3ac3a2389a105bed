/* SPDX-License-Identifier: BSD-3-Clause */
/* The transport velocity spreads light fluid evenly, and its stress is that of server/sim/schemes/riemann.md, conserving
 * momentum. */
#include "sim/terms/terms.h"
#include "tests/support/check.h"
#include "tests/support/cloud.h"
#include <stdlib.h>

static int tank(const double x[3])
{
    if (x[1] < 0.25) return CLOUD_WALL;
    return x[1] < 0.5 + 0.2 * x[0] ? CLOUD_WATER : CLOUD_AIR;
}

static int all_air(const double x[3])
{
    (void)x;
    return CLOUD_AIR;
}

/* Stirred, with an advection velocity of the air beside its velocity. */
static Cloud *stirred(int dim, int (*owner)(const double x[3]), double jitter)
{
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                           .dx = 0.1,
                                           .n = {8, 9, 7},
                                           .jitter = jitter,
                                           .skin = 0.3,
                                           .periodic = {true, true, true},
                                           .owner = owner});
    Particles *s = &cloud->s;
    uint64_t seed = 8;
    cloud_stir(cloud, 21);
    for (size_t i = s->begin[GROUP_SUMMATION]; i < s->begin[GROUP_WALL]; i++)
        for (int d = 0; d < dim; d++) s->b[d][i] = 0.4 * cloud_noise(&seed) / (0.5 * cloud->model.dt);
    return cloud;
}

/* a of both terms together, after it was set to zero. */
static void run_both(Cloud *cloud)
{
    Particles *s = &cloud->s;
    const Pass pass = {"stress", .terms = {&background, &transport_stress}};
    for (int d = 0; d < s->dim; d++)
        for (size_t i = 0; i < s->n; i++) s->a[d][i] = 0;
    particles_changed(s, ON_ALL, ALL_FIELDS);
    pass_run(&pass, s, &cloud->nb, &cloud->model, 1);
}

/* The advection velocity of this step, of which the terms leave the next one's: [dim * n]. */
static double *excess(const Cloud *cloud)
{
    const Particles *s = &cloud->s;
    double *w = malloc((size_t)s->dim * s->n * sizeof *w);
    assert_non_null(w);
    for (int d = 0; d < s->dim; d++)
        for (size_t i = 0; i < s->n; i++) w[(size_t)d * s->n + i] = 0.5 * cloud->model.dt * s->b[d][i];
    return w;
}

static void rates_are_those_of_the_paper(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = stirred(dim, tank, 0.3);
        const Particles *s = &cloud->s;
        double *w = excess(cloud);
        run_both(cloud);
        for (size_t i = 0; i < particles_fluid(s); i++) {
            double a[3] = {0}, b[3] = {0}, size_a = 0, size_b = 0;
            for (size_t j = 0; j < s->n; j++) {
                const CloudPair pair = cloud_pair(cloud, i, j);
                if (j == i || pair.W == 0) continue;
                double own = 0, other = 0; /* A_i . grad W = rho v (w . grad W); A = 0 in water and walls, as w is */
                for (int d = 0; d < dim; d++) {
                    own += w[(size_t)d * s->n + i] * pair.F * pair.dx[d];
                    other += w[(size_t)d * s->n + j] * pair.F * pair.dx[d];
                }
                for (int d = 0; d < dim; d++) {
                    const double stress = cloud_volume(cloud, i) * cloud_volume(cloud, j) / s->m[i] *
                                          (s->rho[i] * s->v[d][i] * own + s->rho[j] * s->v[d][j] * other);
                    const double push = -2 * 1600 * cloud_volume(cloud, j) / s->rho[i] * pair.F * pair.dx[d];
                    a[d] += stress;
                    b[d] += push;
                    size_a = fmax(size_a, fabs(stress));
                    size_b = fmax(size_b, fabs(push));
                }
            }
            const bool air = i >= s->begin[GROUP_SUMMATION];
            for (int d = 0; d < dim; d++) { /* rounding of sums of up to 100 terms */
                assert_close(s->a[d][i], a[d], 1e-12 * size_a);
                assert_close(s->b[d][i], air ? b[d] : 0, 1e-12 * size_b);
            }
        }
        free(w);
        cloud_free(cloud);
    }
}

static void even_particles_are_not_pushed(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = stirred(dim, all_air, 0);
        for (size_t i = 0; i < cloud->s.n; i++) cloud->s.m[i] = cloud->s.rho[i] * cloud->model.cell_volume;
        cloud_term(cloud, &background);
        /* Rounding of terms of up to 3200 * 10. */
        for (size_t i = 0; i < cloud->s.n; i++)
            for (int d = 0; d < dim; d++) assert_close(cloud->s.b[d][i], 0, 1e-9);
        cloud_free(cloud);
    }
}

static void particles_are_pushed_away_from_a_crowd(void **state)
{
    (void)state;
    Cloud *cloud = stirred(2, all_air, 0);
    Particles *s = &cloud->s;
    size_t crowded = 0, left = 0;
    for (size_t i = 0; i < s->n; i++) {
        if (s->id[i] == 3 * 8 + 3) crowded = i;
        if (s->id[i] == 3 * 8 + 2) left = i;
    }
    s->x[0][crowded] -= 0.04;
    s->x[1][crowded] += 0.01;
    cloud_term(cloud, &background);
    assert_true(s->b[0][crowded] > 0 && s->b[1][crowded] < 0);
    assert_true(s->b[0][left] < 0);
    cloud_free(cloud);
}

/* Also between air and water, which has no excess velocity of its own but feels that of the air. */
static void stress_conserves_momentum_between_all_fluids(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = stirred(dim, tank, 0.3);
        Particles *s = &cloud->s;
        cloud->model.cell_volume = 0; /* of walls, which give nothing back */
        run_both(cloud);
        for (int d = 0; d < dim; d++) {
            double sum = 0, size = 0;
            size_t water = 0;
            for (size_t i = 0; i < particles_fluid(s); i++) {
                sum += s->m[i] * s->a[d][i];
                size += s->m[i] * fabs(s->a[d][i]);
                water += i < s->begin[GROUP_SUMMATION] && s->a[d][i] != 0;
            }
            assert_close(sum, 0, 1e-13 * size); /* rounding */
            assert_true(water > 5);
        }
        cloud_free(cloud);
    }
}

static void without_stress_the_background_still_pushes(void **state)
{
    (void)state;
    Cloud *cloud = stirred(2, tank, 0.3);
    Particles *s = &cloud->s;
    const size_t i = s->begin[GROUP_SUMMATION];
    cloud_term(cloud, &background);
    const double b = s->b[0][i];
    assert_true(b != 0 && s->a[0][i] != 0);
    cloud->model.transport_stress = false;
    cloud_term(cloud, &background);
    assert_true(s->b[0][i] == b && s->a[0][i] == 0);
    cloud_free(cloud);
}

static void stress_is_not_needed_where_no_density_is_summed_or_nobody_asks(void **state)
{
    (void)state;
    Cloud *cloud = stirred(2, tank, 0.3);
    assert_true(transport_stress.needed(&cloud->model));
    cloud->model.phase[1].summation = false;
    assert_false(transport_stress.needed(&cloud->model));
    cloud->model.phase[1].summation = true;
    cloud->model.transport_stress = false;
    assert_false(transport_stress.needed(&cloud->model));
    cloud_free(cloud);
}

/* Heavy fluids are spread too, but keep their velocity to themselves. */
static void heavy_particles_are_spread_without_stress(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = stirred(dim, tank, 0.3);
        Particles *s = &cloud->s;
        const size_t water = s->begin[GROUP_SUMMATION];
        for (size_t k = 0; k < cloud->model.n_phases; k++)
            if (!cloud->model.phase[k].summation) cloud->model.phase[k].p_b = 70;
        for (size_t i = 0; i < water; i++)
            for (int d = 0; d < dim; d++) s->b[d][i] = 600;
        cloud_term(cloud, &background);
        for (size_t i = 0; i < water; i++) {
            double b[3] = {0}, size = 0;
            for (size_t j = 0; j < s->n; j++) {
                const CloudPair pair = cloud_pair(cloud, i, j);
                for (int d = 0; d < dim && j != i; d++) {
                    const double push = -2 * 70 * cloud_volume(cloud, j) / s->rho[i] * pair.F * pair.dx[d];
                    b[d] += push;
                    size = fmax(size, fabs(push));
                }
            }
            for (int d = 0; d < dim; d++) {
                assert_close(s->b[d][i], b[d], 1e-12 * size);
                assert_true(s->a[d][i] == 0);
            }
        }
        cloud_free(cloud);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rates_are_those_of_the_paper),
        cmocka_unit_test(even_particles_are_not_pushed),
        cmocka_unit_test(particles_are_pushed_away_from_a_crowd),
        cmocka_unit_test(stress_conserves_momentum_between_all_fluids),
        cmocka_unit_test(without_stress_the_background_still_pushes),
        cmocka_unit_test(heavy_particles_are_spread_without_stress),
        cmocka_unit_test(stress_is_not_needed_where_no_density_is_summed_or_nobody_asks),
    };
    return cmocka_run_group_tests_name("transport", tests, NULL, NULL);
}
