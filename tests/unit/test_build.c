/* SPDX-License-Identifier: BSD-3-Clause */
/* Particles start where the case has them: on a lattice fitted to the domain, each in the fluid or wall that its
 * shape says, with masses and densities that give the pressure asked for. */
#include "tests/support/check.h"
#include "tests/support/sims.h"
#include <stdlib.h>
#include <string.h>

/* A tank 1 x 0.8 (x 0.6) from a corner that is not the origin. */
static MnsCase *tank(int dim)
{
    MnsCase *c = case_blank(dim, 10);
    const double corner[3] = {0.3, -0.7, 0.2}, size[3] = {1, 0.8, 0.6};
    case_add_wall(c, "tank");
    MnsPart *side = case_add_part(&c->walls[0].shape, MNS_BOX);
    side->outside = true;
    for (int d = 0; d < dim; d++) {
        c->min[d] = side->a[d] = corner[d];
        c->max[d] = side->b[d] = corner[d] + size[d];
    }
    return c;
}

static void lattice_is_stretched_to_the_domain_and_continued_into_walls(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = tank(dim);
        c->max[0] = c->walls[0].shape.parts[0].b[0] = 0.3 + 1.012; /* 10.12 spacings: ten, stretched */
        case_add_fluid(c, "water", 5, 10);
        MnsSim *sim = sim_in_arrays(c);
        const Particles *s = &sim->s;
        const double cell[3] = {0.1012, 0.1, 0.1};
        assert_close(sim->model.kernel.h, 1.3 * 0.1, 1e-15); /* of the spacing asked for */
        const size_t inside = dim == 2 ? 10 * 8 : 10 * 8 * 6, whole = dim == 2 ? 16 * 14 : 16 * 14 * 12; /* 3 layers */
        assert_int_equal(particles_fluid(s), inside);
        assert_int_equal(s->n, whole);
        for (size_t i = 0; i < s->n; i++)
            for (int d = 0; d < dim; d++) {
                const double place = (s->x[d][i] - c->min[d]) / cell[d] - 0.5;
                assert_close(place, round(place), 1e-12); /* rounding */
                const bool within = s->x[d][i] > c->min[d] && s->x[d][i] < c->max[d];
                assert_true(within || i >= inside);
            }
        for (size_t i = 0; i < inside; i++) assert_close(s->m[i], 5 * 1.012 * pow(0.1, dim), 1e-15);
        for (size_t i = inside; i < s->n; i++)
            assert_close(particles_volume(s, &sim->model, i), 1.012 * pow(0.1, dim), 1e-15);
        sim_done(sim, c);
    }
}

/* Full neighbourhoods everywhere, as many as a lattice has points in reach: 20, 36, 36; 44 within 3.9 spacings. */
static void dummy_layers_fill_every_kernel_that_reaches_into_a_wall(void **state)
{
    (void)state;
    static const struct {
        MnsKernel kernel;
        double smoothing, neighbours;
    } rows[] = {{MNS_WENDLAND_C2, 1.3, 20},
                {MNS_WENDLAND_C2, 1.6, 36},
                {MNS_TRUNCATED_GAUSSIAN, 1.1, 36},
                {MNS_QUINTIC_SPLINE, 1.3, 44}};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        MnsCase *c = tank(2);
        c->scheme.kernel = rows[k].kernel;
        c->scheme.smoothing = rows[k].smoothing;
        case_add_fluid(c, "water", 5, 10);
        MnsSim *sim = sim_in_arrays(c);
        assert_close(mns_sim_mean_neighbours(sim), rows[k].neighbours, 1e-12);
        sim_done(sim, c);
    }
}

