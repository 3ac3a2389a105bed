/* SPDX-License-Identifier: BSD-3-Clause */
/* Particles that have left the domain, and a void in a domain that fluids filled, are each told once. */
#include "sim/integrator.h"
#include "sim/losses.h"
#include "tests/support/check.h"
#include "tests/support/sims.h"

static MnsSim *water(MnsCase **ret_case, bool periodic)
{
    MnsCase *c = case_blank(2, 16);
    c->scheme.name = "riemann";
    c->periodic[0] = c->periodic[1] = periodic;
    case_add_fluid(c, "water", 1000, 20);
    case_add_part(&c->fluids[0].shape, MNS_BOX);
    c->fluids[0].shape.parts[0].b[0] = c->fluids[0].shape.parts[0].b[1] = 1;
    *ret_case = c;
    return sim_in_arrays(c);
}

static int warnings(const MnsSim *sim, const char *entry)
{
    int n = 0;
    const char *text;
    for (size_t k = 0; (text = mns_sim_warning(sim, k)); k++) n += strncmp(text, entry, strlen(entry)) == 0;
    return n;
}

/* Twice, at steps at which it looks. */
static void look(MnsSim *sim)
{
    sim->progress.step = 300;
    losses_step(sim);
    sim->progress.step = 600;
    losses_step(sim);
}

static void more_than_one_in_a_hundred_outside_is_told(void **state)
{
    (void)state;
    for (size_t out = 2; out <= 3; out++) { /* of 256 */
        MnsCase *c;
        MnsSim *sim = water(&c, false);
        for (size_t i = 0; i < out; i++) sim->s.x[0][i] = 1.5;
        look(sim);
        assert_int_equal(warnings(sim, "domain: after"), out > 2 ? 1 : 0);
        assert_close(mns_sim_losses(sim).escaped_share, (double)out / 256, 1e-15);
        for (size_t i = 0; i < out; i++) sim->s.x[0][i] = 0.5;
        look(sim);
        assert_close(mns_sim_losses(sim).escaped_share, (double)out / 256, 1e-15); /* the most that there were */
        sim_done(sim, c);
    }
}

/* However few steps there are. */
static void what_is_outside_at_the_end_is_told(void **state)
{
    (void)state;
    for (int last = 0; last < 2; last++) {
        MnsCase *c;
        MnsSim *sim = water(&c, false);
        c->end_time = 0.1;
        for (size_t i = 0; i < 3; i++) sim->s.x[0][i] = 1.5;
        sim->progress.step = 7;
        sim->progress.t = last ? 0.1 : 0.09;
        losses_step(sim);
        assert_int_equal(warnings(sim, "domain: after"), last);
        sim_done(sim, c);
    }
}

/* A short run is looked at early: after 64, 128 and 256 steps. */
static void what_is_outside_early_is_told(void **state)
{
    (void)state;
    for (unsigned step = 127; step <= 128; step++) {
        MnsCase *c;
        MnsSim *sim = water(&c, false);
        c->end_time = 9;
        for (size_t i = 0; i < 3; i++) sim->s.x[0][i] = 1.5;
        sim->progress.step = step;
        losses_step(sim);
        assert_int_equal(warnings(sim, "domain: after"), step == 128);
        sim_done(sim, c);
    }
}

/* Its fluid is in the tank, which is not where the domain is, whatever else there is that stays. */
static void a_tank_that_moves_loses_nothing(void **state)
{
    (void)state;
    for (int k = 0; k < 4; k++) {
        const bool lost = k % 2, body = k / 2;
        static MnsMotionPoint way[2] = {{.t = 0, .v = {1}}, {.t = 1, .x = {1}, .v = {1}}};
        MnsCase *c = case_blank(2, 16);
        c->scheme.name = "riemann";
        case_add_fluid(c, "water", 1000, 20);
        case_set_text(&c->fluids[0].velocity[0], "1");
        MnsPart *pool = case_add_part(&c->fluids[0].shape, MNS_BOX);
        pool->b[0] = 1;
        pool->b[1] = 0.5;
        case_add_wall(c, "tank");
        MnsPart *inside = case_add_part(&c->walls[0].shape, MNS_BOX);
        inside->outside = true;
        inside->b[0] = inside->b[1] = 1;
        c->walls[0].motion = (MnsMotion){.kind = MNS_TABLE, .n = 2, .points = way};
        if (body) {
            case_add_wall(c, "body");
            MnsPart *box = case_add_part(&c->walls[1].shape, MNS_BOX);
            box->a[0] = box->a[1] = 0.69;
            box->b[0] = box->b[1] = 0.9;
        }
        MnsSim *sim = sim_in_arrays(c);
        while (mns_sim_progress(sim).t < 0.2) assert_int_equal(mns_sim_step(sim, 0.2, NULL), MNS_OK);
        for (size_t i = 0; i < 8 && lost; i++) sim->s.x[1][i] = -0.5;
        look(sim);
        assert_int_equal(warnings(sim, "domain: after"), lost);
        c->walls[0].motion = (MnsMotion){.kind = MNS_STILL};
        sim_done(sim, c);
    }
}

