/* SPDX-License-Identifier: BSD-3-Clause */
/* Before a simulation takes memory it is known how much; and while it is made it can be given up. */
#include "sim/making.h"
#include "tests/support/check.h"
#include "tests/support/sims.h"
#include <stdatomic.h>
#include <string.h>

static void assert_foreseen(MnsCase *c)
{
    MnsSim *sim = sim_of(c);
    MnsCapture *capture = NULL;
    size_t sizes[GROUPS], copy = 0;
    for (int g = 0; g < GROUPS; g++) sizes[g] = sim->s.begin[g + 1] - sim->s.begin[g];
    const double foreseen = making_bytes(sim, sizes);
    sim_steps(sim, 20);
    assert_int_equal(mns_sim_capture(sim, mns_sim_state_fields(sim), &capture, NULL), MNS_OK);
    for (int f = 0; mns_fields()[f].name; f++)
        for (int d = 0; d < 3; d++) copy += capture->data[f][d] ? capture->n * field_size(&mns_fields()[f]) : 0;
    const double taken = (double)(mns_sim_bytes(sim) + copy);
    assert_true(foreseen >= taken);
    assert_less(foreseen, 1.5 * taken);
    mns_capture_free(capture);
    sim_done(sim, c);
}

/* Large enough that slabs of lists, which are whole megabytes, do not matter. */
static void what_a_simulation_takes_is_foreseen_and_not_much_more(void **state)
{
    (void)state;
    assert_foreseen(case_dam_break(2, 80));
    assert_foreseen(case_dam_break(3, 16));
    assert_foreseen(case_periodic(2, 200));
    assert_foreseen(case_periodic(3, 30));
}

static MnsCase *filled(const char *scheme, int dim, double resolution, MnsSolver solver)
{
    MnsCase *c = case_periodic(dim, resolution);
    c->scheme.name = scheme;
    c->scheme.kernel = MNS_QUINTIC_SPLINE;
    c->scheme.smoothing = 1;
    c->scheme.incompressible.solver = c->scheme.differences.solver = solver;
    return c;
}

static MnsCase *dam_with_lid(bool lid)
{
    MnsCase *c = case_dam_break(2, 80);
    if (lid) case_set_text(&c->walls[0].surface_velocity[0], "1");
    return c;
}

static double foreseen(MnsCase *c)
{
    MnsSim *sim = sim_of(c);
    size_t sizes[GROUPS];
    for (int g = 0; g < GROUPS; g++) sizes[g] = sim->s.begin[g + 1] - sim->s.begin[g];
    const double bytes = making_bytes(sim, sizes);
    sim_done(sim, c);
    return bytes;
}

/* A lid needs a matrix for each wall particle, and its power for each fluid particle. */
static void lids_are_foreseen(void **state)
{
    (void)state;
    double need[2], taken[2];
    for (int lid = 0; lid < 2; lid++) {
        need[lid] = foreseen(dam_with_lid(lid));
        MnsCase *c = dam_with_lid(lid);
        MnsSim *sim = sim_of(c);
        taken[lid] = (double)mns_sim_bytes(sim);
        sim_done(sim, c);
    }
    assert_true(taken[1] > taken[0]);
    assert_less(taken[1] - taken[0] - 1, need[1] - need[0]); /* rounding of a part of a byte */
    assert_less(need[1] - need[0], 1.5 * (taken[1] - taken[0]));
}

/* With what a library will keep, which nobody else counts, where it will be used: 28 neighbours at 12 bytes in two dimensions, 113 in
 * three, at the least. */
static void systems_are_foreseen_with_what_multigrid_keeps(void **state)
{
    (void)state;
    static const char *const schemes[] = {"incompressible", "differences"};
    for (int k = 0; k < 2; k++) {
        assert_foreseen(filled(schemes[k], 2, 100, MNS_SOLVER_BY_SIZE));
        assert_foreseen(filled(schemes[k], 3, 20, MNS_SOLVER_BICGSTAB));
        if (!amg_exists()) continue;
        for (int dim = 2; dim <= 3; dim++) {
            const double resolution = dim == 2 ? 100 : 20, rows = pow(resolution, dim), entries = dim == 2 ? 29 : 114;
            const double plain = foreseen(filled(schemes[k], dim, resolution, MNS_SOLVER_BICGSTAB));
            const double kept = foreseen(filled(schemes[k], dim, resolution, MNS_SOLVER_AMG)) - plain;
            assert_less(12 * rows * entries, kept);
            assert_less(kept, 2 * 16e6 + 60 * rows * entries);
            assert_true(foreseen(filled(schemes[k], dim, resolution, MNS_SOLVER_BY_SIZE)) == plain);
        }
    }
}

static void what_does_not_fit_is_refused_with_what_is_needed_and_what_there_is(void **state)
{
    (void)state;
    MnsCase *c = case_dam_break(2, 40);
    MnsSim *sim = NULL;
    MnsError error = {.path = ""};
    MnsMaking making = {.memory = 2000000, .memory_is = "free in this box"};
    assert_int_equal(mns_sim_make(c, NULL, &making, &sim, &error), MNS_E_MEMORY);
    assert_null(sim);
    assert_string_equal(error.path, "resolution");
    assert_non_null(strstr(error.text, "GB of memory, and 0.002 GB are free in this box: lower the resolution"));
    making.memory = 200000000;
    assert_int_equal(mns_sim_make(c, NULL, &making, &sim, &error), MNS_OK);
    sim_done(sim, c);
}

/* 8e8 points: counting them all would take a minute. */
static void what_is_far_too_big_is_refused_before_it_is_counted(void **state)
{
    (void)state;
    MnsCase *c = case_dam_break(2, 8000);
    MnsSim *sim = NULL;
    MnsError error = {.path = ""};
    const MnsMaking making = {.memory = 2000000};
    assert_int_equal(mns_sim_make(c, NULL, &making, &sim, &error), MNS_E_MEMORY);
    assert_non_null(strstr(error.text, "more than "));
    mns_case_free(c);
}

/* Asked so often, it says so. */
static bool given_up(void *arg)
{
    return atomic_fetch_sub((_Atomic long *)arg, 1) <= 0;
}

static void it_can_be_given_up_at_any_time_until_it_is_ready(void **state)
{
    (void)state;
    MnsCase *c = case_dam_break(2, 20);
    MnsSim *sim = NULL;
    MnsError error = {.path = ""};
    _Atomic long patience = 1000000;
    const MnsMaking making = {.given_up = given_up, .arg = &patience};
    assert_int_equal(mns_sim_make(c, NULL, &making, &sim, &error), MNS_OK);
    const long asked = 1000000 - patience;
    assert_true(asked > 2 * 40); /* at least for each row, twice */
    sim_steps(sim, 2);
    assert_int_equal(asked, 1000000 - patience); /* and never again */
    mns_sim_free(sim);
    for (long k = 0; k < asked; k++) {
        sim = NULL;
        patience = k;
        assert_int_equal(mns_sim_make(c, NULL, &making, &sim, &error), MNS_E_INTERRUPTED);
        assert_null(sim);
    }
    mns_case_free(c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_a_simulation_takes_is_foreseen_and_not_much_more),
        cmocka_unit_test(systems_are_foreseen_with_what_multigrid_keeps),
        cmocka_unit_test(lids_are_foreseen),
        cmocka_unit_test(what_does_not_fit_is_refused_with_what_is_needed_and_what_there_is),
        cmocka_unit_test(what_is_far_too_big_is_refused_before_it_is_counted),
        cmocka_unit_test(it_can_be_given_up_at_any_time_until_it_is_ready),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