/* Left of x = 0.9 all is solid, 0.6 deep: beyond the kernel's reach there is nothing, and no fluid either. */
static void thick_walls_are_hollow_not_filled_with_fluid(void **state)
{
    (void)state;
    MnsCase *c = tank(2);
    case_add_fluid(c, "water", 5, 10);
    MnsPart *block = case_add_part(&c->walls[0].shape, MNS_HALF_SPACE);
    block->a[0] = 0.9;
    block->b[0] = 1;
    MnsSim *sim = sim_in_arrays(c);
    size_t deep = 0;
    for (size_t i = 0; i < sim->s.n; i++) {
        const double x = sim->s.x[0][i];
        if (i < particles_fluid(&sim->s)) assert_true(x > 0.9);
        deep += x < 0.9 - 2 * sim->model.kernel.support;
    }
    assert_int_equal(particles_fluid(&sim->s), 4 * 8);
    assert_int_equal(deep, 0);
    assert_close(mns_sim_mean_neighbours(sim), 20, 1e-12); /* still a full kernel everywhere */
    sim_done(sim, c);
}

/* A periodic direction has no sides to continue. */
static void periodic_directions_have_no_layers(void **state)
{
    (void)state;
    MnsCase *c = tank(3);
    c->periodic[0] = true;
    c->walls[0].shape.parts[0].a[0] = -9;
    c->walls[0].shape.parts[0].b[0] = 9;
    case_add_fluid(c, "water", 5, 10);
    MnsSim *sim = sim_in_arrays(c);
    assert_int_equal(sim->s.n, 10 * 14 * 12);
    assert_int_equal(particles_fluid(&sim->s), 10 * 8 * 6);
    sim_done(sim, c);
}

static void particles_belong_to_the_shape_they_are_in_and_the_rest_to_the_rest(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = tank(dim);
        case_add_fluid(c, "oil", 1, 10);
        case_add_fluid(c, "air", 0.005, 10);
        case_add_fluid(c, "water", 2, 10);
        MnsPart *ball = case_add_part(&c->fluids[0].shape, MNS_BALL);
        const double at[3] = {0.8, -0.3, 0.5};
        for (int d = 0; d < dim; d++) ball->a[d] = at[d];
        ball->radius = 0.22;
        MnsPart *below = case_add_part(&c->fluids[2].shape, MNS_FORMULA);
        case_set_text(&below->formula, "y < ground + 0.1*x");
        c->constants = calloc(1, sizeof *c->constants);
        c->n_constants = 1;
        case_set_text(&c->constants[0].name, "ground");
        case_set_text(&c->constants[0].value, "-1/2 - 0.1 + 0*dx");
        case_add_wall(c, "step");
        MnsPart *step = case_add_part(&c->walls[1].shape, MNS_BOX);
        step->a[0] = 0.3;
        step->b[0] = 0.62;
        step->a[1] = -0.7;
        step->b[1] = -0.38;
        step->a[2] = -1;
        step->b[2] = 2;
        MnsSim *sim = sim_in_arrays(c);
        const Particles *s = &sim->s;
        size_t count[5] = {0};
        for (size_t i = 0; i < s->n; i++) {
            const double x = s->x[0][i], y = s->x[1][i], z = dim == 3 ? s->x[2][i] : 0, dz = dim == 3 ? z - 0.5 : 0;
            const bool outside = x < 0.3 || x > 1.3 || y < -0.7 || y > 0.1 || (dim == 3 && (z < 0.2 || z > 0.8));
            const bool in_step = x < 0.62 && y < -0.38, in_ball = hypot(hypot(x - 0.8, y + 0.3), dz) < 0.22;
            const int owner = outside ? 3 : in_step ? 4 : in_ball ? 0 : y < -0.6 + 0.1 * x ? 2 : 1;
            assert_int_equal(s->phase[i], owner);
            const bool wall = owner >= 3, air = owner == 1; /* lighter than a fiftieth of water: summed */
            assert_int_equal(i >= s->begin[GROUP_WALL], wall);
            if (!wall) assert_int_equal(i >= s->begin[GROUP_SUMMATION], air);
            count[owner]++;
        }
        for (int k = 0; k < 5; k++) assert_true(count[k] > 3);
        sim_done(sim, c);
    }
}

