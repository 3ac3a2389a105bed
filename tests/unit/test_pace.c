/* SPDX-License-Identifier: BSD-3-Clause */
/* The pace of questions: so many in a second for each pool, connections in turn, and nothing lost. */
#include "common/wire/frame.h"
#include "net/pace.h"
#include "tests/support/check.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static Sender sender_of(const char *name, Role role, char connection)
{
    Sender sender = {.size = 1, .who = {.role = role}};
    sender.identity[0] = (uint8_t)connection;
    snprintf(sender.who.name, sizeof sender.who.name, "%s", name);
    return sender;
}

/* A request with an id of one byte. */
static void hold_until(Pace *pace, const Sender *sender, uint8_t number, double deadline)
{
    zmq_msg_t frame;
    MnsError error;
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    request.has_id = true;
    request.id = (ProtobufCBinaryData){.len = 1, .data = &number};
    assert_int_equal(zmq_msg_init_size(&frame, meniscus__request__get_packed_size(&request)), 0);
    meniscus__request__pack(&request, zmq_msg_data(&frame));
    assert_int_equal(pace_hold(pace, sender, &frame, 1, deadline, &error), MNS_OK);
    zmq_msg_close(&frame);
}

static void hold(Pace *pace, const Sender *sender, uint8_t number)
{
    hold_until(pace, sender, number, INFINITY);
}

/* Returns the number of a request, which it frees; 0 if there was no request. */
static int number_of(Held *held)
{
    if (!held) return 0;
    const int number = *request_id(zmq_msg_data(&held->frame), zmq_msg_size(&held->frame)).data;
    held_free(held);
    return number;
}

static int next(Pace *pace, bool hurried, double now)
{
    return number_of(pace_next(pace, hurried, now));
}

static void each_pool_has_its_questions_in_a_second(void **state)
{
    (void)state;
    const Sender senders[] = {sender_of("vera", ROLE_VIEWER, 'v'), sender_of("otto", ROLE_OPERATOR, 'o'),
                              sender_of(WHO_LOCAL, ROLE_ADMIN, 'l')};
    const int rates[] = {PACE_VIEWERS, PACE_STEERERS, PACE_LOCAL};
    Pace pace = {0};
    for (int k = 0; k < 3; k++) {
        int heard = 0;
        for (int ms = 0; ms < 10000; ms++) heard += pace_admits(&pace, &senders[k], 1e6 + 1e-3 * ms);
        assert_in_range(heard, 10 * rates[k], 10 * rates[k] + rates[k] / 4 + 2);
    }
}

static void after_silence_a_quarter_of_a_second_s_questions_come_at_once(void **state)
{
    (void)state;
    const Sender vera = sender_of("vera", ROLE_VIEWER, 'v');
    Pace pace = {0};
    int heard = 0;
    while (pace_admits(&pace, &vera, 1e6)) heard++;
    assert_in_range(heard, PACE_VIEWERS / 4, PACE_VIEWERS / 4 + 1);
    assert_true(pace_admits(&pace, &vera, 1e6 + 2.0 / PACE_VIEWERS));
}

static void connections_take_turns(void **state)
{
    (void)state;
    const Sender vera = sender_of("vera", ROLE_VIEWER, 'v'), zoe = sender_of("zoe", ROLE_VIEWER, 'z');
    const int order[] = {1, 11, 2, 12, 3, 4, 0};
    Pace pace = {0};
    for (uint8_t k = 1; k <= 4; k++) hold(&pace, &vera, k);
    for (uint8_t k = 11; k <= 12; k++) hold(&pace, &zoe, k);
    assert_false(pace_admits(&pace, &zoe, 1e6)); /* what waits comes first */
    for (size_t k = 0; k < sizeof order / sizeof *order; k++)
        assert_int_equal(next(&pace, false, 1e6 + (double)k), order[k]);
    hold(&pace, &zoe, 13);
    hold(&pace, &vera, 5); /* which has had more turns, and is not kept waiting for that */
    assert_int_equal(next(&pace, false, 2e6), 13);
    assert_int_equal(next(&pace, false, 2e6), 5);
}

static void what_waits_is_heard_in_time(void **state)
{
    (void)state;
    const Sender vera = sender_of("vera", ROLE_VIEWER, 'v');
    Pace pace = {0};
    assert_true(isinf(pace_due(&pace)));
    while (pace_admits(&pace, &vera, 1e6)) continue;
    hold(&pace, &vera, 1);
    const double due = pace_due(&pace);
    assert_true(due > 1e6 && due <= 1e6 + 2.0 / PACE_VIEWERS);
    assert_int_equal(next(&pace, false, due - 1e-4), 0);
    assert_int_equal(next(&pace, false, due), 1);
}

static void where_nothing_computes_none_wait(void **state)
{
    (void)state;
    const Sender vera = sender_of("vera", ROLE_VIEWER, 'v');
    Pace pace = {0};
    for (uint8_t k = 1; k <= 50; k++) hold(&pace, &vera, k);
    for (uint8_t k = 1; k <= 50; k++) assert_int_equal(next(&pace, true, 0), k);
    assert_null(pace_next(&pace, true, 0));
}

static void what_waits_can_be_pulled_by_its_connection_or_its_id(void **state)
{
    (void)state;
    const Sender vera = sender_of("vera", ROLE_VIEWER, 'v'), local = sender_of(WHO_LOCAL, ROLE_ADMIN, 'l');
    uint8_t number = 2;
    const ProtobufCBinaryData id = {.len = 1, .data = &number};
    Pace pace = {0};
    hold(&pace, &vera, 1);
    hold(&pace, &local, 2);
    hold(&pace, &vera, 3);
    assert_int_equal(number_of(pace_pull(&pace, NULL, &id)), 2);
    assert_null(pace_pull(&pace, NULL, &id));
    for (int k = 1; k <= 3; k += 2) assert_int_equal(number_of(pace_pull(&pace, &vera, NULL)), k);
    assert_null(pace_pull(&pace, &vera, NULL));
}

