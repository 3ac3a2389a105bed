/* SPDX-License-Identifier: BSD-3-Clause */
/* The books of a stream: credit, what is under way, what was skipped; and when items are due. */
#include "net/subscription.h"
#include "run/due.h"
#include "tests/support/check.h"

static Subscription new_books(uint64_t credit)
{
    Subscription s;
    subscription_begin(&s, 100, credit, 7); /* seven were due before it came */
    return s;
}

static void what_was_due_before_it_came_is_not_skipped(void **state)
{
    (void)state;
    Subscription s = new_books(0);
    assert_false(subscription_wants(&s, 7));
    assert_true(subscription_wants(&s, 8));
    assert_int_equal(subscription_take(&s, 8, 10), 0);
    assert_int_equal(s.sequence, 1);
}

static void what_is_skipped_is_counted_once_and_as_it_happens(void **state)
{
    (void)state;
    Subscription s;
    subscription_begin(&s, 100, 1000, 5);
    assert_int_equal(subscription_skips(&s, 0, 5), 0);
    assert_int_equal(subscription_skips(&s, 6, 6), 0); /* it may still be sent */
    assert_int_equal(subscription_skips(&s, 7, 7), 1);
    assert_int_equal(subscription_skips(&s, 7, 7), 0);
    assert_int_equal(subscription_skips(&s, 7, 8), 0); /* of 8 none was made, and 7 is there yet */
    assert_int_equal(subscription_take(&s, 7, 0), 1);
    subscription_sent(&s, 0);
    assert_int_equal(subscription_skips(&s, 7, 8), 0); /* and of 8 one may be in the making */
    assert_int_equal(subscription_skips(&s, 7, 9), 1);
    assert_int_equal(subscription_skips(&s, 12, 12), 3);
    assert_int_equal(subscription_skips(&s, 13, 12), 1); /* it leaves */
}

static void one_that_is_put_back_is_counted_once(void **state)
{
    (void)state;
    Subscription s;
    subscription_begin(&s, 100, 1000, 0);
    assert_int_equal(subscription_skips(&s, 4, 4), 3);
    const uint64_t skipped = subscription_take(&s, 4, 10);
    subscription_put_back(&s, skipped);
    assert_int_equal(subscription_skips(&s, 6, 6), 2);
    assert_int_equal(subscription_take(&s, 6, 10), 5);
    assert_int_equal(subscription_skips(&s, 6, 6), 0);
}

static void those_in_between_are_skipped_and_counted(void **state)
{
    (void)state;
    Subscription s = new_books(0);
    assert_int_equal(subscription_take(&s, 12, 10), 4);
    assert_int_equal(s.sequence, 5);
    assert_true(subscription_sent(&s, 10));
    assert_int_equal(subscription_take(&s, 13, 10), 0);
    assert_int_equal(s.sequence, 6);
}

static void one_that_was_not_begun_gives_way_to_a_newer_one_and_is_counted_once(void **state)
{
    (void)state;
    Subscription s = new_books(0);
    subscription_put_back(&s, subscription_take(&s, 9, 10));
    assert_true(subscription_wants(&s, 10));
    assert_int_equal(subscription_take(&s, 10, 10), 2);
    assert_int_equal(s.sequence, 3);
}

static void while_one_is_under_way_no_other_is_begun(void **state)
{
    (void)state;
    Subscription s = new_books(0);
    subscription_take(&s, 8, 250);
    assert_false(subscription_sent(&s, subscription_next(&s)));
    assert_false(subscription_wants(&s, 9));
    assert_false(subscription_sent(&s, 100));
    assert_int_equal(subscription_next(&s), 50);
    assert_true(subscription_sent(&s, 50));
    assert_true(subscription_wants(&s, 9));
}

static void an_item_outside_the_feed_skips_nothing_and_does_not_count_there(void **state)
{
    (void)state;
    Subscription s = new_books(0);
    assert_int_equal(subscription_take(&s, 0, 10), 0);
    assert_true(subscription_sent(&s, 10));
    assert_int_equal(subscription_take(&s, 8, 10), 0);
    assert_int_equal(s.sequence, 2);
}

static void no_more_is_paid_than_was_granted(void **state)
{
    (void)state;
    Subscription s = new_books(150);
    assert_true(subscription_pay(&s, 100));
    assert_false(subscription_pay(&s, 51));
    assert_true(subscription_pay(&s, 50));
    assert_false(subscription_pay(&s, 1));
    subscription_grant(&s, 1);
    assert_true(subscription_pay(&s, 1));
}

static void grants_end_at_a_bound_and_never_wrap(void **state)
{
    (void)state;
    Subscription s = new_books(UINT64_MAX);
    subscription_grant(&s, UINT64_MAX);
    assert_int_equal(s.credit, CREDIT_MOST);
}

