/* SPDX-License-Identifier: BSD-3-Clause */
/* One writer at a time, and what an old lease was given for is refused however late it comes. */
#include "run/lease.h"
#include "tests/support/check.h"
#include <string.h>

static MnsStatus take(Lease *lease, double now, MnsError *error)
{
    return lease_take(lease, &(LeaseWish){.ttl_ms = 2000, .holder = "anna"}, 0, now, error);
}

static void without_a_lease_everybody_may(void **state)
{
    (void)state;
    Lease lease = {0};
    assert_false(lease_live(&lease, 0));
    assert_int_equal(lease_admits(&lease, 0, 0, NULL), MNS_OK);
}

static void while_it_lives_only_its_holder_may(void **state)
{
    (void)state;
    Lease lease = {0};
    MnsError error;
    assert_int_equal(take(&lease, 10, &error), MNS_OK);
    assert_int_equal(lease.epoch, 1);
    assert_int_equal(lease_admits(&lease, 1, 11.9, &error), MNS_OK);
    assert_int_equal(lease_admits(&lease, 0, 11.5, &error), MNS_E_HELD);
    assert_string_equal(error.text, "anna holds the lease for another 0.5 s; nothing was done");
    assert_string_equal(error.path, "lease_epoch");
    assert_int_equal(take(&lease, 11, &error), MNS_E_HELD);
    assert_int_equal(lease.epoch, 1);
    assert_true(lease.until == 12);
}

/* From the moment it is over to the nanosecond, and after somebody else has one too. */
static void an_old_lease_is_refused(void **state)
{
    (void)state;
    Lease lease = {0};
    MnsError error;
    assert_int_equal(take(&lease, 0, &error), MNS_OK);
    assert_int_equal(lease_admits(&lease, 1, nextafter(2, 0), &error), MNS_OK);
    assert_int_equal(lease_admits(&lease, 1, 2, &error), MNS_E_EXPIRED);
    assert_string_equal(error.text, "the lease of epoch 1 is over; nothing was done. Take a new one");
    assert_int_equal(lease_admits(&lease, 0, 2, &error), MNS_OK);
    const LeaseWish renewal = {.epoch = 1, .ttl_ms = 1000};
    assert_int_equal(lease_take(&lease, &renewal, 0, 2, &error), MNS_E_EXPIRED);
    assert_int_equal(take(&lease, 3, &error), MNS_OK);
    assert_int_equal(lease.epoch, 2);
    assert_int_equal(lease_admits(&lease, 1, 3.5, &error), MNS_E_EXPIRED);
    assert_non_null(strstr(error.text, "the present one is held by anna"));
    assert_int_equal(lease_admits(&lease, 3, 3.5, &error), MNS_E_EXPIRED); /* nobody was ever given that one */
}

static void it_can_be_renewed_and_given_back(void **state)
{
    (void)state;
    Lease lease = {0};
    MnsError error;
    assert_int_equal(take(&lease, 0, &error), MNS_OK);
    assert_int_equal(lease_take(&lease, &(LeaseWish){.epoch = 1, .ttl_ms = 5000}, 0, 1.5, &error), MNS_OK);
    assert_true(lease.epoch == 1 && lease.until == 6.5);
    assert_int_equal(lease_take(&lease, &(LeaseWish){.release = true}, 0, 2, &error), MNS_E_HELD);
    assert_int_equal(lease_take(&lease, &(LeaseWish){.epoch = 1, .release = true}, 0, 2, &error), MNS_OK);
    assert_false(lease_live(&lease, 2));
    assert_int_equal(lease_take(&lease, &(LeaseWish){.release = true}, 0, 2, &error), MNS_E_INVALID);
    assert_int_equal(take(&lease, 2, &error), MNS_OK);
    assert_int_equal(lease.epoch, 2);
}

/* After a crash the numbers go on, whatever was lost. */
static void epochs_rise_above_what_they_are_told(void **state)
{
    (void)state;
    Lease lease = {0};
    const LeaseWish wish = {.ttl_ms = 100, .holder = "b"};
    assert_int_equal(lease_take(&lease, &wish, 700, 0, NULL), MNS_OK);
    assert_int_equal(lease.epoch, 700);
    assert_int_equal(lease_take(&lease, &wish, 5, 1, NULL), MNS_OK);
    assert_int_equal(lease.epoch, 701);
}

static void bounds_are_told(void **state)
{
    (void)state;
    static const uint64_t times[] = {0, 99, 86400001, UINT64_MAX};
    Lease lease = {0};
    MnsError error;
    for (size_t k = 0; k < sizeof times / sizeof *times; k++) {
        const LeaseWish wish = {.ttl_ms = times[k], .holder = "anna"};
        assert_int_equal(lease_take(&lease, &wish, 0, 0, &error), MNS_E_INVALID);
        assert_string_equal(error.path, "ttl_ms");
    }
    char name[65];
    memset(name, 'n', 64);
    name[64] = 0;
    const char *const names[] = {NULL, "", name};
    for (size_t k = 0; k < 3; k++) {
        const LeaseWish wish = {.ttl_ms = 1000, .holder = names[k]};
        assert_int_equal(lease_take(&lease, &wish, 0, 0, &error), MNS_E_INVALID);
        assert_string_equal(error.path, "holder");
    }
    assert_int_equal(lease.epoch, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(without_a_lease_everybody_may),
        cmocka_unit_test(while_it_lives_only_its_holder_may),
        cmocka_unit_test(an_old_lease_is_refused),
        cmocka_unit_test(it_can_be_renewed_and_given_back),
        cmocka_unit_test(epochs_rise_above_what_they_are_told),
        cmocka_unit_test(bounds_are_told),
    };
    return cmocka_run_group_tests_name("lease", tests, NULL, NULL);
}
