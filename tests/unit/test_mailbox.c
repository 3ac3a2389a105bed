/* SPDX-License-Identifier: BSD-3-Clause */
/* Orders on their way in: what overtakes what, and what happens when there are too many. */
#include "base/clock.h"
#include "run/mailbox.h"
#include "tests/support/check.h"
#include <string.h>

static int begin(void **state)
{
    static Mailbox box;
    mailbox_init(&box, 3);
    *state = &box;
    return 0;
}

static int end(void **state)
{
    mailbox_done(*state);
    return 0;
}

static void orders_come_out_as_they_went_in_but_urgent_ones_first(void **state)
{
    Order plain[2] = {{.urgent = false}}, urgent[2] = {{.urgent = true}, {.urgent = true}};
    mailbox_post(*state, &plain[0], NULL);
    mailbox_post(*state, &urgent[0], NULL);
    mailbox_post(*state, &plain[1], NULL);
    mailbox_post(*state, &urgent[1], NULL);
    assert_ptr_equal(mailbox_take(*state, 0), &urgent[0]);
    assert_ptr_equal(mailbox_take(*state, 0), &urgent[1]);
    assert_ptr_equal(mailbox_take(*state, 0), &plain[0]);
    assert_ptr_equal(mailbox_take(*state, 0), &plain[1]);
    assert_null(mailbox_take(*state, 0));
}

/* A pause that comes before the runner has so much as looked at the load of a way back is for the run that comes back. */
static void nothing_overtakes_an_order_that_leads(void **state)
{
    Order leads = {.leads = true}, plain = {.urgent = false}, urgent[2] = {{.urgent = true}, {.urgent = true}};
    mailbox_post(*state, &leads, NULL);
    mailbox_post(*state, &plain, NULL);
    for (int k = 0; k < 2; k++) mailbox_post(*state, &urgent[k], NULL);
    assert_ptr_equal(mailbox_take_but(*state, true, false), &leads);
    for (int k = 0; k < 2; k++) assert_ptr_equal(mailbox_take(*state, 0), &urgent[k]);
    assert_ptr_equal(mailbox_take(*state, 0), &plain);
    mailbox_post(*state, &urgent[0], NULL);
    mailbox_post(*state, &leads, NULL);
    assert_ptr_equal(mailbox_take(*state, 0), &leads);
    assert_ptr_equal(mailbox_take(*state, 0), &urgent[0]);
}

static void a_full_box_says_so_and_still_takes_urgent_orders(void **state)
{
    Order orders[5] = {{.urgent = false}}, urgent = {.urgent = true};
    MnsError error = {.text = ""};
    for (int k = 0; k < 3; k++) assert_int_equal(mailbox_post(*state, &orders[k], &error), MNS_OK);
    assert_int_equal(mailbox_post(*state, &orders[3], &error), MNS_E_LIMIT);
    assert_int_equal(mailbox_post(*state, &urgent, &error), MNS_OK);
    assert_ptr_equal(mailbox_take(*state, 0), &urgent);
    assert_ptr_equal(mailbox_take(*state, 0), &orders[0]);
    assert_int_equal(mailbox_post(*state, &orders[3], &error), MNS_OK);
}

/* The box holds three. */
static void who_only_looks_leaves_room_for_who_does_something(void **state)
{
    Order looks[2] = {{.looks = true}, {.looks = true}}, plain[2] = {{.urgent = false}};
    MnsError error = {.text = ""};
    assert_int_equal(mailbox_post(*state, &looks[0], &error), MNS_OK);
    assert_int_equal(mailbox_post(*state, &looks[1], &error), MNS_E_LIMIT);
    for (int k = 0; k < 2; k++) assert_int_equal(mailbox_post(*state, &plain[k], &error), MNS_OK);
    assert_ptr_equal(mailbox_take(*state, 0), &looks[0]);
    assert_int_equal(mailbox_post(*state, &looks[1], &error), MNS_OK);
    assert_ptr_equal(mailbox_remove(*state, looks[1].id), &plain[0]); /* all have the same id */
    assert_ptr_equal(mailbox_take(*state, 0), &plain[1]);
    assert_ptr_equal(mailbox_take(*state, 0), &looks[1]);
    assert_int_equal(mailbox_post(*state, &looks[0], &error), MNS_OK);
}

