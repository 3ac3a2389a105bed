/* SPDX-License-Identifier: BSD-3-Clause */
/* The operators of the two projections are those of P4 put right: one system for fluids and walls that is symmetric to the last bit and has
 * nothing to say to constants; exact on lattices for what is linear or quadratic; forces that keep momentum; a layer at rest between
 * walls as a solution; and a solution that leaves a velocity without divergence. */
#include "sim/solve/solve.h"
#include "sim/terms/terms.h"
#include "tests/support/check.h"
#include "tests/support/cloud.h"
#include <stdlib.h>
#include <string.h>

static int three_kinds(const double x[3])
{
    return x[1] < 0.3 ? CLOUD_WALL : x[0] < 0.5 ? CLOUD_WATER : CLOUD_AIR;
}

static int two_kinds(const double x[3])
{
    return x[0] < 0.5 ? CLOUD_WATER : CLOUD_AIR;
}

static int layers(const double x[3])
{
    return x[1] < 0.3 || x[1] > 1.5 ? CLOUD_WALL : x[1] < 0.9 ? CLOUD_WATER : CLOUD_AIR;
}

/* Two fluids and a wall, in disorder; volumes by number density. */
static Cloud *disordered(int dim)
{
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                           .dx = 0.1,
                                           .n = {10, 9, 8},
                                           .jitter = 0.2,
                                           .skin = 0.3,
                                           .smoothing = 1,
                                           .kernel = MNS_QUINTIC_SPLINE,
                                           .periodic = {true, false, true},
                                           .viscous = true,
                                           .owner = three_kinds});
    uint64_t seed = 3;
    for (size_t i = 0; i < particles_fluid(&cloud->s); i++) cloud->s.m[i] *= 1 + 0.1 * cloud_noise(&seed);
    return cloud;
}

/* c_ij by unknowns, from the matrix; 0 where there is none. */
static double entry(const Matrix *m, size_t row, size_t column)
{
    double sum = 0;
    for (size_t k = m->start[row] * ENTRIES; k < (m->start[row] + m->blocks[row]) * ENTRIES; k++)
        if (m->column[k] == column) sum += (double)m->c[k];
    return sum;
}

static double square(double x)
{
    return x * x;
}

static void the_system_is_that_of_the_paper_and_symmetric_to_the_last_bit(void **state)
{
    (void)state;
    const Term *const terms[2][2] = {{&velocity_matrix, &velocity_wall_matrix},
                                     {&density_matrix, &density_wall_matrix}};
    for (int dim = 2; dim <= 3; dim++)
        for (int k = 0; k < 3; k++) {
            Cloud *cloud = disordered(dim);
            const Particles *s = &cloud->s;
            const Matrix *m = &cloud->system.matrix;
            cloud->model.projection.unit_mobility = k == 2;
            cloud_term(cloud, &wall_density);
            cloud_term(cloud, terms[k > 0][0]);
            cloud_term(cloud, terms[k > 0][1]);
            size_t walls = 0, others = 0;
            for (size_t i = 0; i < particles_fluid(s); i++) {
                double diagonal = 0;
                for (size_t j = 0; j < s->n; j++) {
                    const bool wall = j >= particles_fluid(s);
                    const double rho = cloud->model.phase[s->phase[i]].rho0,
                                 its = wall ? s->rho[j] : cloud->model.phase[s->phase[j]].rho0;
                    const CloudPair pair = cloud_pair(cloud, i, j);
                    const double A = (square(cloud_volume(cloud, i)) + square(cloud_volume(cloud, j))) * pair.F;
                    const double c = i == j ? 0 : -A / (k == 2 ? 2 : rho + its);
                    assert_close(entry(m, i, j), c, 1e-6 * c + 1e-30);
                    assert_true(entry(m, i, j) == entry(m, j, i));
                    assert_true(entry(m, i, j) >= 0);
                    walls += wall && c > 0 && its > 1.1 * fmin(1, rho) && its < 0.9 * fmax(1000, rho);
                    others += !wall && c > 0 && s->phase[i] != s->phase[j];
                    diagonal += entry(m, i, j);
                }
                assert_close(m->diagonal[i], diagonal, 1e-12 * diagonal);
            }
            assert_true(walls > 20 && others > 20);
            cloud_free(cloud);
        }
}