/* A tank 1 x 1 with water half-way up, told as the outside of a box, as half-spaces, as a wall each, as slabs, as a box with a hole, or without a lid. */
enum { AS_OUTSIDE, AS_HALF_SPACES, AS_WALLS, AS_SLABS, AS_HOLE, AS_OPEN, TELLINGS };

static void add_side(MnsCase *c, int telling, int side)
{
    const int d = side / 2, upper = side % 2;
    const size_t wall = telling == AS_WALLS ? c->n_walls : 0;
    if (wall == c->n_walls) case_add_wall(c, "side");
    MnsPart *part = case_add_part(&c->walls[wall].shape, telling == AS_SLABS ? MNS_BOX : MNS_HALF_SPACE);
    part->a[d] = upper;
    part->b[d] = upper ? -1 : 1;
    if (telling != AS_SLABS) return;
    part->a[d] = upper ? 1 : -0.25;
    part->b[d] = upper ? 1.25 : 0;
    part->a[1 - d] = -0.25;
    part->b[1 - d] = 1.25;
}

static void tell(MnsCase *c, int telling)
{
    if (telling == AS_OUTSIDE || telling == AS_HOLE) {
        case_add_wall(c, "tank");
        MnsPart *part = case_add_part(&c->walls[0].shape, MNS_BOX);
        if (telling == AS_HOLE) {
            part->a[0] = part->a[1] = -1;
            part->b[0] = part->b[1] = 2;
            part = case_add_part(&c->walls[0].shape, MNS_BOX);
            part->operation = MNS_SUBTRACT;
        } else part->outside = true;
        part->b[0] = part->b[1] = 1;
        return;
    }
    for (int side = 0; side < (telling == AS_OPEN ? 3 : 4); side++) add_side(c, telling, side);
}

/* Eight particles leave through the floor, or into the post, or none does. The post does not move as the tank does, so that the tank has to be found. */
static void one_tank_told_in_six_ways_is_one_tank(void **state)
{
    (void)state;
    for (int k = 0; k < 6 * TELLINGS; k++) {
        static MnsMotionPoint way[2] = {{.t = 0, .v = {1}}, {.t = 1, .x = {1}, .v = {1}}};
        const int telling = k / 6, lost = k % 3, wider = k / 3 % 2;
        MnsCase *c = case_blank(2, 16);
        c->scheme.name = "riemann";
        for (int d = 0; d < 2 && (wider || telling == AS_SLABS); d++) {
            c->min[d] = -0.25;
            c->max[d] = 1.25;
        }
        case_add_fluid(c, "water", 1000, 20);
        MnsPart *pool = case_add_part(&c->fluids[0].shape, MNS_BOX);
        pool->b[0] = 1;
        pool->b[1] = 0.5;
        tell(c, telling);
        const size_t n = c->n_walls;
        for (size_t w = 0; w < n; w++) c->walls[w].motion = (MnsMotion){.kind = MNS_TABLE, .n = 2, .points = way};
        case_add_wall(c, "post");
        MnsPart *post = case_add_part(&c->walls[n].shape, MNS_BOX);
        post->a[0] = post->a[1] = 0.6875;
        post->b[0] = post->b[1] = 0.9375;
        MnsSim *sim = sim_in_arrays(c);
        for (size_t w = 0; w < n; w++) sim->model.wall[w].x[0] = 0.5;
        for (size_t i = 0; i < sim->s.n; i++) sim->s.x[0][i] += 0.5;
        for (size_t i = 0; i < 8 && lost; i++) {
            sim->s.x[0][i] = 0.8;
            sim->s.x[1][i] = lost == 1 ? -0.5 : 0.8;
        }
        look(sim);
        assert_int_equal(warnings(sim, "domain: after"), lost > 0);
        for (size_t w = 0; w < n; w++) c->walls[w].motion = (MnsMotion){.kind = MNS_STILL};
        sim_done(sim, c);
    }
}