static void who_has_a_file_written_can_be_left_waiting_and_keeps_its_place(void **state)
{
    Order writes = {.writes = true}, looks = {.looks = true}, urgent = {.urgent = true};
    mailbox_post(*state, &looks, NULL);
    mailbox_post(*state, &writes, NULL);
    mailbox_post(*state, &urgent, NULL);
    assert_ptr_equal(mailbox_take_but(*state, false, true), &urgent);
    assert_ptr_equal(mailbox_take_but(*state, false, true), &looks);
    assert_null(mailbox_take_but(*state, false, true));
    assert_null(mailbox_take_but(*state, true, true));
    assert_ptr_equal(mailbox_take_but(*state, true, false), &writes);
}

static void who_only_looks_can_be_left_waiting_and_keeps_its_place(void **state)
{
    Order looks = {.looks = true}, plain[2] = {{.urgent = false}}, urgent = {.urgent = true};
    mailbox_post(*state, &plain[0], NULL);
    mailbox_post(*state, &looks, NULL);
    mailbox_post(*state, &plain[1], NULL);
    mailbox_post(*state, &urgent, NULL);
    assert_ptr_equal(mailbox_take_but(*state, true, false), &urgent);
    assert_ptr_equal(mailbox_take_but(*state, true, false), &plain[0]);
    assert_null(mailbox_take_but(*state, true, false));
    assert_ptr_equal(mailbox_take(*state, 0), &looks);
    assert_ptr_equal(mailbox_take_but(*state, true, false), &plain[1]);
    assert_null(mailbox_take_but(*state, true, false));
}

static void those_who_come_later_do_not_wait_for_all_files_that_another_wants(void **state)
{
    Mailbox *box = *state;
    Order files[3] = {{.writes = true, .from = 1}, {.writes = true, .from = 1}, {.writes = true, .from = 1}},
          after = {.from = 1}, set = {.from = 2}, file = {.writes = true, .from = 3};
    box->limit = 10;
    for (int k = 0; k < 3; k++) mailbox_post(box, &files[k], NULL);
    mailbox_post(box, &after, NULL);
    assert_ptr_equal(mailbox_take(box, 0), &files[0]);
    mailbox_post(box, &set, NULL);
    mailbox_post(box, &file, NULL);
    assert_ptr_equal(mailbox_take(box, 0), &set);
    assert_ptr_equal(mailbox_take(box, 0), &file);
    assert_ptr_equal(mailbox_take(box, 0), &files[1]);
    assert_ptr_equal(mailbox_take(box, 0), &files[2]);
    assert_ptr_equal(mailbox_take(box, 0), &after);
    assert_null(mailbox_take(box, 0));
}

/* Neither those who change something all the time keep files from being written, nor do few orders change places. */
static void connections_take_turns(void **state)
{
    enum { SETS = 100 };
    Mailbox *box = *state;
    Order files[2] = {{.writes = true, .from = 1}, {.writes = true, .from = 1}}, sets[SETS] = {{.from = 2}},
          last = {.from = 3};
    int before = 0;
    box->limit = 2 * SETS;
    for (int k = 0; k < 2; k++) mailbox_post(box, &files[k], NULL);
    for (int k = 0; k < SETS; k++) {
        sets[k].from = 2;
        mailbox_post(box, &sets[k], NULL);
    }
    mailbox_post(box, &last, NULL);
    assert_ptr_equal(mailbox_take(box, 0), &files[0]);
    for (int k = 0; k < 10; k++) assert_ptr_equal(mailbox_take(box, 0), &sets[k]);
    for (const Order *order; (order = mailbox_take(box, 0)) != &files[1]; before++)
        assert_ptr_equal(order, before < 54 ? &sets[10 + before] : &last);
    assert_int_equal(before, 55);
    for (int k = 64; k < SETS; k++) assert_ptr_equal(mailbox_take(box, 0), &sets[k]);
    assert_null(mailbox_take(box, 0));
}

