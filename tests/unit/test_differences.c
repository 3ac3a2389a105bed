/* SPDX-License-Identifier: BSD-3-Clause */
/* Generalized finite differences: what they are exact for, what mixtures and interfaces they find, how walls continue fields, and that
 * the pressure takes divergence away. */
#include "sim/locals/locals.h"
#include "sim/solve/solve.h"
#include "sim/terms/curvature.h"
#include "sim/terms/matrix_row.h"
#include "sim/terms/terms.h"
#include "tests/support/check.h"
#include "tests/support/cloud.h"
#include "tests/support/sims.h"

static const double CENTRE[3] = {0.43, 0.56, 0.47}, DENSITY = 1000;

/* Of the first velocity component and so on: d_b u_a. */
static const double GRADIENT[3][3] = {{0.7, -0.2, 0.4}, {0.3, -1.1, 0.6}, {-0.5, 0.8, 0.9}};

static int halves(const double x[3])
{
    return x[1] < 0.5 ? CLOUD_WATER : CLOUD_AIR;
}

static int disc(const double x[3])
{
    return hypot(x[0] - 0.5, x[1] - 0.5) < 0.25 ? CLOUD_WATER : CLOUD_AIR;
}

static int over_a_wall(const double x[3])
{
    return x[1] < 0.3 ? CLOUD_WALL : CLOUD_WATER;
}

/* Density 1000 throughout, viscosities 3 and 0.5, no tension. */
static Cloud *cloud_of(int dim, double dx, double jitter, bool periodic, int (*owner)(const double[3]))
{
    const size_t n = (size_t)lround(1 / dx);
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                           .dx = dx,
                                           .n = {n, n, n},
                                           .jitter = jitter,
                                           .smoothing = 0.9,
                                           .kernel = MNS_QUINTIC_SPLINE,
                                           .calibrated = true,
                                           .viscous = true,
                                           .periodic = {periodic, periodic, periodic},
                                           .owner = owner});
    cloud_weigh(cloud, 1, DENSITY);
    return cloud;
}

static void find_shape(Cloud *cloud)
{
    cloud_term(cloud, &truncation);
    cloud_term(cloud, &mixture);
}

static void set_linear(Cloud *cloud)
{
    Particles *s = &cloud->s;
    for (size_t i = 0; i < s->n; i++)
        for (int a = 0; a < s->dim; a++) {
            s->v[a][i] = 3 - a;
            for (int b = 0; b < s->dim; b++) s->v[a][i] += GRADIENT[a][b] * s->x[b][i];
        }
}

static double square_at(const Particles *s, size_t i)
{
    double r2 = 0;
    for (int d = 0; d < s->dim; d++) r2 += (s->x[d][i] - CENTRE[d]) * (s->x[d][i] - CENTRE[d]);
    return r2;
}

static void correct_velocities(Cloud *cloud)
{
    cloud_term(cloud, &difference_correction);
    local_run(&corrected_velocity, &cloud->s, &cloud->model, 1);
}

static double density_of(const Cloud *cloud, size_t i)
{
    return mixed(mixture_of_densities(&cloud->model), cloud->s.colour[i]);
}

static double viscosity_of(const Cloud *cloud, size_t i)
{
    return mixed(mixture_of_viscosities(&cloud->model), cloud->s.colour[i]);
}

/* --- what differences are exact for ---------------------------------------------------------------------------------------- */

static void gradients_of_linear_fields_are_exact_anywhere(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = cloud_of(dim, 1.0 / 12, 0.3, false, NULL);
        Particles *s = &cloud->s;
        double trace = 0;
        for (int d = 0; d < dim; d++) trace += GRADIENT[d][d];
        set_linear(cloud);
        find_shape(cloud);
        for (size_t i = 0; i < s->n; i++) {
            cloud->system.x[i] = 5;
            for (int d = 0; d < dim; d++) cloud->system.x[i] += (2 + d) * s->x[d][i];
        }
        assert_true(matrix_rows_lay(s, &cloud->nb));
        cloud_term(cloud, &difference_matrix);
        for (size_t i = 0; i < s->n; i++)
            if (cloud_inner(cloud, i)) assert_close(cloud->system.b[i], -trace, 1e-11);
        for (int d = 0; d < dim; d++)
            for (size_t i = 0; i < s->n; i++) s->v[d][i] = 0;
        correct_velocities(cloud); /* at corners, too */
        for (size_t i = 0; i < s->n; i++)
            for (int d = 0; d < dim; d++) assert_close(s->v[d][i], -(2 + d) / DENSITY, 1e-11 / DENSITY);
        cloud_free(cloud);
    }
}

