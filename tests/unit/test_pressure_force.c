/* SPDX-License-Identifier: BSD-3-Clause */
/* Pressure forces are those of P1 eq. 9 and P2 eq. 24, opposite for the two of a pair to the last bit, minus the gradient over the
 * density where pressure is linear, and repel unlike fluids whatever the sign of the pressure. P2's does the work that its continuity
 * stores. A gas under P1 is not pulled by what is the same everywhere. */
#include "sim/terms/terms.h"
#include "tests/support/check.h"
#include "tests/support/cloud.h"
#include <stdlib.h>

static const Term *const TERMS[] = {&pressure_force, &volume_pressure_force};

static int tank(const double x[3])
{
    if (x[1] < 0.3 || x[0] < 0.25) return CLOUD_WALL;
    return x[1] < 0.55 + 0.2 * x[0] ? CLOUD_WATER : CLOUD_AIR;
}

static int no_walls(const double x[3])
{
    return x[1] < 0.4 + 0.2 * x[0] ? CLOUD_WATER : CLOUD_AIR;
}

static Cloud *stirred(int dim, int (*owner)(const double x[3]))
{
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                           .dx = 0.1,
                                           .n = {9, 10, 7},
                                           .jitter = 0.2,
                                           .skin = 0.3,
                                           .periodic = {false, false, true},
                                           .flowing = true,
                                           .owner = owner});
    Particles *s = &cloud->s;
    uint64_t seed = 3;
    cloud_stir(cloud, 9);
    for (size_t i = 0; i < particles_fluid(s); i++) s->shepard[i] = 1 + 0.3 * cloud_noise(&seed);
    for (size_t i = particles_fluid(s); i < s->n; i++)
        for (int a = 0; a < 2; a++) s->p_wall[a][i - particles_fluid(s)] = (a == 0 ? 3e4 : 30) * cloud_noise(&seed);
    return cloud;
}

/* The force of j on i along x_ij, over F. Walls show a pressure and a sum of W V of 1, and average plainly. */
static double push(const Cloud *cloud, size_t i, size_t j, bool squares)
{
    const Particles *s = &cloud->s;
    const Model *model = &cloud->model;
    const bool wall = j >= particles_fluid(s);
    double P_i = s->p[i] / s->shepard[i], P_j = 0;
    if (wall) P_j = s->p_wall[s->phase[i]][j - particles_fluid(s)];
    else P_j = s->p[j] / s->shepard[j];
    const double beta = !wall && s->phase[i] != s->phase[j] ? model->repulsion : 0;
    const double repel_i = beta * fabs(P_i), repel_j = beta * fabs(P_j);
    if (!wall && model->density_average > 0) {
        P_i *= 2 * cloud_impedance(cloud, j) / (cloud_impedance(cloud, i) + cloud_impedance(cloud, j));
        P_j *= 2 * cloud_impedance(cloud, i) / (cloud_impedance(cloud, i) + cloud_impedance(cloud, j));
    }
    if (squares)
        return -cloud_volume(cloud, i) * cloud_volume(cloud, i) * (P_i + repel_i) -
               cloud_volume(cloud, j) * cloud_volume(cloud, j) * (P_j + repel_j);
    return -cloud_volume(cloud, i) * cloud_volume(cloud, j) * (P_i + repel_i + P_j + repel_j);
}

static void forces_are_those_of_the_papers_among_fluids_and_walls(void **state)
{
    (void)state;
    for (int way = 0; way < 16; way++) {
        const int dim = way & 1 ? 3 : 2, k = way >> 1 & 1;
        Cloud *cloud = stirred(dim, tank);
        const Particles *s = &cloud->s;
        cloud->model.density_average = way >> 2 & 1;
        if (way >> 3 & 1) cloud->model.repulsion = 0;
        cloud_term(cloud, TERMS[k]);
        for (size_t i = 0; i < particles_fluid(s); i++) {
            double a[3] = {0}, size = 0;
            for (size_t j = 0; j < s->n; j++) {
                if (j == i) continue;
                const CloudPair pair = cloud_pair(cloud, i, j);
                const double c = push(cloud, i, j, k == 1) * pair.F / s->m[i];
                for (int d = 0; d < dim; d++) a[d] += c * pair.dx[d];
                size = fmax(size, fabs(c) * pair.r);
            }
            for (int d = 0; d < dim; d++) assert_close(s->a[d][i], a[d], 1e-12 * size); /* rounding */
        }
        for (size_t i = particles_fluid(s); i < s->n; i++) assert_true(s->a[0][i] == 0);
        cloud_free(cloud);
    }
}

static int pair_of[2];

static int two_points(const double x[3])
{
    return x[0] < 0.1 ? pair_of[0] : x[0] < 0.2 ? pair_of[1] : CLOUD_NOTHING;
}

