/* SPDX-License-Identifier: BSD-3-Clause */
/* Connections are counted as they come, go, and are cut. */
#include "net/visitors.h"
#include "tests/support/check.h"
#include "tests/support/io_fixture.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zmq.h>

enum { GUESTS = 5, PATIENCE_MS = 5000 };

/* A socket at two addresses, and who may connect to it. */
typedef struct Stand {
    char *home;
    void *context, *socket, *guests[GUESTS];
    char near[128], far[128];
    Visitors visitors;
} Stand;

static int begin(void **state)
{
    Stand *stand = calloc(1, sizeof *stand);
    size_t size = sizeof stand->far;
    if (!stand) return 1;
    *state = stand;
    stand->home = scratch_new();
    stand->context = zmq_ctx_new();
    stand->socket = zmq_socket(stand->context, ZMQ_XPUB);
    snprintf(stand->near, sizeof stand->near, "ipc://%.64s/news", stand->home);
    return visitors_init(&stand->visitors, stand->context, stand->socket, "inproc://watch", NULL) ||
           zmq_bind(stand->socket, stand->near) || zmq_bind(stand->socket, "tcp://127.0.0.1:*") ||
           zmq_getsockopt(stand->socket, ZMQ_LAST_ENDPOINT, stand->far, &size);
}

static int end(void **state)
{
    Stand *stand = *state;
    for (int k = 0; k < GUESTS; k++)
        if (stand->guests[k]) zmq_close(stand->guests[k]);
    visitors_done(&stand->visitors);
    zmq_close(stand->socket);
    zmq_ctx_term(stand->context);
    scratch_free(stand->home);
    free(stand);
    return 0;
}

/* They are that many soon, so many of them from afar. */
static void assert_visitors(Stand *stand, long n, long far)
{
    Visitors *visitors = &stand->visitors;
    zmq_pollitem_t item = {.socket = visitors->monitor, .events = ZMQ_POLLIN};
    visitors_note(visitors);
    while ((visitors->n != n || visitors->far != far) && zmq_poll(&item, 1, PATIENCE_MS) > 0) visitors_note(visitors);
    assert_int_equal(visitors->n, n);
    assert_int_equal(visitors->far, far);
}

static void comes(Stand *stand, int k, const char *address)
{
    stand->guests[k] = zmq_socket(stand->context, ZMQ_SUB);
    assert_int_equal(zmq_connect(stand->guests[k], address), 0);
}

static void goes(Stand *stand, int k)
{
    zmq_close(stand->guests[k]);
    stand->guests[k] = NULL;
}

static void who_comes_and_goes_is_counted(void **state)
{
    Stand *stand = *state;
    comes(stand, 0, stand->near);
    comes(stand, 1, stand->near);
    comes(stand, 2, stand->far);
    assert_visitors(stand, 3, 1);
    goes(stand, 1);
    assert_visitors(stand, 2, 1);
    goes(stand, 2);
    assert_visitors(stand, 1, 0);
}

/* The monitor tells late, or never, that those from afar are gone: whoever is near stays. */
static void who_is_cut_is_gone_and_not_twice(void **state)
{
    Stand *stand = *state;
    comes(stand, 0, stand->near);
    comes(stand, 1, stand->far);
    comes(stand, 2, stand->far);
    assert_visitors(stand, 3, 2);
    visitors_cut(&stand->visitors);
    assert_visitors(stand, 1, 0);
    goes(stand, 1);
    goes(stand, 2);
    comes(stand, 3, stand->near); /* behind what is told of those two */
    assert_visitors(stand, 2, 0);
    comes(stand, 4, stand->far);
    assert_visitors(stand, 3, 1);
}

/* Who came a moment before the cut, and of whom nobody has taken note yet, is cut too. */
static void whoever_has_just_come_is_cut_with_the_others(void **state)
{
    Stand *stand = *state;
    zmq_pollitem_t item = {.socket = stand->visitors.monitor, .events = ZMQ_POLLIN};
    comes(stand, 0, stand->far);
    assert_int_equal(zmq_poll(&item, 1, PATIENCE_MS), 1);
    visitors_cut(&stand->visitors);
    assert_visitors(stand, 0, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(who_comes_and_goes_is_counted, begin, end),
        cmocka_unit_test_setup_teardown(who_is_cut_is_gone_and_not_twice, begin, end),
        cmocka_unit_test_setup_teardown(whoever_has_just_come_is_cut_with_the_others, begin, end),
    };
    return cmocka_run_group_tests_name("visitors", tests, NULL, NULL);
}
