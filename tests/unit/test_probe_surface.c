/* SPDX-License-Identifier: BSD-3-Clause */
/* Probes of surfaces and bodies measure what is known: layers, discs, balls and boxes, in gas and in nothing, on walls and
 * across seams. */
#include "sim/sample.h"
#include "tests/support/check.h"
#include "tests/support/sims.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double DX = 0.05;

static void put_point(double to[3], double x, double y, double z)
{
    to[0] = x;
    to[1] = y;
    to[2] = z;
}

static void add_box(MnsFluid *fluid, double x, double y, double width, double height)
{
    MnsPart *box = case_add_part(&fluid->shape, MNS_BOX);
    put_point(box->a, x, y, 0);
    put_point(box->b, x + width, y + height, 1);
}

/* A closed tank 1 x 1 (x 0.6) with water up to 0.3 and oil up to 0.55, and a drop of oil at x = 0.2, y = 0.8. */
static MnsCase *layers(int dim)
{
    MnsCase *c = case_blank(dim, 1 / DX);
    c->max[2] = dim == 3 ? 0.6 : 0;
    case_add_fluid(c, "water", 2, 10);
    case_add_fluid(c, "oil", 0.5, 10);
    add_box(&c->fluids[0], 0, 0, 1, 0.3);
    add_box(&c->fluids[1], 0, 0.3, 1, 0.25);
    add_box(&c->fluids[1], 0.1, 0.7, 0.2, 0.2);
    case_add_wall(c, "tank");
    MnsPart *side = case_add_part(&c->walls[0].shape, MNS_BOX);
    side->outside = true;
    for (int d = 0; d < 3; d++) side->b[d] = c->max[d];
    return c;
}

static MnsProbe *add_gauge(MnsCase *c, unsigned fluids, double x, bool lowest)
{
    MnsProbe *probe = case_add_probe(c, MNS_PROBE_ELEVATION);
    probe->fluids = fluids;
    probe->axis = 1;
    probe->least = lowest;
    put_point(probe->at, x, 7, 0.33); /* its height does not count */
    return probe;
}

static void elevation_is_where_fluids_end_on_the_way_up(void **state)
{
    (void)state;
    static const struct {
        unsigned fluids;
        double x;
        bool lowest;
        double expected;
    } gauges[] = {
        {1, 0.52, true, 0.3},  {2, 0.52, true, 0.55},  {3, 0.52, true, 0.55},
        {0, 0.52, true, 0.55}, {0, 0.52, false, 0.55}, {0, 0.2, true, 0.55},
        {0, 0.2, false, 0.9},  {1, 0.2, false, 0.3},   {0, 1.7, true, NAN},
    };
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = layers(dim);
        const size_t n = sizeof gauges / sizeof *gauges;
        for (size_t k = 0; k < n; k++) add_gauge(c, gauges[k].fluids, gauges[k].x, gauges[k].lowest);
        MnsSim *sim = sim_in_arrays(c);
        for (size_t k = 0; k < n; k++) {
            const double value = mns_sim_probe(sim, k);
            /* Halfway between rows, but for compression and what the lattice leaves. */
            if (isfinite(gauges[k].expected)) assert_close(value, gauges[k].expected, 0.02 * DX);
            else assert_true(isnan(value));
        }
        /* A swell of a part of a spacing, anywhere between rows. */
        for (int step = 1; step < 5; step++) {
            for (size_t i = 0; i < particles_fluid(&sim->s); i++) sim->s.x[1][i] += 0.1 * DX;
            assert_close(mns_sim_probe(sim, 0), 0.3 + 0.1 * step * DX, 0.05 * DX);
            assert_close(mns_sim_probe(sim, 2), 0.55 + 0.1 * step * DX, 0.05 * DX);
        }
        sim_done(sim, c);
    }
}