static void laplacians_see_nothing_in_linear_fields_and_all_of_a_square(void **state)
{
    (void)state;
    static const Term *const terms[] = {&harmonic_diffusion, &divtau_diffusion, &conservative_diffusion};
    static const MnsDiffusion diffusions[] = {MNS_DIFFUSION_HARMONIC, MNS_DIFFUSION_DIVTAU, MNS_DIFFUSION_CONSERVATIVE};
    for (int dim = 2; dim <= 3; dim++)
        for (int k = 0; k < 3; k++) {
            Cloud *cloud = cloud_of(dim, 1.0 / 12, 0.3, false, NULL);
            Particles *s = &cloud->s;
            const double nu = 3 / DENSITY;
            cloud->model.differences.diffusion = diffusions[k];
            find_shape(cloud);
            set_linear(cloud);
            cloud_term(cloud, terms[k]);
            for (size_t i = 0; i < s->n; i++)
                for (int d = 0; d < dim && cloud_inner(cloud, i); d++) assert_close(s->a[d][i], 0, 1e-9 * nu);
            for (size_t i = 0; i < s->n; i++)
                for (int d = 0; d < dim; d++) s->v[d][i] = (1 + d) * square_at(s, i);
            cloud_term(cloud, terms[k]);
            for (size_t i = 0; i < s->n; i++)
                for (int d = 0; d < dim && cloud_inner(cloud, i); d++)
                    assert_close(s->a[d][i], nu * 2 * dim * (1 + d), 1e-9 * nu);
            cloud_free(cloud);
        }
}

/* The same weights are those of the pressure, as floats. */
static void the_pressure_system_is_the_laplacian_over_density(void **state)
{
    (void)state;
    Cloud *cloud = cloud_of(2, 1.0 / 12, 0.3, false, NULL);
    Particles *s = &cloud->s;
    System *y = &cloud->system;
    find_shape(cloud);
    assert_true(matrix_rows_lay(s, &cloud->nb));
    cloud_term(cloud, &difference_matrix);
    for (size_t i = 0; i < s->n; i++) y->x[i] = square_at(s, i);
    matrix_multiply(&y->matrix, y->x, y->work[0], 1);
    for (size_t i = 0; i < s->n; i++)
        if (cloud_inner(cloud, i)) assert_close(y->work[0][i], -4 / DENSITY, 1e-4 / DENSITY); /* floats */
    cloud_free(cloud);
}

/* --- two fluids --------------------------------------------------------------------------------------------------------- */

static void mixtures_are_between_their_fluids(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = cloud_of(dim, 0.1, 0.2, true, halves);
        Particles *s = &cloud->s;
        cloud->model.phase[1].rho0 = 10;
        find_shape(cloud);
        size_t pure = 0, between = 0;
        for (size_t i = 0; i < s->n; i++) {
            double all = 0, first = 0;
            for (size_t j = 0; j < s->n; j++) {
                const CloudPair pair = cloud_pair(cloud, i, j);
                all += pair.W;
                if (s->phase[j] == 0) first += pair.W;
            }
            assert_close(s->colour[i], first / all, 1e-13);
            assert_close(density_of(cloud, i), 10 + 990 * first / all, 1e-10);
            assert_close(viscosity_of(cloud, i), 0.5 + 2.5 * first / all, 1e-12);
            pure += s->colour[i] == 0 || s->colour[i] == 1;
            between += s->colour[i] > 0 && s->colour[i] < 1;
        }
        assert_true(pure > 0 && between > 0);
        cloud_free(cloud);
    }
}

