/* SPDX-License-Identifier: BSD-3-Clause */
/* Nothing that came to a socket is missed by who waits for its descriptor, takes all there is, and asks before waiting again. */
#include "net/bell.h"
#include "tests/support/check.h"
#include <poll.h>
#include <stdlib.h>
#include <zmq.h>

enum { PATIENCE_MS = 5000, A_MOMENT_MS = 50, ROUNDS = 2000 };

typedef struct Pair {
    void *context, *here, *there;
    Bell bell;
} Pair;

static int begin(void **state)
{
    Pair *pair = calloc(1, sizeof *pair);
    if (!pair) return 1;
    *state = pair;
    pair->context = zmq_ctx_new();
    pair->here = zmq_socket(pair->context, ZMQ_PAIR);
    pair->there = zmq_socket(pair->context, ZMQ_PAIR);
    bell_init(&pair->bell, pair->here);
    return zmq_bind(pair->here, "inproc://bell") || zmq_connect(pair->there, "inproc://bell");
}

static int end(void **state)
{
    Pair *pair = *state;
    zmq_close(pair->here);
    zmq_close(pair->there);
    zmq_ctx_term(pair->context);
    free(pair);
    return 0;
}

/* How many messages there were. */
static int take_all(Pair *pair)
{
    char byte;
    int n = 0;
    while (zmq_recv(pair->here, &byte, 1, ZMQ_DONTWAIT) >= 0) n++;
    pair->bell.rings = false;
    return n;
}

static bool wait_for(Pair *pair, int milliseconds)
{
    struct pollfd item = {.fd = pair->bell.fd, .events = POLLIN};
    bell_ask(&pair->bell);
    pair->bell.rings |= poll(&item, 1, pair->bell.rings ? 0 : milliseconds) > 0;
    return pair->bell.rings;
}

static void it_rings_at_first_and_when_something_comes_and_not_else(void **state)
{
    Pair *pair = *state;
    assert_true(pair->bell.rings);
    assert_true(pair->bell.fd >= 0);
    assert_int_equal(take_all(pair), 0);
    assert_false(wait_for(pair, A_MOMENT_MS));
    zmq_send(pair->there, "a", 1, 0);
    zmq_send(pair->there, "b", 1, 0);
    assert_true(wait_for(pair, PATIENCE_MS));
    assert_int_equal(take_all(pair), 2);
    assert_false(wait_for(pair, A_MOMENT_MS));
}

/* The call that sends takes in what has come, and the descriptor is quiet. */
static void what_came_while_something_was_sent_is_found_by_asking(void **state)
{
    Pair *pair = *state;
    struct pollfd item = {.fd = pair->bell.fd, .events = POLLIN};
    take_all(pair);
    assert_false(wait_for(pair, A_MOMENT_MS));
    zmq_send(pair->there, "a", 1, 0);
    for (int k = 0; k < ROUNDS && poll(&item, 1, 0) > 0; k++) zmq_send(pair->here, "b", 1, 0);
    assert_int_equal(poll(&item, 1, A_MOMENT_MS), 0);
    assert_false(pair->bell.rings);
    bell_ask(&pair->bell);
    assert_true(pair->bell.rings);
    assert_int_equal(take_all(pair), 1);
}

static void who_left_something_finds_it_ringing(void **state)
{
    Pair *pair = *state;
    zmq_send(pair->there, "a", 1, 0);
    zmq_send(pair->there, "b", 1, 0);
    assert_true(wait_for(pair, PATIENCE_MS));
    assert_int_equal(zmq_recv(pair->here, (char[1]){0}, 1, 0), 1);
    pair->bell.rings = true;
    assert_true(wait_for(pair, A_MOMENT_MS));
    assert_int_equal(take_all(pair), 1);
}

static void without_a_socket_it_has_no_descriptor(void **state)
{
    (void)state;
    Bell bell;
    bell_init(&bell, NULL);
    assert_int_equal(bell.fd, -1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(it_rings_at_first_and_when_something_comes_and_not_else, begin, end),
        cmocka_unit_test_setup_teardown(what_came_while_something_was_sent_is_found_by_asking, begin, end),
        cmocka_unit_test_setup_teardown(who_left_something_finds_it_ringing, begin, end),
        cmocka_unit_test(without_a_socket_it_has_no_descriptor),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
