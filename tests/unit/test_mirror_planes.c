/* SPDX-License-Identifier: BSD-3-Clause */
/* Planes that mirror the fluid: walls that are such planes, warnings of walls that only look like them, and runs beside them. */
#include "sim/mirror_planes.h"
#include "tests/support/check.h"
#include "tests/support/cloud.h"
#include "tests/support/sims.h"
#include <math.h>
#include <string.h>

static const double DX = 0.1;

static int over_nothing(const double x[3])
{
    (void)x;
    return CLOUD_WATER;
}

static MnsCase *tank(int dim, const char *scheme)
{
    MnsCase *c = case_blank(dim, dim == 2 ? 20 : 12);
    c->scheme.name = scheme;
    c->scheme.kernel = MNS_QUINTIC_SPLINE;
    c->scheme.smoothing = 0.9;
    case_set_text(&c->gravity[0], "0.3");
    case_set_text(&c->gravity[1], "-1");
    case_add_fluid(c, "water", 1, 10);
    c->fluids[0].viscosity = 0.01;
    case_add_wall(c, "tank");
    MnsPart *box = case_add_part(&c->walls[0].shape, MNS_BOX);
    box->outside = true;
    for (int d = 0; d < 3; d++) box->b[d] = c->max[d];
    return c;
}

typedef void Change(MnsCase *c);

static void as_it_is(MnsCase *c)
{
    (void)c;
}

static void sticky(MnsCase *c)
{
    c->walls[0].no_slip = true;
}

static void moving(MnsCase *c)
{
    c->walls[0].motion = (MnsMotion){.kind = MNS_SINE, .amplitude = {0.01, 0, 0}, .frequency = 1};
}

static void cut_off(MnsCase *c, bool no_slip)
{
    MnsPart *half = case_add_part(&c->walls[0].shape, MNS_HALF_SPACE);
    half->operation = MNS_SUBTRACT;
    half->b[1] = 1;
    case_add_wall(c, "floor");
    c->walls[1].no_slip = no_slip;
    case_add_part(&c->walls[1].shape, MNS_HALF_SPACE)->b[1] = 1;
}

static void on_a_sticky_floor(MnsCase *c)
{
    cut_off(c, true);
}

static void on_another_floor(MnsCase *c)
{
    cut_off(c, false);
}

static void with_a_step(MnsCase *c, double height)
{
    case_add_wall(c, "step");
    c->walls[1].no_slip = true;
    case_put_part(c->dim, &c->walls[1].shape,
                  (MnsPart){.primitive = MNS_BOX, .a = {0.3, -1, 0}, .b = {0.6, height, 1}});
}

/* It goes on behind the side, within the tank's own wall, where no fluid sees it. */
static void with_a_sticky_step(MnsCase *c)
{
    with_a_step(c, 0.3);
}

static void with_a_moving_step(MnsCase *c)
{
    with_a_step(c, 0.3);
    c->walls[1].motion = (MnsMotion){.kind = MNS_SINE, .amplitude = {0.01, 0, 0}, .frequency = 1};
}

static void with_a_ball(MnsCase *c, double along_x, double along_y)
{
    case_add_wall(c, "ball");
    MnsPart *ball = case_add_part(&c->walls[1].shape, MNS_BALL);
    ball->a[0] = 0;
    ball->a[1] = 0.5;
    ball->radius = 0.2;
    c->walls[1].no_slip = true;
    c->walls[1].motion = (MnsMotion){.kind = MNS_SINE, .amplitude = {along_x, along_y}, .frequency = 1};
}

/* Up and down a side, half of it behind. */
static void with_a_gliding_ball(MnsCase *c)
{
    with_a_ball(c, 0, 0.1);
}

static void with_a_ball_that_comes_through(MnsCase *c)
{
    with_a_ball(c, 0.1, 0);
}

