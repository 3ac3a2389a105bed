/* SPDX-License-Identifier: BSD-3-Clause */
/* The two-phase Riemann terms are what server/sim/schemes/riemann.md write, pair by pair; they conserve momentum to the
 * last bit, dissipate only where particles approach, reduce to the single-phase solver, and look the same to a moving
 * observer. */
#include "sim/terms/terms.h"
#include "tests/support/check.h"
#include "tests/support/cloud.h"
#include <stdlib.h>
#include <string.h>

enum { DENSITY = 3, RATES }; /* rates of a particle: acceleration, then density */

/* Water below air in a tank with a floor and a left side. */
static int tank(const double x[3])
{
    if (x[1] < 0.3 || x[0] < 0.25) return CLOUD_WALL;
    return x[1] < 0.55 + 0.2 * x[0] ? CLOUD_WATER : CLOUD_AIR;
}

static int no_walls(const double x[3])
{
    return x[1] < 0.4 + 0.2 * x[0] ? CLOUD_WATER : CLOUD_AIR;
}

/* A tank full of stirred fluid, with walls that move and show each fluid some pressure. */
static Cloud *stirred(int dim, int (*owner)(const double x[3]))
{
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                           .dx = 0.1,
                                           .n = {9, 10, 7},
                                           .jitter = 0.2,
                                           .skin = 0.3,
                                           .periodic = {false, false, true},
                                           .owner = owner});
    Particles *s = &cloud->s;
    uint64_t seed = 12;
    cloud_stir(cloud, 5);
    for (size_t i = particles_fluid(s); i < s->n; i++) {
        for (int d = 0; d < dim; d++) s->v[d][i] = 0.7 * cloud_noise(&seed);
        s->p_wall[0][i - particles_fluid(s)] = 3e4 * cloud_noise(&seed);
        s->p_wall[1][i - particles_fluid(s)] = 30 * cloud_noise(&seed);
    }
    return cloud;
}

/* What a particle is to the Riemann problem: of j seen from i, as a wall shows every fluid a state of its own. */
typedef struct State {
    double rho, p, v[3];
} State;

static State state_of(const Cloud *cloud, size_t i, size_t j)
{
    const Particles *s = &cloud->s;
    State state = {s->rho[j], s->p[j], {0}};
    for (int d = 0; d < s->dim; d++) state.v[d] = s->v[d][j];
    if (j >= particles_fluid(s)) {
        const Phase *fluid = &cloud->model.phase[s->phase[i]];
        state.p = s->p_wall[s->phase[i]][j - particles_fluid(s)];
        state.rho = fluid->rho0 + state.p / (fluid->c * fluid->c);
    }
    return state;
}

/* P3 eq. 8-10 as printed: left is i, right is j, along e from i to j, one speed of sound for all. */
static void riemann(const State *l, const State *r, const double e[3], double c, double limiter, bool wall,
                    double *p_star, double v_star[3])
{
    double UL = 0, UR = 0;
    for (int d = 0; d < 3; d++) {
        UL += l->v[d] * e[d];
        UR += r->v[d] * e[d];
    }
    const double sum = l->rho + r->rho, beta = fmin(limiter * fmax(UL - UR, 0), c);
    *p_star = (l->rho * r->p + r->rho * l->p) / sum;
    if (!wall) *p_star += l->rho * r->rho * beta * (UL - UR) / sum;
    for (int d = 0; d < 3; d++)
        v_star[d] = (l->rho * l->v[d] + r->rho * r->v[d]) / sum + (l->p - r->p) / (c * sum) * e[d];
}

/* Rates of fluid particle i by the sums of P3 eq. 5 and 6, and the size of their largest term, for rounding. */
static void reference(const Cloud *cloud, size_t i, double rates[RATES], double scale[RATES])
{
    const Particles *s = &cloud->s;
    const State l = state_of(cloud, i, i);
    memset(rates, 0, RATES * sizeof *rates);
    memset(scale, 0, RATES * sizeof *scale);
    for (size_t j = 0; j < s->n; j++) {
        const CloudPair pair = cloud_pair(cloud, i, j);
        if (j == i || pair.W == 0) continue;
        const State r = state_of(cloud, i, j);
        double e[3] = {0}, p_star = 0, v_star[3] = {0};
        for (int d = 0; d < 3; d++) e[d] = -pair.dx[d] / pair.r;
        riemann(&l, &r, e, 20, cloud->model.limiter, j >= particles_fluid(s), &p_star, v_star);
        for (int d = 0; d < 3; d++) {
            const double grad = pair.F * pair.dx[d];
            const double a = -2 / s->m[i] * cloud_volume(cloud, i) * cloud_volume(cloud, j) * p_star * grad;
            const double rho = 2 * l.rho * cloud_volume(cloud, j) * (l.v[d] - v_star[d]) * grad;
            rates[d] += a;
            rates[DENSITY] += rho;
            scale[d] = fmax(scale[d], fabs(a));
            scale[DENSITY] = fmax(scale[DENSITY], fabs(rho));
        }
    }
}

