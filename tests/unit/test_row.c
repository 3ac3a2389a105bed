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

/* All that is listed, or what was marked as in reach when that was built; with all that terms may need. */
static void row_of(Cloud *cloud, size_t i, Row *row, RowPairs pairs)
{
    enum { NEEDS = NEED_ALL & ~(NEED_NORMAL | NEED_GRADIENT | NEED_SHEPARD) }; /* some of which are where fluxes are */
    neighbours_refresh(&cloud->nb, &cloud->s, &cloud->model, NEEDS);
    const RowPlan plan = row_plan(&cloud->nb, &cloud->s, &cloud->model, NEEDS, pairs);
    row_build(row, &plan, i);
}

/* Particles have moved since the lists were built, by less than half a skin. */
static Cloud *drifted(int dim, int periodic, MnsKernel kernel)
{
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                           .dx = 0.1,
                                           .kernel = kernel,
                                           .smoothing = kernel == MNS_WENDLAND_C2 ? 1.3 : 0.86, /* as far, nearly */
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

/* What a row says of pair k is what positions and fields say of it. */
static void check_pair(const Cloud *cloud, const Row *row, size_t k)
{
    const Particles *s = &cloud->s;
    const Block *b = &row->block[k / LANES];
    const size_t j = row->j[k], l = k % LANES;
    const CloudPair pair = cloud_pair(cloud, row->i, j);
    for (int d = 0; d < s->dim; d++) assert_close(b->x[d][l], pair.dx[d], 1e-15); /* rounding */
    assert_close(b->r[l], pair.r, 1e-15);
    assert_close(b->W[l], pair.W, 1e-11);
    assert_close(b->F[l], pair.F, 1e-9);
    assert_true(b->V[l] == cloud_volume(cloud, j) && b->p[l] == s->p[j] && b->z[l] == cloud_impedance(cloud, j));
    for (int d = 0; d < s->dim; d++) assert_true(b->v[d][l] == s->v[d][j]);
}

static void every_pair_in_reach_is_there_once_and_right(void **state)
{
    (void)state;
    static const MnsKernel kernels[] = {MNS_WENDLAND_C2, MNS_TRUNCATED_GAUSSIAN, MNS_QUINTIC_SPLINE};
    for (int k = 0; k < 96; k++) {
        const int dim = k & 16 ? 3 : 2, periodic = k & 7;
        const RowPairs pairs = k & 8 ? ROW_MARKED : ROW_LISTED;
        Cloud *cloud = drifted(dim, periodic, kernels[k / 32]);
        Particles *s = &cloud->s;
        const double reach = cloud->model.kernel.support;
        cloud_stir(cloud, 3);
        for (size_t i = 0; i < s->n; i++) {
            Row row;
            row_of(cloud, i, &row, ROW_LISTED);
            if (pairs == ROW_MARKED) row_of(cloud, i, &row, pairs);
            int found[8 * 9 * 7] = {0};
            size_t out_of_reach = 0;
            for (size_t q = 0; q < row.n * LANES; q++) {
                const Block *b = &row.block[q / LANES];
                const size_t l = q % LANES;
                assert_int_equal(group_of(s, row.j[q]) == GROUP_WALL, q >= row.n_fluid * LANES);
                if (b->r[l] < reach) {
                    check_pair(cloud, &row, q);
                    found[row.j[q]]++;
                } else {
                    assert_true(b->W[l] == 0 && b->F[l] == 0);
                    out_of_reach++;
                }
            }
            if (pairs == ROW_MARKED) assert_true(out_of_reach <= 2 * (LANES - 1)); /* padding, no more */
            for (size_t j = 0; j < s->n; j++) {
                const double r = cloud_pair(cloud, i, j).r;
                const bool both_walls = i >= particles_fluid(s) && j >= particles_fluid(s);
                if (fabs(r - reach) < 1e-12) continue;
                assert_int_equal(found[j], i != j && !both_walls && r < reach);
            }
        }
        cloud_free(cloud);
    }
}

/* Nobody says that these were written: they are made of density and mass, whose writers do. */
static void volumes_and_impedances_of_neighbours_follow_density_and_mass(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int round = 0; round < 3; round++) {
            Cloud *cloud = drifted(dim, 3, MNS_WENDLAND_C2);
            Particles *s = &cloud->s;
            static Row row;
            row_of(cloud, 0, &row, ROW_LISTED);
            for (size_t i = 0; i < s->n; i++) *(round == 0 ? &s->rho[i] : &s->m[i]) *= 1 + 0.01 * (double)(i % 7 + 1);
            if (round < 2) particles_changed(s, ON_ALL, round == 0 ? FIELD(RHO) : FIELD(M));
            row_of(cloud, 0, &row, ROW_LISTED);
            assert_true(row.n_fluid > 0);
            for (size_t k = 0; k < row.n_fluid * LANES; k++) {
                const Block *b = &row.block[k / LANES];
                const size_t j = row.j[k], l = k % LANES;
                assert_true((b->V[l] == cloud_volume(cloud, j)) == (round < 2)); /* copies, if nobody said */
                assert_true(b->z[l] == cloud_impedance(cloud, j));
            }
            cloud_free(cloud);
        }
}

