/* SPDX-License-Identifier: BSD-3-Clause */
/* A row holds every pair within the kernel's support once, and the operators made of its sums are what SPH says of
 * them. */
#include "tests/support/check.h"
#include "tests/support/cloud.h"
#include <string.h>

static int three_kinds(const double x[3])
{
    if (x[1] < 0.25 + 0.1 * x[0]) return CLOUD_WALL;
    return x[0] + 0.3 * x[1] < 0.5 ? CLOUD_WATER : CLOUD_AIR;
}

static int group_of(const Particles *s, size_t i)
{
    return i < s->begin[1] ? GROUP_CONTINUITY : i < s->begin[2] ? GROUP_SUMMATION : GROUP_WALL;
}

static void row_of(const Cloud *cloud, size_t i, Row *row)
{
    row_build(row, &cloud->nb, &cloud->s, &cloud->model, i);
}

/* Particles have moved since the lists were built, by less than half a skin. */
static Cloud *drifted(int dim, int periodic)
{
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                           .dx = 0.1,
                                           .n = {9, 8, 7},
                                           .jitter = 0.4,
                                           .skin = 0.5,
                                           .periodic = {periodic & 1, periodic & 2, periodic & 4},
                                           .owner = three_kinds});
    uint64_t seed = 31;
    for (int d = 0; d < dim; d++)
        for (size_t i = 0; i < cloud->s.n; i++) cloud->s.x[d][i] += 0.014 * cloud_noise(&seed);
    return cloud;
}

static void every_pair_in_reach_is_there_once_and_right(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int periodic = 0; periodic < 8; periodic++) {
            Cloud *cloud = drifted(dim, periodic);
            for (size_t i = 0; i < cloud->s.n; i++) {
                Row row;
                row_of(cloud, i, &row);
                int found[8 * 9 * 7] = {0};
                for (size_t k = 0; k < row.n; k++) {
                    const int group = k < row.end[0] ? 0 : k < row.end[1] ? 1 : 2;
                    assert_int_equal(group_of(&cloud->s, row.j[k]), group);
                    if (row.r[k] >= cloud->model.kernel.support) {
                        assert_true(row.W[k] == 0 && row.F[k] == 0);
                        continue;
                    }
                    const Pair pair = cloud_pair(cloud, i, row.j[k]);
                    for (int d = 0; d < dim; d++) assert_close(row.dx[d][k], pair.dx[d], 1e-15); /* rounding */
                    assert_close(row.r[k], pair.r, 1e-15);
                    assert_close(row.W[k], pair.W, 1e-11);
                    assert_close(row.F[k], pair.F, 1e-9);
                    found[row.j[k]]++;
                }
                for (size_t j = 0; j < cloud->s.n; j++) {
                    const double r = cloud_pair(cloud, i, j).r;
                    const bool both_walls = i >= particles_fluid(&cloud->s) && j >= particles_fluid(&cloud->s);
                    if (fabs(r - cloud->model.kernel.support) < 1e-12) continue;
                    assert_int_equal(found[j], i != j && !both_walls && r < cloud->model.kernel.support);
                }
            }
            cloud_free(cloud);
        }
}