static void none_waits_longer_than_its_deadline(void **state)
{
    (void)state;
    const Sender vera = sender_of("vera", ROLE_VIEWER, 'v');
    Pace pace = {0};
    while (pace_admits(&pace, &vera, 1e6)) continue;
    hold(&pace, &vera, 1);
    const double due = pace_due(&pace), deadline = due - 1e-3;
    hold_until(&pace, &vera, 2, deadline);
    assert_true(pace_due(&pace) == deadline);
    assert_int_equal(next(&pace, false, deadline), 2);
    assert_int_equal(next(&pace, false, deadline), 0);
    assert_int_equal(next(&pace, false, due), 1);
}

/* Holds one more of so many bytes. */
static MnsStatus hold_bytes(Pace *pace, const Sender *sender, size_t bytes)
{
    zmq_msg_t frame;
    MnsError error;
    assert_int_equal(zmq_msg_init_size(&frame, bytes), 0);
    memset(zmq_msg_data(&frame), 0, bytes);
    const MnsStatus status = pace_hold(pace, sender, &frame, 1, INFINITY, &error);
    if (status) assert_non_null(strstr(error.text, "of this connection"));
    zmq_msg_close(&frame);
    return status;
}

static void a_connection_has_so_many_that_wait(void **state)
{
    (void)state;
    const Sender vera = sender_of("vera", ROLE_VIEWER, 'v'), zoe = sender_of("zoe", ROLE_VIEWER, 'z');
    Pace pace = {0};
    for (int k = 0; k < PACE_EACH; k++) assert_int_equal(hold_bytes(&pace, &vera, 1), MNS_OK);
    assert_int_equal(hold_bytes(&pace, &vera, 1), MNS_E_LIMIT);
    assert_int_equal(hold_bytes(&pace, &zoe, 1), MNS_OK);
    pace_forget(&pace, vera.identity, vera.size);
    assert_int_equal(hold_bytes(&pace, &vera, 1), MNS_OK);
    pace_done(&pace);
    for (int k = 0; k < PACE_EACH_BYTES >> 20; k++) assert_int_equal(hold_bytes(&pace, &vera, 1 << 20), MNS_OK);
    assert_int_equal(hold_bytes(&pace, &vera, 1), MNS_E_LIMIT);
    pace_done(&pace);
    for (size_t pool = 0; pool < POOLS; pool++) assert_true(!pace.lines[pool].n && !pace.lines[pool].bytes);
}

static void in_a_full_pool_each_connection_has_its_share(void **state)
{
    (void)state;
    const Sender zoe = sender_of("zoe", ROLE_VIEWER, 'z'), local = sender_of(WHO_LOCAL, ROLE_ADMIN, 'l');
    Pace pace = {0};
    for (int c = 1; c <= PACE_POOL / PACE_EACH; c++) {
        const Sender vera = sender_of("vera", ROLE_VIEWER, (char)c);
        for (int k = 0; k < PACE_EACH; k++) assert_int_equal(hold_bytes(&pace, &vera, 1), MNS_OK);
    }
    int n = 0;
    while (!hold_bytes(&pace, &zoe, 1)) n++;
    assert_in_range(n, PACE_POOL / (PACE_POOL / PACE_EACH + 1), PACE_POOL / (PACE_POOL / PACE_EACH + 1) + 1);
    assert_int_equal(hold_bytes(&pace, &local, 1), MNS_OK);
    pace_done(&pace);
}

static void what_a_connection_that_has_ended_asked_is_dropped(void **state)
{
    (void)state;
    const Sender vera = sender_of("vera", ROLE_VIEWER, 'v'), zoe = sender_of("zoe", ROLE_VIEWER, 'z');
    Pace pace = {0};
    for (uint8_t k = 1; k <= 3; k++) hold_until(&pace, &vera, k, k);
    hold(&pace, &zoe, 11);
    pace_forget(&pace, vera.identity, vera.size);
    pace_forget(&pace, vera.identity, vera.size);
    assert_int_equal(next(&pace, true, 1e6), 11);
    assert_int_equal(next(&pace, true, 1e6), 0);
    assert_true(isinf(pace_due(&pace)));
}

static void so_many_requests_are_read_in_a_second(void **state)
{
    (void)state;
    Pace pace = {0};
    int n = 0;
    for (int ms = 0; ms < 10000; ms++)
        for (; !pace_rests(&pace, 1e6 + 1e-3 * ms); n++) pace_note_read(&pace, 1e6 + 1e-3 * ms);
    assert_in_range(n, 10 * PACE_READ, 11 * PACE_READ + 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_pool_has_its_questions_in_a_second),
        cmocka_unit_test(after_silence_a_quarter_of_a_second_s_questions_come_at_once),
        cmocka_unit_test(connections_take_turns),
        cmocka_unit_test(what_waits_is_heard_in_time),
        cmocka_unit_test(where_nothing_computes_none_wait),
        cmocka_unit_test(what_waits_can_be_pulled_by_its_connection_or_its_id),
        cmocka_unit_test(none_waits_longer_than_its_deadline),
        cmocka_unit_test(a_connection_has_so_many_that_wait),
        cmocka_unit_test(in_a_full_pool_each_connection_has_its_share),
        cmocka_unit_test(so_many_requests_are_read_in_a_second),
        cmocka_unit_test(what_a_connection_that_has_ended_asked_is_dropped),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