/* What walls balance of a body force is the flux that it makes in each pair, whatever densities the two have. */
static void walls_balance_the_pull_on_each_pair(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = disordered(dim);
        const Particles *s = &cloud->s;
        size_t of_both = 0;
        for (int d = 0; d < dim; d++) {
            cloud->model.gravity[d] = -9.81 + 4 * d;
            cloud->model.wall[0].a[d] = 0.5 - d;
        }
        cloud_term(cloud, &wall_density);
        cloud_term(cloud, &velocity_wall_matrix);
        for (size_t w = particles_fluid(s); w < s->n; w++) {
            double flux = 0, size = 0;
            bool has[2] = {false, false};
            for (size_t i = 0; i < particles_fluid(s); i++) {
                const CloudPair pair = cloud_pair(cloud, w, i);
                const double A = (square(cloud_volume(cloud, w)) + square(cloud_volume(cloud, i))) * pair.F;
                double along = 0;
                for (int d = 0; d < dim; d++)
                    along += cloud->model.dt * (cloud->model.gravity[d] - cloud->model.wall[0].a[d]) * pair.dx[d];
                flux -= 0.5 * A * along;
                size += fabs(A * along);
                has[s->phase[i]] |= pair.F < 0;
            }
            of_both += has[0] && has[1];
            assert_close(cloud->system.b[w], flux, 1e-6 * size); /* entries are floats */
        }
        assert_true(of_both > 5 && cloud->model.dt > 0);
        cloud_free(cloud);
    }
}

/* One or two fluids on a lattice without sides. */
static Cloud *lattice(int dim, bool two)
{
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                           .dx = 0.1,
                                           .n = {12, 12, 9},
                                           .skin = 0.3,
                                           .smoothing = 1,
                                           .kernel = MNS_QUINTIC_SPLINE,
                                           .calibrated = true,
                                           .viscous = true,
                                           .owner = two ? three_kinds : NULL});
    return cloud;
}

static void on_a_lattice_gradients_of_linear_fields_are_exact(void **state)
{
    (void)state;
    static const double SLOPE[3] = {2.5, -1.25, 0.75};
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = lattice(dim, false);
        Particles *s = &cloud->s;
        for (size_t i = 0; i < s->n; i++) {
            cloud->system.x[i] = 7;
            for (int d = 0; d < dim; d++) cloud->system.x[i] += SLOPE[d] * s->x[d][i];
        }
        cloud_term(cloud, &velocity_correction);
        size_t inner = 0;
        for (size_t i = 0; i < s->n; i++) {
            if (!cloud_inner(cloud, i)) continue;
            inner++;
            for (int d = 0; d < dim; d++) assert_close(s->v[d][i], -SLOPE[d] / 1000, 1e-13);
        }
        assert_true(inner > 3);
        cloud_free(cloud);
    }
}

static void on_a_lattice_the_laplacian_of_a_square_and_the_divergence_of_a_stretch_are_exact(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = lattice(dim, false);
        Particles *s = &cloud->s;
        double *out = cloud->system.work[0];
        for (size_t i = 0; i < s->n; i++) {
            cloud->system.x[i] = 3 * s->x[0][i] * s->x[0][i] - 5 * s->x[1][i] * s->x[1][i] + s->x[0][i];
            s->v[0][i] = 5 + 3 * s->x[0][i] - 2 * s->x[1][i];
            s->v[1][i] = 1 - 4 * s->x[1][i] + s->x[0][i];
        }
        cloud_term(cloud, &velocity_matrix);
        matrix_multiply(&cloud->system.matrix, cloud->system.x, out, 1);
        cloud_term(cloud, &velocity_divergence);
        for (size_t i = 0; i < s->n; i++) {
            if (!cloud_inner(cloud, i)) continue;
            assert_close(-2 / cloud_volume(cloud, i) * out[i], (6.0 - 10.0) / 1000, 1e-8); /* floats */
            assert_close(-2 / cloud_volume(cloud, i) * cloud->system.b[i], 3 - 4, 1e-12);
        }
        cloud_free(cloud);
    }
}

