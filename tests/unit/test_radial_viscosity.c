/* SPDX-License-Identifier: BSD-3-Clause */
/* Viscous forces along the line of a pair: they keep both momenta, leave a body that turns alone, and give the Laplacian of plane flows along the rows of
 * a lattice exactly and across them nearly. */
#include "sim/terms/terms.h"
#include "tests/support/check.h"
#include "tests/support/cloud.h"

static int tank(const double x[3])
{
    if (x[1] < 0.3) return CLOUD_WALL;
    return x[1] < 0.5 + 0.3 * x[0] ? CLOUD_WATER : CLOUD_AIR;
}

static int no_walls(const double x[3])
{
    return x[1] < 0.4 + 0.3 * x[0] ? CLOUD_WATER : CLOUD_AIR;
}

static Cloud *stirred(int dim, int (*owner)(const double x[3]), bool periodic)
{
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                           .dx = 0.1,
                                           .n = {9, 10, 7},
                                           .jitter = 0.25,
                                           .skin = 0.3,
                                           .periodic = {periodic, false, periodic},
                                           .flowing = true,
                                           .owner = owner,
                                           .viscous = true});
    Particles *s = &cloud->s;
    uint64_t seed = 19;
    cloud_stir(cloud, 4);
    cloud->model.radial = true;
    cloud->model.radial_scale = 97;
    for (size_t i = particles_fluid(s); i < s->n; i++)
        for (int d = 0; d < dim; d++) {
            s->v[d][i] = cloud_noise(&seed);
            s->v_wall[d][i - particles_fluid(s)] = cloud_noise(&seed);
        }
    return cloud;
}

/* What j does to i, which sees it at velocity v: the acceleration along x_ij. */
static double drag(const Cloud *cloud, size_t i, size_t j, double mu, const double v[3], double dx[3])
{
    const Particles *s = &cloud->s;
    const CloudPair pair = cloud_pair(cloud, i, j);
    double along = 0;
    for (int d = 0; d < s->dim; d++) {
        dx[d] = pair.dx[d];
        along += (s->v[d][i] - v[d]) * pair.dx[d];
    }
    return 97 * cloud_volume(cloud, i) * cloud_volume(cloud, j) / s->m[i] * 2 * mu * along * pair.F;
}

static void forces_between_fluids_are_those_of_the_sum(void **state)
{
    (void)state;
    static const double mu_w = 3, mu_a = 0.5;
    const double mu[2][2] = {{mu_w, 2 * mu_w * mu_a / (mu_w + mu_a)}, {2 * mu_w * mu_a / (mu_w + mu_a), mu_a}};
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = stirred(dim, tank, true);
        const Particles *s = &cloud->s;
        cloud_term(cloud, &radial_viscosity);
        for (size_t i = 0; i < particles_fluid(s); i++) {
            double a[3] = {0}, size = 0;
            for (size_t j = 0; j < particles_fluid(s); j++) {
                double v[3] = {0}, dx[3];
                if (j == i) continue;
                for (int d = 0; d < dim; d++) v[d] = s->v[d][j];
                const double c = drag(cloud, i, j, mu[s->phase[i]][s->phase[j]], v, dx);
                for (int d = 0; d < dim; d++) a[d] += c * dx[d];
                size = fmax(size, fabs(c) * cloud->model.kernel.support);
            }
            for (int d = 0; d < dim; d++) assert_close(s->a[d][i], a[d], 1e-12 * size); /* rounding */
        }
        cloud->model.phase[0].mu = cloud->model.phase[1].mu = 0;
        cloud_term(cloud, &radial_viscosity);
        for (size_t i = 0; i < s->n; i++) assert_true(s->a[0][i] == 0);
        cloud->model.viscous = false;
        assert_false(radial_viscosity.needed(&cloud->model) || radial_friction.needed(&cloud->model));
        cloud_free(cloud);
    }
}

static int pair_of[2];

static int two_points(const double x[3])
{
    return x[0] < 0.1 ? pair_of[0] : x[0] < 0.2 ? pair_of[1] : CLOUD_NOTHING;
}

