/* SPDX-License-Identifier: BSD-3-Clause */
/* Densities that follow continuity: rates are the sums of P1 eq. 7 and P2 eq. 16, -rho div v where velocities are linear, nothing
 * where all moves as one body, and the same to a moving observer. */
#include "sim/terms/terms.h"
#include "tests/support/check.h"
#include "tests/support/cloud.h"
#include <stdlib.h>
#include <string.h>

static const Term *const TERMS[] = {&continuity, &volume_continuity};

static int tank(const double x[3])
{
    if (x[1] < 0.3 || x[0] < 0.25) return CLOUD_WALL;
    return x[1] < 0.55 + 0.2 * x[0] ? CLOUD_WATER : CLOUD_AIR;
}

/* Stirred water and air over a floor that moves, each particle with a sum of W V of its own. */
static Cloud *stirred(int dim)
{
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                           .dx = 0.1,
                                           .n = {9, 10, 7},
                                           .jitter = 0.2,
                                           .skin = 0.3,
                                           .periodic = {false, false, true},
                                           .flowing = true,
                                           .owner = tank});
    Particles *s = &cloud->s;
    uint64_t seed = 12;
    cloud_stir(cloud, 5);
    for (size_t i = 0; i < particles_fluid(s); i++) s->shepard[i] = 1 + 0.2 * cloud_noise(&seed);
    for (size_t i = particles_fluid(s); i < s->n; i++)
        for (int d = 0; d < dim; d++) s->v[d][i] = 0.7 * cloud_noise(&seed);
    return cloud;
}

/* A calibrated lattice of water and air, periodic, so that all particles have all their neighbours. */
static Cloud *lattice(int dim, int (*owner)(const double x[3]))
{
    return cloud_new(&(CloudSetup){
        .dim = dim, .dx = 0.1, .n = {12, 11, 10}, .skin = 0.3, .flowing = true, .calibrated = true, .owner = owner});
}

/* The sum over the pairs of i as the paper has it, and its largest term. Fluids yield by their impedance if so asked. */
static double reference(const Cloud *cloud, size_t i, bool by_volume, double *ret_size)
{
    const Particles *s = &cloud->s;
    double sum = 0;
    *ret_size = 0;
    for (size_t j = 0; j < s->n; j++) {
        if (j == i) continue;
        const CloudPair pair = cloud_pair(cloud, i, j);
        const bool weighted = cloud->model.density_average > 0 && j < particles_fluid(s);
        double u = 0;
        for (int d = 0; d < s->dim; d++) u += (s->v[d][i] - s->v[d][j]) * pair.F * pair.dx[d];
        if (weighted) u *= 2 * cloud_impedance(cloud, j) / (cloud_impedance(cloud, i) + cloud_impedance(cloud, j));
        const double term = by_volume ? s->m[i] / s->shepard[i] * u : s->rho[i] * cloud_volume(cloud, j) * u;
        sum += term;
        *ret_size = fmax(*ret_size, fabs(term));
    }
    return sum;
}

static void rates_are_those_of_the_papers_among_fluids_and_walls(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int by_density = 0; by_density < 2; by_density++)
            for (int k = 0; k < 2; k++) {
                Cloud *cloud = stirred(dim);
                const Particles *s = &cloud->s;
                cloud->model.density_average = by_density;
                cloud_term(cloud, TERMS[k]);
                for (size_t i = 0; i < particles_fluid(s); i++) {
                    double size = 0;
                    const double expected = reference(cloud, i, k == 1, &size);
                    assert_close(s->rate[i], expected, 1e-12 * size); /* rounding of up to 100 terms */
                }
                cloud_free(cloud);
            }
}

static int no_walls(const double x[3])
{
    return x[1] < 0.4 + 0.2 * x[0] ? CLOUD_WATER : CLOUD_AIR;
}

