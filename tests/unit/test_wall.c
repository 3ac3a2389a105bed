/* SPDX-License-Identifier: BSD-3-Clause */
/* What walls show to fluids: a pressure that is exact for the hydrostatic field of the fluid that is there, also in an accelerated
 * tank, and the mean velocity of the fluid around. */
#include "sim/terms/terms.h"
#include "tests/support/check.h"
#include "tests/support/cloud.h"
#include <math.h>

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
        if (phase < 0 || cloud->s.phase[j] == phase) sum += cloud_pair(cloud, i, j).W * cloud_volume(cloud, j);
    return sum;
}

/* sum_b q_ab p_b / sum_b q_ab of two, q_ab = s_b^4 min(1, rho_a/rho_b); a fluid that is not there has no p. */
static double passing(const Cloud *cloud, int a, const double share[2], const double p[2])
{
    double up = 0, down = 0;
    for (int b = 0; b < 2; b++) {
        const double q = pow(share[b], 4) * fmin(1, cloud->model.phase[a].rho0 / cloud->model.phase[b].rho0);
        up += q > 0 ? q * p[b] : 0;
        down += q;
    }
    const Phase *own = &cloud->model.phase[a]; /* whose density is 0.1 to 10 times that of reference */
    return fmin(fmax(up / down, -0.9 * own->rho0 * own->c * own->c), 9 * own->rho0 * own->c * own->c);
}

/* p = p0 + rho0 (g - a_w) . x in each fluid, each with its own p0: what the wall shows is the same formula at its place, of the fluids
 * that are there. */
static void pressure_is_exact_for_hydrostatic_fields(void **state)
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
                s->m[i] *= 1 + 0.1 * s->x[0][i]; /* weights do not matter */
            }
            cloud_term(cloud, &wall_pressure);
            size_t of_one[2] = {0}, of_both = 0;
            for (size_t i = particles_fluid(s); i < s->n; i++) {
                double there[2], share[2];
                for (int a = 0; a < 2; a++) {
                    there[a] = p0[a];
                    share[a] = weight_at(cloud, i, a);
                    for (int d = 0; d < dim; d++)
                        there[a] += cloud->model.phase[a].rho0 * (g[d] - accelerations[k][d]) * s->x[d][i];
                }
                of_both += share[0] > 0 && share[1] > 0;
                for (int a = 0; a < 2; a++) {
                    const double shown = s->p_wall[a][i - particles_fluid(s)];
                    if (share[0] + share[1] == 0) assert_true(shown == 0);
                    if (share[0] + share[1] < 1e-9) continue;
                    of_one[a] += share[1 - a] == 0;
                    /* Rounding, for heights up to 1 and g up to 10. */
                    assert_close(shown, passing(cloud, a, share, there), 1e-6);
                }
            }
            assert_true(of_one[0] > 10 && of_one[1] > 5 && of_both > 5);
            cloud_free(cloud);
        }
}

/* The density of what is there, between those of fluids that share it, by the fourth powers of how much there is. */
static void density_is_that_of_the_fluids_around(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = tank_cloud(dim);
        Particles *s = &cloud->s;
        size_t of_one[2] = {0}, of_both = 0, of_none = 0;
        cloud_term(cloud, &wall_density);
        for (size_t i = particles_fluid(s); i < s->n; i++) {
            double share[2] = {0};
            for (size_t j = 0; j < particles_fluid(s); j++) share[s->phase[j]] += cloud_pair(cloud, i, j).W;
            const double q[2] = {pow(share[0], 4), pow(share[1], 4)};
            const double rho =
                q[0] + q[1] > 0
                    ? (q[0] * cloud->model.phase[0].rho0 + q[1] * cloud->model.phase[1].rho0) / (q[0] + q[1])
                    : cloud->model.rho_min;
            assert_close(s->rho[i], rho, 1e-9 * rho); /* rounding, of fourth powers */
            of_none += q[0] + q[1] == 0;
            of_both += share[0] > 0 && share[1] > 0;
            for (int a = 0; a < 2; a++) of_one[a] += share[a] > 0 && share[1 - a] == 0;
        }
        assert_true(of_one[0] > 10 && of_one[1] > 5 && of_both > 5 && of_none > 0);
        cloud_free(cloud);
    }
}