/* The same numbers, to the last bit, from the instructions of every level that this machine has and that fuses. */
static void levels_give_the_same_bits(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = drifted(dim, 3, MNS_WENDLAND_C2);
        cloud_stir(cloud, 8);
        const Level best = cloud->model.level;
        for (int level = BASE_FUSES ? 0 : 1; level < (int)best; level++)
            for (size_t i = 0; i < cloud->s.n; i++)
                for (int pairs = ROW_LISTED; pairs <= ROW_MARKED; pairs++) {
                    static Row a, b;
                    memset(&a, 0, sizeof a);
                    memset(&b, 0, sizeof b);
                    cloud->model.level = (Level)level;
                    row_of(cloud, i, &a, (RowPairs)pairs);
                    cloud->model.level = best;
                    row_of(cloud, i, &b, (RowPairs)pairs);
                    assert_true(a.n == b.n && a.n_fluid == b.n_fluid);
                    assert_memory_equal(a.j, b.j, a.n * LANES * sizeof *a.j);
                    for (size_t k = 0; k < a.n; k++) {
                        const size_t used = dim == 3 ? sizeof(Block) : offsetof(Block, normal[2]);
                        assert_memory_equal(&a.block[k], &b.block[k], used);
                    }
                }
        cloud_free(cloud);
    }
}

/* Without instructions to fuse, weights are rounded otherwise; what is only fetched is what it is. */
static void what_is_fetched_is_the_same_at_every_level(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = drifted(dim, 3, MNS_WENDLAND_C2);
        cloud_stir(cloud, 8);
        const Level best = cloud->model.level;
        for (size_t i = 0; i < cloud->s.n; i++) {
            static Row a, b;
            memset(&a, 0, sizeof a);
            memset(&b, 0, sizeof b);
            cloud->model.level = LEVEL_BASE;
            row_of(cloud, i, &a, ROW_LISTED);
            cloud->model.level = best;
            row_of(cloud, i, &b, ROW_LISTED);
            assert_true(a.n == b.n && a.n > 0);
            assert_memory_equal(a.j, b.j, a.n * LANES * sizeof *a.j);
            for (size_t k = 0; k < a.n; k++) {
                const Block *const of_a = &a.block[k], *const of_b = &b.block[k];
                assert_memory_equal(of_a->p, of_b->p, sizeof of_a->p);
                assert_memory_equal(of_a->V, of_b->V, sizeof of_a->V);
                for (int d = 0; d < dim; d++) assert_memory_equal(of_a->v[d], of_b->v[d], sizeof of_a->v[d]);
            }
        }
        cloud_free(cloud);
    }
}

/* sum_j (f_j - f_i) grad_i W V_j */
static double gradient(Cloud *cloud, size_t i, int d, const double *f)
{
    Row row;
    row_of(cloud, i, &row, ROW_LISTED);
    double sum = 0;
    for (size_t k = 0; k < row.n * LANES; k++) {
        const Block *b = &row.block[k / LANES];
        sum += (f[row.j[k]] - f[i]) * b->F[k % LANES] * b->V[k % LANES] * b->x[d][k % LANES];
    }
    return sum;
}

/* sum_j (v_j - v_i) . grad_i W V_j */
static double divergence(Cloud *cloud, size_t i)
{
    Row row;
    row_of(cloud, i, &row, ROW_LISTED);
    double sum = 0;
    for (size_t k = 0; k < row.n * LANES; k++) {
        const Block *b = &row.block[k / LANES];
        const size_t l = k % LANES;
        for (int d = 0; d < cloud->s.dim; d++) sum += (b->v[d][l] - cloud->s.v[d][i]) * b->F[l] * b->V[l] * b->x[d][l];
    }
    return sum;
}

/* Lanes are added up as a tree, whatever the compiler would like. */
static void lanes_have_an_order(void **state)
{
    (void)state;
    const Lanes a = {{1, 1e16, -1e16, 3, 1e16, 5, 1, -1e16}};
    assert_true(lanes_sum(&a) == ((1 + 1e16) + (-1e16 + 1)) + ((1e16 + 5) + (3 + -1e16)));
}

static void weights_cancel_on_a_lattice(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim, .dx = 0.1, .n = {8, 9, 10}, .periodic = {true, true, true}});
        for (size_t i = 0; i < cloud->s.n; i++) {
            static Row row;
            row_of(cloud, i, &row, ROW_LISTED);
            double sum[3] = {0};
            for (size_t k = 0; k < row.n * LANES; k++) {
                const Block *b = &row.block[k / LANES];
                const size_t l = k % LANES;
                for (int d = 0; d < dim; d++) sum[d] += b->F[l] * b->V[l] * b->x[d][l];
            }
            for (int d = 0; d < dim; d++) assert_close(sum[d], 0, 1e-12); /* rounding of terms of up to 10 */
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
        particles_changed(s, ON_ALL, ALL_FIELDS);
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
    Cloud *cloud = drifted(3, 1, MNS_WENDLAND_C2);
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
        cmocka_unit_test(volumes_and_impedances_of_neighbours_follow_density_and_mass),
        cmocka_unit_test(levels_give_the_same_bits),
        cmocka_unit_test(what_is_fetched_is_the_same_at_every_level),
        cmocka_unit_test(lanes_have_an_order),
        cmocka_unit_test(weights_cancel_on_a_lattice),
        cmocka_unit_test(gradient_and_divergence_of_linear_fields_are_constant_and_nearly_one),
        cmocka_unit_test(gradient_of_a_constant_is_zero_wherever_particles_are),
        cmocka_unit_test(error_on_a_lattice_is_of_second_order),
        cmocka_unit_test(error_of_disorder_is_proportional_to_it_and_does_not_go_away),
    };
    return cmocka_run_group_tests_name("row", tests, NULL, NULL);
}
