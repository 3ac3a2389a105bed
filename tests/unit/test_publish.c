/* SPDX-License-Identifier: BSD-3-Clause */
/* Telemetry: what goes out, and how often. */
#include "base/clock.h"
#include "meniscus.pb-c.h"
#include "net/publish.h"
#include "tests/support/check.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <zmq.h>

typedef struct Stand {
    void *context, *out, *in;
    TopicTraffic traffic[TRAFFIC_TOPICS];
    Publisher *publisher;
} Stand;

static int begin(void **state)
{
    static const int patience = 2000;
    Stand *stand = calloc(1, sizeof *stand);
    if (!stand) return 1;
    *state = stand;
    stand->context = zmq_ctx_new();
    stand->out = zmq_socket(stand->context, ZMQ_XPUB);
    stand->in = zmq_socket(stand->context, ZMQ_SUB);
    zmq_setsockopt(stand->in, ZMQ_RCVTIMEO, &patience, sizeof patience);
    stand->publisher = publisher_new(stand->out, 7, stand->traffic);
    return !stand->publisher || zmq_bind(stand->out, "inproc://news") || zmq_connect(stand->in, "inproc://news");
}

static int end(void **state)
{
    Stand *stand = *state;
    publisher_free(stand->publisher);
    zmq_close(stand->in);
    zmq_close(stand->out);
    zmq_ctx_term(stand->context);
    free(stand);
    return 0;
}

/* Ask for a topic; the publisher knows of it when this returns. */
static void subscribe(Stand *stand, const char *topic)
{
    char frame[64];
    zmq_setsockopt(stand->in, ZMQ_SUBSCRIBE, topic, strlen(topic));
    const int size = zmq_recv(stand->out, frame, sizeof frame, 0);
    assert_int_equal(size, strlen(topic) + 1);
    publisher_welcome(stand->publisher, frame + 1, (size_t)size - 1);
}

static void tell(Stand *stand, NoteKind kind, uint64_t step)
{
    Note note = {.kind = kind, .step = step, .state = RUN_RUNNING};
    publisher_send(stand->publisher, &note);
}

/* The next message is of this topic, number and step; NULL: there is none. */
static void assert_hears(Stand *stand, const char *topic, uint64_t sequence, uint64_t step)
{
    char name[16] = "", body[512];
    const int flags = topic ? 0 : ZMQ_DONTWAIT, got = zmq_recv(stand->in, name, sizeof name - 1, flags);
    if (!topic) {
        assert_int_equal(got, -1);
        return;
    }
    assert_string_equal(name, topic);
    const int size = zmq_recv(stand->in, body, sizeof body, 0);
    assert_true(size > 0);
    Meniscus__Telemetry *message = meniscus__telemetry__unpack(NULL, (size_t)size, (uint8_t *)body);
    assert_non_null(message);
    assert_int_equal(message->sequence, sequence);
    assert_int_equal(message->step, step);
    meniscus__telemetry__free_unpacked(message, NULL);
}

static void few_get_each_message_at_once(void **state)
{
    Stand *stand = *state;
    subscribe(stand, "");
    publisher_crowd(stand->publisher, 200);
    for (uint64_t k = 1; k <= 3; k++) {
        tell(stand, NOTE_PROGRESS, k);
        assert_hears(stand, "progress", k, k);
    }
    assert_int_equal(stand->traffic[TRAFFIC_PROGRESS].thinned, 0);
}

/* What is spread over time can be looked at only as long as that time lasts. false: the machine had something else to do, and all is done again. */
static void in_time(bool (*look)(Stand *), void **state)
{
    int k = 0;
    for (; k < 100 && !look(*state); k++) {
        assert_int_equal(end(state), 0);
        assert_int_equal(begin(state), 0);
    }
    assert_true(k < 100);
}

