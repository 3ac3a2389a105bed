/* SPDX-License-Identifier: BSD-3-Clause */
/* All of a range is done once, whoever is kept from its part; what a thread has of its own lies together. */
#include "sim/shares.h"
#include "tests/support/check.h"
#include <omp.h>
#include <string.h>
#include <unistd.h>

enum { MOST = 5000, SLOW_US = 20000 };

static unsigned char done[MOST];

static void everything_is_done_once_by_any_number_of_threads(void **state)
{
    (void)state;
    for (int threads = 1; threads <= SHARES_MAX + 3; threads += threads < 5 ? 1 : 31)
        for (size_t n = 0; n < MOST; n = 3 * n + 1) {
            Shares shares;
            memset(done, 0, sizeof done);
            shares_init(&shares, n, threads);
#pragma omp parallel num_threads(threads)
            for (size_t k; shares_take(&shares, omp_get_thread_num(), &k);) {
#pragma omp atomic
                done[k]++;
            }
            for (size_t k = 0; k < MOST; k++) assert_int_equal(done[k], k < n);
        }
}

static void a_thread_has_its_own_part_from_the_front_and_then_that_of_the_fullest_from_the_back(void **state)
{
    (void)state;
    Shares shares;
    size_t k;
    shares_init(&shares, 12, 3);
    assert_true(shares_take(&shares, 2, &k));
    assert_int_equal(k, 8);
    shares_init(&shares, 12, 3);
    for (size_t i = 0; i < 4; i++) {
        assert_true(shares_take(&shares, 0, &k));
        assert_int_equal(k, i);
    }
    size_t left[3] = {0, 4, 4};
    for (size_t i = 4; i < 12; i++) { /* of equals either will do */
        assert_true(shares_take(&shares, 0, &k));
        const size_t of = k / 4;
        assert_true(left[of] >= left[3 - of]);
        assert_int_equal(k, 4 * of + --left[of]);
    }
    assert_false(shares_take(&shares, 0, &k));
}

/* One that sleeps with the first thing it has leaves all else to the others. */
static void nobody_waits_for_one_that_is_kept_from_its_processor(void **state)
{
    (void)state;
    int by_slow = 0;
    Shares shares;
    shares_init(&shares, 1000, 2);
#pragma omp parallel num_threads(2)
    for (size_t k; shares_take(&shares, omp_get_thread_num(), &k);) {
        if (omp_get_thread_num() || omp_get_num_threads() < 2) continue;
        by_slow++;
        usleep(SLOW_US);
    }
    if (omp_get_max_threads() > 1) assert_true(by_slow < 50);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(everything_is_done_once_by_any_number_of_threads),
        cmocka_unit_test(a_thread_has_its_own_part_from_the_front_and_then_that_of_the_fullest_from_the_back),
        cmocka_unit_test(nobody_waits_for_one_that_is_kept_from_its_processor),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