/* Against sums over all pairs: the harmonic one with its sign turned from what is printed, and that of smoothed particles. */
static void the_single_sums_are_those_of_the_paper(void **state)
{
    (void)state;
    for (int sph = 0; sph < 2; sph++) {
        Cloud *cloud = cloud_of(2, 0.1, 0.2, true, halves);
        Particles *s = &cloud->s;
        uint64_t seed = 5;
        cloud->model.phase[1].rho0 = 300;
        cloud->model.differences.diffusion = sph ? MNS_DIFFUSION_SPH : MNS_DIFFUSION_HARMONIC;
        find_shape(cloud);
        for (size_t i = 0; i < s->n; i++) {
            s->m[i] = s->rho[i] * 0.01 * (1 + 0.1 * cloud_noise(&seed));
            for (int d = 0; d < 2; d++) s->v[d][i] = cloud_noise(&seed);
        }
        cloud_term(cloud, sph ? &sph_diffusion : &harmonic_diffusion);
        const double printed = cloud->model.kernel.alpha / cloud->model.kernel.beta;
        for (size_t i = 0; i < s->n; i++) {
            double above[2] = {0}, below = 0;
            for (size_t j = 0; j < s->n; j++) {
                const CloudPair pair = cloud_pair(cloud, i, j);
                const double a = viscosity_of(cloud, i), b = viscosity_of(cloud, j), mu = 2 * a * b / (a + b);
                const double k = pair.W * (1 - pair.dx[0] * s->offset[0][i] - pair.dx[1] * s->offset[1][i]);
                const double V2 =
                    cloud_volume(cloud, i) * cloud_volume(cloud, i) + cloud_volume(cloud, j) * cloud_volume(cloud, j);
                const double c = sph ? -mu * V2 * printed * pair.F : 4 * mu * k;
                for (int d = 0; d < 2 && j != i; d++) above[d] += c * (s->v[d][j] - s->v[d][i]);
                below += pair.r * pair.r * k;
            }
            for (int d = 0; d < 2; d++)
                assert_close(s->a[d][i], above[d] / ((sph ? cloud_volume(cloud, i) : below) * density_of(cloud, i)),
                             1e-9);
        }
        cloud_free(cloud);
    }
}

/* Flow along a flat interface has no part in grad u^T of grad mu: the conservative operator is the harmonic one to the last bit. */
static void in_parallel_shear_the_transpose_does_nothing(void **state)
{
    (void)state;
    Cloud *cloud = cloud_of(2, 0.05, 0, true, halves);
    Particles *s = &cloud->s;
    double harmonic[400], most = 0;
    find_shape(cloud);
    cloud_term(cloud, &colour_gradient);
    for (size_t i = 0; i < s->n; i++) s->v[0][i] = sin(6 * s->x[1][i]);
    cloud->model.differences.diffusion = MNS_DIFFUSION_HARMONIC;
    cloud_term(cloud, &harmonic_diffusion);
    for (size_t i = 0; i < s->n; i++) harmonic[i] = s->a[0][i];
    cloud->model.differences.diffusion = MNS_DIFFUSION_CONSERVATIVE;
    cloud_term(cloud, &conservative_diffusion);
    for (size_t i = 0; i < s->n; i++) {
        assert_true(s->a[0][i] == harmonic[i]);
        assert_close(s->a[1][i], 0, 1e-14);
    }
    cloud->model.differences.diffusion = MNS_DIFFUSION_DIVTAU;
    cloud_term(cloud, &divtau_diffusion);
    for (size_t i = 0; i < s->n; i++) most = fmax(most, fabs(s->a[0][i] - harmonic[i]));
    assert_true(most > 1e-3);
    cloud_free(cloud);
}