static void density_method_is_that_of_the_case_or_by_the_ratio(void **state)
{
    (void)state;
    static const struct {
        double density;
        MnsDensityMethod method;
        bool summed;
    } rows[] = {{0.021, MNS_DENSITY_AUTOMATIC, false},
                {0.019, MNS_DENSITY_AUTOMATIC, true},
                {0.5, MNS_DENSITY_SUMMATION, true},
                {0.001, MNS_DENSITY_CONTINUITY, false}}; /* nothing is summed: then all are spread alike */
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        MnsCase *c = case_periodic(2, 10);
        c->fluids[1].density = rows[k].density;
        c->fluids[1].density_method = rows[k].method;
        MnsSim *sim = sim_in_arrays(c);
        assert_int_equal(sim->s.begin[GROUP_SUMMATION] < particles_fluid(&sim->s), rows[k].summed);
        /* p_b over rho c^2 of the fluid itself: 4, but a half beside a fluid that is summed. */
        assert_close(sim->model.phase[1].p_b, 4 * rows[k].density * 100, 1e-12);
        assert_close(sim->model.phase[0].p_b, (rows[k].summed ? 0.5 : 4) * 100, 1e-12);
        sim_done(sim, c);
    }
}

/* At a free surface they would be pushed out. */
static void heavy_fluids_are_spread_only_where_nothing_is_empty(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int empty = 0; empty < 3; empty++) {
            MnsCase *c = tank(dim);
            case_add_fluid(c, "water", 5, 10);
            MnsPart *water = case_add_part(&c->fluids[0].shape, MNS_BOX);
            for (int d = 0; d < dim; d++) {
                water->a[d] = c->min[d];
                water->b[d] = c->max[d] - (empty == 1 && d == 1 ? 0.3 : 0);
            }
            if (empty == 2) { /* sides without walls */
                mns_case_free(c);
                c = case_blank(dim, 10);
                case_add_fluid(c, "water", 5, 10);
            }
            MnsSim *sim = sim_in_arrays(c);
            for (int again = 0; again < 2; again++) {
                assert_close(sim->model.phase[0].p_b, empty ? 0 : 4 * 5 * 100, 1e-12);
                setup_options(sim, c); /* as after a steered value */
            }
            sim_done(sim, c);
        }
}

/* p from a formula: rho = rho0 + p/c^2, with a mass that keeps it there, whichever way the density is found, on the
 * lattice as it is stretched. */
static void masses_and_densities_give_the_pressure_asked_for(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = case_periodic(dim, 10);
        for (int k = 0; k < 2; k++) case_set_text(&c->fluids[k].pressure, k == 0 ? "3 + x" : "0.7 - 0.2*y");
        c->max[1] = 1.015; /* ten spacings */
        MnsSim *sim = sim_in_arrays(c);
        const Particles *s = &sim->s;
        for (size_t i = 0; i < s->n; i++) {
            const int k = s->phase[i];
            const double p = k == 0 ? 3 + s->x[0][i] : 0.7 - 0.2 * s->x[1][i], rho = c->fluids[k].density + p / 100;
            assert_close(s->p[i], p, 1e-12);
            assert_close(s->rho[i], rho, 1e-15);
            assert_close(s->m[i], rho * 1.015 * pow(0.1, dim), 1e-16);
        }
        sim_done(sim, c);
    }
}

/* At a free edge the sum would give less than the case asks for: the start is the case's. */
static void summed_densities_start_as_given_at_a_free_edge_too(void **state)
{
    (void)state;
    MnsCase *c = case_blank(2, 10);
    case_add_fluid(c, "gas", 3, 10);
    c->fluids[0].density_method = MNS_DENSITY_SUMMATION;
    case_set_text(&c->fluids[0].pressure, "20");
    MnsSim *sim = sim_in_arrays(c);
    assert_int_equal(sim->s.n, 100);
    for (size_t i = 0; i < sim->s.n; i++) {
        assert_close(sim->s.rho[i], 3.2, 1e-15);
        assert_close(sim->s.p[i], 20, 1e-12);
    }
    sim_done(sim, c);
}