/* An even flow has no divergence, wherever the particles are; nor does one over a wall that goes with it. */
static void even_flows_have_no_divergence(void **state)
{
    (void)state;
    for (int slip = 0; slip < 2; slip++) {
        Cloud *cloud = disordered(2);
        Particles *s = &cloud->s;
        cloud->model.wall[0].no_slip = !slip;
        cloud->model.wall[0].a[1] = 3;
        for (size_t i = 0; i < s->n; i++) {
            s->v[0][i] = 11;
            s->v[1][i] = -7 + (i < particles_fluid(s) ? 0 : 3 * cloud->model.dt); /* the wall has gained on the fluid */
        }
        cloud_term(cloud, &mirrored_start);
        cloud_term(cloud, &velocity_divergence);
        for (size_t i = 0; i < particles_fluid(s); i++) assert_close(cloud->system.b[i], 0, 1e-14);
        cloud_free(cloud);
    }
}

/* Where a fluid may slip walls push against what flows into them and let what flows along them alone; where it sticks they show their own velocity. */
static void walls_show_what_they_have_fluids_do(void **state)
{
    (void)state;
    for (int slip = 0; slip < 2; slip++) {
        Cloud *cloud = disordered(2);
        Particles *s = &cloud->s;
        const size_t n = particles_fluid(s);
        cloud->model.wall[0].no_slip = !slip;
        for (size_t i = 0; i < n; i++) {
            s->v[0][i] = 2;
            s->v[1][i] = -0.5;
        }
        cloud_term(cloud, &mirrored_start);
        double along = 0, into = 0, count = 0;
        for (size_t w = 0; w < s->n - n; w++) {
            if (s->x[1][n + w] < 0.2) continue; /* out of sight */
            along += s->v_wall[0][w];
            into += s->v_wall[1][w];
            count++;
        }
        assert_true(count > 5);
        if (slip) assert_close(along / count, 2, 0.15);
        else assert_true(along == 0);
        if (slip) assert_close(into / count, 0.5, 0.05);
        else assert_true(into == 0);
        cloud_free(cloud);
    }
}

/* Each opposite for the two of a pair: weighted by what resists them, all corrections of a space without walls add up to nothing. Those of
 * the density where no pressure is below 0. */
static void corrections_keep_momentum(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int k = 0; k < 3; k++) {
            Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                                   .dx = 0.1,
                                                   .n = {9, 9, 8},
                                                   .jitter = 0.05,
                                                   .smoothing = 1,
                                                   .kernel = MNS_QUINTIC_SPLINE,
                                                   .periodic = {true, true, true},
                                                   .owner = two_kinds});
            Particles *s = &cloud->s;
            uint64_t seed = 3;
            double before[3][1024];
            assert_true(s->n <= 1024 && s->n == particles_fluid(s));
            cloud->model.projection.unit_mobility = k == 2;
            for (size_t i = 0; i < s->n; i++) cloud->system.x[i] = 1e-4 * (cloud_noise(&seed) + (k ? 1 : 0));
            for (int d = 0; d < dim; d++) memcpy(before[d], s->x[d], s->n * sizeof(double));
            cloud_term(cloud, k ? &density_correction : &velocity_correction);
            for (int d = 0; d < dim; d++) {
                double sum = 0, size = 0;
                for (size_t i = 0; i < s->n; i++) {
                    const double change = k ? s->x[d][i] - before[d][i] : s->v[d][i], weight = k == 2 ? 1 : s->m[i];
                    sum += weight * change;
                    size += weight * fabs(change);
                }
                assert_true(size > 0);
                assert_close(sum, 0, 1e-11 * size); /* changes of positions have few digits */
            }
            cloud_free(cloud);
        }
}

/* The largest move, in spacings, by a pressure that is the same everywhere; it is given over h^2, as densities count as 1. */
static double moved_by(double pressure)
{
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = 2,
                                           .dx = 0.1,
                                           .n = {9, 9},
                                           .jitter = 0.1,
                                           .smoothing = 1,
                                           .kernel = MNS_QUINTIC_SPLINE,
                                           .periodic = {true, true}});
    Particles *s = &cloud->s;
    double before[2][128], most = 0;
    assert_true(s->n <= 128 && s->n == particles_fluid(s));
    for (size_t i = 0; i < s->n; i++) cloud->system.x[i] = pressure * cloud->model.kernel.h * cloud->model.kernel.h;
    for (int d = 0; d < 2; d++) memcpy(before[d], s->x[d], s->n * sizeof(double));
    cloud_term(cloud, &density_correction);
    for (size_t i = 0; i < s->n; i++) most = fmax(most, hypot(s->x[0][i] - before[0][i], s->x[1][i] - before[1][i]));
    cloud_free(cloud);
    return most / 0.1;
}