/* Water from here to the right side, half as high as the domain. */
static MnsCase *pool(double left)
{
    MnsCase *c = case_blank(2, 16);
    c->scheme.name = "riemann";
    case_add_fluid(c, "water", 1000, 20);
    MnsPart *box = case_add_part(&c->fluids[0].shape, MNS_BOX);
    box->a[0] = left;
    box->b[0] = 1;
    box->b[1] = 0.5;
    return c;
}

/* It is lifted, with water that is above where the domain's upper side was; eight particles leave through the floor, or none does. */
static void a_tank_without_a_lid_takes_its_open_side_along(void **state)
{
    (void)state;
    static MnsMotionPoint way[2] = {{.t = 0, .v = {0, 1}}, {.t = 1, .x = {0, 1}, .v = {0, 1}}};
    for (int lost = 0; lost < 2; lost++) {
        MnsCase *c = pool(0);
        tell(c, AS_OPEN);
        c->walls[0].motion = (MnsMotion){.kind = MNS_TABLE, .n = 2, .points = way};
        MnsSim *sim = sim_in_arrays(c);
        sim->model.wall[0].x[1] = 0.75;
        for (size_t i = 0; i < sim->s.n; i++) sim->s.x[1][i] += 0.75;
        for (size_t i = 0; i < 8 && lost; i++) sim->s.x[1][i] = 0.5;
        look(sim);
        assert_int_equal(warnings(sim, "domain: after"), lost);
        c->walls[0].motion = (MnsMotion){.kind = MNS_STILL};
        sim_done(sim, c);
    }
}

/* Though all of it is where the domain would be if the plate took it along. */
static void what_a_plate_carries_out_is_told(void **state)
{
    (void)state;
    MnsCase *c = pool(0.5);
    for (int k = 0; k < 2; k++) {
        static MnsMotionPoint way[2] = {{.t = 0, .v = {1}}, {.t = 1, .x = {1}, .v = {1}}};
        case_add_wall(c, k ? "plate" : "floor");
        MnsPart *box = case_add_part(&c->walls[k].shape, MNS_BOX);
        box->a[0] = k ? 0.25 : -1;
        box->b[0] = k ? 0.5 : 3;
        box->a[1] = k ? 0 : -1;
        box->b[1] = k ? 1 : 0;
        if (k) c->walls[k].motion = (MnsMotion){.kind = MNS_TABLE, .n = 2, .points = way};
    }
    MnsSim *sim = sim_in_arrays(c);
    sim->model.wall[1].x[0] = 0.5;
    for (size_t i = 0; i < particles_fluid(&sim->s); i++) sim->s.x[0][i] += 0.5;
    look(sim);
    assert_int_equal(warnings(sim, "domain: after"), 1);
    c->walls[1].motion = (MnsMotion){.kind = MNS_STILL};
    sim_done(sim, c);
}

static void a_void_is_told(void **state)
{
    (void)state;
    for (int bare = 0; bare < 2; bare++) {
        MnsCase *c;
        MnsSim *sim = water(&c, true);
        for (size_t i = 0; i < sim->s.n && bare; i++)
            if (hypot(sim->s.x[0][i] - 0.5, sim->s.x[1][i] - 0.5) < 0.2) sim->s.x[0][i] += 0.4;
        particles_changed(&sim->s, ON_FLUID, FIELD(X));
        assert_int_equal(integrator_lists(sim, NULL), MNS_OK);
        look(sim);
        assert_int_equal(warnings(sim, "coverage:"), bare);
        assert_true((mns_sim_losses(sim).least_coverage < 0.3) == bare);
        assert_int_equal(warnings(sim, "domain: after"), 0);
        sim_done(sim, c);
    }
}

