/* SPDX-License-Identifier: BSD-3-Clause */
/* The transport velocity spreads fluid evenly, and what particles find by it is w . grad v, as server/sim/schemes/riemann.md has it: nothing in a
 * uniform flow, in whatever frame. */
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
    const Pass pass = {"stress", .terms = {&transport_stress, &background}};
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

static void rates_are_those_of_differences(void **state)
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
                double along = 0;
                for (int d = 0; d < dim; d++) along += w[(size_t)d * s->n + i] * pair.F * pair.dx[d];
                for (int d = 0; d < dim; d++) {
                    const bool own = s->phase[j] == s->phase[i]; /* another fluid may glide along it */
                    const double stress = own ? cloud_volume(cloud, j) * (s->v[d][j] - s->v[d][i]) * along : 0;
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

/* Of P3's eq. 12 the particle's own part is a drag against the frame. */
static void a_uniform_flow_feels_nothing(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = stirred(dim, tank, 0.3);
        Particles *s = &cloud->s;
        for (int d = 0; d < dim; d++)
            for (size_t i = 0; i < particles_fluid(s); i++) s->v[d][i] = 3 + d;
        cloud_term(cloud, &transport_stress);
        for (size_t i = 0; i < particles_fluid(s); i++)
            for (int d = 0; d < dim; d++) assert_true(s->a[d][i] == 0);
        cloud_free(cloud);
    }
}

/* Within a linear flow: w . grad v, by what plain differences are off among particles on a lattice, which is nothing with a calibrated kernel. */
static void a_linear_flow_is_found_where_particles_come_to(void **state)
{
    (void)state;
    static const double slope[3][3] = {{0.3, -2, 0.5}, {1, -0.3, 0.2}, {0.7, 0.4, 0.6}}, w[3] = {0.2, -0.1, 0.05};
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud =
            cloud_new(&(CloudSetup){.dim = dim, .dx = 0.1, .n = {13, 13, 13}, .calibrated = true, .owner = all_air});
        Particles *s = &cloud->s;
        size_t seen = 0;
        for (size_t i = 0; i < s->n; i++)
            for (int d = 0; d < dim; d++) {
                s->v[d][i] = 0;
                for (int e = 0; e < dim; e++) s->v[d][i] += slope[d][e] * s->x[e][i];
                s->b[d][i] = w[d] / (0.5 * cloud->model.dt);
            }
        cloud_term(cloud, &transport_stress);
        for (size_t i = 0; i < s->n; i++) {
            if (!cloud_inner(cloud, i)) continue;
            for (int d = 0; d < dim; d++) {
                double exact = 0;
                for (int e = 0; e < dim; e++) exact += slope[d][e] * w[e];
                assert_close(s->a[d][i], exact, 1e-12);
            }
            seen++;
        }
        assert_true(seen > 5);
        cloud_free(cloud);
    }
}

static void stress_is_not_needed_where_nothing_is_spread_or_nobody_asks(void **state)
{
    (void)state;
    Cloud *cloud = stirred(2, tank, 0.3);
    assert_true(transport_stress.needed(&cloud->model));
    cloud->model.phase[1].p_b = 0;
    assert_false(transport_stress.needed(&cloud->model));
    cloud->model.phase[0].p_b = 70;
    assert_true(transport_stress.needed(&cloud->model));
    cloud->model.transport_stress = false;
    assert_false(transport_stress.needed(&cloud->model));
    cloud_free(cloud);
}

/* Those whose density follows continuity too, by a background of their own. */
static void heavy_particles_are_spread_too(void **state)
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
        run_both(cloud);
        for (size_t i = 0; i < water; i++) {
            double b[3] = {0}, size = 0, a2 = 0;
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
                a2 += s->a[d][i] * s->a[d][i];
            }
            assert_true(a2 > 0);
        }
        cloud_free(cloud);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rates_are_those_of_differences),
        cmocka_unit_test(even_particles_are_not_pushed),
        cmocka_unit_test(particles_are_pushed_away_from_a_crowd),
        cmocka_unit_test(a_uniform_flow_feels_nothing),
        cmocka_unit_test(a_linear_flow_is_found_where_particles_come_to),
        cmocka_unit_test(heavy_particles_are_spread_too),
        cmocka_unit_test(stress_is_not_needed_where_nothing_is_spread_or_nobody_asks),
    };
    return cmocka_run_group_tests_name("transport", tests, NULL, NULL);
}