/* With densities that differ from particle to particle, the sums as written. */
static void pressure_is_the_weighted_sum_of_adami_in_each_fluid(void **state)
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
            double mean[2] = {0}, share[2] = {0};
            for (int a = 0; a < 2; a++) {
                for (size_t j = 0; j < first; j++) {
                    const CloudPair pair = cloud_pair(cloud, i, j);
                    if (s->phase[j] != a) continue;
                    const double w = pair.W * cloud_volume(cloud, j);
                    share[a] += w;
                    mean[a] += w * s->p[j];
                    for (int d = 0; d < dim; d++)
                        mean[a] += w * s->rho[j] * (cloud->model.gravity[d] - cloud->model.wall[0].a[d]) * pair.dx[d];
                }
                mean[a] /= share[a];
            }
            /* Pictures show the mean of all. */
            const double of_all = (share[0] > 0 ? share[0] * mean[0] : 0) + (share[1] > 0 ? share[1] * mean[1] : 0);
            if (share[0] + share[1] > 1e-9) assert_close(s->p[i], of_all / (share[0] + share[1]), 1e-6);
            for (int a = 0; a < 2; a++) {
                if (share[0] + share[1] > 1e-9)
                    assert_close(s->p_wall[a][i - first], passing(cloud, a, share, mean), 1e-6);
                if (share[0] + share[1] == 0) assert_true(s->p_wall[a][i - first] == 0);
            }
        }
        cloud_free(cloud);
    }
}

/* Water, of which it has nine times as much as of air, a wall particle shows to water within 2e-4 of the difference, and air to air even
 * where there is as much water: a thousandth of what differs would move it as all of that moves the water. */
static void fluids_pressures_mix_in_a_wall_only_where_both_are(void **state)
{
    (void)state;
    Cloud *cloud = tank_cloud(2);
    Particles *s = &cloud->s;
    const double of[2] = {5e4, 2};
    size_t nearly = 0, equally = 0, beyond = 0;
    for (size_t i = 0; i < particles_fluid(s); i++) s->p[i] = of[s->phase[i]];
    cloud_term(cloud, &wall_pressure);
    for (size_t i = particles_fluid(s); i < s->n; i++) {
        const double water = weight_at(cloud, i, 0), air = weight_at(cloud, i, 1);
        const double *const shown[2] = {&s->p_wall[0][i - particles_fluid(s)], &s->p_wall[1][i - particles_fluid(s)]};
        if (water < 1e-9 || air < 1e-9) continue;
        for (int a = 0; a < 2; a++) assert_true(*shown[a] >= of[1] && *shown[a] <= of[0]);
        if (water > 50 * air) {
            beyond++;
            assert_close(*shown[1], 9 * 400, 1e-9); /* all that air bears, ten times as dense */
        }
        if (water > 9 * air) {
            nearly++;
            assert_close(*shown[0], of[0], 2e-4 * (of[0] - of[1]));
        }
        if (water < air) {
            equally++;
            assert_close(*shown[1], of[1], 1e-3 * (of[0] - of[1]));
        }
    }
    assert_true(nearly > 0 && equally > 1 && beyond > 0);
    cloud_free(cloud);
}

/* Two fluids whose pressures differ by what the curvature of their interface asks for: a wall that sees both shows each its own pressure, and where it has
 * one for both, that lacks the difference between them; also where the curvature of one alone is known. */
static void walls_show_pressures_as_they_are_seen_across_an_interface(void **state)
{
    (void)state;
    static const double of[2] = {9, 2};
    for (int dim = 2; dim <= 3; dim++)
        for (unsigned knows = 0; knows < 3; knows++) {
            Cloud *cloud = tank_cloud(dim);
            Particles *s = &cloud->s;
            const size_t first = particles_fluid(s);
            const double kappa = (of[0] - of[1]) / cloud->model.tension[0][1];
            size_t both = 0;
            for (size_t i = 0; i < first; i++) {
                s->p[i] = of[s->phase[i]];
                s->curvature[i] = s->phase[i] == knows ? 0 : s->phase[i] == 0 ? kappa : -kappa;
            }
            cloud_term(cloud, &wall_pressure);
            for (size_t i = first; i < s->n; i++)
                for (unsigned a = 0; a < 2; a++)
                    if (weight_at(cloud, i, (int)a) > 1e-9) assert_close(s->p_wall[a][i - first], of[a], 1e-12);
            cloud_term(cloud, &wall_jump);
            for (size_t i = first; i < s->n; i++) {
                const bool sees_both = weight_at(cloud, i, 0) > 1e-9 && weight_at(cloud, i, 1) > 1e-9;
                const double between = s->p_wall[0][i - first] - s->p_wall[1][i - first];
                both += sees_both;
                if (sees_both) assert_close(between, of[0] - of[1], 1e-12);
                else assert_true(s->p_wall[0][i - first] == 0 || weight_at(cloud, i, 0) < 1e-9);
            }
            assert_true(both > 5);
            cloud_free(cloud);
        }
}

