/* SPDX-License-Identifier: BSD-3-Clause */
/* Closed spaces under the schemes that solve for a pressure: each has its own, walls so thin that two would share one are refused, and so is a space
 * that is not full. */
#include "tests/support/check.h"
#include "tests/support/sims.h"
#include <string.h>

/* A wall across the tank, from the floor up. */
static void add_partition(MnsCase *c, double from, double to, double top)
{
    case_add_wall(c, "partition");
    MnsPart *box = case_add_part(&c->walls[1].shape, MNS_BOX);
    box->a[0] = from;
    box->b[0] = to;
    box->b[1] = top;
    box->b[2] = 1;
}

/* The wall between them is so thick that nothing of a pressure gets through, and the smaller one is not fluid of the other. */
static void two_closed_spaces_are_stirred_in_one_case(void **state)
{
    (void)state;
    static const char *const schemes[] = {"incompressible", "differences"};
    for (int k = 0; k < 2; k++)
        for (int held = 0; held < 2; held++) {
            MnsCase *c = case_layers(2, 20, 3);
            c->scheme.name = schemes[k];
            c->scheme.differences.holds_pressure = held;
            c->scheme.differences.zero_pressure[0] = c->scheme.differences.zero_pressure[1] = 0.2;
            c->scheme.incompressible.gauge = held ? MNS_GAUGE_MEAN : c->scheme.incompressible.gauge;
            c->scheme.incompressible.tolerance = c->scheme.differences.tolerance = 1e-7;
            add_partition(c, 0.4, 0.8, 1);
            c->walls[1].no_slip = true;
            for (int f = 0; f < 2; f++) {
                case_set_text(&c->fluids[f].velocity[0], "0.3*sin(5*x + 2*y)");
                case_set_text(&c->fluids[f].velocity[1], "0.2*cos(3*x - 4*y)");
            }
            MnsSim *sim = sim_in_arrays(c);
            sim_steps(sim, 10);
            assert_int_equal(sim->system.parts, 2);
            double least[2] = {INFINITY, INFINITY}, mean[2] = {0}, n[2] = {0};
            for (size_t i = 0; i < particles_fluid(&sim->s); i++) {
                const int right = sim->s.x[0][i] > 0.6;
                mean[right] += sim->s.p[i];
                n[right]++;
                if (sim->s.phase[i] == 1) least[right] = fmin(least[right], sim->s.p[i]);
            }
            for (int right = 0; right < 2; right++) {
                if (k == 0 && held == 0) assert_close(least[right], 0, 1e-9);
                else if (k == 0 || right == 1) assert_close(mean[right] / n[right], 0, 1e-9);
            }
            sim_done(sim, c);
        }
}

/* Thinner than twice the kernel's reach it would let through what neither space can hold. A gap in it makes it well; so does another scheme.
 * Spaces are told apart by all threads. */
static void a_wall_that_would_join_two_spaces_is_refused(void **state)
{
    (void)state;
    static const double THICK[] = {0.05, 0.1, 0.15, 0.2, 0.25, 0.3};
    static const char *const schemes[] = {"incompressible", "differences", "riemann"};
    for (int k = 0; k < 3; k++)
        for (int of = 0; of < 6; of++)
            for (int open = 0; open < 2; open++) {
                MnsCase *c = case_layers(2, 20, 3);
                MnsSim *sim = NULL;
                MnsError error = {0};
                c->scheme.name = schemes[k];
                c->threads = of % 2 ? 1 : 2;
                if (k == 1) c->scheme.smoothing = 0.9;
                add_partition(c, 0.5, 0.5 + THICK[of], open ? 0.8 : 1);
                const MnsStatus status = mns_sim_new(c, &sim, &error);
                if (of < 2) { /* thinner than the reach itself: of whatever scheme, and with a gap */
                    assert_int_equal(status, MNS_E_INVALID);
                    assert_string_equal(error.path, "walls[1].shape");
                } else if (of < (k ? 3 : 5) && !open && k < 2) {
                    assert_int_equal(status, MNS_E_INVALID);
                    assert_string_equal(error.path, "walls");
                    assert_non_null(strstr(error.text, k == 0 ? "at least 0.35 m thick" : "at least 0.32 m thick"));
                } else if (of == 5 || open || k == 2) assert_int_equal(status, MNS_OK);
                mns_sim_free(sim);
                mns_case_free(c);
            }
}