static void who_waits_for_the_disk_keeps_only_its_own_orders_waiting(void **state)
{
    Mailbox *box = *state;
    Order writes = {.writes = true, .from = 1}, behind = {.from = 1}, other = {.from = 2};
    mailbox_post(box, &writes, NULL);
    mailbox_post(box, &behind, NULL);
    mailbox_post(box, &other, NULL);
    assert_ptr_equal(mailbox_take_but(box, false, true), &other);
    assert_null(mailbox_take_but(box, false, true));
    assert_ptr_equal(mailbox_take_but(box, false, false), &writes);
    assert_ptr_equal(mailbox_take_but(box, false, true), &behind);
}

/* Also when the one before it is taken out of turn. */
static void nobody_waits_behind_what_was_taken_back(void **state)
{
    Mailbox *box = *state;
    Order writes = {.writes = true, .from = 1, .id = "file"}, behind = {.from = 1};
    mailbox_post(box, &writes, NULL);
    mailbox_post(box, &behind, NULL);
    assert_ptr_equal(mailbox_remove(box, writes.id), &writes);
    assert_ptr_equal(mailbox_take_but(box, false, true), &behind);
}

static void one_connection_wants_so_many_files_at_most(void **state)
{
    Mailbox *box = *state;
    Order files[MAILBOX_FILES + 1] = {{.writes = true}}, set = {.from = 1}, other = {.writes = true, .from = 2};
    MnsError error = {.text = ""};
    box->limit = 2 * MAILBOX_FILES;
    for (int k = 0; k <= MAILBOX_FILES; k++) {
        files[k] = (Order){.writes = true, .from = 1};
        assert_int_equal(mailbox_post(box, &files[k], &error), k < MAILBOX_FILES ? MNS_OK : MNS_E_LIMIT);
    }
    assert_non_null(strstr(error.text, "64 commands of this connection"));
    assert_int_equal(mailbox_post(box, &set, &error), MNS_OK);
    assert_int_equal(mailbox_post(box, &other, &error), MNS_OK);
    assert_ptr_equal(mailbox_take(box, 0), &files[0]);
    assert_int_equal(mailbox_post(box, &files[MAILBOX_FILES], &error), MNS_OK);
}

static void an_order_can_be_taken_back_by_its_id(void **state)
{
    Order orders[2] = {{.id = "first"}, {.id = "second"}};
    const uint8_t unknown[ORDER_ID] = "third";
    mailbox_post(*state, &orders[0], NULL);
    mailbox_post(*state, &orders[1], NULL);
    assert_null(mailbox_remove(*state, unknown));
    assert_ptr_equal(mailbox_remove(*state, orders[0].id), &orders[0]);
    assert_ptr_equal(mailbox_take(*state, 0), &orders[1]);
    assert_null(mailbox_take(*state, 0));
}

/* Of whatever is under way, or of one order alone; it is still served afterwards. */
static void an_order_may_end_what_is_under_way(void **state)
{
    Order orders[3] = {{.ends = true}, /* of an id that is all zeros, and nobody else's */
                       {.ends = true, .ends_id = "second"},
                       {.ends = true, .ends_any = true, .urgent = true}};
    const uint8_t first[ORDER_ID] = "first", second[ORDER_ID] = "second";
    mailbox_post(*state, &orders[0], NULL);
    assert_false(mailbox_ends(*state, first, false));
    mailbox_post(*state, &orders[1], NULL);
    assert_false(mailbox_ends(*state, first, false) || orders[1].ended);
    assert_true(mailbox_ends(*state, second, false) && orders[1].ended);
    mailbox_post(*state, &orders[2], NULL);
    assert_true(mailbox_ends(*state, first, false) && orders[2].ended);
    assert_ptr_equal(mailbox_take(*state, 0), &orders[2]);
    assert_ptr_equal(mailbox_take(*state, 0), &orders[0]);
    assert_ptr_equal(mailbox_take(*state, 0), &orders[1]);
}

static void only_older_orders_that_set_in_motion_are_called_off(void **state)
{
    Order old = {.motion = true}, still = {.motion = false}, pause = {.urgent = true}, young = {.motion = true};
    Mailbox *box = *state;
    mailbox_post(box, &still, NULL);
    mailbox_post(box, &old, NULL);
    mailbox_post(box, &pause, NULL);
    assert_ptr_equal(mailbox_take(box, 0), &pause);
    mailbox_post(box, &young, NULL);
    assert_ptr_equal(mailbox_remove_motion(box, pause.number), &old);
    assert_null(mailbox_remove_motion(box, pause.number));
    assert_ptr_equal(mailbox_take(box, 0), &still);
    assert_ptr_equal(mailbox_take(box, 0), &young);
}

