/* SPDX-License-Identifier: BSD-3-Clause */
/* The surface stress is P4's: of all other fluids by their tensions, without a trace, forces opposite in pairs, nothing at a flat
 * interface but along its normal. */
#include "sim/terms/terms.h"
#include "tests/support/check.h"
#include "tests/support/cloud.h"
#include <stdlib.h>

static int beside(const double x[3])
{
    return x[0] < 0.45 ? CLOUD_WATER : CLOUD_AIR;
}

static int drop(const double x[3])
{
    double r2 = 0;
    for (int d = 0; d < 2; d++) r2 += (x[d] - 0.8) * (x[d] - 0.8);
    return r2 < 0.4 * 0.4 ? CLOUD_WATER : CLOUD_AIR;
}

/* Three fluids in disorder, without sides. */
static Cloud *three_fluids(int dim)
{
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                           .dx = 0.1,
                                           .n = {9, 9, 8},
                                           .jitter = 0.2,
                                           .smoothing = 1,
                                           .kernel = MNS_QUINTIC_SPLINE,
                                           .periodic = {true, true, true},
                                           .flowing = true,
                                           .owner = beside});
    Particles *s = &cloud->s;
    uint64_t seed = 2;
    cloud->model.n_phases = 3;
    cloud->model.phase[2] = (Phase){.rho0 = 80};
    cloud->model.tension[0][2] = cloud->model.tension[2][0] = 0.7;
    cloud->model.tension[0][1] = cloud->model.tension[1][0] = 0.2;
    cloud->model.tension[1][2] = cloud->model.tension[2][1] = 0.7;
    for (size_t i = 0; i < s->n; i++) {
        s->m[i] *= 1 + 0.1 * cloud_noise(&seed);
        if (s->x[1][i] > 0.5) s->phase[i] = 2;
    }
    if (neighbours_build(&cloud->nb, s, &cloud->model, NULL)) abort(); /* lists know of whose fluid they are */
    return cloud;
}

/* V_i^2 Pi_i from nothing but positions. */
static void stress(const Cloud *cloud, size_t i, double ret[3][3])
{
    const Particles *s = &cloud->s;
    double g[3] = {0}, size2 = 0;
    for (size_t j = 0; j < s->n; j++) {
        const CloudPair pair = cloud_pair(cloud, i, j);
        if (s->phase[j] == s->phase[i]) continue;
        const double c = cloud->model.tension[s->phase[i]][s->phase[j]] * cloud_volume(cloud, j) *
                         cloud_volume(cloud, j) / cloud_volume(cloud, i) * pair.F;
        for (int d = 0; d < s->dim; d++) g[d] += c * pair.dx[d];
    }
    for (int d = 0; d < s->dim; d++) size2 += g[d] * g[d];
    if (sqrt(size2) * cloud->model.kernel.h <= 1e-8 * 0.7) size2 = 0; /* so far away that it is none */
    for (int d = 0; d < 3; d++)
        for (int e = 0; e < 3; e++)
            ret[d][e] = size2 > 0 ? cloud_volume(cloud, i) * cloud_volume(cloud, i) *
                                        ((d == e ? size2 / s->dim : 0) - g[d] * g[e]) / sqrt(size2)
                                  : 0;
}

static void forces_are_those_of_the_paper_among_three_fluids(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = three_fluids(dim);
        const Particles *s = &cloud->s;
        cloud_term(cloud, &surface_vector);
        cloud_term(cloud, &surface_stress);
        cloud_assert_no_force(cloud, 1e-12);
        for (size_t i = 0; i < s->n; i += 5) {
            double mine[3][3], its[3][3], force[3] = {0}, scale = 0;
            stress(cloud, i, mine);
            for (size_t j = 0; j < s->n; j++) {
                const CloudPair pair = cloud_pair(cloud, i, j);
                if (i == j || pair.F == 0) continue;
                stress(cloud, j, its);
                for (int d = 0; d < dim; d++)
                    for (int e = 0; e < dim; e++) {
                        force[d] += (mine[d][e] + its[d][e]) * pair.F * pair.dx[e];
                        scale += fabs((mine[d][e] + its[d][e]) * pair.F * pair.dx[e]);
                    }
            }
            for (int d = 0; d < dim; d++) assert_close(s->m[i] * s->a[d][i], force[d], 1e-11 * scale);
        }
        cloud_free(cloud);
    }
}

static void a_flat_interface_pulls_along_its_normal_only_and_the_stress_has_no_trace(void **state)
{
    (void)state;
    for (int round = 0; round < 2; round++) {
        Cloud *cloud = cloud_new(&(CloudSetup){.dim = 2,
                                               .dx = 0.1,
                                               .n = {16, 16},
                                               .smoothing = 1,
                                               .kernel = MNS_QUINTIC_SPLINE,
                                               .periodic = {!round, true},
                                               .flowing = true,
                                               .calibrated = true,
                                               .owner = round ? drop : beside});
        const Particles *s = &cloud->s;
        double inward = 0, most = 0;
        cloud_term(cloud, &surface_vector);
        cloud_term(cloud, &surface_stress);
        for (size_t i = 0; i < s->n; i++) {
            const double size = hypot(s->a[0][i], s->a[1][i]);
            most = fmax(most, s->m[i] * size);
            inward -= s->m[i] * (s->a[0][i] * (s->x[0][i] - 0.8) + s->a[1][i] * (s->x[1][i] - 0.8));
            if (!round) assert_close(s->m[i] * s->a[1][i], 0, 1e-12);
        }
        assert_true(most > 0);
        if (round) assert_close(inward, 0, 1e-12); /* the virial is the trace */
        cloud_free(cloud);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(forces_are_those_of_the_paper_among_three_fluids),
        cmocka_unit_test(a_flat_interface_pulls_along_its_normal_only_and_the_stress_has_no_trace),
    };
    return cmocka_run_group_tests_name("surface stress", tests, NULL, NULL);
}