static void the_place_of_such_a_wall_is_the_same_for_any_number_of_threads(void **state)
{
    (void)state;
    MnsError one = {0};
    for (unsigned threads = 1; threads <= 2; threads++)
        for (int again = 0; again < 10; again++) {
            MnsCase *c = case_layers(2, 40, 3);
            MnsSim *sim = NULL;
            MnsError error = {0};
            c->scheme.name = "incompressible";
            c->threads = threads;
            add_partition(c, 0.5, 0.575, 1);
            assert_int_equal(mns_sim_new(c, &sim, &error), MNS_E_INVALID);
            if (threads == 1) one = error;
            assert_string_equal(error.text, one.text);
            mns_case_free(c);
        }
}

/* A particle of a wall has one unknown, whatever fluids there are. */
static void a_thin_wall_between_two_fluids_joins_them_as_well(void **state)
{
    (void)state;
    for (int k = 0; k < 2; k++) {
        MnsCase *c = case_layers(2, 20, 3);
        MnsSim *sim = NULL;
        MnsError error = {0};
        c->scheme.name = k ? "differences" : "incompressible";
        if (k) c->scheme.smoothing = 0.9;
        c->fluids[0].shape.parts[0].b[0] = 0.5;
        c->fluids[0].shape.parts[0].b[1] = 1;
        add_partition(c, 0.5, 0.65, 1);
        assert_int_equal(mns_sim_new(c, &sim, &error), MNS_E_INVALID);
        assert_string_equal(error.path, "walls");
        mns_sim_free(sim);
        mns_case_free(c);
    }
}

/* Its fluids would touch across the diagonal of a lattice, were it not for the wall between them. */
static void a_thin_slanted_wall_is_seen(void **state)
{
    (void)state;
    for (int thick = 0; thick < 2; thick++) {
        MnsCase *c = case_layers(2, 20, 3);
        MnsSim *sim = NULL;
        MnsError error = {0};
        case_add_wall(c, "partition");
        for (int k = 0; k < 2; k++) {
            MnsPart *side = case_add_part(&c->walls[1].shape, MNS_HALF_SPACE);
            side->a[0] = 1 + (1 - 2 * k) * (thick ? 0.25 : 0.03);
            side->b[0] = side->b[1] = 1 - 2 * k;
            if (k) side->operation = MNS_INTERSECT;
        }
        const MnsStatus status = mns_sim_new(c, &sim, &error);
        if (status != (thick ? MNS_OK : MNS_E_INVALID)) fail_msg("%d: %s", thick, error.text);
        mns_sim_free(sim);
        mns_case_free(c);
    }
}

static void a_space_that_is_not_full_is_refused(void **state)
{
    (void)state;
    MnsCase *c = case_layers(2, 20, 2);
    MnsSim *sim = NULL;
    MnsError error = {0};
    case_add_part(&c->fluids[1].shape, MNS_BOX)->b[1] = 0.8;
    c->fluids[1].shape.parts[0].b[0] = 1;
    c->fluids[1].shape.parts[0].a[1] = 0.5;
    assert_int_equal(mns_sim_new(c, &sim, &error), MNS_E_INVALID);
    assert_string_equal(error.path, "fluids");
    mns_case_free(c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(two_closed_spaces_are_stirred_in_one_case),
        cmocka_unit_test(a_wall_that_would_join_two_spaces_is_refused),
        cmocka_unit_test(the_place_of_such_a_wall_is_the_same_for_any_number_of_threads),
        cmocka_unit_test(a_thin_wall_between_two_fluids_joins_them_as_well),
        cmocka_unit_test(a_thin_slanted_wall_is_seen),
        cmocka_unit_test(a_space_that_is_not_full_is_refused),
    };
    return cmocka_run_group_tests_name("spaces", tests, NULL, NULL);
}
