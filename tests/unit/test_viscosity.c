/* SPDX-License-Identifier: BSD-3-Clause */
/* Viscous forces are the sums of P1 eq. 10, give the Laplacian of plane flows, conserve momentum between fluids, and
 * act on walls only where these do not let the fluid slip. Where viscosities are unlike, a second term adds the rest of the stress. */
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

static int layers(const double x[3])
{
    return x[1] < 0.45 ? CLOUD_WATER : CLOUD_AIR;
}

static Cloud *stirred(int dim, int (*owner)(const double x[3]))
{
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                           .dx = 0.1,
                                           .n = {9, 10, 7},
                                           .jitter = 0.25,
                                           .skin = 0.3,
                                           .periodic = {true, false, true},
                                           .owner = owner,
                                           .viscous = true});
    Particles *s = &cloud->s;
    uint64_t seed = 19;
    cloud_stir(cloud, 4);
    for (size_t i = particles_fluid(s); i < s->n; i++)
        for (int d = 0; d < dim; d++) {
            s->v[d][i] = cloud_noise(&seed);
            s->v_wall[d][i - particles_fluid(s)] = cloud_noise(&seed);
        }
    return cloud;
}

/* mu of a pair times V_i V_j F r^2 / (r^2 + 0.01 h^2), over m_i. */
static double weight(const Cloud *cloud, size_t i, size_t j, double mu)
{
    const Particles *s = &cloud->s;
    const CloudPair pair = cloud_pair(cloud, i, j);
    const double soft = 0.1 * cloud->model.kernel.h;
    return cloud_volume(cloud, i) * cloud_volume(cloud, j) / s->m[i] * mu * pair.F * pair.r * pair.r /
           (pair.r * pair.r + soft * soft);
}

static void forces_between_fluids_are_those_of_the_paper(void **state)
{
    (void)state;
    static const double mu_w = 3, mu_a = 0.5;
    const double mu[2][2] = {{2 * mu_w, 4 * mu_w * mu_a / (mu_w + mu_a)}, {4 * mu_w * mu_a / (mu_w + mu_a), 2 * mu_a}};
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = stirred(dim, tank);
        const Particles *s = &cloud->s;
        cloud_term(cloud, &viscosity);
        for (size_t i = 0; i < particles_fluid(s); i++)
            for (int d = 0; d < dim; d++) {
                double sum = 0, size = 0;
                for (size_t j = 0; j < particles_fluid(s); j++) {
                    if (j == i) continue;
                    const double term = weight(cloud, i, j, mu[s->phase[i]][s->phase[j]]) * (s->v[d][i] - s->v[d][j]);
                    sum += term;
                    size = fmax(size, fabs(term));
                }
                assert_close(s->a[d][i], sum, 1e-11 * size); /* rounding: v_i is taken out of the sum */
            }
        cloud_free(cloud);
    }
}

static void inviscid_fluids_do_not_drag_each_other(void **state)
{
    (void)state;
    Cloud *cloud = stirred(2, no_walls);
    Particles *s = &cloud->s;
    assert_true(viscosity.needed(&cloud->model));
    cloud->model.phase[1].mu = 0;
    cloud_term(cloud, &viscosity);
    for (size_t i = s->begin[GROUP_SUMMATION]; i < s->n; i++) assert_true(s->a[0][i] == 0);
    cloud->model.phase[0].mu = 0;
    cloud_term(cloud, &viscosity);
    for (size_t i = 0; i < s->n; i++) assert_true(s->a[0][i] == 0);
    cloud->model.viscous = false;
    assert_false(viscosity.needed(&cloud->model) || wall_friction.needed(&cloud->model));
    cloud_free(cloud);
}

static void total_force_between_fluids_is_zero(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = stirred(dim, no_walls);
        const Particles *s = &cloud->s;
        cloud_term(cloud, &viscosity);
        for (int d = 0; d < dim; d++) {
            double sum = 0, size = 0;
            for (size_t i = 0; i < s->n; i++) {
                sum += s->m[i] * s->a[d][i];
                size += s->m[i] * fabs(s->a[d][i]);
            }
            assert_close(sum, 0, 1e-12 * size); /* rounding */
        }
        cloud_free(cloud);
    }
}