/* And no event is left out, before which comes the newest of what was. */
static bool very_many(Stand *stand)
{
    subscribe(stand, "");
    publisher_crowd(stand->publisher, 100000);
    const double began = clock_now();
    for (uint64_t k = 1; k <= 5; k++) tell(stand, NOTE_PROGRESS, k);
    if (clock_now() - began > 1) return false;
    assert_hears(stand, "progress", 1, 1);
    assert_hears(stand, NULL, 0, 0);
    assert_int_equal(stand->traffic[TRAFFIC_PROGRESS].messages, 1);
    assert_int_equal(stand->traffic[TRAFFIC_PROGRESS].thinned, 3);
    tell(stand, NOTE_EVENT, 6);
    tell(stand, NOTE_EVENT, 7);
    assert_hears(stand, "progress", 5, 5);
    assert_hears(stand, "event", 1, 6);
    assert_hears(stand, "event", 2, 7);
    publisher_crowd(stand->publisher, 201);
    nanosleep(&(struct timespec){.tv_nsec = 250000000}, NULL);
    const double told = clock_now();
    tell(stand, NOTE_PROGRESS, 8);
    tell(stand, NOTE_PROGRESS, 9);
    if (clock_now() - told > 0.201) return false;
    assert_hears(stand, "progress", 6, 8);
    assert_hears(stand, NULL, 0, 0);
    return true;
}

static void very_many_get_the_newest_and_each_event(void **state)
{
    in_time(very_many, state);
}

/* Where a run stands is told after the event that says why it stands there, and nothing may follow. */
static bool held_back(Stand *stand)
{
    subscribe(stand, "");
    assert_true(isinf(publisher_flush(stand->publisher)));
    publisher_crowd(stand->publisher, 300);
    const double began = clock_now();
    for (uint64_t k = 1; k <= 3; k++) tell(stand, NOTE_PROGRESS, k);
    const double due = publisher_flush(stand->publisher);
    if (clock_now() - began > 0.3) return false;
    assert_true(isfinite(due));
    assert_hears(stand, "progress", 1, 1);
    assert_hears(stand, NULL, 0, 0);
    nanosleep(&(struct timespec){.tv_nsec = 350000000}, NULL);
    assert_true(isinf(publisher_flush(stand->publisher)));
    assert_hears(stand, "progress", 3, 3);
    assert_hears(stand, NULL, 0, 0);
    return true;
}

static void what_is_held_back_goes_out_when_it_may(void **state)
{
    in_time(held_back, state);
}

/* As each goes to all, what comes for one newcomer comes for the others too. */
static void many_who_come_in_one_turn_are_welcomed_once(void **state)
{
    Stand *stand = *state;
    tell(stand, NOTE_EVENT, 3);
    tell(stand, NOTE_PROGRESS, 4);
    subscribe(stand, "event");
    for (int k = 0; k < 3; k++) publisher_welcome(stand->publisher, "ev", 2);
    publisher_welcome(stand->publisher, "events", 6); /* there is no such topic */
    assert_hears(stand, NULL, 0, 0);
    publisher_greet(stand->publisher);
    assert_hears(stand, "event", 1, 3);
    publisher_greet(stand->publisher);
    assert_hears(stand, NULL, 0, 0);
}

/* Whoever comes after a load would take it for where this run is. */
static void newcomers_do_not_hear_of_a_run_that_is_gone(void **state)
{
    Stand *stand = *state;
    const Note running = {.kind = NOTE_PROGRESS, .step = 90, .state = RUN_RUNNING};
    Note ready = {.kind = NOTE_EVENT, .state = RUN_READY};
    publisher_send(stand->publisher, &running);
    publisher_send(stand->publisher, &ready);
    subscribe(stand, "");
    publisher_greet(stand->publisher);
    assert_hears(stand, "event", 1, 0);
    assert_hears(stand, NULL, 0, 0);
    publisher_send(stand->publisher, &running);
    assert_hears(stand, "progress", 2, 90);
    ready.state = RUN_PAUSED;
    publisher_send(stand->publisher, &ready);
    assert_hears(stand, "event", 2, 0);
    publisher_welcome(stand->publisher, "", 0);
    publisher_greet(stand->publisher);
    assert_hears(stand, "event", 2, 0);
    assert_hears(stand, "progress", 2, 90);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(few_get_each_message_at_once, begin, end),
        cmocka_unit_test_setup_teardown(very_many_get_the_newest_and_each_event, begin, end),
        cmocka_unit_test_setup_teardown(what_is_held_back_goes_out_when_it_may, begin, end),
        cmocka_unit_test_setup_teardown(many_who_come_in_one_turn_are_welcomed_once, begin, end),
        cmocka_unit_test_setup_teardown(newcomers_do_not_hear_of_a_run_that_is_gone, begin, end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