/* Of any two volumes and viscosities. Along the line of the two, a force has no torque. */
static void forces_of_a_pair_are_opposite_to_the_last_bit_and_do_not_turn_it(void **state)
{
    (void)state;
    static const int kinds[3][2] = {{CLOUD_WATER, CLOUD_AIR}, {CLOUD_WATER, CLOUD_WATER}, {CLOUD_AIR, CLOUD_AIR}};
    for (int k = 0; k < 300; k++) {
        const int dim = 2 + k % 2;
        pair_of[0] = kinds[k % 3][0];
        pair_of[1] = kinds[k % 3][1];
        Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                               .dx = 0.1,
                                               .n = {3, 1, 1},
                                               .jitter = 0.3,
                                               .flowing = true,
                                               .owner = two_points,
                                               .viscous = true});
        Particles *s = &cloud->s;
        cloud_stir(cloud, (uint64_t)k);
        cloud->model.radial = true;
        cloud->model.radial_scale = 97;
        s->m[0] = s->m[1] = 1; /* unit masses: a is the force [N] */
        cloud_term(cloud, &radial_viscosity);
        const CloudPair pair = cloud_pair(cloud, 0, 1);
        const double f[3] = {s->a[0][0], s->a[1][0], dim == 3 ? s->a[2][0] : 0};
        assert_true(f[0] != 0);
        for (int d = 0; d < dim; d++) {
            const int e = (d + 1) % dim;
            assert_true(s->a[d][0] == -s->a[d][1]);
            assert_close(pair.dx[d] * f[e], pair.dx[e] * f[d], 1e-15 * pair.r * (fabs(f[d]) + fabs(f[e])));
        }
        cloud_free(cloud);
    }
}

static void momentum_and_angular_momentum_are_kept(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = stirred(dim, no_walls, false);
        const Particles *s = &cloud->s;
        cloud_term(cloud, &radial_viscosity);
        cloud_assert_no_force(cloud, 1e-13);
        for (int d = 0; d < dim; d++) {
            const int e = (d + 1) % dim;
            double sum = 0, size = 0;
            for (size_t i = 0; i < s->n; i++) {
                const double torque = s->m[i] * (s->x[d][i] * s->a[e][i] - s->x[e][i] * s->a[d][i]);
                sum += torque;
                size += fabs(torque);
            }
            assert_close(sum, 0, 1e-13 * size);
        }
        cloud_free(cloud);
    }
}

static void a_body_that_moves_and_turns_is_left_alone(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = stirred(dim, no_walls, false);
        Particles *s = &cloud->s;
        const double w[3] = {dim == 3 ? 0.3 : 0, dim == 3 ? -0.8 : 0, 2};
        for (size_t i = 0; i < s->n; i++) {
            const double x = s->x[0][i], y = s->x[1][i], z = dim == 3 ? s->x[2][i] : 0;
            s->v[0][i] = 5 + w[1] * z - w[2] * y;
            s->v[1][i] = -3 + w[2] * x - w[0] * z;
            if (dim == 3) s->v[2][i] = 1 + w[0] * y - w[1] * x;
        }
        cloud_term(cloud, &radial_viscosity);
        /* Rounding of velocities of 5, times mu/(rho dx^2) of air, 50, and some more neighbours. */
        for (size_t i = 0; i < s->n; i++)
            for (int d = 0; d < dim; d++) assert_close(s->a[d][i], 0, 1e-12);
        cloud_free(cloud);
    }
}

/* Acceleration along the flow in the middle of a lattice, where the velocity is slope y + bend y^2 along x, or the same turned by 45
 * degrees; over the exact one, if there is a bend. */
static double middle(int dim, MnsKernel kernel, double smoothing, double slope, double bend, bool turned)
{
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                           .dx = 0.1,
                                           .n = {13, 14, 13},
                                           .kernel = kernel,
                                           .smoothing = smoothing,
                                           .viscous = true,
                                           .flowing = true,
                                           .calibrated = true});
    Particles *s = &cloud->s;
    const double c = turned ? sqrt(0.5) : 1, q = turned ? sqrt(0.5) : 0;
    cloud->model.radial = true;
    cloud->model.radial_scale = radial_viscosity_scale(&cloud->model.kernel, dim, cloud->model.cell);
    for (size_t i = 0; i < s->n; i++) {
        const double y = c * s->x[1][i] - q * s->x[0][i], u = slope * y + bend * y * y;
        s->v[0][i] = c * u;
        s->v[1][i] = q * u;
    }
    cloud_term(cloud, &radial_viscosity);
    double a = NAN;
    for (size_t i = 0; i < s->n; i++)
        if (cloud_inner(cloud, i)) {
            const double along = c * s->a[0][i] + q * s->a[1][i];
            if (!isnan(a)) assert_close(along, a, 1e-12); /* the same wherever we look */
            a = along;
            assert_close(c * s->a[1][i] - q * s->a[0][i], 0, 1e-12);
        }
    cloud_free(cloud);
    return bend == 0 ? a : a / (3e-3 * 2 * bend); /* mu/rho u'' */
}

/* Along the rows to rounding. Across them, where a lattice has another sum of fourth moments, by what it is off for a smooth kernel: what to expect of the
 * first steps of an oblique flow, before particles are mixed. */