/* Sum of the forces of an operator on all, over that of their magnitudes; on a lattice without sides. */
static double net_force(const Term *term, MnsDiffusion diffusion)
{
    Cloud *cloud = cloud_of(2, 0.05, 0, true, disc);
    Particles *s = &cloud->s;
    double sum = 0, size = 0;
    cloud->model.differences.diffusion = diffusion;
    find_shape(cloud);
    cloud_term(cloud, &colour_gradient);
    for (size_t i = 0; i < s->n; i++) {
        s->v[0][i] = sin(6.283185307179586 * (s->x[1][i] - 0.3 * s->x[0][i] * (1 - s->x[0][i])));
        s->v[1][i] = cos(6.283185307179586 * s->x[0][i]);
    }
    cloud_term(cloud, term);
    for (size_t i = 0; i < s->n; i++) {
        sum += density_of(cloud, i) * s->a[0][i];
        size += density_of(cloud, i) * fabs(s->a[0][i]);
    }
    cloud_free(cloud);
    return fabs(sum) / size;
}

/* What the harmonic sum gives one particle it takes from another; div tau as products does not. */
static void sums_of_pairs_keep_momentum(void **state)
{
    (void)state;
    assert_less(net_force(&harmonic_diffusion, MNS_DIFFUSION_HARMONIC), 1e-12);
    assert_less(net_force(&sph_diffusion, MNS_DIFFUSION_SPH), 1e-12);
    assert_true(net_force(&divtau_diffusion, MNS_DIFFUSION_DIVTAU) > 1e-4);
}

/* Root mean square error of an operator, over div tau, where the viscosity is a smooth function of y: u = (sin a x cos a y, -cos a x sin a y),
 * mu = 2 + sin 2 pi y, so that div tau = mu lap u + mu' (d_y u + d_x v, 2 d_y v). */
static double smooth_error(const Term *term, MnsDiffusion diffusion, double dx)
{
    Cloud *cloud = cloud_of(2, dx, 0, true, disc);
    Particles *s = &cloud->s;
    const double a = 6.283185307179586;
    double error = 0, size = 0;
    cloud->model.differences.diffusion = diffusion;
    cloud->model.phase[0].mu = 3;
    cloud->model.phase[1].mu = 1;
    find_shape(cloud);
    for (size_t i = 0; i < s->n; i++) {
        s->colour[i] = (1 + sin(a * s->x[1][i])) / 2;
        s->v[0][i] = sin(a * s->x[0][i]) * cos(a * s->x[1][i]);
        s->v[1][i] = -cos(a * s->x[0][i]) * sin(a * s->x[1][i]);
    }
    cloud_term(cloud, &colour_gradient);
    cloud_term(cloud, term);
    for (size_t i = 0; i < s->n; i++) {
        const double x = a * s->x[0][i], y = a * s->x[1][i], mu = 2 + sin(y), slope = a * cos(y);
        const double exact[2] = {-2 * a * a * mu * sin(x) * cos(y), /* d_y u + d_x v = 0 */
                                 2 * a * a * mu * cos(x) * sin(y) - 2 * slope * a * cos(x) * cos(y)};
        for (int d = 0; d < 2; d++) {
            error += pow(DENSITY * s->a[d][i] - exact[d], 2);
            size += exact[d] * exact[d];
        }
    }
    cloud_free(cloud);
    return sqrt(error / size);
}

static void two_operators_are_the_divergence_of_the_stress_and_one_is_not(void **state)
{
    (void)state;
    const double divtau[2] = {smooth_error(&divtau_diffusion, MNS_DIFFUSION_DIVTAU, 1.0 / 20),
                              smooth_error(&divtau_diffusion, MNS_DIFFUSION_DIVTAU, 1.0 / 40)},
                 whole[2] = {smooth_error(&conservative_diffusion, MNS_DIFFUSION_CONSERVATIVE, 1.0 / 20),
                             smooth_error(&conservative_diffusion, MNS_DIFFUSION_CONSERVATIVE, 1.0 / 40)};
    assert_less(divtau[1], 0.01);
    assert_less(whole[1], 0.01);
    assert_less(divtau[1], 0.28 * divtau[0]); /* second order */
    assert_less(whole[1], 0.28 * whole[0]);
    assert_true(smooth_error(&harmonic_diffusion, MNS_DIFFUSION_HARMONIC, 1.0 / 40) > 0.1);
}

/* --- surface tension ------------------------------------------------------------------------------------------------------ */

