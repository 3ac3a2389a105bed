/* SPDX-License-Identifier: BSD-3-Clause */
/* Differences where something is curved: a sphere has twice the curvature of its radius, and a tube with slip holds nothing that flows
 * along it. */
#include "sim/terms/curvature.h"
#include "sim/terms/terms.h"
#include "tests/support/check.h"
#include "tests/support/cloud.h"
#include "tests/support/sims.h"

static const double MIDDLE = 0.5, RADIUS = 0.3, DENSITY = 1000;

static double from_middle(const double x[3], int dim)
{
    double r2 = 0;
    for (int d = 0; d < dim; d++) r2 += (x[d] - MIDDLE) * (x[d] - MIDDLE);
    return sqrt(r2);
}

static int ball(const double x[3])
{
    return from_middle(x, 3) < RADIUS ? CLOUD_WATER : CLOUD_AIR;
}

static int disc(const double x[3])
{
    return from_middle(x, 2) < RADIUS ? CLOUD_WATER : CLOUD_AIR;
}

static int tube(const double x[3])
{
    return from_middle(x, 2) < RADIUS ? CLOUD_WATER : CLOUD_WALL;
}

static Cloud *cloud_of(int dim, size_t n, double jitter, int (*owner)(const double[3]))
{
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = dim,
                                           .dx = 1.0 / (double)n,
                                           .n = {n, n, n},
                                           .jitter = jitter,
                                           .smoothing = 0.9,
                                           .kernel = MNS_QUINTIC_SPLINE,
                                           .calibrated = true,
                                           .viscous = true,
                                           .periodic = {true, true, true},
                                           .owner = owner});
    cloud_weigh(cloud, 1, DENSITY);
    cloud_term(cloud, &truncation);
    cloud_term(cloud, &mixture);
    return cloud;
}

static double place_of(const Particles *s, size_t i, int dim)
{
    return from_middle((double[3]){s->x[0][i], s->x[1][i], dim == 3 ? s->x[2][i] : 0}, dim);
}

/* --- curvature ------------------------------------------------------------------------------------------------------------- */

/* Of exact normals: the relative error of the curvature, root mean square over a shell about the sphere. */
static double curvature_error(int dim, size_t n, double jitter)
{
    Cloud *cloud = cloud_of(dim, n, jitter, dim == 3 ? ball : disc);
    Particles *s = &cloud->s;
    double squares = 0, count = 0;
    for (size_t i = 0; i < s->n; i++)
        for (int d = 0; d < dim; d++) {
            s->normal[d][i] = (MIDDLE - s->x[d][i]) / place_of(s, i, dim);
            s->colour_gradient[d][i] = s->normal[d][i];
        }
    cloud_term(cloud, &colour_curvature);
    for (size_t i = 0; i < s->n; i++) {
        const double r = place_of(s, i, dim), exact = (dim - 1) / r, kappa = curvature_step(s)[i];
        if (fabs(r - RADIUS) > 0.05) continue;
        squares += (kappa / exact - 1) * (kappa / exact - 1);
        count++;
    }
    assert_true(count > 40);
    cloud_free(cloud);
    return sqrt(squares / count);
}

static void the_curvature_of_a_sphere_is_that_of_two_circles_and_converges(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        const double coarse = curvature_error(dim, 16, 0), fine = curvature_error(dim, 32, 0);
        assert_less(fine, 0.01);
        assert_less(fine, 0.3 * coarse); /* second order on a lattice */
        const double uneven = curvature_error(dim, 16, 0.1), less = curvature_error(dim, 32, 0.1);
        assert_less(less, 0.02);
        assert_less(less, 0.65 * uneven); /* first among particles in disorder */
    }
}

/* All of it, from the colour on: the mean is 2/R where the colour changes, and the colour rises by 1. */
static void a_ball_has_twice_the_curvature_of_its_radius(void **state)
{
    (void)state;
    const size_t n = 28;
    const double dx = 1.0 / (double)n, surface = 4 * acos(-1) * RADIUS * RADIUS;
    Cloud *cloud = cloud_of(3, n, 0, ball);
    const Particles *s = &cloud->s;
    cloud_term(cloud, &colour_gradient);
    cloud_term(cloud, &colour_curvature);
    cloud_term(cloud, &mean_colour_curvature);
    double sum = 0, weight = 0, N = 0;
    for (size_t i = 0; i < s->n; i++) {
        double N2 = 0;
        for (int d = 0; d < 3; d++) N2 += s->colour_gradient[d][i] * s->colour_gradient[d][i];
        N += sqrt(N2);
        sum += curvature_weights(s)[i] * s->curvature[i];
        weight += curvature_weights(s)[i];
    }
    assert_close(sum / weight, 2 / RADIUS, 0.04 * 2 / RADIUS);
    assert_close(N * DENSITY * dx * dx * dx, surface, 0.04 * surface);
    cloud_free(cloud);
}

/* --- a tube with slip -------------------------------------------------------------------------------------------------------- */

/* Or a slice of one. */
static Cloud *filled_tube(int dim, size_t n, bool no_slip)
{
    Cloud *cloud = cloud_of(dim, n, 0, tube);
    Particles *s = &cloud->s;
    cloud->model.wall[0].no_slip = no_slip;
    for (size_t w = particles_fluid(s); w < s->n; w++) {
        const double r = place_of(s, w, 2);
        for (int d = 0; d < 2; d++) s->to_surface[d][w - particles_fluid(s)] = (RADIUS - r) / r * (s->x[d][w] - MIDDLE);
    }
    return cloud;
}