/* A sticky plate that glides in a side, flush with it: fluid feels it. */
static void with_a_flush_plate(MnsCase *c)
{
    with_a_step(c, 0.6);
    MnsPart *box = &c->walls[1].shape.parts[0];
    box->a[0] = -1;
    box->b[0] = 0;
    box->a[1] = 0.3;
    c->walls[1].motion = (MnsMotion){.kind = MNS_SINE, .amplitude = {0, 0.1, 0}, .frequency = 1};
    const MnsWall plate = c->walls[1]; /* before the tank, which would have its particles */
    c->walls[1] = c->walls[0];
    c->walls[0] = plate;
}

/* In place of a side: a plate that covers it, at all times or at the start alone. */
static void with_a_plate(MnsCase *c, double above, double amplitude)
{
    static MnsMotionPoint way[3] = {{.t = 0}, {.t = 1}, {.t = 2}};
    MnsPart *half = case_add_part(&c->walls[0].shape, MNS_HALF_SPACE);
    half->operation = MNS_SUBTRACT;
    half->b[0] = 1;
    case_add_wall(c, "plate");
    case_put_part(c->dim, &c->walls[1].shape,
                  (MnsPart){.primitive = MNS_BOX, .a = {-1, -above, -1}, .b = {0, 1 + above, 2}});
    way[1].x[1] = amplitude;
    c->walls[1].motion = (MnsMotion){.kind = MNS_TABLE, .n = 3, .points = way};
}

static void with_a_long_plate(MnsCase *c)
{
    with_a_plate(c, 0.5, 0.3);
}

static void with_a_short_plate(MnsCase *c)
{
    with_a_plate(c, 0.1, 0.3);
}

/* Half of a side is sticky. */
static void on_two_floors(MnsCase *c)
{
    cut_off(c, true);
    MnsPart *half = case_add_part(&c->walls[1].shape, MNS_HALF_SPACE);
    half->operation = MNS_INTERSECT;
    half->a[0] = 0.5;
    half->b[0] = 1;
    case_add_wall(c, "other floor");
    case_add_part(&c->walls[2].shape, MNS_HALF_SPACE)->b[1] = 1;
    half = case_add_part(&c->walls[2].shape, MNS_HALF_SPACE);
    half->operation = MNS_SUBTRACT;
    half->a[0] = 0.5;
    half->b[0] = 1;
}

static void with_a_post(MnsCase *c)
{
    MnsPart *post = case_add_part(&c->walls[0].shape, MNS_BALL);
    post->a[0] = 0.5;
    post->a[1] = post->a[2] = 0;
    post->radius = 0.2;
}

static void shrunk(MnsCase *c)
{
    c->walls[0].shape.parts[0].a[0] = 0.1;
}

/* Not by whole cells. */
static void shrunk_a_little(MnsCase *c)
{
    c->walls[0].shape.parts[0].a[0] = 0.11;
}

static void shrunk_above(MnsCase *c)
{
    c->walls[0].shape.parts[0].b[1] = 0.7;
}

/* The floor goes on behind the sides. */
static void in_a_wide_domain(MnsCase *c)
{
    shrunk(c);
    on_a_sticky_floor(c);
    c->walls[1].shape.parts[0].a[1] = 0.2;
}

static void endless(MnsCase *c)
{
    c->periodic[0] = true;
}

static void planes_that_a_wall_covers_and_along_which_fluid_slips_are_mirrors(void **state)
{
    (void)state;
    static const struct {
        Change *change;
        unsigned mirrors;
    } rows[] = {{as_it_is, 15},
                {sticky, 0},
                {moving, 12},
                {on_a_sticky_floor, 11},
                {with_a_sticky_step, 15},
                {with_a_moving_step, 15},
                {with_a_gliding_ball, 15},
                {with_a_ball_that_comes_through, 14},
                {with_a_flush_plate, 14},
                {on_another_floor, 15},
                {on_two_floors, 11},
                {with_a_post, 15},
                {shrunk, 15},
                {shrunk_above, 15},
                {shrunk_a_little, 14},
                {in_a_wide_domain, 11},
                {endless, 12}};
    static const char *const schemes[] = {"incompressible", "differences", "interfacial"};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++)
        for (int scheme = 0; scheme < 3; scheme++) {
            MnsCase *c = tank(2, schemes[scheme]);
            rows[k].change(c);
            MnsSim *sim = sim_of(c);
            if (sim->model.mirrors != (scheme < 2 ? rows[k].mirrors : 0))
                fail_msg("row %zu, %s: mirrors are %u", k, schemes[scheme], sim->model.mirrors);
            sim_done(sim, c);
        }
}

