/* SPDX-License-Identifier: BSD-3-Clause */
/* A simulation from the outside: its sizes are as counted, steps end where they are told and never in the past, and output
 * times are met to the bit. */
#include "sim/limits.h"
#include "tests/support/check.h"
#include "tests/support/sims.h"

static void sizes_are_as_counted(void **state)
{
    (void)state;
    static const double neighbours[2] = {20, 80}; /* points of a lattice within 2.6 spacings */
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = case_periodic(dim, 10);
        MnsSim *sim = sim_of(c);
        assert_int_equal(mns_sim_particles(sim), dim == 2 ? 100 : 1000);
        assert_int_equal(mns_sim_fluid_particles(sim), dim == 2 ? 100 : 1000);
        assert_close(mns_sim_spacing(sim), 0.1, 1e-15);
        assert_close(mns_sim_mean_neighbours(sim), neighbours[dim - 2], 1e-12);
        assert_true(mns_sim_bytes(sim) > mns_sim_particles(sim) * 100);
        size_t n = 0;
        sim_steps(sim, 4);
        const MnsTimer *timers = mns_sim_timers(sim, &n);
        assert_true(n >= 5);
        for (size_t k = 0; k < n; k++) assert_true(timers[k].name && timers[k].seconds >= 0);
        sim_done(sim, c);
    }
    mns_sim_free(NULL);
    mns_capture_free(NULL);
}

static void steps_end_where_they_are_cut(void **state)
{
    (void)state;
    MnsCase *c = case_shaken(2, 1);
    MnsSim *sim = sim_of(c);
    const Limit *limit = NULL;
    const double dt = limits_dt(sim, &limit);
    assert_int_equal(mns_sim_step(sim, 0.37 * dt, NULL), MNS_OK);
    assert_true(mns_sim_progress(sim).t == 0.37 * dt);
    assert_true(mns_sim_progress(sim).dt == 0.37 * dt);
    assert_true(mns_sim_progress(sim).dt_first == dt); /* what it would have been */
    const double whole = limits_dt(sim, &limit), end = 0.37 * dt + whole;
    /* Longer by less than rounding: no second step of almost nothing. */
    assert_int_equal(mns_sim_step(sim, end * (1 + 1e-15), NULL), MNS_OK);
    assert_true(mns_sim_progress(sim).t == end * (1 + 1e-15));
    assert_int_equal(mns_sim_progress(sim).step, 2);
    /* Longer by a tenth: two steps, the second as short as it must be. */
    const double next = limits_dt(sim, &limit), goal = mns_sim_progress(sim).t + 1.1 * next;
    assert_int_equal(mns_sim_step(sim, goal, NULL), MNS_OK);
    assert_close(mns_sim_progress(sim).dt, next, 1e-15 * next);
    assert_int_equal(mns_sim_step(sim, goal, NULL), MNS_OK);
    assert_true(mns_sim_progress(sim).t == goal);
    assert_int_equal(mns_sim_progress(sim).step, 4);
    assert_true(next != dt && mns_sim_progress(sim).dt_first == dt);
    sim_done(sim, c);
}

/* Sums of many steps meet round numbers to the bit. */
static void output_times_are_met_exactly(void **state)
{
    (void)state;
    MnsCase *c = case_shaken(2, 1);
    MnsSim *sim = sim_of(c);
    for (int k = 1; k <= 20; k++) {
        const double goal = k * 0.01;
        double shortest = INFINITY;
        while (mns_sim_progress(sim).t < goal) {
            assert_int_equal(mns_sim_step(sim, goal, NULL), MNS_OK);
            shortest = fmin(shortest, mns_sim_progress(sim).dt);
        }
        assert_true(mns_sim_progress(sim).t == goal);
        assert_true(shortest > 1e-9 * mns_sim_progress(sim).dt_first);
    }
    sim_done(sim, c);
}

static void steps_into_the_past_are_refused_and_forgotten(void **state)
{
    (void)state;
    MnsCase *c = case_shaken(2, 1);
    MnsSim *sim = sim_of(c);
    sim_steps(sim, 2);
    const uint64_t hash = mns_sim_hash(sim);
    assert_int_equal(mns_sim_step(sim, mns_sim_progress(sim).t, NULL), MNS_E_INVALID);
    assert_int_equal(mns_sim_step(sim, -1, NULL), MNS_E_INVALID);
    assert_int_equal(mns_sim_step(sim, NAN, NULL), MNS_E_INVALID);
    assert_true(mns_sim_hash(sim) == hash);
    sim_steps(sim, 1);
    sim_done(sim, c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sizes_are_as_counted),
        cmocka_unit_test(steps_end_where_they_are_cut),
        cmocka_unit_test(output_times_are_met_exactly),
        cmocka_unit_test(steps_into_the_past_are_refused_and_forgotten),
    };
    return cmocka_run_group_tests_name("sim", tests, NULL, NULL);
}