static void elevation_of_what_fills_a_tank_is_no_number(void **state)
{
    (void)state;
    MnsCase *c = layers(2);
    c->fluids[1].shape.n = 0;
    add_gauge(c, 0, 0.4, true);
    add_gauge(c, 1, 0.4, true);
    MnsSim *sim = sim_in_arrays(c);
    assert_true(isnan(mns_sim_probe(sim, 0)));
    assert_close(mns_sim_probe(sim, 1), 0.3, 0.02 * DX);
    c->fluids[1].shape.n = 2; /* to be freed */
    sim_done(sim, c);
}

static void elevation_may_be_along_any_axis_and_moves_with_its_wall(void **state)
{
    (void)state;
    MnsCase *c = layers(2);
    MnsProbe *sideways = add_gauge(c, 2, 0, true);
    sideways->axis = 0;
    put_point(sideways->at, 0, 0.8, 0);
    add_gauge(c, 0, 0.2 + 0.5, false)->wall = 0;
    MnsSim *sim = sim_in_arrays(c);
    assert_close(mns_sim_probe(sim, 0), 0.3, 0.02 * DX); /* of the drop */
    sim->model.wall[0].x[0] = -0.5;
    assert_close(mns_sim_probe(sim, 1), 0.9, 0.02 * DX);
    sim_done(sim, c);
}

/* A body of fluid 0, given by a formula of u, v, w around its middle (0.51, 0.49, 0.5), in a periodic box of side 1 filled with
 * gas, or empty. R = 0.25 is so many spacings. */
static MnsCase *body(int dim, const char *formula, double R, bool gas)
{
    static const char *const names[] = {"a", "b", "c"}, *const middle[] = {"0.51", "0.49", "0.5"};
    MnsCase *c = case_blank(dim, 4 * R);
    c->n_constants = 3;
    c->constants = calloc(3, sizeof *c->constants);
    for (size_t k = 0; k < 3 && c->constants; k++) {
        case_set_text(&c->constants[k].name, names[k]);
        case_set_text(&c->constants[k].value, middle[k]);
    }
    for (int d = 0; d < dim; d++) c->periodic[d] = true;
    case_add_fluid(c, "liquid", 2, 10);
    if (gas) case_add_fluid(c, "gas", 0.5, 10);
    case_set_text(&case_add_part(&c->fluids[0].shape, MNS_FORMULA)->formula, formula);
    return c;
}

static const char DISC[] = "(x - a)^2 + (y - b)^2 < 0.25^2", ELLIPSE[] = "((x - a)/0.3)^2 + ((y - b)/0.15)^2 < 1",
                  SQUARE[] = "abs(x - a) < 0.25 and abs(y - b) < 0.25",
                  BALL[] = "(x - a)^2 + (y - b)^2 + (z - c)^2 < 0.25^2",
                  SPINDLE[] = "((x - a)/0.3)^2 + ((y - b)^2 + (z - c)^2)/0.15^2 < 1",
                  CUBE[] = "abs(x - a) < 0.25 and abs(y - b) < 0.25 and abs(z - c) < 0.25";

static MnsProbe *add_of_body(MnsCase *c, MnsProbeKind kind)
{
    MnsProbe *probe = case_add_probe(c, kind);
    probe->fluid = 0;
    return probe;
}

