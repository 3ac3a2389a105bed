/* SPDX-License-Identifier: BSD-3-Clause */
/* With corrected gradients linear velocities compress as they should and a uniform pressure does the work of the change of volume,
 * however particles lie; forces are the crosswise sums and cancel. */
#include "sim/terms/terms.h"
#include "tests/support/check.h"
#include "tests/support/cloud.h"
#include <string.h>

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
    Cloud *cloud = cloud_new(&(CloudSetup){
        .dim = dim, .dx = 0.1, .n = {9, 10, 7}, .jitter = 0.2, .skin = 0.3, .flowing = true, .owner = owner});
    Particles *s = &cloud->s;
    uint64_t seed = 3;
    cloud_stir(cloud, 9);
    cloud->model.corrects_gradients = true;
    for (size_t i = particles_fluid(s); i < s->n; i++)
        for (int a = 0; a < 2; a++) s->p_wall[a][i - particles_fluid(s)] = (a == 0 ? 3e4 : 30) * cloud_noise(&seed);
    return cloud;
}

/* v = slope . x, of walls too. */
static void flow_linearly(Cloud *cloud, double slope[3][3])
{
    Particles *s = &cloud->s;
    for (size_t i = 0; i < s->n; i++)
        for (int d = 0; d < s->dim; d++) {
            s->v[d][i] = 0;
            for (int e = 0; e < s->dim; e++) s->v[d][i] += slope[d][e] * s->x[e][i];
        }
}

static double SLOPE[3][3] = {{2, -3, 1}, {5, 0.5, -2}, {0.7, 4, -1}};

static void linear_velocities_compress_exactly_however_particles_lie(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = stirred(dim, tank);
        const Particles *s = &cloud->s;
        const double divergence = SLOPE[0][0] + SLOPE[1][1] + (dim == 3 ? SLOPE[2][2] : 0);
        cloud->model.density_average = 0;
        flow_linearly(cloud, SLOPE);
        cloud_term(cloud, &corrected_continuity);
        for (size_t i = 0; i < particles_fluid(s); i++)
            assert_close(s->rate[i], -s->rho[i] * divergence, 1e-11 * s->rho[i]); /* rounding, and of the inverse */
        cloud_free(cloud);
    }
}