/* A plate that moves along itself. */
static void planes_are_covered_at_all_times(void **state)
{
    (void)state;
    static Change *const plates[2] = {with_a_long_plate, with_a_short_plate};
    for (unsigned k = 0; k < 2; k++) {
        MnsCase *c = tank(2, "dissipation");
        case_set_text(&c->gravity[0], "0");
        plates[k](c);
        MnsSim *sim = sim_of(c);
        assert_int_equal(sim->model.mirrors, 3 - k);
        c->walls[1].motion = (MnsMotion){.kind = MNS_STILL};
        sim_done(sim, c);
    }
}

/* Along the sides, which the interface meets. */
static void moving_along(MnsCase *c)
{
    c->walls[0].motion = (MnsMotion){.kind = MNS_SINE, .amplitude = {0, 0.01, 0}, .frequency = 1};
    case_set_text(&c->gravity[0], "0");
}

/* Gravity is along it. */
static void oblique(MnsCase *c)
{
    MnsPart *half = case_add_part(&c->walls[0].shape, MNS_HALF_SPACE);
    half->a[0] = 0.1;
    half->b[0] = 1;
    half->b[1] = -1;
    case_set_text(&c->gravity[0], "-0.3");
    case_set_text(&c->gravity[1], "-0.3");
}

static bool warns_of_slip(const MnsSim *sim)
{
    for (size_t k = 0; mns_sim_warning(sim, k); k++)
        if (strstr(mns_sim_warning(sim, k), "walls[0].slip: an interface meets the face of tank")) return true;
    return false;
}

static void with_oil_below(MnsCase *c)
{
    case_add_fluid(c, "oil", 0.9, 10);
    c->fluids[1].viscosity = 0.01;
    case_put_part(c->dim, &c->fluids[1].shape, (MnsPart){.primitive = MNS_BOX, .a = {-1, -1, -1}, .b = {2, 0.5, 2}});
}

static void faces_that_stand_as_planes_of_symmetry_and_are_none_are_warned_of(void **state)
{
    (void)state;
    static const struct {
        Change *change;
        const char *scheme;
        bool oil, warns;
    } rows[] = {{as_it_is, "incompressible", true, false},
                {shrunk, "incompressible", true, false},
                {shrunk_a_little, "incompressible", true, true},
                {shrunk_a_little, "differences", true, true},
                {shrunk_a_little, "incompressible", false, false},
                {sticky, "incompressible", true, false},
                {moving, "differences", true, true},
                {on_two_floors, "differences", true, false},
                {as_it_is, "riemann", true, false},
                {with_a_post, "incompressible", true, false},
                {moving, "interfacial", true, false},
                {moving_along, "interfacial", true, false},
                {oblique, "interfacial", true, true},
                {oblique, "riemann", false, false}};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        MnsCase *c = tank(2, rows[k].scheme);
        if (rows[k].oil) with_oil_below(c);
        rows[k].change(c);
        MnsSim *sim = sim_of(c);
        if (warns_of_slip(sim) != rows[k].warns) fail_msg("row %zu", k);
        sim_done(sim, c);
    }
    MnsCase *c = tank(2, "dissipation"); /* along what gravity acts across, nothing is a plane of symmetry */
    with_oil_below(c);
    shrunk_a_little(c);
    for (int k = 0; k < 2; k++) {
        case_set_text(&c->gravity[0], k ? "0" : "0.3");
        MnsSim *sim = sim_of(c);
        assert_int_equal(warns_of_slip(sim), k);
        mns_sim_free(sim);
    }
    mns_case_free(c);
}