/* As measured, and a quarter more: see contour.c. */
static void roundness_and_surface_are_those_of_known_bodies(void **state)
{
    (void)state;
    static const struct {
        int dim;
        const char *formula;
        double R, roundness, allowed, surface, surface_allowed;
    } rows[] = {
        {2, DISC, 6, 1, 0.01, 1.5708, 0.02},          {2, DISC, 12, 1, 0.01, 1.5708, 0.02},
        {2, DISC, 25, 1, 0.007, 1.5708, 0.01},        {2, ELLIPSE, 6, 0.9172, 0.01, 1.4533, 0.04},
        {2, ELLIPSE, 12, 0.9172, 0.01, 1.4533, 0.01}, {2, ELLIPSE, 25, 0.9172, 0.007, 1.4533, 0.01},
        {2, SQUARE, 6, 0.8862, 0.07, 2, 0.1},         {2, SQUARE, 12, 0.8862, 0.04, 2, 0.05},
        {2, SQUARE, 25, 0.8862, 0.02, 2, 0.025},      {3, BALL, 6, 1, 0.01, 0.7854, 0.07},
        {3, BALL, 12, 1, 0.008, 0.7854, 0.025},       {3, SPINDLE, 12, 0.9287, 0.01, 0.4833, 0.05},
        {3, CUBE, 12, 0.8060, 0.07, 1.5, 0.1},
    };
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++)
        for (int gas = 0; gas < 2; gas++) {
            MnsCase *c = body(rows[k].dim, rows[k].formula, rows[k].R, gas);
            add_of_body(c, MNS_PROBE_ROUNDNESS);
            add_of_body(c, MNS_PROBE_SURFACE_AREA);
            MnsSim *sim = sim_in_arrays(c);
            assert_close(mns_sim_probe(sim, 0), rows[k].roundness, rows[k].allowed);
            assert_close(mns_sim_probe(sim, 1) / rows[k].surface, 1, rows[k].surface_allowed);
            sim_done(sim, c);
        }
}

/* A formula of U, V and W, which go from -0.5 to 0.5, in the coordinates of a mirror image that may be turned. */
static void write_image(const char *formula, int dim, int image, char ret[400])
{
    static const char *const plus[] = {"(x - 0.5)", "(y - 0.5)", "(z - 0.5)"}, *const minus[] = {"(0.5 - x)",
                                                                                                 "(0.5 - y)",
                                                                                                 "(0.5 - z)"};
    static const int orders[6][3] = {{0, 1, 2}, {1, 0, 2}, {0, 2, 1}, {2, 1, 0}, {1, 2, 0}, {2, 0, 1}};
    const int *order = orders[image >> dim];
    size_t n = 0;
    for (ret[0] = '\0'; *formula; formula++) {
        const int d = *formula - 'U';
        if (d >= 0 && d < 3) n += (size_t)snprintf(ret + n, 400 - n, "%s", (image >> d & 1 ? minus : plus)[order[d]]);
        else n += (size_t)snprintf(ret + n, 400 - n, "%c", *formula);
    }
}

/* Strips aslant, in gas in a periodic box, and a slope and a hump on the walls of a tank. */
static void images_have_one_surface_and_one_roundness(void **state)
{
    (void)state;
    static const struct {
        int dim, n;
        bool tank;
        const char *formula;
    } rows[] = {
        {2, 20, false, "abs(V - 0.5*U + 0.0317) < 0.1937 and abs(U) < 0.3373"},
        {2, 24, true, "V + 0.7*U < 0.1237"},
        {2, 20, true, "V < -0.2137 + 0.3*exp(-40*(U - 0.1131)^2)"},
        {3, 14, false, "abs(V - 0.5*U + 0.3*W + 0.0317) < 0.1937 and abs(U) < 0.3373 and abs(W - 0.0513) < 0.2831"},
        {3, 12, true, "V + 0.7*U - 0.3*W < 0.0837"},
    };
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        const int dim = rows[k].dim, images = dim == 2 ? 8 : check_at_length() ? 48 : 13;
        double first[2] = {0, 0};
        for (int image = 0; image < images; image++) {
            char text[400];
            MnsCase *c = case_blank(dim, rows[k].n);
            write_image(rows[k].formula, dim, dim == 2 || check_at_length() ? image : (5 * image) % 48, text);
            case_add_fluid(c, "liquid", 2, 10);
            case_set_text(&case_add_part(&c->fluids[0].shape, MNS_FORMULA)->formula, text);
            if (!rows[k].tank) case_add_fluid(c, "gas", 0.5, 10);
            for (int d = 0; d < dim; d++) c->periodic[d] = !rows[k].tank;
            if (rows[k].tank) case_add_wall(c, "tank");
            if (rows[k].tank) {
                MnsPart *side = case_add_part(&c->walls[0].shape, MNS_BOX);
                side->outside = true;
                put_point(side->b, 1, 1, 1);
            }
            add_of_body(c, MNS_PROBE_SURFACE_AREA);
            add_of_body(c, MNS_PROBE_ROUNDNESS);
            MnsSim *sim = sim_in_arrays(c);
            for (size_t q = 0; q < 2; q++) {
                const double value = mns_sim_probe(sim, q);
                if (image == 0) first[q] = value;
                assert_close(value, first[q], 1e-11); /* rounding */
            }
            assert_true(first[0] > 0.2);
            sim_done(sim, c);
        }
    }
}