/* The inverse of sum_j (x_j - x_i) (x) grad_i W V_j; 1 of walls. */
static void correction(const Cloud *cloud, size_t i, double ret[3][3])
{
    const Particles *s = &cloud->s;
    double moments[3][3] = {{0}}, one[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    memcpy(ret, one, sizeof one);
    if (i >= particles_fluid(s)) return;
    for (size_t j = 0; j < s->n; j++) {
        if (j == i) continue;
        const CloudPair pair = cloud_pair(cloud, i, j);
        for (int d = 0; d < s->dim; d++)
            for (int e = 0; e < s->dim; e++) moments[d][e] -= cloud_volume(cloud, j) * pair.F * pair.dx[d] * pair.dx[e];
    }
    cloud_invert(moments, s->dim, ret);
}

/* The force of j on i; M: of i and of j. */
static void push(const Cloud *cloud, size_t i, size_t j, double M[2][3][3], double ret[3])
{
    const Particles *s = &cloud->s;
    const CloudPair pair = cloud_pair(cloud, i, j);
    const bool wall = j >= particles_fluid(s);
    const double p_j = wall ? s->p_wall[s->phase[i]][j - particles_fluid(s)] : s->p[j];
    const double beta = !wall && s->phase[i] != s->phase[j] ? cloud->model.repulsion : 0;
    const bool weighted = !wall && cloud->model.density_average > 0;
    const double mine =
        (weighted ? 2 * cloud_impedance(cloud, j) / (cloud_impedance(cloud, i) + cloud_impedance(cloud, j)) : 1) *
            s->p[i] +
        beta * fabs(s->p[i]);
    const double its =
        (weighted ? 2 * cloud_impedance(cloud, i) / (cloud_impedance(cloud, i) + cloud_impedance(cloud, j)) : 1) * p_j +
        beta * fabs(p_j);
    for (int d = 0; d < s->dim; d++) {
        ret[d] = 0;
        for (int e = 0; e < s->dim; e++)
            ret[d] -= cloud_volume(cloud, i) * cloud_volume(cloud, j) * pair.F *
                      (mine * M[1][d][e] + its * M[0][d][e]) * pair.dx[e];
    }
}

static void forces_are_crosswise_sums_among_fluids_and_walls(void **state)
{
    (void)state;
    for (int way = 0; way < 8; way++) {
        const int dim = way & 1 ? 3 : 2;
        Cloud *cloud = stirred(dim, tank);
        const Particles *s = &cloud->s;
        cloud->model.density_average = way >> 1 & 1;
        if (way >> 2 & 1) cloud->model.repulsion = 0;
        cloud_term(cloud, &corrected_continuity);
        cloud_term(cloud, &corrected_pressure_force);
        for (size_t i = 0; i < particles_fluid(s); i += 5) {
            double a[3] = {0}, size = 0, M[2][3][3], force[3];
            correction(cloud, i, M[0]);
            for (size_t j = 0; j < s->n; j++) {
                if (j == i || cloud_pair(cloud, i, j).F == 0) continue;
                correction(cloud, j, M[1]);
                push(cloud, i, j, M, force);
                for (int d = 0; d < dim; d++) {
                    a[d] += force[d] / s->m[i];
                    size = fmax(size, fabs(force[d]) / s->m[i]);
                }
            }
            for (int d = 0; d < dim; d++)
                assert_close(s->a[d][i], a[d], 1e-11 * size); /* rounding, and of the inverse */
        }
        cloud_free(cloud);
    }
}

static void total_force_is_zero_to_rounding(void **state)
{
    (void)state;
    for (int way = 0; way < 4; way++) {
        Cloud *cloud = stirred(way & 1 ? 3 : 2, no_walls);
        cloud->model.density_average = way >> 1;
        cloud_term(cloud, &corrected_continuity);
        cloud_term(cloud, &corrected_pressure_force);
        cloud_assert_no_force(cloud, 1e-13);
        cloud_free(cloud);
    }
}

/* Of the pressure force on particles that flow linearly, over p times their volume. */
static double work(Cloud *cloud, const Term *term, double p)
{
    const Particles *s = &cloud->s;
    double all = 0, volume = 0;
    cloud_term(cloud, &corrected_continuity);
    cloud_term(cloud, term);
    for (size_t i = 0; i < s->n; i++) {
        volume += cloud_volume(cloud, i);
        for (int d = 0; d < s->dim; d++) all += s->m[i] * s->v[d][i] * s->a[d][i];
    }
    return all / (p * volume);
}

/* So there is no modulus of shear in a uniform pressure: without corrections there is. */
static void uniform_pressure_works_on_linear_velocities_by_their_divergence(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = stirred(dim, no_walls);
        const Particles *s = &cloud->s;
        const double p = 700, divergence = SLOPE[0][0] + SLOPE[1][1] + (dim == 3 ? SLOPE[2][2] : 0);
        cloud->model.density_average = cloud->model.repulsion = 0;
        for (size_t i = 0; i < s->n; i++) s->p[i] = p;
        flow_linearly(cloud, SLOPE);
        assert_close(work(cloud, &corrected_pressure_force, p), divergence, 1e-11);
        assert_true(fabs(work(cloud, &volume_pressure_force, p) - divergence) > 0.1);
        cloud_free(cloud);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(linear_velocities_compress_exactly_however_particles_lie),
        cmocka_unit_test(forces_are_crosswise_sums_among_fluids_and_walls),
        cmocka_unit_test(total_force_is_zero_to_rounding),
        cmocka_unit_test(uniform_pressure_works_on_linear_velocities_by_their_divergence),
    };
    return cmocka_run_group_tests_name("corrected", tests, NULL, NULL);
}