static Cloud *two(int dim, int first, int second, double jitter)
{
    pair_of[0] = first;
    pair_of[1] = second;
    return cloud_new(
        &(CloudSetup){.dim = dim, .dx = 0.1, .n = {3, 1, 1}, .jitter = jitter, .flowing = true, .owner = two_points});
}

/* m_i a_i = -m_j a_j, exactly, with repulsion, either average and pressures of either sign, even across a density jump of 1000. */
static void forces_of_a_pair_are_equal_and_opposite_to_the_last_bit(void **state)
{
    (void)state;
    static const int kinds[3][2] = {{CLOUD_WATER, CLOUD_AIR}, {CLOUD_WATER, CLOUD_WATER}, {CLOUD_AIR, CLOUD_AIR}};
    uint64_t seed = 77;
    int signs[2] = {0, 0};
    for (int k = 0; k < 600; k++) {
        const int dim = 2 + k % 2;
        Cloud *cloud = two(dim, kinds[k % 3][0], kinds[k % 3][1], 0.3);
        Particles *s = &cloud->s;
        cloud_stir(cloud, (uint64_t)k);
        for (int q = 0; q < 2; q++) s->shepard[q] = 1 + 0.4 * cloud_noise(&seed);
        s->m[0] = s->m[1] = 1; /* unit masses: a is the force [N] */
        cloud->model.density_average = k / 6 % 2;
        cloud_term(cloud, TERMS[k / 12 % 2]);
        assert_true(s->a[0][0] != 0);
        for (int d = 0; d < dim; d++) assert_true(s->a[d][0] == -s->a[d][1]);
        signs[s->p[0] * s->p[1] > 0]++;
        cloud_free(cloud);
    }
    assert_true(signs[0] > 50 && signs[1] > 50);
}

static void total_force_is_zero_to_rounding(void **state)
{
    (void)state;
    for (int way = 0; way < 8; way++) {
        Cloud *cloud = stirred(way & 1 ? 3 : 2, no_walls);
        cloud->model.density_average = way >> 1 & 1;
        cloud_term(cloud, TERMS[way >> 2]);
        cloud_assert_no_force(cloud, 1e-13);
        cloud_free(cloud);
    }
}

/* What repulsion adds pushes apart for any sign of the pressures, and is not there within a fluid. */
static void unlike_fluids_repel_each_other_at_any_pressure(void **state)
{
    (void)state;
    static const double pressures[4][2] = {{500, 800}, {-500, -800}, {500, -800}, {-500, 800}};
    for (int way = 0; way < 32; way++) {
        const int dim = way & 1 ? 3 : 2;
        const bool like = way >> 2 & 1;
        Cloud *cloud = two(dim, CLOUD_WATER, like ? CLOUD_WATER : CLOUD_AIR, 0);
        Particles *s = &cloud->s;
        for (int q = 0; q < 2; q++) s->p[q] = pressures[way >> 3][q];
        double a[2];
        for (int on = 0; on < 2; on++) {
            cloud->model.repulsion = on ? 0.08 : 0;
            cloud_term(cloud, TERMS[way >> 1 & 1]);
            a[on] = s->a[0][0];
        }
        const double away = s->x[0][0] - s->x[0][1];
        if (like) assert_true(a[1] == a[0]);
        else {
            assert_true((a[1] - a[0]) * away > 0);
            const CloudPair pair = cloud_pair(cloud, 0, 1);
            const double V = cloud_volume(cloud, 0), expected = -V * V * 0.08 * 1300 * pair.F * pair.dx[0] / s->m[0];
            assert_close(a[1] - a[0], expected, 1e-12 * fabs(expected));
        }
        cloud_free(cloud);
    }
}

/* On the lattice, where all sums of W V are 1 (cloud.h). The two averages agree as impedances do. */
static void linear_pressures_push_along_their_gradient(void **state)
{
    (void)state;
    const double slope[3] = {4e3, -9e3, 2500};
    for (int way = 0; way < 8; way++) {
        const int dim = way & 1 ? 3 : 2;
        Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                               .dx = 0.1,
                                               .n = {12, 11, 10},
                                               .skin = 0.3,
                                               .smoothing = 1.6,
                                               .flowing = true,
                                               .calibrated = true});
        Particles *s = &cloud->s;
        cloud->model.density_average = way >> 2;
        for (int round = 0; round < 2; round++) {
            for (size_t i = 0; i < s->n; i++) {
                s->p[i] = round == 0 ? 2e3 : 0; /* uniform, then linear */
                for (int d = 0; d < dim; d++) s->p[i] += round * slope[d] * s->x[d][i];
            }
            cloud_term(cloud, TERMS[way >> 1 & 1]);
            size_t inner = 0;
            for (size_t i = 0; i < s->n; i++) {
                const double margin = cloud->model.kernel.support + 0.01;
                bool inside = true;
                for (int d = 0; d < dim; d++)
                    inside = inside && s->x[d][i] > margin && s->x[d][i] < cloud->model.max[d] - margin;
                for (int d = 0; d < dim && inside; d++) assert_close(s->a[d][i], -round * slope[d] / 1000, 1e-12);
                inner += inside;
            }
            assert_true(inner > 8);
        }
        cloud_free(cloud);
    }
}