static void assert_rates_are_those_of_the_paper(Cloud *cloud)
{
    const Particles *s = &cloud->s;
    double *expected = malloc(s->n * RATES * sizeof *expected), *scale = malloc(s->n * RATES * sizeof *scale);
    assert_true(expected && scale);
    for (size_t i = 0; i < particles_fluid(s); i++) reference(cloud, i, expected + i * RATES, scale + i * RATES);
    /* Rounding of sums of some 100 terms; the softened direction adds 1e-12. */
    cloud_term(cloud, &riemann_momentum);
    for (size_t i = 0; i < particles_fluid(s); i++)
        for (int d = 0; d < s->dim; d++)
            assert_close(s->a[d][i], expected[i * RATES + (size_t)d], 1e-10 * scale[i * RATES + (size_t)d]);
    cloud_term(cloud, &riemann_density);
    for (size_t i = 0; i < s->begin[GROUP_SUMMATION]; i++)
        assert_close(s->rate[i], expected[i * RATES + DENSITY], 1e-10 * scale[i * RATES + DENSITY]);
    free(expected);
    free(scale);
}

static void rates_are_those_of_the_paper_among_fluids_and_walls(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = stirred(dim, tank);
        assert_rates_are_those_of_the_paper(cloud);
        cloud->model.limiter = 0.4; /* where the limit at c is not reached */
        assert_rates_are_those_of_the_paper(cloud);
        cloud_free(cloud);
    }
}

static void other_groups_are_left_alone(void **state)
{
    (void)state;
    Cloud *cloud = stirred(2, tank);
    const Particles *s = &cloud->s;
    cloud_term(cloud, &riemann_density);
    for (size_t i = s->begin[GROUP_SUMMATION]; i < s->n; i++) assert_true(s->rate[i] == 0);
    cloud_term(cloud, &riemann_momentum);
    for (size_t i = particles_fluid(s); i < s->n; i++) assert_true(s->a[0][i] == 0 && s->a[1][i] == 0);
    cloud_free(cloud);
}

static int pair_of[2]; /* what the next two particles are */

static int two_points(const double x[3])
{
    if (x[0] < 0.1) return pair_of[0];
    return x[0] < 0.2 ? pair_of[1] : CLOUD_NOTHING;
}

/* Two particles, id 0 at a and id 1 at b. */
static Cloud *two(int dim, int first, int second, const double a[3], const double b[3])
{
    pair_of[0] = first;
    pair_of[1] = second;
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim, .dx = 0.1, .n = {3, 1, 1}, .owner = two_points});
    assert_int_equal(cloud->s.n, 2);
    for (int k = 0; k < 2; k++)
        for (int d = 0; d < dim; d++) cloud->s.x[d][k] = cloud->s.id[k] == 0 ? a[d] : b[d];
    assert_int_equal(cloud_build(cloud), MNS_OK);
    assert_int_equal(cloud->nb.end[0][END_WALLS], 1);
    return cloud;
}

/* Its volume stays. */
static void put(Cloud *cloud, size_t i, double rho, double p, double vx, double vy)
{
    Particles *s = &cloud->s;
    s->rho[i] = rho;
    s->m[i] = rho * cloud->model.cell_volume;
    s->p[i] = p;
    s->v[0][i] = vx;
    s->v[1][i] = vy;
}

static size_t index_of(const Cloud *cloud, uint32_t id)
{
    return cloud->s.id[0] == id ? 0 : 1;
}

static const double A[3] = {0.2, 0.3, 0.15}, B[3] = {0.29, 0.24, 0.2};

/* P3 eq. 10 with rho_L = rho_R is Zhang, Hu and Adams 2017: p* = (p_L + p_R)/2 + rho beta dU/2, U* = U + dp/(2 rho
 * c). */