/* The sums, over all of a row and over one group of it, against loops over all particles. */
static void sums_are_those_over_all_particles(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = drifted(dim, 2);
        cloud_stir(cloud, 3);
        const Particles *s = &cloud->s;
        for (size_t i = 0; i < particles_fluid(s); i++) {
            Row row;
            row_of(cloud, i, &row);
            row_dot_difference(&row, s->v);
            double all[5] = {0}, air[5] = {0};
            for (size_t j = 0; j < s->n; j++) {
                if (j == i) continue;
                const Pair pair = cloud_pair(cloud, i, j);
                double dot = 0;
                for (int d = 0; d < dim; d++) dot += (s->v[d][i] - s->v[d][j]) * pair.dx[d];
                const double terms[5] = {pair.F * pair.dx[0], pair.F * pair.dx[1], pair.F * s->p[j], pair.F,
                                         pair.F * dot};
                for (int q = 0; q < 5; q++) {
                    all[q] += terms[q];
                    air[q] += group_of(s, j) == GROUP_SUMMATION ? terms[q] : 0;
                }
            }
            const size_t first = row.end[GROUP_CONTINUITY], last = row.end[GROUP_SUMMATION];
            memcpy(row.c, row.F, row.n * sizeof *row.c);
            /* Rounding of some 100 terms of up to 10^4 (F), times 40 (p of air) or 4 10^4 (of water). */
            for (int d = 0; d < 2; d++) {
                assert_close(row_sum_along(&row, d, 0, row.n), all[d], 1e-9);
                assert_close(row_sum_along(&row, d, first, last), air[d], 1e-9);
            }
            assert_close(row_sum_field(&row, s->p, 0, row.n), all[2], 1e-5);
            assert_close(row_sum_field(&row, s->p, first, last), air[2], 1e-7);
            assert_close(row_sum(&row, 0, row.n), all[3], 1e-9);
            assert_close(row_sum(&row, first, last), air[3], 1e-9);
            for (size_t k = 0; k < row.n; k++) row.c[k] = row.F[k] * row.u[k];
            assert_close(row_sum(&row, 0, row.n), all[4], 1e-8);
        }
        cloud_free(cloud);
    }
}

/* sum_j (f_j - f_i) grad_i W V_j */
static double gradient(const Cloud *cloud, size_t i, int d, const double *f)
{
    Row row;
    row_of(cloud, i, &row);
    for (size_t k = 0; k < row.n; k++) row.c[k] = (f[row.j[k]] - f[i]) * row.F[k] * cloud->s.vol[row.j[k]];
    return row_sum_along(&row, d, 0, row.n);
}

/* sum_j (v_j - v_i) . grad_i W V_j */
static double divergence(const Cloud *cloud, size_t i)
{
    Row row;
    row_of(cloud, i, &row);
    row_dot_difference(&row, cloud->s.v);
    for (size_t k = 0; k < row.n; k++) row.c[k] = -row.u[k] * row.F[k] * cloud->s.vol[row.j[k]];
    return row_sum(&row, 0, row.n);
}

static void weights_cancel_on_a_lattice(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim, .dx = 0.1, .n = {8, 9, 10}, .periodic = {true, true, true}});
        for (size_t i = 0; i < cloud->s.n; i++) {
            Row row;
            row_of(cloud, i, &row);
            for (size_t k = 0; k < row.n; k++) row.c[k] = row.F[k] * cloud->s.vol[row.j[k]];
            /* Rounding of terms of up to 10. */
            for (int d = 0; d < dim; d++) assert_close(row_sum_along(&row, d, 0, row.n), 0, 1e-12);
        }
        cloud_free(cloud);
    }
}

/* Slope that the operators give to a linear field on a lattice, computed from the sum over its points. */
static double lattice_slope(const Kernel *kernel, int dim, double dx)
{
    double sum = 0;
    for (int x = -4; x <= 4; x++)
        for (int y = -4; y <= 4; y++)
            for (int z = dim == 3 ? -4 : 0; z <= (dim == 3 ? 4 : 0); z++) {
                const double r = dx * sqrt(x * x + y * y + z * z);
                double W = 0, F = 0;
                kernel_eval(kernel, 1, &r, &W, &F);
                sum -= F * x * x * dx * dx * pow(dx, dim);
            }
    return sum;
}