static void velocities_are_those_of_the_formulas(void **state)
{
    (void)state;
    MnsCase *c = case_periodic(3, 10);
    MnsSim *sim = sim_in_arrays(c);
    const double pi2 = 2 * acos(-1);
    for (size_t i = 0; i < sim->s.n; i++) {
        const double x = sim->s.x[0][i], y = sim->s.x[1][i];
        assert_close(sim->s.v[0][i], 0.3 * sin(pi2 * y), 1e-15);
        assert_close(sim->s.v[1][i], 0.5 * cos(pi2 * x) + 0.1, 1e-15);
        assert_close(sim->s.v[2][i], 0.2 * sin(pi2 * (x + y)), 1e-15);
    }
    sim_done(sim, c);
}

/* Weight of all fluid between a particle and the end of its column that gravity points away from, whichever way that
 * is. */
static void hydrostatic_pressure_is_the_weight_above(void **state)
{
    (void)state;
    static const struct {
        int dim, axis;
        const char *g;
    } rows[] = {{2, 1, "-4"}, {3, 2, "-4"}, {2, 0, "4"}};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        const int dim = rows[k].dim, axis = rows[k].axis;
        MnsCase *c = tank(dim);
        case_set_text(&c->gravity[axis], rows[k].g);
        case_add_fluid(c, "water", 5, 40);
        case_add_fluid(c, "air", 0.01, 40);
        MnsPart *half = case_add_part(&c->fluids[0].shape, MNS_HALF_SPACE);
        for (int d = 0; d < dim; d++) half->a[d] = 0.5 * (c->min[d] + c->max[d]);
        half->b[axis] = rows[k].g[0] == '-' ? 1 : -1;
        for (int f = 0; f < 2; f++) case_set_text(&c->fluids[f].pressure, "hydrostatic");
        MnsSim *sim = sim_in_arrays(c);
        const double length = c->max[axis] - c->min[axis];
        for (size_t i = 0; i < particles_fluid(&sim->s); i++) {
            const double low = sim->s.x[axis][i] - c->min[axis], depth = rows[k].g[0] == '-' ? length - low : low;
            const double p = depth < length / 2 ? 0.01 * 4 * depth : 4 * (0.01 * length / 2 + 5 * (depth - length / 2));
            assert_close(sim->s.p[i], p, 1e-11); /* rounding of c^2 rho */
        }
        sim_done(sim, c);
    }
}

/* y = x + d: particles are at y, and stand for as much of the fluid as there is around it. */
static void moved_particles_are_where_the_formulas_say_and_have_the_volume_there(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = tank(dim);
        case_add_fluid(c, "water", 5, 10);
        case_set_text(&c->displacement[0], "0.4*(x - 0.3)*(1.3 - x)*y");
        case_set_text(&c->displacement[1], "0.5*x*(y + 0.7)*(0.1 - y)");
        MnsCase *still = tank(dim);
        case_add_fluid(still, "water", 5, 10);
        MnsSim *sim = sim_in_arrays(c), *as_it_was = sim_in_arrays(still);
        const double cell = pow(0.1, dim);
        double grown[10 * 8 * 6];
        size_t by_id[16 * 14 * 12];  /* as many as the tank has with its walls */
        double all = 0, sampled = 0; /* of the map: the determinant at the middles of cells, in the mean */
        assert_true(as_it_was->s.n <= sizeof by_id / sizeof *by_id && sim->s.n == as_it_was->s.n);
        for (size_t i = 0; i < as_it_was->s.n; i++) by_id[as_it_was->s.id[i]] = i;
        for (size_t i = 0; i < particles_fluid(&sim->s); i++) {
            const size_t then = by_id[sim->s.id[i]];
            const double x = as_it_was->s.x[0][then], y = as_it_was->s.x[1][then];
            const double xx = 1 + 0.4 * (1.6 - 2 * x) * y, xy = 0.4 * (x - 0.3) * (1.3 - x),
                         yx = 0.5 * (y + 0.7) * (0.1 - y), yy = 1 + 0.5 * x * (-0.6 - 2 * y);
            assert_close(sim->s.x[0][i], x + xy * y, 1e-14); /* rounding */
            assert_close(sim->s.x[1][i], y + yx * x, 1e-14);
            if (dim == 3) assert_true(sim->s.x[2][i] == as_it_was->s.x[2][then]);
            sampled += (xx * yy - xy * yx) / (double)particles_fluid(&sim->s);
            grown[i] = xx * yy - xy * yx;
            all += sim->s.m[i];
        }
        assert_close(sampled, 1, 0.002);                      /* the sides stay */
        for (size_t i = 0; i < particles_fluid(&sim->s); i++) /* differences over 1e-4 of quadratics: rounding */
            assert_close(sim->s.m[i], 5 * grown[i] / sampled * cell, 1e-10 * cell);
        const double water = 5 * (dim == 2 ? 0.8 : 0.8 * 0.6);
        assert_close(all, water, 1e-12 * water); /* all of the tank */
        for (size_t i = particles_fluid(&sim->s); i < sim->s.n; i++)
            for (int d = 0; d < dim; d++) assert_true(sim->s.x[d][i] == as_it_was->s.x[d][by_id[sim->s.id[i]]]);
        sim_done(sim, c);
        sim_done(as_it_was, still);
    }
}