/* What is the other fluid's surface too, but for its own walls and seams. */
static void both_sides_have_one_surface(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = body(dim, dim == 2 ? ELLIPSE : SPINDLE, 8, true);
        for (int fluid = 0; fluid < 2; fluid++) add_of_body(c, MNS_PROBE_SURFACE_AREA)->fluid = fluid;
        MnsSim *sim = sim_in_arrays(c);
        const double surface = mns_sim_probe(sim, 0);
        assert_true(surface > 0.3);
        assert_close(mns_sim_probe(sim, 1), surface, 1e-12); /* rounding */
        sim_done(sim, c);
    }
}

/* By whole spacings, so that samples see the same. */
static void a_body_across_a_seam_is_the_same_body(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = body(dim, dim == 2 ? ELLIPSE : SPINDLE, 5, true);
        add_of_body(c, MNS_PROBE_ROUNDNESS);
        add_of_body(c, MNS_PROBE_SURFACE_AREA);
        MnsSim *sim = sim_in_arrays(c);
        const double roundness = mns_sim_probe(sim, 0), surface = mns_sim_probe(sim, 1);
        sim_done(sim, c);
        c = body(dim, dim == 2 ? ELLIPSE : SPINDLE, 5, true);
        char moved[200];
        snprintf(moved, sizeof moved,
                 dim == 2 ? "((abs(x - a) - 0.5)/0.3)^2 + ((y - b)/0.15)^2 < 1"
                          : "((abs(x - a) - 0.5)/0.3)^2 + ((y - b)^2 + (z - c)^2)/0.15^2 < 1");
        case_set_text(&c->fluids[0].shape.parts[0].formula, moved);
        add_of_body(c, MNS_PROBE_ROUNDNESS);
        add_of_body(c, MNS_PROBE_SURFACE_AREA);
        sim = sim_in_arrays(c);
        assert_close(mns_sim_probe(sim, 0), roundness, 1e-10);
        assert_close(mns_sim_probe(sim, 1), surface, 1e-10);
        sim_done(sim, c);
    }
}

/* Layers: interfaces are 1 wide (and 0.6 deep), and what is on walls is none of them. */
static void a_surface_on_a_wall_is_not_free(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = layers(dim);
        c->fluids[1].shape.n--; /* without the drop */
        for (int fluid = 0; fluid < 2; fluid++) add_of_body(c, MNS_PROBE_SURFACE_AREA)->fluid = fluid;
        MnsSim *sim = sim_in_arrays(c);
        const double width = dim == 2 ? 1 : 0.6;
        assert_close(mns_sim_probe(sim, 0), width, 0.5 * DX);
        assert_close(mns_sim_probe(sim, 1), 2 * width, DX);
        c->fluids[1].shape.n++;
        sim_done(sim, c);
    }
}

static void a_fluid_that_is_not_there_has_no_roundness(void **state)
{
    (void)state;
    MnsCase *c = body(2, "x < 0.1 and y < 0.1", 5, true);
    add_of_body(c, MNS_PROBE_ROUNDNESS);
    add_of_body(c, MNS_PROBE_SURFACE_AREA);
    add_of_body(c, MNS_PROBE_EXTENT);
    MnsSim *sim = sim_in_arrays(c);
    for (size_t i = 0; i < particles_fluid(&sim->s); i++) sim->s.phase[i] = 1;
    assert_true(isnan(mns_sim_probe(sim, 0)));
    assert_true(mns_sim_probe(sim, 1) == 0);
    assert_true(isnan(mns_sim_probe(sim, 2)));
    sim_done(sim, c);
}

