/* SPDX-License-Identifier: BSD-3-Clause */
/* Orders that wait for a step or a time: when they are due, in which order, and how they are taken out before that. */
#include "run/agenda.h"
#include "tests/support/check.h"
#include <math.h>

static Order at_step(uint64_t step)
{
    return (Order){.at = {step, INFINITY}, .deadline = INFINITY};
}

static Order at_time(double t)
{
    return (Order){.at = {UINT64_MAX, t}, .deadline = INFINITY};
}

static MnsProgress now(uint64_t step, double t)
{
    return (MnsProgress){.step = step, .t = t};
}

static void an_order_is_due_at_its_step_or_time_and_not_before(void **state)
{
    (void)state;
    Agenda agenda = {.n = 0};
    Order step = at_step(7), time = at_time(0.5);
    agenda_add(&agenda, &step, NULL);
    agenda_add(&agenda, &time, NULL);
    assert_null(agenda_take_due(&agenda, now(6, 0.4)));
    assert_ptr_equal(agenda_take_due(&agenda, now(7, 0.45)), &step);
    assert_null(agenda_take_due(&agenda, now(8, 0.49)));
    assert_ptr_equal(agenda_take_due(&agenda, now(9, 0.5)), &time);
    assert_int_equal(agenda.n, 0);
}

static void those_of_one_boundary_come_in_the_order_of_acceptance(void **state)
{
    (void)state;
    Agenda agenda = {.n = 0};
    Order orders[4] = {at_step(9), at_step(7), at_time(0.5), at_step(7)};
    for (int k = 0; k < 4; k++) agenda_add(&agenda, &orders[k], NULL);
    for (int k = 1; k < 4; k++) assert_ptr_equal(agenda_take_due(&agenda, now(7, 0.5)), &orders[k]);
    assert_null(agenda_take_due(&agenda, now(7, 0.5)));
    assert_ptr_equal(agenda_take_first(&agenda), &orders[0]);
    assert_null(agenda_take_first(&agenda));
}

static void steps_are_shortened_to_the_earliest_time(void **state)
{
    (void)state;
    Agenda agenda = {.n = 0};
    Order orders[3] = {at_time(0.7), at_time(0.3), at_step(1)};
    assert_true(isinf(agenda_limit(&agenda)));
    for (int k = 0; k < 3; k++) agenda_add(&agenda, &orders[k], NULL);
    assert_true(agenda_limit(&agenda) == 0.3);
}

static void one_can_be_taken_out_by_its_id_or_when_its_deadline_has_passed(void **state)
{
    (void)state;
    Agenda agenda = {.n = 0};
    Order orders[3] = {at_step(7), at_step(7), at_step(7)};
    const uint8_t unknown[ORDER_ID] = "unknown";
    for (int k = 0; k < 3; k++) {
        orders[k].id[0] = (uint8_t)(1 + k);
        orders[k].deadline = 10.0 * (3 - k);
        agenda_add(&agenda, &orders[k], NULL);
    }
    assert_true(agenda_deadline(&agenda) == 10);
    assert_null(agenda_take_id(&agenda, unknown));
    assert_ptr_equal(agenda_take_id(&agenda, orders[1].id), &orders[1]);
    assert_null(agenda_take_late(&agenda, 10));
    assert_ptr_equal(agenda_take_late(&agenda, 11), &orders[2]);
    assert_null(agenda_take_late(&agenda, 11));
    assert_int_equal(agenda.n, 1);
}

static void so_many_wait_and_no_more(void **state)
{
    (void)state;
    enum { MOST = 64 }; /* of this machine */
    static Order orders[MOST + 1];
    Agenda agenda = {.n = 0};
    MnsError error;
    for (int k = 0; k <= MOST; k++) orders[k] = at_step(7);
    for (int k = 0; k < MOST; k++) assert_int_equal(agenda_add(&agenda, &orders[k], &error), MNS_OK);
    assert_int_equal(agenda_add(&agenda, &orders[MOST], &error), MNS_E_LIMIT);
    assert_ptr_equal(agenda_take_first(&agenda), &orders[0]);
    assert_int_equal(agenda_add(&agenda, &orders[MOST], &error), MNS_OK);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_order_is_due_at_its_step_or_time_and_not_before),
        cmocka_unit_test(those_of_one_boundary_come_in_the_order_of_acceptance),
        cmocka_unit_test(steps_are_shortened_to_the_earliest_time),
        cmocka_unit_test(one_can_be_taken_out_by_its_id_or_when_its_deadline_has_passed),
        cmocka_unit_test(so_many_wait_and_no_more),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