/* Two layers whose interface and all within is moved along gravity, or lifted and moved across it: the pressure is that of where it is. */
static void hydrostatic_pressure_is_that_of_where_particles_are_moved(void **state)
{
    (void)state;
    static const char *const moved[][2] = {{"0", "0.1*sin(3*x)*(0.4 - abs(y + 0.3))/0.4"},
                                           {"0.05*sin(2*pi*(x - 0.3))", "0.05*(0.4 - abs(y + 0.3))/0.4"}};
    for (int k = 0; k < 2; k++) {
        MnsCase *c = tank(2);
        case_set_text(&c->gravity[1], "-4");
        case_add_fluid(c, "water", 5, 40);
        case_add_fluid(c, "oil", 2, 40);
        case_set_text(&case_add_part(&c->fluids[0].shape, MNS_FORMULA)->formula, "y < -0.3");
        for (int d = 0; d < 2; d++) case_set_text(&c->displacement[d], moved[k][d]);
        for (int f = 0; f < 2; f++) case_set_text(&c->fluids[f].pressure, "hydrostatic");
        MnsSim *sim = sim_in_arrays(c);
        for (size_t i = 0; i < particles_fluid(&sim->s); i++) {
            const double x = sim->s.x[0][i], y = sim->s.x[1][i], at = -0.3 + (k ? 0.05 : 0.1 * sin(3 * x));
            const double p = 4 * (2 * (0.1 - fmax(y, at)) + 5 * fmax(at - y, 0));
            assert_close(sim->s.p[i], p, 1e-9); /* heights are linear along each layer: only rounding */
        }
        sim_done(sim, c);
    }
}

static void displacements_that_tear_or_leave_are_refused(void **state)
{
    (void)state;
    static const struct {
        const char *formula, *told;
    } rows[] = {{"-2*y", "-1 times what it is"},
                {"0.06*(y + 0.7)*(0.1 - y)/0.16", "into a wall"},
                {"0/0", "nan"},
                {"-0.1", "out of the domain"},
                {"x > 0.5 and (y < 0) or 0.001", "fails at"},
                {"0.015*(2*y + 0.6)/0.8 + 0.01*(y + 0.3)", "times the domain that they fill"}};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        MnsCase *c = tank(2);
        MnsError error = {0};
        MnsSim *sim = NULL;
        case_add_fluid(c, "water", 5, 10);
        case_add_wall(c, "plate");
        MnsPart *plate = case_add_part(&c->walls[1].shape, MNS_BOX);
        plate->a[0] = 0.5;
        plate->b[0] = 0.9;
        plate->a[1] = -0.4;
        plate->b[1] = -0.2;
        c->scheme.smoothing = 0.9; /* which reaches less far than the plate is thick */
        case_set_text(&c->displacement[1], rows[k].formula);
        assert_int_equal(mns_sim_new(c, &sim, &error), MNS_E_INVALID);
        assert_string_equal(error.path, "domain.displacement");
        if (!strstr(error.text, rows[k].told)) fail_msg("%s", error.text);
        case_set_text(&c->displacement[1], "0.001*y");
        case_set_text(&c->fluids[0].pressure, "laplace");
        assert_int_equal(mns_sim_new(c, &sim, &error), MNS_E_INVALID);
        assert_string_equal(error.path, "domain.displacement");
        assert_non_null(strstr(error.text, "moves water, whose pressure is that of a drop"));
        mns_case_free(c);
    }
}