/* Its size is 1/R, positive within and without, as it is that of the first fluid's surface, and none far away. */
static void a_disc_has_its_curvature(void **state)
{
    (void)state;
    const double dx = 0.025, R = 0.25;
    Cloud *cloud = cloud_of(2, dx, 0, true, disc);
    Particles *s = &cloud->s;
    find_shape(cloud);
    cloud_term(cloud, &colour_gradient);
    cloud_term(cloud, &colour_curvature);
    cloud_term(cloud, &mean_colour_curvature);
    double sum = 0, weight = 0, N = 0;
    for (size_t i = 0; i < s->n; i++) {
        const double r = hypot(s->x[0][i] - 0.5, s->x[1][i] - 0.5);
        sum += curvature_weights(s)[i] * s->curvature[i];
        weight += curvature_weights(s)[i];
        N += hypot(s->colour_gradient[0][i], s->colour_gradient[1][i]);
        if (fabs(r - R) > 8 * dx) assert_true(s->curvature[i] == 0);
    }
    assert_close(sum / weight, 1 / R, 0.02 / R);
    assert_close(N * DENSITY * dx * dx, 2 * acos(-1) * R, 0.03 * 2 * acos(-1) * R); /* the colour rises by 1 */
    cloud_free(cloud);
}

/* --- walls ----------------------------------------------------------------------------------------------------------------- */

static Cloud *wall_below(int dim, double jitter, bool no_slip)
{
    Cloud *cloud = cloud_of(dim, 1.0 / 12, jitter, false, over_a_wall);
    Particles *s = &cloud->s;
    cloud->model.wall[0].no_slip = no_slip;
    for (size_t w = particles_fluid(s); w < s->n; w++) {
        s->v[0][w] = 2;
        s->to_surface[1][w - particles_fluid(s)] = 0.3 - s->x[1][w];
    }
    find_shape(cloud);
    return cloud;
}

static void a_shear_over_a_wall_goes_on_in_it(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = wall_below(dim, 0.2, true);
        Particles *s = &cloud->s;
        size_t seen = 0;
        for (size_t i = 0; i < particles_fluid(s); i++) {
            s->v[0][i] = 2 + 3 * (s->x[1][i] - 0.3);
            s->v[1][i] = -0.7 * (s->x[1][i] - 0.3);
        }
        cloud_term(cloud, &continued_velocity);
        for (size_t w = particles_fluid(s); w < s->n; w++) {
            if (s->x[1][w] < 0.2) continue;
            const size_t k = w - particles_fluid(s);
            assert_close(s->v_wall[0][k], 2 + 3 * (s->x[1][w] - 0.3), 1e-12);
            assert_close(s->v_wall[1][k], -0.7 * (s->x[1][w] - 0.3), 1e-12);
            seen++;
        }
        assert_true(seen > 5);
        cloud_free(cloud);
    }
}

/* What glides is not held; what flows into the wall is. */
static void with_slip_only_what_flows_into_a_wall_is_turned(void **state)
{
    (void)state;
    Cloud *cloud = wall_below(2, 0.2, false);
    Particles *s = &cloud->s;
    for (size_t i = 0; i < particles_fluid(s); i++) {
        s->v[0][i] = 5;
        s->v[1][i] = -0.7 * (s->x[1][i] - 0.3);
    }
    cloud_term(cloud, &continued_velocity);
    for (size_t w = particles_fluid(s); w < s->n; w++) {
        if (s->x[1][w] < 0.2) continue;
        assert_close(s->v_wall[0][w - particles_fluid(s)], 5, 1e-12);
        assert_close(s->v_wall[1][w - particles_fluid(s)], -0.7 * (s->x[1][w] - 0.3), 1e-12);
    }
    cloud_free(cloud);
}