/* Its ends on each axis; half a spacing beyond its last particles for a flat side, whatever part of a spacing it has moved. */
static void extent_is_where_a_body_ends(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int gas = 0; gas < 2; gas++) {
            MnsCase *c = body(dim, "x > 0.2 and x < 0.65 and y > 0.25 and y < 0.7", 5, gas);
            for (int k = 0; k < 4; k++) {
                MnsProbe *probe = add_of_body(c, MNS_PROBE_EXTENT);
                probe->axis = k / 2;
                probe->least = k % 2;
            }
            MnsSim *sim = sim_in_arrays(c);
            static const double ends[] = {0.65, 0.2, 0.7, 0.25};
            for (int step = 0; step < 4; step++) {
                for (size_t k = 0; k < 4; k++)
                    assert_close(mns_sim_probe(sim, k), ends[k] + (k < 2 ? step * 0.1 * DX : 0), 0.05 * DX);
                for (size_t i = 0; i < sim->s.n; i++) sim->s.x[0][i] += 0.1 * DX;
            }
            sim_done(sim, c);
        }
}

/* What reaches across a periodic side has no end along that axis, unless a box says of which side. */
static void extent_along_a_side_that_a_body_reaches_across_is_none(void **state)
{
    (void)state;
    MnsCase *c = body(2, "(x > 0.7 or x < 0.2) and y > 0.25 and y < 0.7", 5, true);
    c->periodic[0] = true;
    for (int k = 0; k < 4; k++) {
        MnsProbe *probe = add_of_body(c, MNS_PROBE_EXTENT);
        probe->axis = k / 2;
        probe->least = k % 2;
    }
    MnsProbe *left = add_of_body(c, MNS_PROBE_EXTENT);
    left->within = true;
    put_point(left->min, 0, 0, 0);
    put_point(left->max, 0.5, 1, 1);
    MnsSim *sim = sim_in_arrays(c);
    assert_true(isnan(mns_sim_probe(sim, 0)) && isnan(mns_sim_probe(sim, 1)));
    assert_close(mns_sim_probe(sim, 2), 0.7, 0.05 * DX);
    assert_close(mns_sim_probe(sim, 3), 0.25, 0.05 * DX);
    assert_close(mns_sim_probe(sim, 4), 0.2, 0.05 * DX);
    sim_done(sim, c);
}

static void extent_leaves_out_what_is_alone_or_outside_its_box(void **state)
{
    (void)state;
    MnsCase *c = body(2, "x > 0.2 and x < 0.65 and y > 0.25 and y < 0.7 and (y < 0.5 or x < 0.4)", 5, true);
    for (int k = 0; k < 2; k++) add_of_body(c, k == 0 ? MNS_PROBE_FRONT : MNS_PROBE_EXTENT);
    MnsProbe *upper = add_of_body(c, MNS_PROBE_EXTENT);
    upper->within = true;
    put_point(upper->min, 0, 0.6, 0);
    put_point(upper->max, 1, 1, 1);
    MnsSim *sim = sim_in_arrays(c);
    const Particles *s = &sim->s;
    for (size_t i = 0; i < particles_fluid(s); i++)
        if (fabs(s->x[0][i] - 0.925) < 1e-9 && fabs(s->x[1][i] - 0.425) < 1e-9) sim->s.phase[i] = 0;
    assert_close(mns_sim_probe(sim, 0), 0.95, 1e-12);
    assert_close(mns_sim_probe(sim, 1), 0.65, 0.05 * DX);
    assert_close(mns_sim_probe(sim, 2), 0.4, 0.05 * DX);
    sim_done(sim, c);
}

/* Where fluid 0 ends on the way out from particle i, by what is said of the probe in case.proto alone: where its share falls below a half within a
 * support, between samples a quarter of a spacing apart. -INFINITY: nowhere. */
