/* SPDX-License-Identifier: BSD-3-Clause */
/* Runs give the same bits with the instructions of every level that this machine has. */
#include "tests/support/cases.h"
#include "tests/support/check.h"
#include "tests/support/sims.h"
#include <stdio.h>
#include <string.h>

static const char *const LEVELS_OF_X86[] = {"x86-64", "x86-64-v3", "x86-64-v4"};

static void every_level_gives_the_same_bits(void **state)
{
    static const MnsKernel kernels[] = {MNS_WENDLAND_C2, MNS_TRUNCATED_GAUSSIAN, MNS_QUINTIC_SPLINE};
    const char *best = *state;
    for (int dim = 2; dim <= 3; dim++)
        for (size_t kernel = 0; kernel < 3; kernel++) {
            uint64_t expected = 0;
            int tried = 0;
            for (size_t k = 0; k < 3; k++) {
                if (mns_level_force(LEVELS_OF_X86[k], NULL)) continue;
                assert_string_equal(mns_level(), LEVELS_OF_X86[k]);
                MnsCase *c = case_shaken(dim, 1 + (unsigned)k);
                c->scheme.kernel = kernels[kernel];
                c->scheme.smoothing = kernel == 0 ? 1.3 : 1.0;
                MnsSim *sim = sim_of(c);
                sim_steps(sim, dim == 2 ? 60 : 15);
                if (kernel == 0 && dim == 2) assert_true(mns_sim_progress(sim).rebuilds > 0);
                if (expected) assert_true(mns_sim_hash(sim) == expected);
                expected = mns_sim_hash(sim);
                sim_done(sim, c);
                tried++;
            }
            if (strncmp(best, "x86", 3) == 0) assert_true(tried >= 2);
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
        cmocka_unit_test_prestate(every_level_gives_the_same_bits, best),
        cmocka_unit_test_prestate(a_level_that_is_not_there_is_refused, best),
    };
    return cmocka_run_group_tests_name("level", tests, NULL, NULL);
}