/* Two fluids, a wall, formulas everywhere. */
static MnsCase *of_everything(unsigned threads)
{
    MnsCase *c = tank(3);
    c->threads = threads;
    case_set_text(&c->gravity[1], "-2");
    case_add_fluid(c, "water", 5, 40);
    case_add_fluid(c, "air", 0.01, 40);
    case_set_text(&case_add_part(&c->fluids[0].shape, MNS_FORMULA)->formula, "y < -0.2 + 0.1*sin(9*x) and z < 0.7");
    case_set_text(&c->fluids[0].pressure, "hydrostatic");
    case_set_text(&c->fluids[0].velocity[2], "x*y - z");
    case_set_text(&c->fluids[1].pressure, "0.01*x");
    return c;
}

static void particles_are_the_same_for_any_number_of_threads(void **state)
{
    (void)state;
    static const char moved[] = "0.01*sin(20*x)*cos(9*y)";
    MnsCase *c = of_everything(1);
    case_set_text(&c->displacement[2], moved);
    MnsSim *sim = sim_in_arrays(c);
    static const unsigned threads[] = {2, 3, 7};
    for (size_t k = 0; k < 3; k++) {
        MnsCase *other = of_everything(threads[k]);
        case_set_text(&other->displacement[2], moved);
        MnsSim *twin = sim_in_arrays(other);
        assert_int_equal(twin->s.n, sim->s.n);
        assert_memory_equal(twin->s.id, sim->s.id, sim->s.n * sizeof *sim->s.id);
        assert_memory_equal(twin->s.m, sim->s.m, sim->s.n * sizeof *sim->s.m);
        assert_true(mns_sim_hash(twin) == mns_sim_hash(sim));
        sim_done(twin, other);
    }
    sim_done(sim, c);
}

static void a_pressure_that_no_density_gives_is_told_high_or_low(void **state)
{
    (void)state;
    static const char *const of[][3] = {{"riemann", "1e6", "1e+06 Pa is too high"},
                                        {"riemann", "-1e6", "-1e+06 Pa is too low"},
                                        {"riemann", "0/0", "not finite"},
                                        {"interfacial", "-1e6", "is below any that the equation of state has"}};
    for (size_t k = 0; k < sizeof of / sizeof *of; k++) {
        MnsCase *c = of_everything(1);
        MnsError error = {0};
        MnsSim *sim = NULL;
        c->scheme.name = of[k][0];
        case_set_text(&c->fluids[1].pressure, of[k][1]);
        assert_int_equal(mns_sim_new(c, &sim, &error), MNS_E_INVALID);
        assert_memory_equal(error.path, "fluids[1]", 9);
        if (!strstr(error.text, of[k][2])) fail_msg("%s", error.text);
        mns_case_free(c);
    }
}

/* A wrong case is wrong in the same words each time. */
static void what_is_wrong_is_told_of_the_first_point_that_is(void **state)
{
    (void)state;
    for (unsigned threads = 1; threads <= 7; threads += 2) {
        MnsCase *c = of_everything(threads);
        MnsError error = {0};
        MnsSim *sim = NULL;
        case_set_text(&case_add_part(&c->fluids[1].shape, MNS_FORMULA)->formula, "y > -0.5 or z > 0.4");
        assert_int_equal(mns_sim_new(c, &sim, &error), MNS_E_INVALID);
        assert_string_equal(error.path, "fluids[1].shape");
        assert_non_null(strstr(error.text, "water and air overlap at (0.35, -0.45, 0.25) m"));
        case_set_text(&c->fluids[1].shape.parts[0].formula, "y > -0.1 and 3 or y > 0 and z");
        assert_int_equal(mns_sim_new(c, &sim, &error), MNS_E_INVALID);
        assert_string_equal(error.path, "fluids[1].shape[0].formula");
        case_set_text(&c->fluids[1].shape.parts[0].formula, "x > 0.45 and y < 0.05 and sinn(x) > 0");
        assert_int_equal(mns_sim_new(c, &sim, &error), MNS_E_INVALID);
        assert_string_equal(error.path, "fluids[1].shape[0].formula");
        assert_non_null(strstr(error.text, "unknown name 'sinn'"));
        case_set_text(&c->fluids[1].shape.parts[0].formula, "false");
        case_set_text(&c->fluids[0].velocity[0], "x > 0.7 and (y < -0.55) or 0.1");
        assert_int_equal(mns_sim_new(c, &sim, &error), MNS_E_INVALID);
        assert_null(sim);
        mns_case_free(c);
    }
}