static double end_from(const MnsSim *sim, size_t i, int axis, double sign)
{
    const Particles *s = &sim->s;
    const double step = 0.25 * sim->model.dx;
    double x[3] = {s->x[0][i], s->x[1][i], 0}, before = 0;
    for (int k = 0; k == 0 || (before >= 0.5 && (k - 1) * step < sim->model.kernel.support); k++) {
        x[axis] = s->x[axis][i] + sign * k * step;
        const Share share = sample_share(sim, x, 1);
        const double now = fmin(share.fluid, share.open);
        if (k > 0 && now < 0.5) return sign * x[axis] - step + step * (before - 0.5) / (before - now);
        before = now;
    }
    return -INFINITY;
}

/* Of all particles, where the probe leaves out those that cannot be farther out. A square frays towards its sides, where ever more of its particles are
 * gas, so that some that lie deep end farther out than the outermost. */
static void extent_is_the_farthest_end_above_all_particles(void **state)
{
    (void)state;
    unsigned deep = 0;
    for (int seed = 1; seed <= 24; seed++) {
        MnsCase *c = body(2, "abs(x - a) < 0.3 and abs(y - b) < 0.3", 6, true);
        c->disorder = 0.2;
        c->seed = (uint32_t)seed;
        for (int k = 0; k < 4; k++) {
            MnsProbe *probe = add_of_body(c, MNS_PROBE_EXTENT);
            probe->axis = k / 2;
            probe->least = k % 2;
        }
        MnsSim *sim = sim_in_arrays(c);
        const size_t n = particles_fluid(&sim->s);
        for (size_t i = 0; i < n; i++) {
            const double out = fmax(fabs(sim->s.x[0][i] - 0.51), fabs(sim->s.x[1][i] - 0.49)) / 0.3;
            if (rand() / (double)RAND_MAX < 1.2 * out * out - 0.4) sim->s.phase[i] = 1;
        }
        for (size_t k = 0; k < 4; k++) {
            const int axis = (int)k / 2;
            const double sign = k % 2 ? -1 : 1;
            double farthest = -INFINITY, top = -INFINITY, from = -INFINITY;
            for (size_t i = 0; i < n; i++) {
                if (sim->s.phase[i] != 0) continue;
                const double start = sign * sim->s.x[axis][i], end = end_from(sim, i, axis, sign);
                if (end > farthest) from = start;
                farthest = fmax(farthest, end);
                top = fmax(top, start);
            }
            deep += from < top - sim->model.dx;
            assert_close(mns_sim_probe(sim, k), sign * farthest, 1e-12);
        }
        sim_done(sim, c);
    }
    assert_true(deep >= 8); /* else nothing was tried */
}

/* Layers end at the walls they lie against. */
static void extent_ends_at_walls(void **state)
{
    (void)state;
    MnsCase *c = layers(3);
    for (int k = 0; k < 6; k++) {
        MnsProbe *probe = add_of_body(c, MNS_PROBE_EXTENT);
        probe->axis = k / 2;
        probe->least = k % 2;
    }
    MnsSim *sim = sim_in_arrays(c);
    static const double ends[] = {1, 0, 0.3, 0, 0.6, 0};
    for (size_t k = 0; k < 6; k++) assert_close(mns_sim_probe(sim, k), ends[k], 0.05 * DX);
    sim_done(sim, c);
}

/* Wherever in a cell of the lattice they stand: their particles stand up to half a spacing from there. */
static void extent_ends_at_walls_off_the_lattice(void **state)
{
    (void)state;
    for (int part = 1; part < 8; part++) {
        MnsCase *c = layers(2);
        MnsPart *tank = &c->walls[0].shape.parts[0];
        tank->a[0] = tank->a[1] = part * DX / 8;
        tank->b[0] = 1 - part * DX / 8;
        for (int k = 0; k < 3; k++) {
            MnsProbe *probe = add_of_body(c, MNS_PROBE_EXTENT);
            probe->axis = k / 2;
            probe->least = k != 1;
        }
        MnsSim *sim = sim_in_arrays(c);
        const double ends[3] = {tank->a[0], tank->b[0], tank->a[1]};
        for (size_t k = 0; k < 3; k++) assert_close(mns_sim_probe(sim, k), ends[k], 0.05 * DX);
        sim_done(sim, c);
    }
}