/* A body that moves without turning does not know of any difference: not a bit is left. One that turns leaves rounding. */
static void rigid_motion_changes_no_density(void **state)
{
    (void)state;
    const double U[3] = {13, -7, 5}, omega[3] = {0.3, -0.8, 2};
    for (int dim = 2; dim <= 3; dim++)
        for (int k = 0; k < 2; k++) {
            Cloud *cloud = stirred(dim);
            Particles *s = &cloud->s;
            for (int d = 0; d < dim; d++)
                for (size_t i = 0; i < s->n; i++) s->v[d][i] = U[d];
            cloud_term(cloud, TERMS[k]);
            for (size_t i = 0; i < s->n; i++) assert_true(s->rate[i] == 0);
            cloud_free(cloud);
            cloud = cloud_new(&(CloudSetup){.dim = dim,
                                            .dx = 0.1,
                                            .n = {9, 10, 7},
                                            .jitter = 0.2,
                                            .skin = 0.3,
                                            .flowing = true,
                                            .owner = no_walls});
            s = &cloud->s;
            for (size_t i = 0; i < s->n; i++) {
                const double x = s->x[0][i], y = s->x[1][i], z = dim == 3 ? s->x[2][i] : 0;
                const double w[3] = {dim == 3 ? omega[0] : 0, dim == 3 ? omega[1] : 0, omega[2]};
                s->v[0][i] = w[1] * z - w[2] * y;
                s->v[1][i] = w[2] * x - w[0] * z;
                if (dim == 3) s->v[2][i] = w[0] * y - w[1] * x;
            }
            cloud_term(cloud, TERMS[k]);
            /* Of terms up to rho v/h = 1e4. */
            for (size_t i = 0; i < s->n; i++) assert_close(s->rate[i], 0, 1e-10);
            cloud_free(cloud);
        }
}

static void linear_expansion_is_felt_exactly_on_the_lattice(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int k = 0; k < 2; k++) {
            Cloud *cloud = lattice(dim, NULL);
            Particles *s = &cloud->s;
            const double slope[3] = {2, 2, 2}; /* on a cubic lattice the calibration holds for each direction */
            for (int d = 0; d < dim; d++)
                for (size_t i = 0; i < s->n; i++) s->v[d][i] = 3 + slope[d] * s->x[d][i];
            cloud_term(cloud, TERMS[k]);
            size_t inner = 0;
            for (size_t i = 0; i < s->n; i++) {
                if (!cloud_inner(cloud, i)) continue;
                assert_close(s->rate[i], -1000 * 2.0 * dim, 1e-9); /* -rho div v to rounding */
                inner++;
            }
            assert_true(inner > 10);
            for (size_t i = 0; i < s->n; i++) s->v[1][i] = 0, s->v[0][i] = 5 * s->x[0][i] - 4 * s->x[1][i];
            if (dim == 3)
                for (size_t i = 0; i < s->n; i++) s->v[2][i] = 0;
            cloud_term(cloud, TERMS[k]);
            for (size_t i = 0; i < s->n; i++)
                if (cloud_inner(cloud, i)) assert_close(s->rate[i], -1000 * 5.0, 1e-9);
            cloud_free(cloud);
        }
}

static void rates_are_the_same_for_a_moving_observer(void **state)
{
    (void)state;
    const double U[3] = {130, -70, 50};
    for (int dim = 2; dim <= 3; dim++)
        for (int by_density = 0; by_density < 2; by_density++)
            for (int k = 0; k < 2; k++) {
                Cloud *cloud = stirred(dim);
                Particles *s = &cloud->s;
                cloud->model.density_average = by_density;
                cloud_term(cloud, TERMS[k]);
                double *before = malloc(s->n * sizeof *before), size = 0;
                assert_non_null(before);
                for (size_t i = 0; i < s->n; i++) {
                    before[i] = s->rate[i];
                    size = fmax(size, fabs(before[i]));
                }
                for (int d = 0; d < dim; d++)
                    for (size_t i = 0; i < s->n; i++) s->v[d][i] += U[d];
                cloud_term(cloud, TERMS[k]);
                for (size_t i = 0; i < s->n; i++)
                    assert_close(s->rate[i], before[i], 1e-12 * size); /* rounding of v + U */
                free(before);
                cloud_free(cloud);
            }
}