static void equal_densities_give_the_single_phase_solver(void **state)
{
    (void)state;
    Cloud *cloud = two(2, CLOUD_WATER, CLOUD_WATER, A, B);
    const size_t i = index_of(cloud, 0), j = 1 - i;
    put(cloud, i, 990, 5000, 0.9, -0.2);
    put(cloud, j, 990, -2000, 0.3, 0.7);
    const Particles *s = &cloud->s;
    const CloudPair pair = cloud_pair(cloud, i, j);
    const double e[2] = {-pair.dx[0] / pair.r, -pair.dx[1] / pair.r}, dU = (0.9 - 0.3) * e[0] + (-0.2 - 0.7) * e[1];
    assert_true(dU > 0);
    const double p_star = 1500 + 0.5 * 990 * fmin(3 * dU, 20) * dU, V = cloud_volume(cloud, i);
    cloud_term(cloud, &riemann_momentum);
    /* Rounding. */
    for (int d = 0; d < 2; d++)
        assert_close(s->a[d][i], -2 * V * V * p_star * pair.F * pair.dx[d] / s->m[i], 1e-11 * fabs(s->a[d][i]));
    cloud_term(cloud, &riemann_density);
    const double away = 0.5 * dU - 7000 / (2 * 990 * 20.0); /* (v_i - v*) . e */
    assert_close(s->rate[i], 2 * 990 * V * away * -pair.F * pair.r, 1e-11 * fabs(s->rate[i]));
    cloud_free(cloud);
}

/* At an infinite ratio of densities the light particle keeps its own pressure at the interface, which moves with the
 * heavy. */
static void light_feels_heavy_as_a_moving_wall(void **state)
{
    (void)state;
    Cloud *cloud = two(2, CLOUD_WATER, CLOUD_WATER, A, B);
    const size_t light = index_of(cloud, 0), heavy = 1 - light;
    put(cloud, light, 1e-6, 300, 0, 0);
    put(cloud, heavy, 1e6, -9000, 0, 0);
    const Particles *s = &cloud->s;
    const CloudPair pair = cloud_pair(cloud, light, heavy);
    cloud_term(cloud, &riemann_momentum);
    /* The other pressure's weight is 1e-12. */
    for (int d = 0; d < 2; d++) {
        const double expected =
            -2 * cloud_volume(cloud, 0) * cloud_volume(cloud, 1) * 300 * pair.F * pair.dx[d] / s->m[light];
        assert_close(s->a[d][light], expected, 1e-9 * fabs(expected));
    }
    put(cloud, light, 1e-6, 300, 0.4, 0);
    put(cloud, heavy, 1e6, 300, -0.1, 0.2);
    cloud_term(cloud, &riemann_density);
    const double closing = (0.4 + 0.1) * pair.dx[0] - 0.2 * pair.dx[1];
    assert_close(s->rate[light], 2 * 1e-6 * cloud_volume(cloud, heavy) * closing * pair.F, 1e-9 * fabs(s->rate[light]));
    cloud_free(cloud);
}

static void dissipation_acts_only_where_particles_approach(void **state)
{
    (void)state;
    const double along[2] = {B[0] - A[0], B[1] - A[1]};
    for (int k = 0; k < 2; k++) {
        Cloud *cloud = two(2, CLOUD_WATER, CLOUD_AIR, A, B);
        const size_t i = index_of(cloud, 0), j = 1 - i;
        const double speed = k == 0 ? 3 : -3;
        put(cloud, i, 1000, 0, speed * along[0], speed * along[1]);
        put(cloud, j, 1, 0, 0, 0);
        cloud_term(cloud, &riemann_momentum);
        if (k == 0) /* approach: i is pushed back */
            assert_true(cloud->s.a[0][i] * along[0] < 0 && cloud->s.a[1][i] * along[1] < 0);
        else assert_true(cloud->s.a[0][i] == 0 && cloud->s.a[1][i] == 0);
        put(cloud, i, 1000, 0, 3 * along[1], -3 * along[0]); /* past each other */
        cloud_term(cloud, &riemann_momentum);
        assert_true(fabs(cloud->s.a[0][i]) < 1e-12); /* of 1e3: what rounding leaves of the closing speed */
        cloud_free(cloud);
    }
}