static void a_pressure_below_nothing_draws_nobody_together(void **state)
{
    (void)state;
    const double offset = moved_by(0); /* of the offset alone, which spreads them */
    assert_true(offset > 0 && moved_by(0.1) > 1.4 * offset);
    assert_close(moved_by(-0.3), offset, 1e-12);
}

/* What long waves of densities make of it grows with the number of particles. */
static void a_pressure_spreads_them_no_more_however_high_it_is(void **state)
{
    (void)state;
    const double bound = moved_by(1);
    assert_true(bound > moved_by(0.1) && bound < 2 * moved_by(0.1));
    assert_close(moved_by(100), bound, 1e-12);
}

static void a_density_correction_moves_nobody_far(void **state)
{
    (void)state;
    Cloud *cloud = disordered(2);
    Particles *s = &cloud->s;
    uint64_t seed = 3;
    double before[2][128], most = 0;
    assert_true(s->n <= 128);
    for (size_t i = 0; i < s->n; i++) cloud->system.x[i] = 1e3 * cloud_noise(&seed);
    for (int d = 0; d < 2; d++) memcpy(before[d], s->x[d], s->n * sizeof(double));
    cloud_term(cloud, &density_correction);
    for (size_t i = 0; i < s->n; i++) most = fmax(most, hypot(s->x[0][i] - before[0][i], s->x[1][i] - before[1][i]));
    assert_close(most, 0.1 * cloud->model.dx, 1e-12);
    cloud_free(cloud);
}

/* Two layers between two walls, on a lattice: the pressure that they have at rest solves the system to the last digits of its
 * entries, and takes away what gravity does. */
static void layers_at_rest_are_a_solution(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                               .dx = 0.1,
                                               .n = {8, 18, 8},
                                               .skin = 0.3,
                                               .smoothing = 1,
                                               .kernel = MNS_QUINTIC_SPLINE,
                                               .calibrated = true,
                                               .viscous = true,
                                               .periodic = {true, false, true},
                                               .owner = layers});
        Particles *s = &cloud->s;
        System *y = &cloud->system;
        const double g = -9.81, dt = cloud->model.dt, weight = 1000;
        cloud->model.gravity[1] = g;
        cloud_weigh(cloud, 1, weight); /* one fluid on a lattice is exact; of two, see the case of a tank */
        cloud_term(cloud, &wall_density);
        cloud_term(cloud, &velocity_matrix);
        cloud_term(cloud, &velocity_wall_matrix);
        cloud_term(cloud, &velocity_divergence);
        for (size_t i = 0; i < particles_fluid(s); i++) y->x[i] = weight * dt * g * s->x[1][i];
        system_relax(y, particles_fluid(s));
        for (size_t w = particles_fluid(s); w < s->n; w++)
            if (y->matrix.blocks[w]) assert_close(y->x[w], weight * dt * g * s->x[1][w], 1e-4);
        matrix_multiply(&y->matrix, y->x, y->work[0], 1);
        double most = 0, left = 0;
        for (size_t i = 0; i < y->matrix.n; i++) {
            most = fmax(most, fabs(y->b[i]));
            left = fmax(left, fabs(y->work[0][i] - y->b[i]));
        }
        assert_true(most > 0);
        assert_less(left, 1e-6 * most);
        cloud_term(cloud, &velocity_correction);
        for (size_t i = 0; i < particles_fluid(s); i++) {
            assert_close(s->v[1][i], -dt * g, 1e-6 * dt * fabs(g));
            assert_close(s->v[0][i], 0, 1e-6 * dt * fabs(g));
        }
        cloud_free(cloud);
    }
}

/* Largest divergence of all. */
static double divergence_of(Cloud *cloud)
{
    double most = 0;
    cloud_term(cloud, &velocity_divergence);
    for (size_t i = 0; i < cloud->s.n; i++) most = fmax(most, fabs(cloud->system.b[i]));
    return most;
}

/* The Laplacian has a narrower stencil than divergence after gradient, so what is left is not nothing, but small where the
 * flow is smooth. */