/* Acceleration along x of the middle of a lattice where u(y) = slope y + bend y^2, in water, without its
 * neighbourhood's rim. */
static double middle(int dim, double smoothing, double slope, double bend)
{
    Cloud *cloud = cloud_new(&(CloudSetup){
        .dim = dim, .dx = 0.1, .n = {13, 14, 12}, .smoothing = smoothing, .viscous = true, .owner = NULL});
    Particles *s = &cloud->s;
    cloud->model.viscous_scale = viscosity_scale(&cloud->model.kernel, dim, cloud->model.cell);
    for (size_t i = 0; i < s->n; i++) s->v[0][i] = slope * s->x[1][i] + bend * s->x[1][i] * s->x[1][i];
    cloud_term(cloud, &viscosity);
    double a = NAN;
    for (size_t i = 0; i < s->n; i++)
        if (cloud_inner(cloud, i)) {
            if (!isnan(a)) assert_close(s->a[0][i], a, 1e-12); /* the same wherever we look */
            a = s->a[0][i];
            assert_true(s->a[1][i] == 0);
        }
    cloud_free(cloud);
    return a;
}

static void plane_flows_feel_the_laplacian(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        assert_close(middle(dim, 1.3, 4, 0), 0, 1e-13); /* Couette: rounding */
        /* Poiseuille: mu/rho u'' = 3/1000 * 2 bend, to rounding, as the sum is scaled to be exact on the lattice. */
        const double exact = 3e-3 * 2 * 5;
        assert_close(middle(dim, 1.3, 4, 5), exact, 1e-11 * exact);
        assert_close(middle(dim, 2, 4, 5), exact, 1e-11 * exact);
    }
}

/* Against the mirrored velocity 2 v_w - v~. */
static void walls_without_slip_show_the_mirrored_velocity(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = stirred(dim, tank);
        const Particles *s = &cloud->s;
        const size_t first = particles_fluid(s);
        cloud->model.wall[0].no_slip = true;
        cloud_term(cloud, &wall_friction);
        size_t touched = 0;
        for (size_t i = 0; i < first; i++)
            for (int d = 0; d < dim; d++) {
                double sum = 0, size = 0;
                for (size_t j = first; j < s->n; j++) {
                    const double mirrored = s->v_wall[d][j - first]; /* wall.c */
                    const double term =
                        weight(cloud, i, j, 2 * cloud->model.phase[s->phase[i]].mu) * (s->v[d][i] - mirrored);
                    sum += term;
                    size = fmax(size, fabs(term));
                }
                assert_close(s->a[d][i], sum, 1e-12 * size); /* rounding */
                touched += sum != 0;
            }
        assert_true(touched > 30);
        cloud_free(cloud);
    }
}

static void walls_with_slip_do_nothing(void **state)
{
    (void)state;
    Cloud *cloud = stirred(3, tank);
    cloud_term(cloud, &wall_friction);
    for (size_t i = 0; i < cloud->s.n; i++)
        for (int d = 0; d < 3; d++) assert_true(cloud->s.a[d][i] == 0);
    cloud_free(cloud);
}

/* Friction slows what moves past, and carries along what rests. */
static void friction_is_against_the_motion_relative_to_the_wall(void **state)
{
    (void)state;
    Cloud *cloud = stirred(2, tank);
    Particles *s = &cloud->s;
    const size_t first = particles_fluid(s);
    cloud->model.wall[0].no_slip = true;
    for (int k = 0; k < 2; k++) {
        const double fluid = k == 0 ? 1.5 : 0, wall = k == 0 ? 0 : 1.5;
        for (size_t i = 0; i < s->n; i++) s->v[0][i] = i < first ? fluid : wall;
        cloud_term(cloud, &wall_velocity);
        cloud_term(cloud, &wall_friction);
        for (size_t i = 0; i < first; i++) assert_true(k == 0 ? s->a[0][i] <= 0 : s->a[0][i] >= 0);
        double sum = 0;
        for (size_t i = 0; i < first; i++) sum += s->a[0][i];
        assert_true(fabs(sum) > 1e-3);
    }
    cloud_free(cloud);
}