/* With sound an image has the pressure of whose it is: only what gravity never acts across is a mirror, also of a gravity that is set later. */
static void sides_across_gravity_are_no_mirrors_with_sound(void **state)
{
    (void)state;
    static const struct {
        const char *gravity[2];
        unsigned mirrors;
    } rows[] = {{{"0", "-1"}, 3}, {{"0", "0"}, 15}, {{"2", "1 - 1"}, 12}, {{"0.3", "-1"}, 0}, {{"0*t", "-1"}, 0}};
    static const char *const schemes[] = {"riemann", "dissipation", "interfacial"};
    enum { ROWS = sizeof rows / sizeof *rows };
    for (int k = 0; k < 3; k++) {
        MnsCase *c[ROWS];
        for (size_t q = 0; q < ROWS; q++) {
            c[q] = tank(2, schemes[k]);
            for (int d = 0; d < 2; d++) case_set_text(&c[q]->gravity[d], rows[q].gravity[d]);
        }
        MnsSim *sim = sim_of(c[0]);
        assert_int_equal(sim->model.mirrors, rows[0].mirrors);
        for (size_t q = 1; q < ROWS; q++) {
            assert_int_equal(mns_sim_steer(sim, c[q], NULL), MNS_OK);
            assert_int_equal(sim->model.mirrors, rows[q].mirrors);
            sim_steps(sim, 2);
        }
        mns_sim_free(sim);
        for (size_t q = 0; q < ROWS; q++) mns_case_free(c[q]);
    }
}

/* What interfaces see in it is in the rows. A wall that has moved has its faces elsewhere. */
static void faces_that_lie_in_a_mirror_are_told_from_others(void **state)
{
    (void)state;
    static const struct {
        Face face;
        double moved;
        bool mirrors;
    } rows[] = {
        {{{0, 0.5, 0}, {1, 0, 0}, 0}, 0, true},          {{{2, 0.5, 0}, {-1, 0, 0}, 0}, 0, false},
        {{{0.7, 1, 0}, {0, -1, 0}, 0}, 0, true},         {{{0.7, 0, 0}, {0, 1, 0}, 0}, 0, false},
        {{{0.3, 0.5, 0}, {1, 0, 0}, 0}, 0, false},       {{{-0.3, 0.5, 0}, {1, 0, 0}, 0}, 0.3, true},
        {{{0, 0.5, 0}, {1, 0, 0}, 0}, 0.3, false},       {{{0, 0.5, 0}, {-1, 0, 0}, 0}, 0, false},
        {{{0, 0.5, 0}, {0.9998, 0.02, 0}, 0}, 0, false}, {{{0, 1, 0}, {0.8, -0.6, 0}, 0}, 0, false},
    };
    Cloud *cloud = cloud_new(&(CloudSetup){.dim = 2, .dx = DX, .n = {20, 10}, .smoothing = 1, .owner = over_nothing});
    Model *model = &cloud->model;
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        model->wall[0].x[0] = rows[k].moved;
        model->mirrors = 1 | 8; /* the lower side along x, the upper one along y */
        if (mirror_planes_have(model, &rows[k].face) != rows[k].mirrors) fail_msg("face %zu", k);
        model->mirrors = 0;
        assert_false(mirror_planes_have(model, &rows[k].face));
    }
    cloud_free(cloud);
}

/* --- runs ----------------------------------------------------------------------------------------------------------------- */

static double fastest(const MnsSim *sim)
{
    double most = 0;
    for (size_t i = 0; i < particles_fluid(&sim->s); i++)
        for (int d = 0; d < sim->s.dim; d++) most = fmax(most, fabs(sim->s.v[d][i]));
    return most;
}