static void failing_start_is_told_with_its_reason(void **state)
{
    (void)state;
    for (unsigned threads = 1; threads <= 5; threads += 2) {
        MnsCase *c = of_everything(threads);
        MnsError error = {0};
        MnsSim *sim = NULL;
        case_set_text(&c->fluids[0].velocity[0], "x > 0.7 and (y < 0) or 0.1");
        assert_int_equal(mns_sim_new(c, &sim, &error), MNS_E_INVALID);
        assert_string_equal(error.path, "fluids[0].velocity[0]");
        assert_non_null(strstr(error.text, "at (0.75, -0.65, 0.25) m: it is true or false there"));
        assert_null(sim);
        mns_case_free(c);
    }
}

/* Neither the lattice nor the cells of the neighbour search may follow the size of the domain. */
static void empty_space_takes_no_memory(void **state)
{
    (void)state;
    MnsCase *c = case_blank(3, 10);
    c->max[0] = 20;
    c->max[1] = c->max[2] = 10;
    case_add_fluid(c, "drop", 5, 40);
    MnsPart *drop = case_add_part(&c->fluids[0].shape, MNS_BALL);
    drop->radius = 0.5;
    drop->a[0] = drop->a[1] = drop->a[2] = 3;
    MnsSim *sim = sim_in_arrays(c);
    assert_in_range(sim->s.n, 500, 560);
    assert_less((double)mns_sim_bytes(sim), 3000.0 * (double)sim->s.n);
    sim_done(sim, c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lattice_is_stretched_to_the_domain_and_continued_into_walls),
        cmocka_unit_test(dummy_layers_fill_every_kernel_that_reaches_into_a_wall),
        cmocka_unit_test(thick_walls_are_hollow_not_filled_with_fluid),
        cmocka_unit_test(periodic_directions_have_no_layers),
        cmocka_unit_test(particles_belong_to_the_shape_they_are_in_and_the_rest_to_the_rest),
        cmocka_unit_test(density_method_is_that_of_the_case_or_by_the_ratio),
        cmocka_unit_test(heavy_fluids_are_spread_only_where_nothing_is_empty),
        cmocka_unit_test(masses_and_densities_give_the_pressure_asked_for),
        cmocka_unit_test(summed_densities_start_as_given_at_a_free_edge_too),
        cmocka_unit_test(velocities_are_those_of_the_formulas),
        cmocka_unit_test(hydrostatic_pressure_is_the_weight_above),
        cmocka_unit_test(moved_particles_are_where_the_formulas_say_and_have_the_volume_there),
        cmocka_unit_test(hydrostatic_pressure_is_that_of_where_particles_are_moved),
        cmocka_unit_test(displacements_that_tear_or_leave_are_refused),
        cmocka_unit_test(particles_are_the_same_for_any_number_of_threads),
        cmocka_unit_test(a_pressure_that_no_density_gives_is_told_high_or_low),
        cmocka_unit_test(what_is_wrong_is_told_of_the_first_point_that_is),
        cmocka_unit_test(failing_start_is_told_with_its_reason),
        cmocka_unit_test(empty_space_takes_no_memory),
    };
    return cmocka_run_group_tests_name("build", tests, NULL, NULL);
}