/* A layer of one row on the floor, and a few particles in a corner. */
static void extent_ends_at_walls_in_corners_too(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int lump = 0; lump < 2; lump++) {
            MnsCase *c = layers(dim);
            c->fluids[1].shape.n = 1;
            put_point(c->fluids[0].shape.parts[0].b, lump ? 2 * DX : 1, lump ? 2 * DX : DX, lump ? 2 * DX : 0.6);
            put_point(c->fluids[1].shape.parts[0].a, 0.8, 0.8, 0); /* away from it */
            put_point(c->fluids[1].shape.parts[0].b, 0.9, 0.9, 0.1);
            const double ends[3] = {lump ? 2 * DX : 1, lump ? 2 * DX : DX, lump ? 2 * DX : 0.6};
            for (int k = 0; k < 2 * dim; k++) {
                MnsProbe *probe = add_of_body(c, MNS_PROBE_EXTENT);
                probe->axis = k / 2;
                probe->least = k % 2;
            }
            MnsSim *sim = sim_in_arrays(c);
            for (size_t k = 0; k < c->n_probes; k++)
                assert_close(mns_sim_probe(sim, k), k % 2 ? 0 : ends[k / 2], 0.5 * DX);
            c->fluids[1].shape.n = 2; /* to be freed */
            sim_done(sim, c);
        }
}

static void velocity_is_the_mean_by_mass_and_volume_the_sum(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = layers(dim);
        for (int fluid = -1; fluid < 2; fluid++) {
            MnsProbe *velocity = case_add_probe(c, MNS_PROBE_VELOCITY);
            velocity->fluid = fluid;
            velocity->axis = 1;
            case_add_probe(c, MNS_PROBE_VOLUME)->fluid = fluid;
        }
        MnsSim *sim = sim_in_arrays(c);
        double mass[2] = {0}, momentum[2] = {0}, volume[2] = {0};
        for (size_t i = 0; i < particles_fluid(&sim->s); i++) {
            const int fluid = sim->s.phase[i];
            sim->s.v[1][i] = (fluid ? -3 : 5) + sim->s.x[0][i];
            const double heavier = 1 + 0.3 * sim->s.x[0][i]; /* so that a mean by number is another one */
            sim->s.m[i] *= heavier;
            sim->s.rho[i] *= heavier;
            mass[fluid] += sim->s.m[i];
            momentum[fluid] += sim->s.m[i] * sim->s.v[1][i];
            volume[fluid] += particles_volume(&sim->s, &sim->model, i);
        }
        assert_close(mns_sim_probe(sim, 0), (momentum[0] + momentum[1]) / (mass[0] + mass[1]), 1e-12);
        assert_close(mns_sim_probe(sim, 1), volume[0] + volume[1], 1e-12);
        for (size_t fluid = 0; fluid < 2; fluid++) {
            assert_close(mns_sim_probe(sim, 2 + 2 * fluid), momentum[fluid] / mass[fluid], 1e-12);
            assert_close(mns_sim_probe(sim, 3 + 2 * fluid), volume[fluid], 1e-12);
        }
        assert_close(volume[0], dim == 2 ? 0.3 : 0.18, 0.01); /* but for compression */
        sim_done(sim, c);
    }
}

/* The pressure is 7 inside, 4 outside, and anything beside the surface. */
static void pressure_jump_is_that_between_what_is_away_from_the_surface(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = body(dim, dim == 2 ? DISC : BALL, 6, true);
        for (int k = 0; k < 3; k++) add_of_body(c, MNS_PROBE_PRESSURE_JUMP);
        c->probes[1].fluid = 1;
        c->probes[2].radius = 1.5 / 24;
        MnsSim *sim = sim_in_arrays(c);
        Particles *s = &sim->s;
        const double support = sim->model.kernel.support;
        for (size_t i = 0; i < s->n; i++) {
            double nearest = INFINITY;
            for (size_t j = 0; j < s->n; j++) {
                double r2 = 0;
                for (int d = 0; d < dim; d++) r2 += pow(model_nearest(&sim->model, d, s->x[d][i] - s->x[d][j]), 2);
                if (s->phase[i] != s->phase[j]) nearest = fmin(nearest, sqrt(r2));
            }
            s->p[i] = nearest <= support ? 1e3 * s->x[0][i] : s->phase[i] ? 4 : 7;
        }
        assert_close(mns_sim_probe(sim, 0), 3, 1e-12);
        assert_close(mns_sim_probe(sim, 1), -3, 1e-12);
        assert_true(fabs(mns_sim_probe(sim, 2) - 3) > 1); /* a narrower margin lets some of it in */
        sim_done(sim, c);
    }
}

