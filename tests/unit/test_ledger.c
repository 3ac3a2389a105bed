/* SPDX-License-Identifier: BSD-3-Clause */
/* The ledger: each request once, its reply again, and never more than so much. */
#include "net/ledger.h"
#include "tests/support/check.h"
#include <stdlib.h>
#include <string.h>

enum { ENTRIES = 4096, BYTES = 8 << 20 };

static void set_id(Exchange *exchange, unsigned k)
{
    memset(exchange->order.id, 0, ORDER_ID);
    memcpy(exchange->order.id, &k, sizeof k);
}

static void a_request_is_under_way_until_its_reply_is_kept(void **state)
{
    (void)state;
    Ledger *ledger = ledger_new(ENTRIES, BYTES);
    LedgerEntry entry;
    MnsError error;
    Exchange exchange = {.sizes = {0}};
    set_id(&exchange, 1);
    assert_false(ledger_find(ledger, exchange.order.id, &entry));
    assert_int_equal(ledger_begin(ledger, &exchange, &error), MNS_OK);
    assert_true(ledger_find(ledger, exchange.order.id, &entry));
    assert_ptr_equal(entry.under_way, &exchange);
    ledger_end(ledger, &exchange, (const uint8_t *)"reply", 5);
    assert_true(ledger_find(ledger, exchange.order.id, &entry));
    assert_null(entry.under_way);
    assert_int_equal(entry.size, 5);
    assert_memory_equal(entry.reply, "reply", 5);
    ledger_free(ledger);
}

static void without_a_reply_it_may_be_asked_anew(void **state)
{
    (void)state;
    Ledger *ledger = ledger_new(ENTRIES, BYTES);
    LedgerEntry entry;
    MnsError error;
    Exchange exchange = {.sizes = {0}};
    set_id(&exchange, 2);
    assert_int_equal(ledger_begin(ledger, &exchange, &error), MNS_OK);
    ledger_end(ledger, &exchange, NULL, 0);
    assert_false(ledger_find(ledger, exchange.order.id, &entry));
    ledger_free(ledger);
}

static void replies_of_before_a_restart_are_recalled_and_changed_by_nobody(void **state)
{
    (void)state;
    Ledger *ledger = ledger_new(ENTRIES, BYTES);
    LedgerEntry entry;
    Exchange exchange = {.sizes = {0}};
    set_id(&exchange, 3);
    ledger_recall(ledger, exchange.order.id, 7, (const uint8_t *)"first", 5);
    ledger_recall(ledger, exchange.order.id, 7, (const uint8_t *)"second", 6);
    assert_true(ledger_find(ledger, exchange.order.id, &entry));
    assert_null(entry.under_way);
    assert_int_equal(entry.size, 5);
    assert_memory_equal(entry.reply, "first", 5);
    for (unsigned k = 10; k < 10 + ENTRIES; k++) {
        set_id(&exchange, k);
        ledger_recall(ledger, exchange.order.id, 7, (const uint8_t *)"r", 1);
    }
    set_id(&exchange, 3);
    assert_false(ledger_find(ledger, exchange.order.id, &entry));
    ledger_free(ledger);
}

static void replies_of_before_a_time_are_forgotten(void **state)
{
    (void)state;
    Ledger *ledger = ledger_new(ENTRIES, BYTES);
    LedgerEntry entry;
    Exchange exchange = {.sizes = {0}};
    set_id(&exchange, 1);
    ledger_recall(ledger, exchange.order.id, 7, (const uint8_t *)"early", 5);
    assert_true(ledger_find(ledger, exchange.order.id, &entry));
    assert_int_equal(entry.command, 7);
    ledger_forget(ledger, entry.noted);
    assert_true(ledger_find(ledger, exchange.order.id, &entry));
    ledger_forget(ledger, entry.noted + 1);
    assert_false(ledger_find(ledger, exchange.order.id, &entry));
    ledger_free(ledger);
}

static void the_oldest_reply_gives_way_and_what_is_under_way_never(void **state)
{
    (void)state;
    Ledger *ledger = ledger_new(ENTRIES, BYTES);
    LedgerEntry entry;
    MnsError error;
    Exchange first = {.sizes = {0}}, exchange = {.sizes = {0}};
    set_id(&first, 0);
    assert_int_equal(ledger_begin(ledger, &first, &error), MNS_OK);
    for (unsigned k = 1; k <= ENTRIES + 1; k++) {
        set_id(&exchange, k);
        assert_int_equal(ledger_begin(ledger, &exchange, &error), MNS_OK);
        ledger_end(ledger, &exchange, (const uint8_t *)"r", 1);
    }
    assert_true(ledger_find(ledger, first.order.id, &entry));
    set_id(&exchange, 1);
    assert_false(ledger_find(ledger, exchange.order.id, &entry));
    set_id(&exchange, 2);
    assert_true(ledger_find(ledger, exchange.order.id, &entry));
    ledger_free(ledger);
}

static void a_full_ledger_of_commands_under_way_refuses(void **state)
{
    (void)state;
    Ledger *ledger = ledger_new(ENTRIES, BYTES);
    MnsError error;
    Exchange exchange = {.sizes = {0}};
    for (unsigned k = 0; k < ENTRIES; k++) {
        set_id(&exchange, k);
        assert_int_equal(ledger_begin(ledger, &exchange, &error), MNS_OK);
    }
    set_id(&exchange, ENTRIES);
    assert_int_equal(ledger_begin(ledger, &exchange, &error), MNS_E_LIMIT);
    ledger_free(ledger);
}

static void replies_are_kept_up_to_so_many_bytes(void **state)
{
    (void)state;
    enum { LARGE = 1 << 20 };
    Ledger *ledger = ledger_new(ENTRIES, BYTES);
    LedgerEntry entry;
    MnsError error;
    Exchange exchange = {.sizes = {0}};
    uint8_t *reply = calloc(1, LARGE);
    for (unsigned k = 1; k <= 9; k++) {
        set_id(&exchange, k);
        assert_int_equal(ledger_begin(ledger, &exchange, &error), MNS_OK);
        ledger_end(ledger, &exchange, reply, LARGE);
    }
    free(reply);
    set_id(&exchange, 1);
    assert_false(ledger_find(ledger, exchange.order.id, &entry));
    set_id(&exchange, 9);
    assert_true(ledger_find(ledger, exchange.order.id, &entry));
    ledger_free(ledger);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_request_is_under_way_until_its_reply_is_kept),
        cmocka_unit_test(without_a_reply_it_may_be_asked_anew),
        cmocka_unit_test(replies_of_before_a_restart_are_recalled_and_changed_by_nobody),
        cmocka_unit_test(replies_of_before_a_time_are_forgotten),
        cmocka_unit_test(the_oldest_reply_gives_way_and_what_is_under_way_never),
        cmocka_unit_test(a_full_ledger_of_commands_under_way_refuses),
        cmocka_unit_test(replies_are_kept_up_to_so_many_bytes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