/* What gravity has given a fluid at rest in a step, the pressure of the fluid above takes away, to the digits of floats. */
static void a_layer_at_rest_on_a_wall_stays(void **state)
{
    (void)state;
    const double g = -9.81;
    for (int slip = 0; slip < 2; slip++) {
        Cloud *cloud = wall_below(2, 0.2, !slip);
        Particles *s = &cloud->s;
        System *y = &cloud->system;
        const double dt = cloud->model.dt, weight = DENSITY * dt * g;
        cloud->model.gravity[1] = g;
        for (size_t i = 0; i < s->n; i++) {
            s->v[0][i] = 0;
            s->v[1][i] = i < particles_fluid(s) ? dt * g : 0;
        }
        cloud_term(cloud, &continued_start);
        assert_true(matrix_rows_lay(s, &cloud->nb));
        cloud_term(cloud, &difference_matrix);
        cloud_term(cloud, &difference_wall_matrix);
        for (size_t i = 0; i < particles_fluid(s); i++) {
            y->x[i] = weight * s->x[1][i];
            assert_close(y->b[i], 0, 1e-12);
        }
        system_relax(y, particles_fluid(s));
        for (size_t w = particles_fluid(s); w < s->n; w++)
            if (y->matrix.blocks[w]) assert_close(y->x[w], weight * s->x[1][w], 1e-5 * fabs(weight));
        correct_velocities(cloud);
        for (size_t i = 0; i < particles_fluid(s); i++) assert_close(s->v[1][i], 0, 1e-5 * dt * fabs(g));
        cloud_free(cloud);
    }
}

/* Walls balance gravity towards each particle of fluid by itself, by the density between the two: pressures that do so leave nothing of a
 * wall's row, whatever fluids are in sight, and what gravity does there is no matter of how dense they are. */
static void walls_balance_gravity_pair_by_pair(void **state)
{
    (void)state;
    Cloud *cloud = wall_below(2, 0.2, false), *even = wall_below(2, 0.2, false);
    Particles *s = &cloud->s;
    System *y = &cloud->system;
    const double g[2] = {3, -9.81}, dt = cloud->model.dt;
    cloud->model.phase[1].rho0 = even->model.phase[1].rho0 / 1000;
    size_t seen = 0;
    for (Cloud *each = cloud; each; each = each == cloud ? even : NULL) {
        for (int d = 0; d < 2; d++) each->model.gravity[d] = g[d];
        for (size_t i = 0; i < each->s.n; i++) each->s.colour[i] = each->s.x[0][i] < 0.5 ? 1 : 0;
        assert_true(matrix_rows_lay(&each->s, &each->nb));
        cloud_term(each, &difference_wall_matrix);
    }
    for (size_t w = particles_fluid(s); w < s->n; w++) {
        const Matrix *m = &y->matrix;
        double made = 0, size = 0;
        for (size_t k = m->start[w] * ENTRIES; k < (m->start[w] + m->blocks[w]) * ENTRIES; k++) {
            const size_t f = m->column[k];
            double along = 0;
            for (int d = 0; d < 2; d++) along += g[d] * (s->x[d][w] - s->x[d][f]);
            made += (double)m->c[k] * 0.5 * (density_of(cloud, w) + density_of(cloud, f)) * dt * along;
            size += (double)m->c[k] * fabs(along) * density_of(cloud, w) * dt;
        }
        assert_close(made, y->b[w], 1e-6 * size + 1e-300);
        assert_close(y->b[w], even->system.b[w], 1e-12 * fabs(y->b[w]));
        seen += m->blocks[w] > 0 && fabs(s->x[0][w] - 0.5) < 0.2;
    }
    assert_true(seen > 5);
    cloud_free(cloud);
    cloud_free(even);
}

/* --- the pressure, and shifts -------------------------------------------------------------------------------------------- */

static double divergence_left(Cloud *cloud)
{
    double most = 0;
    cloud_term(cloud, &difference_matrix);
    for (size_t i = 0; i < cloud->s.n; i++) most = fmax(most, fabs(cloud->system.b[i]));
    return most;
}

static void the_pressure_takes_divergence_away(void **state)
{
    (void)state;
    Cloud *cloud = cloud_of(2, 1.0 / 24, 0.1, true, halves);
    Particles *s = &cloud->s;
    SolveReport report;
    const double k = 6.283185307179586;
    for (size_t i = 0; i < s->n; i++) {
        s->v[0][i] = sin(k * s->x[0][i]) + cos(k * s->x[1][i]);
        s->v[1][i] = 0.5 * sin(k * (s->x[0][i] + s->x[1][i]));
    }
    cloud->model.phase[1].rho0 = 250;
    find_shape(cloud);
    assert_true(matrix_rows_lay(s, &cloud->nb));
    const double before = divergence_left(cloud);
    solve_bicgstab.solve(&cloud->system, &(SolveGoal){1e-9, 500}, &report);
    assert_true(report.converged);
    correct_velocities(cloud);
    assert_true(matrix_rows_lay(s, &cloud->nb));
    assert_less(divergence_left(cloud), 0.3 * before);
    cloud_free(cloud);
}