static void pressure_jump_of_a_body_that_is_all_surface_is_no_number(void **state)
{
    (void)state;
    MnsCase *c = body(2, "(x - a)^2 + (y - b)^2 < 0.01", 5, true);
    add_of_body(c, MNS_PROBE_PRESSURE_JUMP);
    MnsSim *sim = sim_in_arrays(c);
    assert_true(isnan(mns_sim_probe(sim, 0)));
    sim_done(sim, c);
}

static void bodies_are_the_same_for_any_number_of_threads(void **state)
{
    (void)state;
    static const MnsProbeKind kinds[] = {MNS_PROBE_ROUNDNESS, MNS_PROBE_SURFACE_AREA, MNS_PROBE_EXTENT,
                                         MNS_PROBE_PRESSURE_JUMP};
    double values[4];
    for (unsigned threads = 1; threads < 4; threads++) {
        MnsCase *c = body(3, SPINDLE, 10, true);
        c->threads = threads;
        for (int k = 0; k < 4; k++) add_of_body(c, kinds[k]);
        MnsSim *sim = sim_in_arrays(c);
        for (size_t i = 0; i < sim->s.n; i++) {
            sim->s.p[i] = sin(40 * sim->s.x[0][i]) + 3 * sim->s.x[1][i];
            sim->s.x[1][i] += 1e-3 * cos(50 * sim->s.x[0][i]);
        }
        for (size_t k = 0; k < 4; k++) {
            const double value = mns_sim_probe(sim, k);
            assert_true(value == value);
            if (threads > 1) assert_true(value == values[k]);
            values[k] = value;
        }
        sim_done(sim, c);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(elevation_is_where_fluids_end_on_the_way_up),
        cmocka_unit_test(elevation_of_what_fills_a_tank_is_no_number),
        cmocka_unit_test(elevation_may_be_along_any_axis_and_moves_with_its_wall),
        cmocka_unit_test(roundness_and_surface_are_those_of_known_bodies),
        cmocka_unit_test(images_have_one_surface_and_one_roundness),
        cmocka_unit_test(both_sides_have_one_surface),
        cmocka_unit_test(a_body_across_a_seam_is_the_same_body),
        cmocka_unit_test(a_surface_on_a_wall_is_not_free),
        cmocka_unit_test(a_fluid_that_is_not_there_has_no_roundness),
        cmocka_unit_test(extent_is_where_a_body_ends),
        cmocka_unit_test(extent_along_a_side_that_a_body_reaches_across_is_none),
        cmocka_unit_test(extent_leaves_out_what_is_alone_or_outside_its_box),
        cmocka_unit_test(extent_is_the_farthest_end_above_all_particles),
        cmocka_unit_test(extent_ends_at_walls),
        cmocka_unit_test(extent_ends_at_walls_off_the_lattice),
        cmocka_unit_test(extent_ends_at_walls_in_corners_too),
        cmocka_unit_test(velocity_is_the_mean_by_mass_and_volume_the_sum),
        cmocka_unit_test(pressure_jump_is_that_between_what_is_away_from_the_surface),
        cmocka_unit_test(pressure_jump_of_a_body_that_is_all_surface_is_no_number),
        cmocka_unit_test(bodies_are_the_same_for_any_number_of_threads),
    };
    return cmocka_run_group_tests_name("probe surface", tests, NULL, NULL);
}