static void a_cancel_ends_the_item_that_it_names_and_no_other(void **state)
{
    (void)state;
    Subscription s = new_books(0);
    assert_false(subscription_cancel(&s, 0));
    subscription_take(&s, 8, 250);
    assert_false(subscription_cancel(&s, 2));
    assert_true(subscription_cancel(&s, 1));
    assert_false(subscription_cancel(&s, 1));
    assert_true(subscription_wants(&s, 9));
}

static void an_item_goes_on_where_its_bytes_ended_and_not_beyond(void **state)
{
    (void)state;
    Subscription s = new_books(0);
    assert_false(subscription_resume(&s, 0, 0));
    subscription_take(&s, 8, 250);
    subscription_sent(&s, 200);
    assert_false(subscription_resume(&s, 1, 201));
    assert_false(subscription_resume(&s, 2, 100));
    assert_true(subscription_resume(&s, 1, 100));
    assert_int_equal(subscription_next(&s), 100);
    assert_true(s.opened);
    assert_true(subscription_resume(&s, 1, 0));
    assert_false(s.opened); /* what it is must be told again */
}

static void one_that_is_whole_can_be_had_again_until_the_next(void **state)
{
    (void)state;
    Subscription s = new_books(0);
    subscription_take(&s, 8, 50);
    assert_true(subscription_sent(&s, 50));
    assert_true(subscription_resume(&s, 1, 20));
    assert_true(s.under_way);
    assert_true(subscription_sent(&s, 30));
    assert_true(subscription_resume(&s, 1, 50));
    assert_false(s.under_way);
}

/* --- when ---------------------------------------------------------------------------------------------------------------- */

static void items_are_due_at_multiples_of_steps(void **state)
{
    (void)state;
    const When when = {.every_steps = 3};
    DueState due = due_begin();
    for (uint64_t step = 1; step < 20; step++)
        assert_int_equal(due_now(&when, &due, step, 0.1 * (double)step, 0.1, 0), step % 3 == 0);
}

static void items_are_due_once_in_each_interval_also_the_first(void **state)
{
    (void)state;
    const When when = {.interval = 0.25};
    DueState due = due_begin();
    int n = 0;
    for (uint64_t step = 11; step <= 40; step++) n += due_now(&when, &due, step, 0.1 * (double)step, 0.1, 0);
    assert_int_equal(n, 12); /* 1.25, 1.5 ... 4.0 */
}

static void none_is_due_before_the_clock_allows_it(void **state)
{
    (void)state;
    const When when = {.gap = 1};
    DueState due = due_begin();
    assert_true(due_now(&when, &due, 1, 0.1, 0.1, 100));
    assert_false(due_now(&when, &due, 2, 0.2, 0.1, 100.9));
    assert_true(due_now(&when, &due, 3, 0.3, 0.1, 101));
}

static void both_conditions_are_met(void **state)
{
    (void)state;
    const When when = {.every_steps = 2, .gap = 1};
    DueState due = due_begin();
    assert_false(due_now(&when, &due, 1, 0.1, 0.1, 100));
    assert_true(due_now(&when, &due, 2, 0.2, 0.1, 100));
    assert_false(due_now(&when, &due, 3, 0.3, 0.1, 102));
    assert_true(due_now(&when, &due, 4, 0.4, 0.1, 102));
}

static void a_run_that_goes_back_is_due_again_only_at_the_next_multiple(void **state)
{
    (void)state;
    const When when = {.interval = 1};
    DueState due = due_begin();
    assert_true(due_now(&when, &due, 50, 5.0, 0.1, 0));
    assert_false(due_now(&when, &due, 12, 1.2, 0.1, 0));
    assert_true(due_now(&when, &due, 20, 2.0, 0.8, 0));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_was_due_before_it_came_is_not_skipped),
        cmocka_unit_test(those_in_between_are_skipped_and_counted),
        cmocka_unit_test(what_is_skipped_is_counted_once_and_as_it_happens),
        cmocka_unit_test(one_that_is_put_back_is_counted_once),
        cmocka_unit_test(one_that_was_not_begun_gives_way_to_a_newer_one_and_is_counted_once),
        cmocka_unit_test(while_one_is_under_way_no_other_is_begun),
        cmocka_unit_test(an_item_outside_the_feed_skips_nothing_and_does_not_count_there),
        cmocka_unit_test(no_more_is_paid_than_was_granted),
        cmocka_unit_test(grants_end_at_a_bound_and_never_wrap),
        cmocka_unit_test(a_cancel_ends_the_item_that_it_names_and_no_other),
        cmocka_unit_test(an_item_goes_on_where_its_bytes_ended_and_not_beyond),
        cmocka_unit_test(one_that_is_whole_can_be_had_again_until_the_next),
        cmocka_unit_test(items_are_due_at_multiples_of_steps),
        cmocka_unit_test(items_are_due_once_in_each_interval_also_the_first),
        cmocka_unit_test(none_is_due_before_the_clock_allows_it),
        cmocka_unit_test(both_conditions_are_met),
        cmocka_unit_test(a_run_that_goes_back_is_due_again_only_at_the_next_multiple),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