/* Two that are close go apart by a twentieth of the spacing and no more; velocities are those of where they went. */
static void shifts_are_capped_and_carry_velocity(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        Cloud *cloud = cloud_of(dim, 0.1, 0.1, true, NULL);
        Particles *s = &cloud->s;
        const size_t pair[2] = {cloud_index(cloud, 44), cloud_index(cloud, 45)};
        double before[3][1000], most = 0;
        for (int d = 0; d < dim; d++) s->x[d][pair[1]] = s->x[d][pair[0]] + 0.004;
        for (int d = 0; d < dim; d++)
            for (size_t i = 0; i < s->n; i++) before[d][i] = s->x[d][i];
        set_linear(cloud);
        cloud->model.dt = 0.02;
        cloud_term(cloud, &even_spacing);
        local_run(&even_position, s, &cloud->model, 1);
        for (size_t i = 0; i < s->n; i++) {
            double dx2 = 0, apart = 0;
            for (int d = 0; d < dim; d++) {
                const double dx = s->x[d][i] - before[d][i];
                dx2 += dx * dx;
                apart += dx * (i == pair[0] ? -1 : 1);
            }
            if (i == pair[0] || i == pair[1]) assert_true(apart > 0);
            most = fmax(most, sqrt(dx2));
            if (!cloud_inner(cloud, i) || before[0][i] < 0.4 || before[0][i] > 0.6 || before[1][i] < 0.4 ||
                before[1][i] > 0.6 || (dim == 3 && (before[2][i] < 0.4 || before[2][i] > 0.6)))
                continue;
            for (int a = 0; a < dim; a++) {
                double u = 3 - a;
                for (int b = 0; b < dim; b++) u += GRADIENT[a][b] * s->x[b][i];
                assert_close(s->v[a][i], u, 1e-12);
            }
        }
        assert_close(most, 0.05 * 0.1, 1e-12);
        cloud_free(cloud);
    }
}

/* Beside an interface no particle is shifted through it, unless that is asked for. */
static void shifts_are_along_interfaces(void **state)
{
    (void)state;
    for (int only = 0; only < 2; only++) {
        Cloud *cloud = cloud_of(2, 0.1, 0.2, true, NULL);
        Particles *s = &cloud->s;
        double before[2][100], along = 0, across = 0;
        for (size_t i = 0; i < s->n; i++)
            for (int d = 0; d < 2; d++) {
                before[d][i] = s->x[d][i];
                s->v[d][i] = i % 2 ? 1 : 0; /* past each other */
                s->normal[d][i] = d == 0 ? 0.6 : 0.8;
            }
        cloud->model.dt = 0.01;
        cloud->model.differences.along = only;
        cloud_term(cloud, &even_spacing);
        local_run(&even_position, s, &cloud->model, 1);
        for (size_t i = 0; i < s->n; i++) {
            const double dx = s->x[0][i] - before[0][i], dy = s->x[1][i] - before[1][i];
            across = fmax(across, fabs(0.6 * dx + 0.8 * dy));
            along = fmax(along, fabs(0.8 * dx - 0.6 * dy));
        }
        assert_true(along > 1e-5 && (only ? across < 1e-15 : across > 1e-5));
        cloud_free(cloud);
    }
}

/* The force is that of the excess of density: none on the fluid in which others float, and g (rho - rho_0) on them. */
static void what_is_lighter_floats(void **state)
{
    (void)state;
    Cloud *cloud = cloud_of(2, 0.1, 0, true, halves);
    Particles *s = &cloud->s;
    cloud->model.gravity[1] = -2;
    cloud->model.differences.buoyancy = 1000;
    cloud->model.phase[1].rho0 = 250;
    for (size_t i = 0; i < s->n; i++) s->colour[i] = i % 2 ? 1 : 0;
    local_run(&buoyancy, s, &cloud->model, 1);
    for (size_t i = 0; i < s->n; i++) assert_close(s->a[1][i], i % 2 ? 0 : 6, 1e-12);
    cloud_free(cloud);
}

