/* SPDX-License-Identifier: BSD-3-Clause */
/* Runs give the same bits with the instructions of every level that fuses, and nearly the same without. */
#include "sim/sim.h"
#include "tests/support/cases.h"
#include "tests/support/check.h"
#include "tests/support/sims.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

static const char *const LEVELS_OF_X86[] = {"x86-64", "x86-64-v3", "x86-64-v4"};

static MnsSim *run_at(const char *level, MnsCase *c, MnsKernel kernel, int steps)
{
    assert_int_equal(mns_level_force(level, NULL), MNS_OK);
    assert_string_equal(mns_level(), level);
    c->scheme.kernel = kernel;
    c->scheme.smoothing = kernel == MNS_WENDLAND_C2 ? 1.3 : 1.0;
    MnsSim *sim = sim_in_arrays(c);
    sim_steps(sim, steps);
    return sim;
}

static void every_level_that_fuses_gives_the_same_bits(void **state)
{
    static const MnsKernel kernels[] = {MNS_WENDLAND_C2, MNS_TRUNCATED_GAUSSIAN, MNS_QUINTIC_SPLINE};
    const char *best = *state;
    for (int dim = 2; dim <= 3; dim++)
        for (size_t kernel = 0; kernel < 3; kernel++) {
            uint64_t expected = 0;
            for (size_t k = 1; k < 3; k++) {
                if (mns_level_force(LEVELS_OF_X86[k], NULL)) continue;
                assert_string_equal(mns_arithmetic(), "fused");
                MnsCase *c = case_shaken(dim, 1 + (unsigned)k);
                MnsSim *sim = run_at(LEVELS_OF_X86[k], c, kernels[kernel], dim == 2 ? 60 : 15);
                if (kernel == 0 && dim == 2) assert_true(mns_sim_progress(sim).rebuilds > 0);
                if (expected) assert_true(mns_sim_hash(sim) == expected);
                expected = mns_sim_hash(sim);
                sim_done(sim, c);
            }
        }
    assert_int_equal(mns_level_force(best, NULL), MNS_OK);
}

/* Rounding is all that differs: after a few steps nobody has gone elsewhere. */
static void the_plainest_level_gives_nearly_the_same(void **state)
{
    const char *best = *state;
    if (mns_level_force(LEVELS_OF_X86[0], NULL)) skip();
    assert_string_equal(mns_arithmetic(), "separate");
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = case_shaken(dim, 1), *d = case_shaken(dim, 1);
        MnsSim *plain = run_at(LEVELS_OF_X86[0], c, MNS_WENDLAND_C2, 5), *other = run_at(best, d, MNS_WENDLAND_C2, 5);
        double most = 0;
        for (size_t i = 0; i < plain->s.n; i++)
            for (int e = 0; e < dim; e++) most = fmax(most, fabs(plain->s.x[e][i] - other->s.x[e][i]));
        assert_true(most < 1e-12 * plain->model.dx);
        if (strcmp(best, LEVELS_OF_X86[0]) != 0) assert_true(mns_sim_hash(plain) != mns_sim_hash(other));
        sim_done(plain, c);
        sim_done(other, d);
    }
    assert_int_equal(mns_level_force(best, NULL), MNS_OK);
}

static void a_level_that_is_not_there_is_refused(void **state)
{
    const char *best = *state;
    MnsError error;
    assert_int_equal(mns_level_force("x86-64-v9", &error), MNS_E_INVALID);
    assert_non_null(strstr(error.text, "x86-64-v9"));
    assert_non_null(strstr(error.text, best));
    assert_string_equal(mns_level(), best);
}

int main(void)
{
    static char best[32];
    snprintf(best, sizeof best, "%s", mns_level());
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_prestate(every_level_that_fuses_gives_the_same_bits, best),
        cmocka_unit_test_prestate(the_plainest_level_gives_nearly_the_same, best),
        cmocka_unit_test_prestate(a_level_that_is_not_there_is_refused, best),
    };
    return cmocka_run_group_tests_name("level", tests, NULL, NULL);
}