static void plane_flows_feel_the_laplacian(void **state)
{
    (void)state;
    static const struct {
        MnsKernel kernel;
        double smoothing, diagonals[2];
    } list[] = {{MNS_WENDLAND_C2, 1.3, {1.0253, 0.9874}},
                {MNS_WENDLAND_C2, 1.6, {1.0063, 1.0184}},
                {MNS_WENDLAND_C2, 2.0, {1.0133, 1.0092}},
                {MNS_TRUNCATED_GAUSSIAN, 1.1, {1.0070, 1.0032}},
                {MNS_QUINTIC_SPLINE, 1.3, {1.0019, 1.0002}}};
    for (int dim = 2; dim <= 3; dim++) {
        assert_close(middle(dim, MNS_WENDLAND_C2, 1.6, 4, 0, false), 0, 1e-13); /* Couette: rounding */
        for (size_t k = 0; k < sizeof list / sizeof *list; k++) {
            const double rows = middle(dim, list[k].kernel, list[k].smoothing, 4, 5, false);
            const double diagonals = middle(dim, list[k].kernel, list[k].smoothing, 4, 5, true);
            assert_close(rows, 1, 1e-11);
            assert_close(diagonals, list[k].diagonals[dim - 2], 5e-5); /* half of the last digit given */
        }
    }
}

/* Against the mirrored velocity, with the fluid's own viscosity, where walls let nothing slip. */
static void walls_without_slip_show_the_mirrored_velocity(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = stirred(dim, tank, true);
        const Particles *s = &cloud->s;
        const size_t first = particles_fluid(s);
        cloud_term(cloud, &radial_friction);
        for (size_t i = 0; i < s->n; i++) assert_true(s->a[0][i] == 0);
        cloud->model.wall[0].no_slip = true;
        cloud_term(cloud, &radial_friction);
        size_t touched = 0;
        for (size_t i = 0; i < first; i++) {
            double a[3] = {0}, size = 0;
            for (size_t j = first; j < s->n; j++) {
                double v[3] = {0}, dx[3];
                for (int d = 0; d < dim; d++) v[d] = s->v_wall[d][j - first];
                const double c = drag(cloud, i, j, cloud->model.phase[s->phase[i]].mu, v, dx);
                for (int d = 0; d < dim; d++) a[d] += c * dx[d];
                size = fmax(size, fabs(c) * cloud->model.kernel.support);
            }
            for (int d = 0; d < dim; d++) assert_close(s->a[d][i], a[d], 1e-12 * size); /* rounding */
            touched += size > 0;
        }
        assert_true(touched > 15);
        cloud_free(cloud);
    }
}

static void walls_with_slip_do_nothing(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = stirred(dim, tank, true);
        cloud_term(cloud, &radial_friction);
        for (size_t i = 0; i < cloud->s.n; i++)
            for (int d = 0; d < dim; d++) assert_true(cloud->s.a[d][i] == 0);
        cloud_free(cloud);
    }
}

/* Friction slows what moves past, and carries along what rests. */
static void friction_is_against_the_motion_relative_to_the_wall(void **state)
{
    (void)state;
    Cloud *cloud = stirred(2, tank, true);
    Particles *s = &cloud->s;
    const size_t first = particles_fluid(s);
    cloud->model.wall[0].no_slip = true;
    for (int k = 0; k < 2; k++) {
        for (size_t i = 0; i < s->n; i++) {
            s->v[0][i] = (i < first) == (k == 0) ? 1.5 : 0;
            s->v[1][i] = 0;
        }
        cloud_term(cloud, &mirrored_velocity);
        cloud_term(cloud, &radial_friction);
        double sum = 0;
        for (size_t i = 0; i < first; i++) sum += s->m[i] * s->a[0][i];
        assert_true(k == 0 ? sum < -1e-3 : sum > 1e-3);
    }
    cloud_free(cloud);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(forces_between_fluids_are_those_of_the_sum),
        cmocka_unit_test(forces_of_a_pair_are_opposite_to_the_last_bit_and_do_not_turn_it),
        cmocka_unit_test(momentum_and_angular_momentum_are_kept),
        cmocka_unit_test(a_body_that_moves_and_turns_is_left_alone),
        cmocka_unit_test(plane_flows_feel_the_laplacian),
        cmocka_unit_test(walls_without_slip_show_the_mirrored_velocity),
        cmocka_unit_test(walls_with_slip_do_nothing),
        cmocka_unit_test(friction_is_against_the_motion_relative_to_the_wall),
    };
    return cmocka_run_group_tests_name("radial viscosity", tests, NULL, NULL);
}