/* beta = min(3 dU, c): quadratic in dU up to c/3, linear beyond. */
static void limiter_turns_quadratic_into_linear_at_a_third_of_the_speed_of_sound(void **state)
{
    (void)state;
    double force[4];
    const double speeds[4] = {3, 6, 12, 24};
    for (int k = 0; k < 4; k++) {
        Cloud *cloud = two(2, CLOUD_WATER, CLOUD_WATER, A, (const double[3]){0.3, 0.3, 0});
        const size_t i = index_of(cloud, 0);
        put(cloud, i, 1000, 0, speeds[k], 0);
        put(cloud, 1 - i, 1000, 0, 0, 0);
        cloud_term(cloud, &riemann_momentum);
        force[k] = cloud->s.a[0][i];
        cloud_free(cloud);
    }
    /* Rounding, and 1e-11 of softened distance. */
    assert_close(force[1] / force[0], 4, 1e-10);
    assert_close(force[3] / force[2], 2, 1e-10);
    assert_close(force[2] / force[1], 20 * 12 / (3.0 * 6 * 6), 1e-9);
}

/* m_i a_i = -m_j a_j, exactly, even across a density jump of 1000. */
static void forces_of_a_pair_are_equal_and_opposite_to_the_last_bit(void **state)
{
    (void)state;
    static const int kinds[3][2] = {{CLOUD_WATER, CLOUD_AIR}, {CLOUD_WATER, CLOUD_WATER}, {CLOUD_AIR, CLOUD_AIR}};
    uint64_t seed = 77;
    for (int dim = 2; dim <= 3; dim++)
        for (int k = 0; k < 300; k++) {
            double b[3];
            for (int d = 0; d < 3; d++) b[d] = A[d] + 0.12 * cloud_noise(&seed);
            Cloud *cloud = two(dim, kinds[k % 3][0], kinds[k % 3][1], A, b);
            Particles *s = &cloud->s;
            cloud_stir(cloud, seed);
            s->m[0] = s->m[1] = 1; /* unit masses: a is the force [N] */
            cloud_term(cloud, &riemann_momentum);
            assert_true(s->a[0][0] != 0);
            for (int d = 0; d < dim; d++) assert_true(s->a[d][0] == -s->a[d][1]);
            cloud_free(cloud);
        }
}

/* With different speeds of sound too, and over a periodic side. */
static void total_force_is_zero_to_rounding(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = stirred(dim, no_walls);
        Particles *s = &cloud->s;
        cloud->model.phase[1].c = 3;
        cloud_term(cloud, &riemann_momentum);
        for (int d = 0; d < dim; d++) {
            double sum = 0, size = 0;
            for (size_t i = 0; i < s->n; i++) {
                sum += s->m[i] * s->a[d][i];
                size += s->m[i] * fabs(s->a[d][i]);
            }
            assert_close(sum, 0, 1e-13 * size);
        }
        cloud_free(cloud);
    }
}

/* Impedances, not densities, weigh the pressures where speeds of sound differ: the harder side yields less. */
static void impedances_weigh_pressures_and_velocities(void **state)
{
    (void)state;
    Cloud *cloud = two(2, CLOUD_WATER, CLOUD_AIR, A, B);
    Particles *s = &cloud->s;
    const size_t i = index_of(cloud, 0), j = 1 - i;
    put(cloud, i, 1000, 4000, 0.5, 0.1);
    put(cloud, j, 1000, 1000, 0, 0);
    cloud->model.phase[1].c = 80;
    const CloudPair pair = cloud_pair(cloud, i, j);
    const double dU = -(0.5 * pair.dx[0] + 0.1 * pair.dx[1]) / pair.r, zi = 2e4, zj = 8e4;
    const double p_star = (zi * 1000 + zj * 4000 + zi * zj * fmin(3 * dU / 20, 1) * dU) / (zi + zj);
    assert_true(dU > 0);
    cloud_term(cloud, &riemann_momentum);
    assert_close(s->a[0][i],
                 -2 * cloud_volume(cloud, i) * cloud_volume(cloud, j) * p_star * pair.F * pair.dx[0] / s->m[i],
                 1e-10 * fabs(s->a[0][i]));
    cloud_term(cloud, &riemann_density);
    const double away = zj * dU / (zi + zj) - 3000 / (zi + zj);
    assert_close(s->rate[i], 2 * 1000 * cloud_volume(cloud, j) * away * -pair.F * pair.r, 1e-10 * fabs(s->rate[i]));
    cloud_free(cloud);
}