/* --- the start -------------------------------------------------------------------------------------------------------------- */

/* Fluid is off the lattice by no more than it says, walls are on it, another seed is another arrangement, and walls know their surface. */
static void disorder_is_bounded_and_repeatable(void **state)
{
    (void)state;
    MnsCase *cases[4];
    MnsSim *sims[4];
    for (int k = 0; k < 4; k++) {
        cases[k] = case_dam_break(2, 10);
        cases[k]->scheme.name = "differences";
        cases[k]->disorder = k == 0 ? 0 : 0.1;
        cases[k]->seed = k == 3 ? 9 : 8;
        sims[k] = sim_of(cases[k]);
    }
    const Particles *s = &sims[0]->s, *a = &sims[1]->s, *b = &sims[2]->s, *c = &sims[3]->s;
    const double most = 0.1 * sims[0]->model.dx * 1.02; /* spacings are stretched to fit */
    double moved = 0, other = 0;
    for (size_t i = 0; i < s->n; i++)
        for (size_t j = 0; j < a->n; j++) { /* storage orders differ */
            if (a->id[j] != s->id[i]) continue;
            for (int d = 0; d < 2; d++) {
                const double dx = fabs(a->x[d][j * a->x_step] - s->x[d][i * s->x_step]);
                assert_true(dx <= most && (i < particles_fluid(s) || dx == 0));
                moved = fmax(moved, dx);
            }
        }
    assert_true(moved > 0.95 * 0.1 * sims[0]->model.dx);
    assert_true(mns_sim_hash(sims[1]) == mns_sim_hash(sims[2]));
    assert_true(mns_sim_hash(sims[1]) != mns_sim_hash(sims[3]));
    assert_true(a->n == b->n && a->n == c->n);
    for (size_t w = particles_fluid(a); w < a->n; w++) {
        const double x = a->x[0][w * a->x_step], y = a->x[1][w * a->x_step];
        if (x < 0.5 || x > 4.5 || y > 0) continue;
        assert_close(a->to_surface[0][w - particles_fluid(a)], 0, 1e-9);
        assert_close(a->to_surface[1][w - particles_fluid(a)], -y, 1e-9);
        other++;
    }
    assert_true(other > 10);
    for (int k = 0; k < 4; k++) sim_done(sims[k], cases[k]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(gradients_of_linear_fields_are_exact_anywhere),
        cmocka_unit_test(laplacians_see_nothing_in_linear_fields_and_all_of_a_square),
        cmocka_unit_test(the_pressure_system_is_the_laplacian_over_density),
        cmocka_unit_test(mixtures_are_between_their_fluids),
        cmocka_unit_test(the_single_sums_are_those_of_the_paper),
        cmocka_unit_test(in_parallel_shear_the_transpose_does_nothing),
        cmocka_unit_test(sums_of_pairs_keep_momentum),
        cmocka_unit_test(two_operators_are_the_divergence_of_the_stress_and_one_is_not),
        cmocka_unit_test(a_disc_has_its_curvature),
        cmocka_unit_test(a_shear_over_a_wall_goes_on_in_it),
        cmocka_unit_test(with_slip_only_what_flows_into_a_wall_is_turned),
        cmocka_unit_test(a_layer_at_rest_on_a_wall_stays),
        cmocka_unit_test(walls_balance_gravity_pair_by_pair),
        cmocka_unit_test(the_pressure_takes_divergence_away),
        cmocka_unit_test(shifts_are_capped_and_carry_velocity),
        cmocka_unit_test(shifts_are_along_interfaces),
        cmocka_unit_test(what_is_lighter_floats),
        cmocka_unit_test(disorder_is_bounded_and_repeatable),
    };
    return cmocka_run_group_tests_name("differences", tests, NULL, NULL);
}