/* Two layers of densities 1 and 3 at rest, where no particle of the lattice is anybody else's: what is left of x is a wall, or fluid. */
static int layers(const double x[3])
{
    return x[1] < 0.6 ? CLOUD_WATER : CLOUD_AIR;
}

static int layers_beside_a_wall(const double x[3])
{
    return x[0] < 0.5 ? CLOUD_WALL : layers(x);
}

static Cloud *layered(int (*owner)(const double x[3]))
{
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = 2, .dx = 0.1, .n = {12, 12}, .flowing = true, .owner = owner});
    Particles *s = &cloud->s;
    const double g = -9.81, rho[2] = {1, 3};
    cloud->model.gravity[1] = g;
    cloud->model.repulsion = 0;
    for (unsigned a = 0; a < 2; a++) cloud_weigh(cloud, a, rho[a]);
    for (size_t i = 0; i < particles_fluid(s); i++) s->p[i] = 50 + rho[s->phase[i]] * g * (s->x[1][i] - 0.6);
    particles_changed(s, ON_ALL, ALL_FIELDS);
    cloud_term(cloud, &wall_pressure);
    cloud_term(cloud, &pressure_force);
    return cloud;
}

/* What the heavy fluid does to the light one along a wall that is a plane of symmetry, it does without the wall too. With a pressure for each
 * fluid of its own half of that would be missing, whatever the spacing: 0.5 of (rho_2 - rho_1) g / 2 rho_1. */
static void fluids_push_each_other_along_a_wall_as_they_do_without(void **state)
{
    (void)state;
    Cloud *with = layered(layers_beside_a_wall), *without = layered(layers);
    size_t seen = 0, compared = 0;
    for (size_t i = 0; i < particles_fluid(&with->s); i++) {
        const double x = with->s.x[0][i], y = with->s.x[1][i];
        if (x > 0.6 || fabs(y - 0.6) > 0.1) continue; /* beside the wall and the interface */
        seen++;
        for (size_t j = 0; j < without->s.n; j++) {
            if (fabs(without->s.x[0][j] - x) > 1e-9 || fabs(without->s.x[1][j] - y) > 1e-9) continue;
            compared++;
            assert_close(with->s.a[1][i], without->s.a[1][j], 0.1 * 9.81 / with->s.rho[i]);
        }
    }
    assert_true(seen == 2 && compared == 2);
    cloud_free(with);
    cloud_free(without);
}

static void velocity_in_a_wall_makes_the_mean_on_it_that_of_the_wall(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = tank_cloud(dim);
        Particles *s = &cloud->s;
        const size_t first = particles_fluid(s);
        cloud_stir(cloud, 6);
        for (size_t i = first; i < s->n; i++)
            for (int d = 0; d < dim; d++) {
                s->v[d][i] = 0.25 + d;
                s->belt[d][i - first] = 0.5; /* its surface is faster than the wall */
            }
        cloud_term(cloud, &wall_velocity);
        size_t seen = 0;
        for (size_t i = first; i < s->n; i++) {
            const double weight = weight_at(cloud, i, -1);
            for (int d = 0; d < dim; d++) {
                double sum = 0;
                for (size_t j = 0; j < first; j++)
                    sum += cloud_pair(cloud, i, j).W * cloud_volume(cloud, j) * s->v[d][j];
                /* Rounding of speeds up to 4; far from any fluid the surface's own. */
                if (weight > 1e-9) assert_close(s->v_wall[d][i - first], 2 * (0.75 + d) - sum / weight, 1e-11);
                if (weight == 0) assert_true(s->v_wall[d][i - first] == 0.75 + d);
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
        cmocka_unit_test(pressure_is_exact_for_hydrostatic_fields),
        cmocka_unit_test(density_is_that_of_the_fluids_around),
        cmocka_unit_test(pressure_is_the_weighted_sum_of_adami_in_each_fluid),
        cmocka_unit_test(fluids_pressures_mix_in_a_wall_only_where_both_are),
        cmocka_unit_test(walls_show_pressures_as_they_are_seen_across_an_interface),
        cmocka_unit_test(fluids_push_each_other_along_a_wall_as_they_do_without),
        cmocka_unit_test(velocity_in_a_wall_makes_the_mean_on_it_that_of_the_wall),
    };
    return cmocka_run_group_tests_name("wall", tests, NULL, NULL);
}