static void waiting_ends_at_its_moment(void **state)
{
    const double until = clock_now() + 0.05;
    assert_null(mailbox_take(*state, until));
    assert_true(clock_now() >= until);
}

static void while_a_run_comes_back_only_some_orders_are_taken(void **state)
{
    Mailbox *box = *state;
    Order set = {.id = "set"}, pause = {.urgent = true},
          stop = {.urgent = true, .meanwhile = true, .ends = true, .ends_any = true};
    Order keep = {.urgent = true, .ends = true, .ends_any = true}; /* what it ends must be there first */
    mailbox_post(box, &keep, NULL);
    assert_false(mailbox_ends(box, keep.id, true));
    assert_true(mailbox_ends(box, keep.id, false));
    assert_ptr_equal(mailbox_take(box, 0), &keep);
    mailbox_post(box, &set, NULL);
    mailbox_post(box, &pause, NULL);
    mailbox_post(box, &stop, NULL);
    assert_true(mailbox_ends(box, set.id, true));
    assert_ptr_equal(mailbox_take_meanwhile(box), &stop);
    assert_null(mailbox_take_meanwhile(box));
    assert_ptr_equal(mailbox_take(box, 0), &pause);
    assert_ptr_equal(mailbox_take(box, 0), &set);
}

static void those_whose_deadline_has_passed_can_be_taken_out(void **state)
{
    Mailbox *box = *state;
    Order patient = {.deadline = 30}, late = {.deadline = 10}, later = {.urgent = true, .deadline = 20};
    mailbox_post(box, &patient, NULL);
    mailbox_post(box, &late, NULL);
    mailbox_post(box, &later, NULL);
    assert_null(mailbox_remove_late(box, 10));
    assert_ptr_equal(mailbox_remove_late(box, 15), &late);
    assert_null(mailbox_remove_late(box, 15));
    assert_ptr_equal(mailbox_remove_late(box, 25), &later);
    assert_ptr_equal(mailbox_take(box, 0), &patient);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(orders_come_out_as_they_went_in_but_urgent_ones_first, begin, end),
        cmocka_unit_test_setup_teardown(nothing_overtakes_an_order_that_leads, begin, end),
        cmocka_unit_test_setup_teardown(a_full_box_says_so_and_still_takes_urgent_orders, begin, end),
        cmocka_unit_test_setup_teardown(who_only_looks_leaves_room_for_who_does_something, begin, end),
        cmocka_unit_test_setup_teardown(who_only_looks_can_be_left_waiting_and_keeps_its_place, begin, end),
        cmocka_unit_test_setup_teardown(who_has_a_file_written_can_be_left_waiting_and_keeps_its_place, begin, end),
        cmocka_unit_test_setup_teardown(those_who_come_later_do_not_wait_for_all_files_that_another_wants, begin, end),
        cmocka_unit_test_setup_teardown(connections_take_turns, begin, end),
        cmocka_unit_test_setup_teardown(who_waits_for_the_disk_keeps_only_its_own_orders_waiting, begin, end),
        cmocka_unit_test_setup_teardown(nobody_waits_behind_what_was_taken_back, begin, end),
        cmocka_unit_test_setup_teardown(one_connection_wants_so_many_files_at_most, begin, end),
        cmocka_unit_test_setup_teardown(an_order_may_end_what_is_under_way, begin, end),
        cmocka_unit_test_setup_teardown(an_order_can_be_taken_back_by_its_id, begin, end),
        cmocka_unit_test_setup_teardown(only_older_orders_that_set_in_motion_are_called_off, begin, end),
        cmocka_unit_test_setup_teardown(while_a_run_comes_back_only_some_orders_are_taken, begin, end),
        cmocka_unit_test_setup_teardown(those_whose_deadline_has_passed_can_be_taken_out, begin, end),
        cmocka_unit_test_setup_teardown(waiting_ends_at_its_moment, begin, end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
