/* SPDX-License-Identifier: BSD-3-Clause */
/* What walls show to fluids: a pressure that is exact for each fluid's own hydrostatic field, also in an accelerated
 * tank, and the mean velocity of the fluid around. */
#include "sim/terms/terms.h"
#include "tests/support/check.h"
#include "tests/support/cloud.h"

/* A floor and a left side; water, with air above. */
static int tank(const double x[3])
{
    if (x[1] < 0.3 || x[0] < 0.25) return CLOUD_WALL;
    return x[1] < 0.45 + 0.3 * x[0] ? CLOUD_WATER : CLOUD_AIR;
}

static Cloud *tank_cloud(int dim)
{
    return cloud_new(&(CloudSetup){
        .dim = dim, .dx = 0.1, .n = {10, 11, 7}, .jitter = 0.2, .skin = 0.3, .owner = tank, .viscous = true});
}

/* Weight of the fluid around wall particle i, of one phase or of all (-1). */
static double weight_at(const Cloud *cloud, size_t i, int phase)
{
    double sum = 0;
    for (size_t j = 0; j < particles_fluid(&cloud->s); j++)
        if (phase < 0 || cloud->s.phase[j] == phase) sum += cloud_pair(cloud, i, j).W * cloud->s.vol[j];
    return sum;
}

/* p = p0 + rho0 (g - a_w) . x in each fluid, each with its own p0: what the wall shows must be the same formula, at
 * its place. */
static void pressure_of_each_fluid_is_exact_for_its_own_hydrostatic_field(void **state)
{
    (void)state;
    static const double accelerations[2][3] = {{0, 0, 0}, {1.5, -2, 0.7}};
    for (int dim = 2; dim <= 3; dim++)
        for (int k = 0; k < 2; k++) {
            Cloud *cloud = tank_cloud(dim);
            Particles *s = &cloud->s;
            const double g[3] = {0.5, -9.81, 2}, p0[2] = {4000, -3};
            for (int d = 0; d < dim; d++) {
                cloud->model.gravity[d] = g[d];
                cloud->model.wall[0].a[d] = accelerations[k][d];
            }
            for (size_t i = 0; i < particles_fluid(s); i++) {
                s->p[i] = p0[s->phase[i]];
                for (int d = 0; d < dim; d++) s->p[i] += s->rho[i] * (g[d] - accelerations[k][d]) * s->x[d][i];
                s->vol[i] *= 1 + 0.1 * s->x[0][i]; /* weights do not matter */
            }
            cloud_term(cloud, &wall_pressure);
            size_t seen[2] = {0};
            for (size_t i = particles_fluid(s); i < s->n; i++)
                for (int a = 0; a < 2; a++) {
                    const double rho0 = cloud->model.phase[a].rho0, shown = s->p_wall[a][i - particles_fluid(s)];
                    double expected = p0[a];
                    for (int d = 0; d < dim; d++) expected += rho0 * (g[d] - accelerations[k][d]) * s->x[d][i];
                    const double weight = weight_at(cloud, i, a);
                    if (weight < 1e-12) {
                        assert_true(weight > 0 || shown == 0);
                        continue;
                    }
                    seen[a]++;
                    assert_close(shown, expected, 1e-9 * rho0); /* rounding, for heights up to 1 and g up to 10 */
                }
            assert_true(seen[0] > 20 && seen[1] > 5);
            cloud_free(cloud);
        }
}

/* With densities that differ from particle to particle, the sum as written. */
static void pressure_is_the_weighted_sum_of_adami(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = tank_cloud(dim);
        Particles *s = &cloud->s;
        const size_t first = particles_fluid(s);
        cloud_stir(cloud, 2);
        for (int d = 0; d < dim; d++) {
            cloud->model.gravity[d] = -3 + 4 * d;
            cloud->model.wall[0].a[d] = 0.5 - d;
        }
        cloud_term(cloud, &wall_pressure);
        for (size_t i = first; i < s->n; i++) {
            double all = 0, all_weight = 0;
            for (int a = 0; a < 2; a++) {
                double sum = 0, weight = 0;
                for (size_t j = 0; j < first; j++) {
                    const CloudPair pair = cloud_pair(cloud, i, j);
                    if (s->phase[j] != a) continue;
                    const double w = pair.W * s->vol[j];
                    weight += w;
                    sum += w * s->p[j];
                    for (int d = 0; d < dim; d++)
                        sum += w * s->rho[j] * (cloud->model.gravity[d] - cloud->model.wall[0].a[d]) * pair.dx[d];
                }
                all += sum;
                all_weight += weight;
                const double rho0 = cloud->model.phase[a].rho0;
                if (weight > 1e-9) assert_close(s->p_wall[a][i - first], sum / weight, 1e-9 * rho0);
                if (weight == 0) assert_true(s->p_wall[a][i - first] == 0);
            }
            /* The mean of all is for pictures. */
            if (all_weight > 1e-9) assert_close(s->p[i], all / all_weight, 1e-6);
            if (all_weight == 0) assert_true(s->p[i] == 0);
        }
        cloud_free(cloud);
    }
}

static void fluids_pressures_do_not_mix_in_a_wall(void **state)
{
    (void)state;
    Cloud *cloud = tank_cloud(2);
    Particles *s = &cloud->s;
    const size_t first = particles_fluid(s);
    for (size_t i = 0; i < first; i++) s->p[i] = s->phase[i] == 0 ? 5e4 : 2;
    cloud_term(cloud, &wall_pressure);
    size_t both = 0;
    for (size_t i = first; i < s->n; i++) {
        if (weight_at(cloud, i, 0) < 1e-9 || weight_at(cloud, i, 1) < 1e-9) continue;
        both++;
        assert_close(s->p_wall[0][i - first], 5e4, 1e-9); /* rounding */
        assert_close(s->p_wall[1][i - first], 2, 1e-13);
    }
    assert_true(both > 3); /* at the triple point */
    cloud_free(cloud);
}

static void velocity_in_a_wall_is_the_mean_of_the_fluid_around(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = tank_cloud(dim);
        Particles *s = &cloud->s;
        const size_t first = particles_fluid(s);
        cloud_stir(cloud, 6);
        for (size_t i = first; i < s->n; i++)
            for (int d = 0; d < dim; d++) s->v[d][i] = 0.25 + d;
        cloud_term(cloud, &wall_velocity);
        size_t seen = 0;
        for (size_t i = first; i < s->n; i++) {
            const double weight = weight_at(cloud, i, -1);
            for (int d = 0; d < dim; d++) {
                double sum = 0;
                for (size_t j = 0; j < first; j++) sum += cloud_pair(cloud, i, j).W * s->vol[j] * s->v[d][j];
                /* Rounding of speeds up to 2; far from any fluid the wall's own. */
                if (weight > 1e-9) assert_close(s->v_wall[d][i - first], sum / weight, 1e-11);
                if (weight == 0) assert_true(s->v_wall[d][i - first] == 0.25 + d);
            }
            seen += weight > 1e-9;
        }
        assert_true(seen > 20);
        cloud_free(cloud);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pressure_of_each_fluid_is_exact_for_its_own_hydrostatic_field),
        cmocka_unit_test(pressure_is_the_weighted_sum_of_adami),
        cmocka_unit_test(fluids_pressures_do_not_mix_in_a_wall),
        cmocka_unit_test(velocity_in_a_wall_is_the_mean_of_the_fluid_around),
    };
    return cmocka_run_group_tests_name("wall", tests, NULL, NULL);
}