/* What flows along the axis goes on in the wall as it is; a wall that holds it turns it round. */
static void what_flows_along_a_tube_is_not_held(void **state)
{
    (void)state;
    for (int no_slip = 0; no_slip < 2; no_slip++) {
        Cloud *cloud = filled_tube(3, 16, no_slip);
        Particles *s = &cloud->s;
        const size_t n = particles_fluid(s);
        for (size_t i = 0; i < n; i++) s->v[2][i] = 1.7;
        cloud_term(cloud, &continued_velocity);
        size_t seen = 0;
        for (size_t w = n; w < s->n; w++) {
            if (place_of(s, w, 2) > RADIUS + 1.2 / 16) continue;
            for (int d = 0; d < 2; d++) assert_close(s->v_wall[d][w - n], 0, 1e-12);
            if (no_slip) assert_true(s->v_wall[2][w - n] < 0);
            else assert_close(s->v_wall[2][w - n], 1.7, 1e-12);
            seen++;
        }
        assert_true(seen > 300);
        cloud_free(cloud);
    }
}

static const double PRESSED = 3; /* outwards, per length from the wall, over the speed of turning */

/* Of what turns as a solid body and flows towards the wall, in the wall: the velocity into it less the one that makes nothing flow through the
 * surface, and what is different from the velocity of the surface along it, in the mean, over that. */
static void turning_errors(size_t n, double *ret_into, double *ret_along)
{
    Cloud *cloud = filled_tube(2, n, false);
    Particles *s = &cloud->s;
    const size_t fluid = particles_fluid(s);
    for (size_t i = 0; i < fluid; i++) {
        const double x = s->x[0][i] - MIDDLE, y = s->x[1][i] - MIDDLE, r = place_of(s, i, 2),
                     outwards = PRESSED * (RADIUS - r) / r;
        s->v[0][i] = outwards * x - y;
        s->v[1][i] = outwards * y + x;
    }
    cloud_term(cloud, &continued_velocity);
    double into = 0, along = 0, count = 0;
    for (size_t w = fluid; w < s->n; w++) {
        const double r = place_of(s, w, 2), x = (s->x[0][w] - MIDDLE) / r, y = (s->x[1][w] - MIDDLE) / r;
        if (r > RADIUS + 1.2 / (double)n) continue;
        const double u = s->v_wall[0][w - fluid], v = s->v_wall[1][w - fluid];
        into += fabs(u * x + v * y - PRESSED * (RADIUS - r));
        along += fabs(v * x - u * y - RADIUS);
        count++;
    }
    *ret_into = into / count / RADIUS;
    *ret_along = along / count / RADIUS;
    cloud_free(cloud);
}

/* What flows into the wall is turned; along it the wall has the velocity of fluid that is within reach. */
static void what_turns_in_a_tube_glides(void **state)
{
    (void)state;
    double into[2], along[2];
    for (size_t k = 0; k < 2; k++) turning_errors(k ? 80 : 20, &into[k], &along[k]);
    assert_less(along[0], 0.1);
    assert_less(into[0], 0.05);
    assert_less(along[1], 0.3 * along[0]); /* four times as fine */
    assert_less(into[1], 0.3 * into[0]);
}

/* A run: a viscous fluid that moves along its tube is a solution that nothing changes; where the wall holds it, it is slowed. */
static void a_flow_along_a_tube_goes_on(void **state)
{
    (void)state;
    for (int no_slip = 0; no_slip < 2; no_slip++) {
        MnsCase *c = case_blank(3, 10);
        c->scheme.name = "differences";
        c->scheme.kernel = MNS_QUINTIC_SPLINE;
        c->scheme.smoothing = 0.9;
        c->scheme.differences.reference_speed = 1;
        c->periodic[2] = true;
        case_add_fluid(c, "liquid", 1, 10);
        c->fluids[0].viscosity = 0.1;
        case_set_text(&c->fluids[0].velocity[2], "1");
        case_add_wall(c, "tube");
        c->walls[0].no_slip = no_slip;
        MnsPart *part = case_add_part(&c->walls[0].shape, MNS_CYLINDER);
        *part = (MnsPart){.primitive = MNS_CYLINDER,
                          .outside = true,
                          .a = {0.5, 0.5, -1},
                          .b = {0.5, 0.5, 2},
                          .radius = 0.5,
                          .formula = part->formula};
        MnsSim *sim = sim_in_arrays(c);
        sim_steps(sim, 5);
        const Particles *s = &sim->s;
        double slowest = 1, across = 0;
        for (size_t i = 0; i < particles_fluid(s); i++) {
            slowest = fmin(slowest, s->v[2][i]);
            across = fmax(across, hypot(s->v[0][i], s->v[1][i]));
        }
        if (no_slip) assert_less(slowest, 0.95);
        else assert_close(slowest, 1, 1e-9);
        assert_less(across, no_slip ? 0.1 : 1e-9);
        sim_done(sim, c);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_curvature_of_a_sphere_is_that_of_two_circles_and_converges),
        cmocka_unit_test(a_ball_has_twice_the_curvature_of_its_radius),
        cmocka_unit_test(what_flows_along_a_tube_is_not_held),
        cmocka_unit_test(what_turns_in_a_tube_glides),
        cmocka_unit_test(a_flow_along_a_tube_goes_on),
    };
    return cmocka_run_group_tests_name("curved", tests, NULL, NULL);
}
