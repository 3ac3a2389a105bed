/* SPDX-License-Identifier: BSD-3-Clause */
/* What P3's dissipation leaves alone: rates of strain of linear flows are exact, of each fluid for itself, and such flows are not dissipated; forces stay
 * opposite, and what is dissipated is never more than without. */
#include "sim/terms/terms.h"
#include "tests/support/check.h"
#include "tests/support/cloud.h"
#include <string.h>

static int tank(const double x[3])
{
    if (x[1] < 0.25) return CLOUD_WALL;
    return x[1] < 0.5 + 0.2 * x[0] ? CLOUD_WATER : CLOUD_AIR;
}

/* grad v of either fluid, [along][component]; the air glides along the water. */
static const double FLOW[2][3][3] = {{{-0.3, 0.2, 0.1}, {0.5, -0.4, 0.7}, {0.2, -0.6, -0.1}},
                                     {{0.9, -0.2, 0.3}, {-0.5, -0.8, 0.1}, {0.4, 0.2, 0.6}}};

/* Both follow continuity; the second is a gas to the first if it is that light. */
static Cloud *linear(int dim, double light, int (*owner)(const double x[3]))
{
    Cloud *cloud = cloud_reconstructing(dim, light, owner);
    Particles *s = &cloud->s;
    cloud->model.limiter = 3;
    for (size_t i = 0; i < particles_fluid(s); i++)
        for (int d = 0; d < dim; d++) {
            s->v[d][i] = 2 * s->phase[i];
            for (int e = 0; e < dim; e++) s->v[d][i] += FLOW[s->phase[i]][e][d] * s->x[e][i];
        }
    return cloud;
}

static double strain_at(const Particles *s, size_t i, int d, int e)
{
    return d == e ? s->strain[d][i] : s->strain_off[d + e - 1][i];
}

static void strains_of_linear_flows_are_exact_in_each_fluid(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = linear(dim, 500, tank);
        const Particles *s = &cloud->s;
        cloud_term(cloud, &strain_rate);
        size_t exact = 0, all = particles_fluid(s);
        for (size_t i = 0; i < all; i++) {
            bool well = true;
            for (int d = 0; d < dim; d++)
                for (int e = 0; e < dim; e++) {
                    const double due = 0.5 * (FLOW[s->phase[i]][d][e] + FLOW[s->phase[i]][e][d]);
                    well = well && fabs(strain_at(s, i, d, e) - due) < 2e-6; /* sums of floats */
                }
            exact += well;
        }
        assert_true((double)exact > 0.97 * (double)all); /* but where there are hardly any neighbours */
        cloud_free(cloud);
    }
}

static bool has_air_in_reach(const Cloud *cloud, size_t i)
{
    double dx[3];
    for (size_t j = 0; j < particles_fluid(&cloud->s); j++)
        if (cloud->s.phase[j] == CLOUD_AIR && cloud_distance(cloud, i, j, dx) < cloud->model.kernel.support)
            return true;
    return false;
}

static void neither_a_gas_nor_a_liquid_beside_one_has_any(void **state)
{
    (void)state;
    for (int gas = 0; gas < 2; gas++) {
        Cloud *cloud = linear(2, gas ? 1 : 500, tank);
        const Particles *s = &cloud->s;
        cloud_term(cloud, &strain_rate);
        size_t air = 0, beside = 0, within = 0;
        for (size_t i = 0; i < particles_fluid(s); i++) {
            const bool near = has_air_in_reach(cloud, i), of_air = s->phase[i] == CLOUD_AIR;
            air += of_air;
            beside += near && !of_air;
            within += !near;
            for (int d = 0; d < 2; d++)
                if (gas && near) assert_true(s->strain[d][i] == 0 && s->strain_off[0][i] == 0);
                else assert_true(s->strain[d][i] != 0);
        }
        assert_true(air > 10 && beside > 10 && within > 10);
        cloud_free(cloud);
    }
}

/* Accelerations of pressures of 0, which are of the dissipation alone. */
static void dissipate(Cloud *cloud)
{
    cloud_term(cloud, &strain_rate);
    cloud_term(cloud, cloud->model.reconstructs ? &reconstructed_momentum : &riemann_momentum);
}

static void a_linear_flow_is_not_dissipated(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = linear(dim, 500, NULL);
        const Particles *s = &cloud->s;
        double most[2] = {0, 0};
        for (int k = 0; k < 2; k++) {
            cloud->model.reconstructs = k;
            dissipate(cloud);
            for (size_t i = 0; i < particles_fluid(s); i++) {
                if (!cloud_inner(cloud, i)) continue;
                for (int d = 0; d < dim; d++) most[k] = fmax(most[k], fabs(s->a[d][i]));
            }
        }
        assert_true(most[0] > 1e-3);
        assert_less(most[1], 1e-9 * most[0]);
        cloud_free(cloud);
    }
}

static double power(const Cloud *cloud)
{
    const Particles *s = &cloud->s;
    double sum = 0;
    for (size_t i = 0; i < particles_fluid(s); i++)
        for (int d = 0; d < s->dim; d++) sum += s->m[i] * s->a[d][i] * s->v[d][i];
    return sum;
}

static void forces_are_opposite_and_dissipate_less(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = linear(dim, 500, cloud_two_fluids);
        Particles *s = &cloud->s;
        uint64_t seed = 5;
        double of[2];
        for (size_t i = 0; i < particles_fluid(s); i++)
            for (int d = 0; d < dim; d++) s->v[d][i] += 0.05 * cloud_noise(&seed);
        for (int k = 0; k < 2; k++) {
            cloud->model.reconstructs = k;
            dissipate(cloud);
            cloud_assert_no_force(cloud, 1e-12);
            of[k] = power(cloud);
        }
        assert_true(of[1] < 0 && of[1] > of[0]);
        cloud_free(cloud);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(strains_of_linear_flows_are_exact_in_each_fluid),
        cmocka_unit_test(neither_a_gas_nor_a_liquid_beside_one_has_any),
        cmocka_unit_test(a_linear_flow_is_not_dissipated),
        cmocka_unit_test(forces_are_opposite_and_dissipate_less),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
