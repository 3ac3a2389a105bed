/* SPDX-License-Identifier: BSD-3-Clause */
/* A request becomes a reply that says all of what came of it, and no half of a result. */
#include "net/exchange.h"
#include "tests/support/check.h"
#include <stdlib.h>
#include <string.h>

static Exchange *new_exchange(void)
{
    Meniscus__Request *request = malloc(sizeof *request);
    meniscus__request__init(request);
    request->id.data = malloc(ORDER_ID);
    memcpy(request->id.data, "sixteen letters!", ORDER_ID);
    request->id.len = ORDER_ID;
    request->has_id = true;
    Exchange *exchange = exchange_new(request, &(Who){WHO_LOCAL, ROLE_ADMIN});
    assert_non_null(exchange);
    return exchange;
}

static void add_numbers(Exchange *exchange)
{
    double *numbers = malloc(6 * sizeof *numbers);
    for (int k = 0; k < 6; k++) numbers[k] = k;
    assert_int_equal(
        exchange_add(exchange, "position", "<f8", "m", (uint64_t[]){3, 2}, 2, numbers, 6 * sizeof *numbers, NULL),
        MNS_OK);
}

static void a_success_says_when_and_brings_its_arrays(void **state)
{
    (void)state;
    Exchange *exchange = new_exchange();
    add_numbers(exchange);
    exchange->at_step = true;
    exchange->order.state = RUN_PAUSED;
    exchange->order.step = 9;
    exchange->order.effect_step = 7;
    exchange->epoch = 42;
    exchange_seal(exchange);
    const Meniscus__Reply *reply = exchange->reply;
    assert_memory_equal(reply->id.data, "sixteen letters!", ORDER_ID);
    assert_int_equal(reply->code, MENISCUS__CODE__OK);
    assert_int_equal(reply->state, MENISCUS__STATE__PAUSED);
    assert_int_equal(reply->daemon_epoch, 42);
    assert_int_equal(reply->step, 9);
    assert_true(reply->has_effect_step && reply->effect_step == 7);
    assert_int_equal(reply->n_arrays, 1);
    assert_int_equal(reply->arrays[0]->n_shape, 2);
    assert_int_equal(reply->arrays[0]->shape[0], 3);
    assert_int_equal(exchange->sizes[0], 48);
    exchange_free(exchange);
}

static void a_failure_brings_reason_place_and_states_and_no_result(void **state)
{
    (void)state;
    Exchange *exchange = new_exchange();
    add_numbers(exchange);
    exchange->at_step = true;
    exchange->allowed = 1u << RUN_READY | 1u << RUN_PAUSED;
    exchange->order.status = mns_fail_at(&exchange->order.error, MNS_E_STATE, "where", "not now");
    exchange->epoch = 42;
    exchange_seal(exchange);
    const Meniscus__Reply *reply = exchange->reply;
    assert_int_equal(reply->code, MENISCUS__CODE__FAILED_PRECONDITION);
    assert_string_equal(reply->message, "not now");
    assert_string_equal(reply->path, "where");
    assert_string_equal(reply->reason, "wrong state");
    assert_int_equal(reply->n_allowed, 2);
    assert_int_equal(reply->allowed[0], MENISCUS__STATE__READY);
    assert_int_equal(reply->allowed[1], MENISCUS__STATE__PAUSED);
    assert_false(reply->has_effect_step);
    assert_int_equal(reply->n_arrays, 0);
    assert_null(exchange->arrays[0]);
    exchange_free(exchange);
}

static void what_only_looks_has_no_effect(void **state)
{
    (void)state;
    Exchange *exchange = new_exchange();
    exchange_seal(exchange);
    assert_false(exchange->reply->has_effect_step);
    exchange_free(exchange);
}

static void values_are_all_there_or_none(void **state)
{
    (void)state;
    Exchange *exchange = new_exchange();
    MnsError error;
    Meniscus__Value **values = calloc(2, sizeof(Meniscus__Value *));
    values[0] = exchange_value("a", 1, NULL, "m");
    assert_int_equal(exchange_values(exchange, values, 2, &error), MNS_E_MEMORY);
    assert_int_equal(exchange->reply->result_case, MENISCUS__REPLY__RESULT__NOT_SET);
    values = calloc(2, sizeof(Meniscus__Value *));
    values[0] = exchange_value("a", 1, NULL, "m");
    values[1] = exchange_value("b", NAN, "text", NULL);
    assert_int_equal(exchange_values(exchange, values, 2, &error), MNS_OK);
    assert_true(exchange->reply->values->values[0]->has_number);
    assert_false(exchange->reply->values->values[1]->has_number);
    assert_string_equal(exchange->reply->values->values[1]->text, "text");
    exchange_free(exchange);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_success_says_when_and_brings_its_arrays),
        cmocka_unit_test(a_failure_brings_reason_place_and_states_and_no_result),
        cmocka_unit_test(what_only_looks_has_no_effect),
        cmocka_unit_test(values_are_all_there_or_none),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