/* What is deep in a solid is none, of which a ball in the middle of a tank has much. */
static void a_thick_solid_is_no_void(void **state)
{
    (void)state;
    MnsCase *c = case_blank(2, 32);
    c->scheme.name = "riemann";
    case_add_fluid(c, "water", 1000, 20);
    for (int k = 0; k < 2; k++) {
        case_add_wall(c, k ? "ball" : "tank");
        MnsPart *part = case_add_part(&c->walls[k].shape, k ? MNS_BALL : MNS_BOX);
        part->outside = !k;
        part->radius = 0.3;
        part->a[0] = part->a[1] = 0.5 * k;
        part->b[0] = part->b[1] = 1;
    }
    MnsSim *sim = sim_in_arrays(c);
    assert_true(sim->model.filled);
    look(sim);
    assert_int_equal(warnings(sim, "coverage:"), 0);
    sim_done(sim, c);
}

/* Nor is what a piston that is a slab has left behind. */
static void behind_a_piston_is_no_void(void **state)
{
    (void)state;
    static MnsMotionPoint way[2] = {{.t = 0, .v = {1}}, {.t = 1, .x = {1}, .v = {1}}};
    MnsCase *c = case_blank(2, 16);
    c->scheme.name = "riemann";
    case_add_fluid(c, "water", 1000, 20);
    case_add_wall(c, "piston");
    MnsPart *part = case_add_part(&c->walls[0].shape, MNS_BOX);
    part->a[0] = part->a[1] = -0.25;
    part->b[1] = 1.25;
    c->walls[0].motion = (MnsMotion){.kind = MNS_TABLE, .n = 2, .points = way};
    for (int side = 1; side < 4; side++) add_side(c, AS_WALLS, side);
    MnsSim *sim = sim_in_arrays(c);
    assert_true(sim->model.filled);
    sim->model.wall[0].x[0] = 0.5;
    for (size_t i = 0; i < sim->s.n; i++) {
        double *x = &sim->s.x[0][i];
        if (i < particles_fluid(&sim->s)) *x = 0.5 + 0.5 * *x;
        else if (sim->s.phase[i] == 1) *x += 0.5;
    }
    particles_changed(&sim->s, ON_ALL, FIELD(X));
    assert_int_equal(integrator_lists(sim, NULL), MNS_OK);
    look(sim);
    assert_int_equal(warnings(sim, "coverage:"), 0);
    assert_int_equal(warnings(sim, "domain: after"), 0);
    c->walls[0].motion = (MnsMotion){.kind = MNS_STILL};
    sim_done(sim, c);
}

/* Though the case has left no room for more to warn of. */
static void it_is_told_after_all_that_there_was_to_warn_of(void **state)
{
    (void)state;
    MnsCase *c = case_blank(2, 16);
    c->scheme.name = "riemann";
    case_add_fluid(c, "water", 1000, 20);
    case_add_part(&c->fluids[0].shape, MNS_BOX);
    c->fluids[0].shape.parts[0].b[0] = c->fluids[0].shape.parts[0].b[1] = 1;
    for (int k = 0; k < 2 * SIM_WARNINGS_MAX; k++) case_add_probe(c, MNS_PROBE_PRESSURE)->at[0] = 100 + k;
    MnsSim *sim = sim_in_arrays(c);
    for (size_t i = 0; i < 3; i++) sim->s.x[0][i] = 1.5;
    look(sim);
    assert_int_equal(warnings(sim, "there is more"), 1);
    assert_int_equal(warnings(sim, "domain: after"), 1);
    sim_done(sim, c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(more_than_one_in_a_hundred_outside_is_told),
        cmocka_unit_test(what_is_outside_at_the_end_is_told),
        cmocka_unit_test(what_is_outside_early_is_told),
        cmocka_unit_test(a_tank_that_moves_loses_nothing),
        cmocka_unit_test(one_tank_told_in_six_ways_is_one_tank),
        cmocka_unit_test(a_tank_without_a_lid_takes_its_open_side_along),
        cmocka_unit_test(what_a_plate_carries_out_is_told),
        cmocka_unit_test(a_void_is_told),
        cmocka_unit_test(a_thick_solid_is_no_void),
        cmocka_unit_test(behind_a_piston_is_no_void),
        cmocka_unit_test(it_is_told_after_all_that_there_was_to_warn_of),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
