/* SPDX-License-Identifier: BSD-3-Clause */
/* Connections are known by their descriptors: who has sent a message is there or gone, and whoever sends without an end is shown out. */
#include "net/links.h"
#include "tests/support/check.h"
#include <stdlib.h>
#include <string.h>
#include <zmq.h>

enum { GUESTS = 3, PATIENCE_MS = 5000, LONG = 6 << 20, SHORT = 1 << 20 };

typedef struct Stand {
    void *context, *socket, *guests[GUESTS];
    char address[128];
    Links links;
} Stand;

static int departures;

static void note_gone(void *user)
{
    departures += *(int *)user;
}

static int begin(void **state)
{
    Stand *stand = calloc(1, sizeof *stand);
    size_t size = sizeof stand->address;
    if (!stand) return 1;
    *state = stand;
    departures = 0;
    stand->context = zmq_ctx_new();
    stand->socket = zmq_socket(stand->context, ZMQ_ROUTER);
    for (int k = 0; k < GUESTS; k++) stand->guests[k] = zmq_socket(stand->context, ZMQ_DEALER);
    return links_init(&stand->links, stand->context, stand->socket, "inproc://watch", note_gone, NULL) ||
           zmq_bind(stand->socket, "tcp://127.0.0.1:*") ||
           zmq_getsockopt(stand->socket, ZMQ_LAST_ENDPOINT, stand->address, &size);
}

static void goes(Stand *stand, int k)
{
    const int none = 0;
    if (!stand->guests[k]) return;
    zmq_setsockopt(stand->guests[k], ZMQ_LINGER, &none, sizeof none);
    zmq_close(stand->guests[k]);
    stand->guests[k] = NULL;
}

static int end(void **state)
{
    Stand *stand = *state;
    for (int k = 0; k < GUESTS; k++) goes(stand, k);
    links_done(&stand->links);
    zmq_close(stand->socket);
    zmq_ctx_term(stand->context);
    free(stand);
    return 0;
}

/* They are that many soon. */
static void assert_links(Stand *stand, long n)
{
    zmq_pollitem_t item = {.socket = stand->links.monitor, .events = ZMQ_POLLIN};
    links_note(&stand->links);
    while (stand->links.n != n && zmq_poll(&item, 1, PATIENCE_MS) > 0) links_note(&stand->links);
    assert_int_equal(stand->links.n, n);
}

static void comes(Stand *stand, int k)
{
    assert_int_equal(zmq_connect(stand->guests[k], stand->address), 0);
}

/* The descriptor of whoever sends this. */
static int hear(Stand *stand, int k, const char *text)
{
    zmq_msg_t frame;
    zmq_msg_init(&frame);
    assert_int_equal(zmq_send(stand->guests[k], text, strlen(text), 0), strlen(text));
    assert_true(zmq_msg_recv(&frame, stand->socket, 0) > 0);
    assert_int_equal(zmq_msg_recv(&frame, stand->socket, 0), strlen(text));
    const int fd = zmq_msg_get(&frame, ZMQ_SRCFD);
    zmq_msg_close(&frame);
    return fd;
}

static void who_has_sent_a_message_is_known_until_the_end(void **state)
{
    Stand *stand = *state;
    int first = 1, second = 10;
    for (int k = 0; k < GUESTS; k++) comes(stand, k);
    assert_links(stand, GUESTS);
    const int one = hear(stand, 0, "one"), two = hear(stand, 1, "two");
    assert_int_not_equal(one, two);
    links_find(&stand->links, one)->user = &first;
    links_find(&stand->links, two)->user = &second;
    goes(stand, 1);
    assert_links(stand, 2);
    assert_int_equal(departures, 10);
    assert_null(links_find(&stand->links, two));
    assert_ptr_equal(links_find(&stand->links, one)->user, &first);
    goes(stand, 2); /* whom nobody knows */
    assert_links(stand, 1);
    assert_int_equal(departures, 10);
    assert_null(links_find(&stand->links, -1));
    assert_null(links_find(&stand->links, stand->links.size));
}

static void send_bytes(Stand *stand, int k, size_t size)
{
    char *bytes = calloc(1, size);
    assert_int_equal(zmq_send(stand->guests[k], bytes, size, 0), size);
    free(bytes);
    zmq_pollitem_t item = {.socket = stand->socket, .events = ZMQ_POLLIN};
    assert_int_equal(zmq_poll(&item, 1, PATIENCE_MS), 1); /* all of it is here */
}

/* To this side, a message that has not been taken is one that has no end. */
static void who_sends_without_an_end_is_shown_out_and_nobody_else(void **state)
{
    Stand *stand = *state;
    const int back = -1;
    for (int k = 0; k < 2; k++) {
        zmq_setsockopt(stand->guests[k], ZMQ_RECONNECT_IVL, &back, sizeof back);
        comes(stand, k);
    }
    const int one = hear(stand, 0, "one"), two = hear(stand, 1, "two");
    assert_links(stand, 2);
    links_took(&stand->links, one);
    links_took(&stand->links, two);
    send_bytes(stand, 0, SHORT);
    send_bytes(stand, 1, SHORT);
    links_watch(&stand->links, 0.2);
    assert_int_equal(stand->links.shown_out, 0);
    links_took(&stand->links, one);
    send_bytes(stand, 1, LONG);
    for (int k = 0; k < 100 && !stand->links.shown_out; k++) {
        zmq_poll(NULL, 0, 20);
        links_watch(&stand->links, 0.02);
    }
    assert_int_equal(stand->links.shown_out, 1);
    assert_links(stand, 1);
    assert_non_null(links_find(&stand->links, one));
    assert_null(links_find(&stand->links, two));
}

/* A connection of weeks, on which nothing comes but signs of life. */
static void what_comes_slowly_is_forgiven(void **state)
{
    Stand *stand = *state;
    comes(stand, 0);
    const int fd = hear(stand, 0, "one");
    assert_links(stand, 1);
    links_took(&stand->links, fd);
    const Link *link = links_find(&stand->links, fd);
    for (int k = 0; k < 8; k++) {
        const uint64_t before = link->taken;
        send_bytes(stand, 0, SHORT);
        for (int look = 0; look < 500 && link->taken < before + SHORT; look++) {
            links_watch(&stand->links, 1000);
            zmq_poll(NULL, 0, 10);
        }
        assert_true(link->taken >= before + SHORT);
    }
    assert_int_equal(stand->links.shown_out, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(who_has_sent_a_message_is_known_until_the_end, begin, end),
        cmocka_unit_test_setup_teardown(who_sends_without_an_end_is_shown_out_and_nobody_else, begin, end),
        cmocka_unit_test_setup_teardown(what_comes_slowly_is_forgiven, begin, end),
    };
    return cmocka_run_group_tests_name("links", tests, NULL, NULL);
}