static void gradient_and_divergence_of_linear_fields_are_constant_and_nearly_one(void **state)
{
    (void)state;
    const double g[3] = {2, -3, 0.5};
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim, .dx = 0.1, .n = {11, 12, 10}});
        Particles *s = &cloud->s;
        const double slope = lattice_slope(&cloud->model.kernel, dim, 0.1);
        assert_close(slope, 1, 0.05); /* the lattice sum of W is 1 % off, that of its second moment some more */
        double sum = 0;
        for (int d = 0; d < dim; d++) sum += g[d];
        size_t inner = 0;
        for (size_t i = 0; i < s->n; i++) {
            s->p[i] = 7;
            for (int d = 0; d < dim; d++) {
                s->p[i] += g[d] * s->x[d][i];
                s->v[d][i] = g[d] * s->x[d][i] + 5 * s->x[(d + 1) % dim][i];
            }
        }
        for (size_t i = 0; i < s->n; i++) {
            if (!cloud_inner(cloud, i)) continue;
            inner++;
            for (int d = 0; d < dim; d++) assert_close(gradient(cloud, i, d, s->p), slope * g[d], 1e-12); /* rounding */
            assert_close(divergence(cloud, i), slope * sum, 1e-12);
        }
        assert_true(inner > 8);
        cloud_free(cloud);
    }
}

static void gradient_of_a_constant_is_zero_wherever_particles_are(void **state)
{
    (void)state;
    Cloud *cloud = drifted(3, 1);
    for (size_t i = 0; i < cloud->s.n; i++) cloud->s.p[i] = 1e5 / 3;
    for (size_t i = 0; i < particles_fluid(&cloud->s); i++)
        for (int d = 0; d < 3; d++) assert_true(gradient(cloud, i, d, cloud->s.p) == 0);
    cloud_free(cloud);
}

/* Largest error of the gradient of a wave, relative to the slope of a linear field. */
static double wave_error(double dx, double jitter)
{
    const size_t n = (size_t)lround(1 / dx);
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = 2, .dx = dx, .n = {n, n + 3}, .jitter = jitter});
    Particles *s = &cloud->s;
    const double slope = lattice_slope(&cloud->model.kernel, 2, dx);
    double worst = 0;
    for (size_t i = 0; i < s->n; i++) s->p[i] = sin(3 * s->x[0][i] + s->x[1][i]);
    for (size_t i = 0; i < s->n; i++) {
        const double exact = 3 * cos(3 * s->x[0][i] + s->x[1][i]);
        if (cloud_inner(cloud, i)) worst = fmax(worst, fabs(gradient(cloud, i, 0, s->p) / slope - exact));
    }
    cloud_free(cloud);
    return worst;
}

static void error_on_a_lattice_is_of_second_order(void **state)
{
    (void)state;
    const double coarse = wave_error(1.0 / 20, 0), fine = wave_error(1.0 / 40, 0);
    /* A factor of 4, less what the finer lattice finds by having particles nearer to the worst place. */
    assert_close(coarse / fine, 4, 0.4);
}

static void error_of_disorder_is_proportional_to_it_and_does_not_go_away(void **state)
{
    (void)state;
    const double some = wave_error(1.0 / 40, 0.05), more = wave_error(1.0 / 40, 0.1),
                 finer = wave_error(1.0 / 80, 0.05);
    assert_true(some > 10 * wave_error(1.0 / 40, 0));
    /* The largest of some 10^3 random numbers: within a half of proportional. */
    assert_close(more / some, 2, 0.5);
    assert_close(finer / some, 1, 0.5);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_pair_in_reach_is_there_once_and_right),
        cmocka_unit_test(sums_are_those_over_all_particles),
        cmocka_unit_test(weights_cancel_on_a_lattice),
        cmocka_unit_test(gradient_and_divergence_of_linear_fields_are_constant_and_nearly_one),
        cmocka_unit_test(gradient_of_a_constant_is_zero_wherever_particles_are),
        cmocka_unit_test(error_on_a_lattice_is_of_second_order),
        cmocka_unit_test(error_of_disorder_is_proportional_to_it_and_does_not_go_away),
    };
    return cmocka_run_group_tests_name("row", tests, NULL, NULL);
}