/* Diffusion: at rest, the particle of higher pressure loses density to the other. */
static void higher_pressure_loses_density(void **state)
{
    (void)state;
    Cloud *cloud = two(3, CLOUD_WATER, CLOUD_WATER, A, B);
    put(cloud, 0, 1010, 4000, 0, 0);
    put(cloud, 1, 990, -4000, 0, 0);
    cloud_term(cloud, &riemann_density);
    assert_true(cloud->s.rate[0] < 0 && cloud->s.rate[1] > 0);
    /* Volumes exchanged are equal: V rate / rho. */
    assert_close(cloud->s.rate[0] / 1010, -cloud->s.rate[1] / 990, 1e-12 * cloud->s.rate[1]);
    cloud_free(cloud);
}

static void approach_compresses(void **state)
{
    (void)state;
    Cloud *cloud = two(2, CLOUD_WATER, CLOUD_WATER, A, B);
    const size_t i = index_of(cloud, 0);
    put(cloud, i, 1000, 0, B[0] - A[0], B[1] - A[1]);
    put(cloud, 1 - i, 1000, 0, 0, 0);
    cloud_term(cloud, &riemann_density);
    assert_true(cloud->s.rate[0] > 0 && cloud->s.rate[1] > 0);
    cloud_free(cloud);
}

static void walls_do_not_dissipate(void **state)
{
    (void)state;
    Cloud *cloud = two(2, CLOUD_WATER, CLOUD_WALL, A, B);
    Particles *s = &cloud->s;
    s->p_wall[0][0] = 2500;
    put(cloud, 0, 1000, 800, 0, 0);
    cloud_term(cloud, &riemann_momentum);
    const double at_rest[2] = {s->a[0][0], s->a[1][0]};
    assert_true(at_rest[0] != 0);
    put(cloud, 0, 1000, 800, 5 * (B[0] - A[0]), 5 * (B[1] - A[1]));
    cloud_term(cloud, &riemann_momentum);
    for (int d = 0; d < 2; d++) assert_true(s->a[d][0] == at_rest[d]);
    cloud_term(cloud, &riemann_density);
    assert_true(s->rate[0] > 0); /* but they do not yield */
    cloud_free(cloud);
}

/* Add a constant velocity to everything, walls too: rates must not know. */
static void rates_are_the_same_for_a_moving_observer(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = stirred(dim, tank);
        Particles *s = &cloud->s;
        const double U[3] = {13, -7, 5};
        double *before = malloc(s->n * RATES * sizeof *before), size = 0;
        assert_non_null(before);
        for (int round = 0; round < 2; round++) {
            for (int k = 0; k < RATES; k++) {
                cloud_term(cloud, k == DENSITY ? &riemann_density : &riemann_momentum);
                if (k < DENSITY && k >= dim) continue;
                double *rate = k == DENSITY ? s->rate : s->a[k];
                const size_t n = k == DENSITY ? s->begin[GROUP_SUMMATION] : particles_fluid(s);
                for (size_t i = 0; i < n; i++) size = fmax(size, fabs(rate[i]));
                /* Velocities of 2 lose 10 ulps to 15: 1e-14 of terms up to the largest rate. */
                for (size_t i = 0; round && i < n; i++)
                    assert_close(rate[i], before[i * RATES + (size_t)k], 1e-12 * size);
                for (size_t i = 0; i < n; i++) before[i * RATES + (size_t)k] = rate[i];
            }
            for (int d = 0; d < dim; d++)
                for (size_t i = 0; i < s->n; i++) s->v[d][i] += U[d];
        }
        free(before);
        cloud_free(cloud);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rates_are_those_of_the_paper_among_fluids_and_walls),
        cmocka_unit_test(other_groups_are_left_alone),
        cmocka_unit_test(equal_densities_give_the_single_phase_solver),
        cmocka_unit_test(light_feels_heavy_as_a_moving_wall),
        cmocka_unit_test(dissipation_acts_only_where_particles_approach),
        cmocka_unit_test(limiter_turns_quadratic_into_linear_at_a_third_of_the_speed_of_sound),
        cmocka_unit_test(forces_of_a_pair_are_equal_and_opposite_to_the_last_bit),
        cmocka_unit_test(total_force_is_zero_to_rounding),
        cmocka_unit_test(impedances_weigh_pressures_and_velocities),
        cmocka_unit_test(higher_pressure_loses_density),
        cmocka_unit_test(approach_compresses),
        cmocka_unit_test(walls_do_not_dissipate),
        cmocka_unit_test(rates_are_the_same_for_a_moving_observer),
    };
    return cmocka_run_group_tests_name("riemann", tests, NULL, NULL);
}
