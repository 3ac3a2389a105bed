/* SPDX-License-Identifier: BSD-3-Clause */
/* Connections are counted as they come and go, but for those at one address. */
#include "net/visitors.h"
#include "tests/support/check.h"
#include "tests/support/io_fixture.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zmq.h>

enum { GUESTS = 5, PATIENCE_MS = 5000 };

/* A socket at two addresses, at one of which nobody is counted, and who may connect to it. */
typedef struct Stand {
    char *home;
    void *context, *socket, *guests[GUESTS];
    char near[128], aside[128];
    Visitors visitors;
} Stand;

static int begin(void **state)
{
    Stand *stand = calloc(1, sizeof *stand);
    if (!stand) return 1;
    *state = stand;
    stand->home = scratch_new();
    stand->context = zmq_ctx_new();
    stand->socket = zmq_socket(stand->context, ZMQ_XPUB);
    snprintf(stand->near, sizeof stand->near, "ipc://%.64s/news", stand->home);
    snprintf(stand->aside, sizeof stand->aside, "ipc://%.64s/news.gate", stand->home);
    return visitors_init(&stand->visitors, stand->context, stand->socket, "inproc://watch", stand->aside, NULL) ||
           zmq_bind(stand->socket, stand->near) || zmq_bind(stand->socket, stand->aside);
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

/* They are that many soon. */
static void assert_visitors(Stand *stand, long n)
{
    Visitors *visitors = &stand->visitors;
    zmq_pollitem_t item = {.socket = visitors->monitor, .events = ZMQ_POLLIN};
    visitors_note(visitors);
    while (visitors->n != n && zmq_poll(&item, 1, PATIENCE_MS) > 0) visitors_note(visitors);
    assert_int_equal(visitors->n, n);
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
    comes(stand, 2, stand->near);
    assert_visitors(stand, 3);
    goes(stand, 1);
    assert_visitors(stand, 2);
    goes(stand, 2);
    assert_visitors(stand, 1);
}

static void who_comes_aside_is_not(void **state)
{
    Stand *stand = *state;
    comes(stand, 0, stand->aside);
    comes(stand, 1, stand->near);
    comes(stand, 2, stand->near);
    assert_visitors(stand, 2);
    goes(stand, 0);
    goes(stand, 1); /* behind what is told of the other */
    assert_visitors(stand, 1);
    comes(stand, 3, stand->aside);
    comes(stand, 4, stand->near);
    assert_visitors(stand, 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(who_comes_and_goes_is_counted, begin, end),
        cmocka_unit_test_setup_teardown(who_comes_aside_is_not, begin, end),
    };
    return cmocka_run_group_tests_name("visitors", tests, NULL, NULL);
}