/* Forces of two fluids that meet at y = 0.45 and move with dv_x/dy = shear, dv_y/dx = turn, dv_y/dy = -dv_x/dx = strain, per length of the
 * interface: what all of them add up to between their rims. */
static void force_of_interface(int dim, double jitter, double shear, double turn, double strain, double force[3])
{
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                           .dx = 0.05,
                                           .n = {18, 18, 12},
                                           .jitter = jitter,
                                           .smoothing = 1.3,
                                           .viscous = true,
                                           .owner = layers});
    Particles *s = &cloud->s;
    cloud->model.viscous_scale = viscosity_scale(&cloud->model.kernel, dim, cloud->model.cell);
    for (size_t i = 0; i < s->n; i++) {
        const double x = s->x[0][i] - 0.45, y = s->x[1][i] - 0.45;
        s->v[0][i] = shear * y - strain * x;
        s->v[1][i] = turn * x + strain * y;
    }
    const Term *const both[] = {&viscosity, &transposed_viscosity};
    for (int d = 0; d < 3; d++) force[d] = 0;
    for (int k = 0; k < 2; k++) {
        cloud_term(cloud, both[k]);
        for (size_t i = 0; i < s->n; i++) {
            if (fabs(s->x[0][i] - 0.45) > 0.2 || fabs(s->x[1][i] - 0.45) > 0.25) continue;
            if (dim == 3 && fabs(s->x[2][i] - 0.3) > 0.1) continue;
            for (int d = 0; d < dim; d++) force[d] += s->m[i] * s->a[d][i];
        }
    }
    const double area = dim == 3 ? 0.4 * 0.2 : 0.4;
    for (int d = 0; d < dim; d++) force[d] /= area;
    cloud_free(cloud);
}

/* The jump of the stress, (0.5 - 3) (dv_i/dx_j + dv_j/dx_i): on a lattice to rounding; in disorder v is linear and its Laplacian noise. */
static void unlike_fluids_have_the_whole_stress(void **state)
{
    (void)state;
    const double jump = 0.5 - 3;
    for (int dim = 2; dim <= 3; dim++)
        for (int disorder = 0; disorder < 2; disorder++) {
            const double jitter = disorder ? 0.1 : 0, within = disorder ? 0.06 * 5 : 1e-13 * 5;
            double force[3];
            force_of_interface(dim, jitter, -1, 1, 0, force); /* as a solid body */
            assert_close(force[0], 0, within);
            assert_close(force[1], 0, within);
            force_of_interface(dim, jitter, 0, 0, 1, force);
            assert_close(force[0], 0, within);
            assert_close(force[1], 2 * jump, within);
            force_of_interface(dim, jitter, 1, 1, 0, force);
            assert_close(force[0], 2 * jump, within);
            assert_close(force[1], 0, within);
        }
}

static void fluids_of_one_viscosity_need_no_more(void **state)
{
    (void)state;
    Cloud *cloud = stirred(2, no_walls);
    assert_true(transposed_viscosity.needed(&cloud->model));
    cloud->model.phase[1].mu = cloud->model.phase[0].mu;
    assert_false(transposed_viscosity.needed(&cloud->model));
    cloud_free(cloud);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(forces_between_fluids_are_those_of_the_paper),
        cmocka_unit_test(inviscid_fluids_do_not_drag_each_other),
        cmocka_unit_test(total_force_between_fluids_is_zero),
        cmocka_unit_test(plane_flows_feel_the_laplacian),
        cmocka_unit_test(walls_without_slip_show_the_mirrored_velocity),
        cmocka_unit_test(walls_with_slip_do_nothing),
        cmocka_unit_test(unlike_fluids_have_the_whole_stress),
        cmocka_unit_test(fluids_of_one_viscosity_need_no_more),
        cmocka_unit_test(friction_is_against_the_motion_relative_to_the_wall),
    };
    return cmocka_run_group_tests_name("viscosity", tests, NULL, NULL);
}