static void a_projection_takes_the_divergence_away(void **state)
{
    (void)state;
    for (int two = 0; two < 2; two++) {
        Cloud *cloud = cloud_new(&(CloudSetup){.dim = 2,
                                               .dx = 1.0 / 24,
                                               .n = {24, 24},
                                               .smoothing = 1,
                                               .kernel = MNS_QUINTIC_SPLINE,
                                               .calibrated = true,
                                               .periodic = {true, true},
                                               .owner = two ? two_kinds : NULL});
        Particles *s = &cloud->s;
        SolveReport report;
        if (two) cloud_weigh(cloud, 1, 250);
        const double k = 2 * acos(-1);
        for (size_t i = 0; i < s->n; i++) {
            s->v[0][i] = sin(k * s->x[0][i]) + cos(k * s->x[1][i]);
            s->v[1][i] = 0.5 * sin(k * (s->x[0][i] + s->x[1][i]));
        }
        cloud_term(cloud, &velocity_matrix);
        const double before = divergence_of(cloud);
        solve_cg.solve(&cloud->system, &(SolveGoal){1e-9, 500}, &report);
        assert_true(report.converged);
        cloud_term(cloud, &velocity_correction);
        assert_less(divergence_of(cloud), (two ? 0.25 : 0.05) * before);
        cloud_free(cloud);
    }
}

static unsigned iterations_of(size_t n, const SolveMethod *method)
{
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = 2,
                                           .dx = 1.0 / (double)n,
                                           .n = {n, n},
                                           .jitter = 0.2,
                                           .smoothing = 1,
                                           .kernel = MNS_QUINTIC_SPLINE,
                                           .calibrated = true,
                                           .periodic = {true, true},
                                           .threads = 2,
                                           .owner = two_kinds});
    Particles *s = &cloud->s;
    SolveReport report;
    const double k = 2 * acos(-1);
    for (size_t i = 0; i < s->n; i++) {
        s->v[0][i] = sin(k * s->x[0][i]) + cos(k * s->x[1][i]);
        s->v[1][i] = 0.5 * sin(k * (s->x[0][i] + s->x[1][i]));
    }
    cloud_term(cloud, &velocity_matrix);
    cloud_term(cloud, &velocity_divergence);
    method->solve(&cloud->system, &(SolveGoal){1e-6, 5000}, &report);
    assert_true(report.converged);
    cloud_free(cloud);
    return report.iterations;
}

/* Of densities 1000 and 1, in disorder; by the diagonal alone they are as many as there are particles along a side. */
static void multigrid_takes_hardly_more_iterations_for_ten_times_the_particles(void **state)
{
    (void)state;
    if (!amg_exists() || getenv("MENISCUS_SANITIZED")) skip();
    const SolveMethod *const methods[] = {&solve_amg, &solve_amg_bicgstab};
    const unsigned plain[] = {iterations_of(100, &solve_cg), iterations_of(316, &solve_cg)};
    for (int k = 0; k < 2; k++) {
        const unsigned few = iterations_of(100, methods[k]), many = iterations_of(316, methods[k]);
        if (many > 1.5 * few + 1) fail_msg("%s: %u iterations, then %u", methods[k]->name, few, many);
    }
    assert_true(plain[1] > 2 * plain[0]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_system_is_that_of_the_paper_and_symmetric_to_the_last_bit),
        cmocka_unit_test(walls_balance_the_pull_on_each_pair),
        cmocka_unit_test(on_a_lattice_gradients_of_linear_fields_are_exact),
        cmocka_unit_test(on_a_lattice_the_laplacian_of_a_square_and_the_divergence_of_a_stretch_are_exact),
        cmocka_unit_test(even_flows_have_no_divergence),
        cmocka_unit_test(walls_show_what_they_have_fluids_do),
        cmocka_unit_test(corrections_keep_momentum),
        cmocka_unit_test(a_pressure_below_nothing_draws_nobody_together),
        cmocka_unit_test(a_pressure_spreads_them_no_more_however_high_it_is),
        cmocka_unit_test(a_density_correction_moves_nobody_far),
        cmocka_unit_test(layers_at_rest_are_a_solution),
        cmocka_unit_test(multigrid_takes_hardly_more_iterations_for_ten_times_the_particles),
        cmocka_unit_test(a_projection_takes_the_divergence_away),
    };
    return cmocka_run_group_tests_name("projection", tests, NULL, NULL);
}