/* On a lattice, which images continue. */
static void each_particle_between_mirrors_has_the_neighbours_of_an_endless_lattice(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = tank(dim, "incompressible");
        MnsSim *sim = sim_of(c);
        const double reach = sim->model.kernel.support / sim->model.dx;
        int pairs = 0;
        for (int x = -3; x <= 3; x++)
            for (int y = -3; y <= 3; y++)
                for (int z = dim == 3 ? -3 : 0; z <= (dim == 3 ? 3 : 0); z++)
                    pairs += (x || y || z) && x * x + y * y + z * z < reach * reach;
        assert_int_equal(sim->model.mirrors, dim == 2 ? 15 : 63);
        assert_true(mns_sim_mean_neighbours(sim) == pairs);
        sim_done(sim, c);
    }
}

/* Under a gravity that is along no side; and hidden walls show the pressure that there would be. P4 moves particles before it finds what holds them. */
static void a_tank_of_mirrors_stays_at_rest(void **state)
{
    (void)state;
    static const char *const schemes[] = {"incompressible", "differences"};
    for (int dim = 2; dim <= 3; dim++)
        for (int k = 0; k < 2; k++) {
            MnsCase *c = tank(dim, schemes[k]);
            c->scheme.incompressible.tolerance = c->scheme.differences.tolerance = 1e-9;
            c->scheme.smoothing = k ? 0.9 : 1;
            MnsSim *sim = sim_in_arrays(c);
            sim_steps(sim, dim == 2 ? 30 : 5);
            assert_less(fastest(sim), k ? 1e-7 : 0.006);
            const Particles *s = &sim->s;
            size_t shown = 0;
            double offset = 0;
            for (size_t i = 0; i < s->n; i++) {
                const double p = 0.3 * s->x[0][i] - s->x[1][i];
                if (i == 0) offset = s->p[i] - p;
                if (i >= particles_fluid(s) && s->p[i] == 0) continue; /* nothing near */
                shown += i >= particles_fluid(s);
                assert_close(s->p[i] - offset, p, k ? 1e-5 : 0.02);
            }
            assert_true(shown > 50);
            sim_done(sim, c);
        }
}

static void bits_beside_mirrors_are_the_same_for_any_number_of_threads(void **state)
{
    (void)state;
    static const char *const schemes[] = {"incompressible", "differences", "riemann", "dissipation", "interfacial"};
    for (int dim = 2; dim <= 3; dim++)
        for (int k = 0; k < 5; k++) {
            uint64_t hash[2];
            for (int many = 0; many < 2; many++) {
                MnsCase *c = tank(dim, schemes[k]);
                if (k >= 2) case_set_text(&c->gravity[0], "0");
                case_set_text(&c->fluids[0].velocity[0], "sin(pi*x)*cos(pi*y)");
                case_set_text(&c->fluids[0].velocity[1], "-cos(pi*x)*sin(pi*y)");
                c->scheme.skin = 0.1; /* lists are built again soon */
                c->threads = many ? 3 : 1;
                MnsSim *sim = sim_of(c);
                sim_steps(sim, dim == 2 ? 20 : 6);
                hash[many] = mns_sim_hash(sim);
                sim_done(sim, c);
            }
            assert_true(hash[0] == hash[1]);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(planes_that_a_wall_covers_and_along_which_fluid_slips_are_mirrors),
        cmocka_unit_test(planes_are_covered_at_all_times),
        cmocka_unit_test(faces_that_stand_as_planes_of_symmetry_and_are_none_are_warned_of),
        cmocka_unit_test(sides_across_gravity_are_no_mirrors_with_sound),
        cmocka_unit_test(faces_that_lie_in_a_mirror_are_told_from_others),
        cmocka_unit_test(each_particle_between_mirrors_has_the_neighbours_of_an_endless_lattice),
        cmocka_unit_test(a_tank_of_mirrors_stays_at_rest),
        cmocka_unit_test(bits_beside_mirrors_are_the_same_for_any_number_of_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