/* Between water and air the air yields. Where impedances are equal the two averages are one, to the last bit, whatever the densities. */
static void averages_differ_only_where_impedances_do(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int k = 0; k < 2; k++) {
            Cloud *cloud = stirred(dim);
            Particles *s = &cloud->s;
            double *plain = malloc(s->n * sizeof *plain);
            assert_non_null(plain);
            cloud_term(cloud, TERMS[k]);
            for (size_t i = 0; i < s->n; i++) plain[i] = s->rate[i];
            size_t changed = 0;
            cloud->model.density_average = 1;
            cloud_term(cloud, TERMS[k]);
            for (size_t i = 0; i < particles_fluid(s); i++) changed += s->rate[i] != plain[i];
            assert_true(changed > 20);
            cloud_weigh(cloud, 0, 1000);
            cloud_weigh(cloud, 1, 1);
            cloud->model.phase[1].c = 1000 * cloud->model.phase[0].c;
            cloud_term(cloud, TERMS[k]);
            for (size_t i = 0; i < s->n; i++) plain[i] = s->rate[i];
            cloud->model.density_average = 0;
            cloud_term(cloud, TERMS[k]);
            for (size_t i = 0; i < s->n; i++) assert_true(s->rate[i] == plain[i]);
            free(plain);
            cloud_free(cloud);
        }
}

static void approach_compresses(void **state)
{
    (void)state;
    for (int k = 0; k < 2; k++) {
        Cloud *cloud = lattice(2, NULL);
        Particles *s = &cloud->s;
        for (int d = 0; d < 2; d++)
            for (size_t i = 0; i < s->n; i++) s->v[d][i] = -s->x[d][i];
        cloud_term(cloud, TERMS[k]);
        for (size_t i = 0; i < s->n; i++) assert_true(s->rate[i] > 0);
        cloud_free(cloud);
    }
}

/* Sum of W V: 1 where particles are all around, on the calibrated lattice; half and the particle's own row at a flat surface. */
static void sums_of_volumes_are_one_inside_and_know_the_surface(void **state)
{
    (void)state;
    static const MnsKernel kernels[] = {MNS_WENDLAND_C2, MNS_TRUNCATED_GAUSSIAN, MNS_QUINTIC_SPLINE};
    for (int dim = 2; dim <= 3; dim++)
        for (int k = 0; k < 3; k++) {
            Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                                   .dx = 0.1,
                                                   .n = {11, 12, 10},
                                                   .skin = 0.3,
                                                   .kernel = kernels[k],
                                                   .smoothing = k == 0 ? 1.6 : 1.1,
                                                   .periodic = {true, false, true},
                                                   .calibrated = true,
                                                   .flowing = true,
                                                   .owner = no_walls});
            Particles *s = &cloud->s;
            cloud_term(cloud, &shepard_sum);
            size_t inside = 0, surface = 0;
            for (size_t i = 0; i < s->n; i++) {
                const double depth = s->x[1][i] / 0.1;
                if (cloud_inner(cloud, i)) {
                    assert_close(s->shepard[i], 1, 1e-13);
                    inside++;
                }
                if (depth > 1) continue;
                double row = 0; /* the surface row itself, of which half is on either side */
                for (size_t j = 0; j < s->n; j++)
                    if (fabs(s->x[1][j] - s->x[1][i]) < 1e-9) row += cloud_pair(cloud, i, j).W * cloud_volume(cloud, j);
                assert_close(s->shepard[i], 0.5 + 0.5 * row, 1e-13);
                surface++;
            }
            assert_true(inside > 20 && surface > 10);
            for (size_t i = 0; i < s->n; i++) s->m[i] *= 1 + 0.01 * (double)(i % 9);
            cloud_term(cloud, &shepard_sum);
            for (size_t i = 0; i < s->n; i++) {
                double sum = 0;
                for (size_t j = 0; j < s->n; j++)
                    sum += cloud_pair(cloud, i, j).W * cloud_volume(cloud, j); /* W(0) with j = i */
                assert_close(s->shepard[i], sum, 1e-13);
            }
            cloud_free(cloud);
        }
}

/* Walls count as what fills the space behind them. */
static void sums_of_volumes_count_walls(void **state)
{
    (void)state;
    Cloud *cloud = cloud_new(&(CloudSetup){
        .dim = 2, .dx = 0.1, .n = {11, 12}, .skin = 0.3, .calibrated = true, .flowing = true, .owner = tank});
    Particles *s = &cloud->s;
    cloud_term(cloud, &shepard_sum);
    size_t beside = 0;
    for (size_t i = 0; i < particles_fluid(s); i++)
        if (s->x[0][i] > 0.4 && s->x[0][i] < 0.8 && s->x[1][i] < 0.9) {
            assert_close(s->shepard[i], 1, 1e-13);
            beside += s->x[1][i] < 0.4;
        }
    assert_true(beside > 0);
    for (size_t i = particles_fluid(s); i < s->n; i++)
        assert_true(s->shepard[i] == 1); /* as they show fluids a pressure of their own */
    cloud_free(cloud);
}