/* sum m v.a = -sum p dV/dt = -sum p V/rho d rho/dt: not a joule is lost between P2's two sums, with either average, as long as nothing
 * repels. */
static void work_of_pressure_is_what_continuity_of_volumes_stores(void **state)
{
    (void)state;
    for (int way = 0; way < 4; way++) {
        Cloud *cloud = stirred(way & 1 ? 3 : 2, no_walls);
        Particles *s = &cloud->s;
        cloud->model.density_average = way >> 1;
        cloud->model.repulsion = 0;
        double work = 0, stored = 0, size = 0;
        cloud_term(cloud, &volume_pressure_force);
        for (size_t i = 0; i < s->n; i++)
            for (int d = 0; d < s->dim; d++) {
                work += s->m[i] * s->v[d][i] * s->a[d][i];
                size += s->m[i] * fabs(s->v[d][i] * s->a[d][i]);
            }
        cloud_term(cloud, &volume_continuity);
        for (size_t i = 0; i < s->n; i++) stored += s->p[i] * cloud_volume(cloud, i) / s->rho[i] * s->rate[i];
        assert_true(fabs(work) > 1e-3 * size);
        assert_close(work, -stored, 1e-13 * size);
        cloud_free(cloud);
    }
}

/* All at one pressure over Gamma, walls too, and at rest. */
static void press(Cloud *cloud, double P)
{
    Particles *s = &cloud->s;
    for (size_t i = 0; i < particles_fluid(s); i++) {
        s->p[i] = P * s->shepard[i];
        for (int d = 0; d < s->dim; d++) s->v[d][i] = 0;
    }
    for (size_t i = particles_fluid(s); i < s->n; i++)
        for (int a = 0; a < 2; a++) s->p_wall[a][i - particles_fluid(s)] = P;
}

/* However its particles lie: the liquid beside it is pulled as before. */
static void gas_feels_nothing_of_a_pressure_below_zero_that_is_even(void **state)
{
    (void)state;
    for (int way = 0; way < 8; way++) {
        const int dim = way & 1 ? 3 : 2;
        const bool below = way >> 1 & 1;
        Cloud *cloud = stirred(dim, tank), *other = stirred(dim, tank);
        Cloud *const clouds[2] = {cloud, other};
        for (int k = 0; k < 2; k++) {
            Model *model = &clouds[k]->model;
            model->density_average = way >> 2 & 1;
            model->repulsion = 0;
            model->any_fills = model->phase[CLOUD_AIR].fills = k == 0;
            press(clouds[k], below ? -40 : 40);
        }
        cloud_term(cloud, &pressure_force);
        cloud_term(other, &pressure_force);
        const Particles *s = &cloud->s;
        double plain[3], most = 0;
        double *const a[3] = {calloc(s->n, sizeof(double)), calloc(s->n, sizeof(double)), calloc(s->n, sizeof(double))};
        for (size_t i = 0; i < particles_fluid(s); i++)
            for (int d = 0; d < dim; d++) a[d][i] = s->a[d][i];
        cloud_term(cloud, &gas_dissipation);
        for (size_t i = 0; i < particles_fluid(s); i++) {
            const bool gas = s->phase[i] == CLOUD_AIR;
            for (int d = 0; d < dim; d++) {
                plain[d] = other->s.a[d][i];
                most = fmax(most, gas ? fabs(plain[d]) : 0);
                if (gas && below) assert_close(a[d][i] + s->a[d][i], 0, 1e-9 * 40 / (s->rho[i] * cloud->model.dx));
                else assert_true(s->a[d][i] == 0 && a[d][i] == plain[d]);
            }
        }
        assert_true(most > 0.01 * 40 / (cloud->model.phase[CLOUD_AIR].rho0 * cloud->model.dx));
        for (int d = 0; d < 3; d++) free(a[d]);
        cloud_free(cloud);
        cloud_free(other);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(forces_are_those_of_the_papers_among_fluids_and_walls),
        cmocka_unit_test(forces_of_a_pair_are_equal_and_opposite_to_the_last_bit),
        cmocka_unit_test(total_force_is_zero_to_rounding),
        cmocka_unit_test(unlike_fluids_repel_each_other_at_any_pressure),
        cmocka_unit_test(linear_pressures_push_along_their_gradient),
        cmocka_unit_test(gas_feels_nothing_of_a_pressure_below_zero_that_is_even),
        cmocka_unit_test(work_of_pressure_is_what_continuity_of_volumes_stores),
    };
    return cmocka_run_group_tests_name("pressure force", tests, NULL, NULL);
}