/* What flows linearly, shears, turns and spreads, over a wall that does too. */
static Cloud *linear(int dim)
{
    static const double SLOPE[3][3] = {{2, -3, 1}, {5, 0.5, -2}, {0.7, 4, -1}};
    Cloud *cloud = cloud_new(&(CloudSetup){
        .dim = dim, .dx = 0.1, .n = {9, 10, 7}, .jitter = 0.2, .skin = 0.3, .flowing = true, .owner = tank});
    Particles *s = &cloud->s;
    cloud->model.density_average = 0;
    for (size_t i = 0; i < s->n; i++)
        for (int d = 0; d < dim; d++) {
            s->v[d][i] = 0;
            for (int e = 0; e < dim; e++) s->v[d][i] += SLOPE[d][e] * s->x[e][i];
        }
    return cloud;
}

/* Rates of a term with positions so much later than velocities, as rows or as far as that is told: [n], yours. */
static double *rates_after(const Term *term, int dim, double later, double told)
{
    Cloud *cloud = linear(dim);
    Particles *s = &cloud->s;
    double *rates = malloc(s->n * sizeof *rates);
    assert_non_null(rates);
    for (int d = 0; d < dim; d++)
        for (size_t i = 0; i < s->n; i++) s->x[d][i] += later * s->v[d][i];
    cloud->model.corrects_gradients = term == &corrected_continuity;
    cloud->model.lag = told;
    cloud_term(cloud, term);
    memcpy(rates, s->rate, s->n * sizeof *rates);
    cloud_free(cloud);
    return rates;
}

/* The root of the mean square of how two such differ. */
static double difference(const Term *term, int dim, double later, double told)
{
    Cloud *cloud = linear(dim);
    const size_t n = particles_fluid(&cloud->s);
    double *now = rates_after(term, dim, 0, 0), *then = rates_after(term, dim, later, told), sum = 0;
    for (size_t i = 0; i < n; i++) sum += pow(now[i] - then[i], 2);
    free(now);
    free(then);
    cloud_free(cloud);
    return sqrt(sum / (double)n);
}

/* Velocities of half a step before at the positions of now: what is left is of second order, and not what they have turned, sheared or spread
 * meanwhile. Rates of the middle of a step know nothing of it, to the last bit. */
static void rates_are_of_the_time_of_the_velocities(void **state)
{
    (void)state;
    static const Term *const staggered[] = {&volume_continuity, &corrected_continuity, &riemann_density};
    const double lag = 2e-4;
    for (int dim = 2; dim <= 3; dim++) {
        for (int k = 0; k < 3; k++) {
            const double whole = difference(staggered[k], dim, lag, lag),
                         half = difference(staggered[k], dim, 0.5 * lag, 0.5 * lag);
            assert_close(whole / half, 4, 0.1);
            assert_less(whole, 0.02 * difference(staggered[k], dim, lag, 0));
        }
        double *plain = rates_after(&continuity, dim, 0, 0), *told = rates_after(&continuity, dim, 0, lag);
        Cloud *cloud = linear(dim);
        assert_memory_equal(plain, told, particles_fluid(&cloud->s) * sizeof *plain);
        cloud_free(cloud);
        free(plain);
        free(told);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rates_are_those_of_the_papers_among_fluids_and_walls),
        cmocka_unit_test(rigid_motion_changes_no_density),
        cmocka_unit_test(linear_expansion_is_felt_exactly_on_the_lattice),
        cmocka_unit_test(rates_are_the_same_for_a_moving_observer),
        cmocka_unit_test(averages_differ_only_where_impedances_do),
        cmocka_unit_test(approach_compresses),
        cmocka_unit_test(sums_of_volumes_are_one_inside_and_know_the_surface),
        cmocka_unit_test(sums_of_volumes_count_walls),
        cmocka_unit_test(rates_are_of_the_time_of_the_velocities),
    };
    return cmocka_run_group_tests_name("continuity", tests, NULL, NULL);
}
