/* SPDX-License-Identifier: BSD-3-Clause */
/* Events of a socket's monitor, counted. */
#include "net/visitors.h"

#include "base/clock.h"
#include <stdbool.h>
#include <string.h>
#include <zmq.h>

MnsStatus visitors_init(Visitors *visitors, void *context, void *socket, const char *address, const char *aside,
                        MnsError *error)
{
    const int none = 0, events = ZMQ_EVENT_ACCEPTED | ZMQ_EVENT_DISCONNECTED | ZMQ_EVENT_HANDSHAKE_FAILED_AUTH |
                                 ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL | ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL;
    *visitors = (Visitors){.socket = socket, .monitor = zmq_socket(context, ZMQ_PAIR), .aside = aside};
    if (visitors->monitor) zmq_setsockopt(visitors->monitor, ZMQ_LINGER, &none, sizeof none);
    if (visitors->monitor && !zmq_socket_monitor(socket, address, events) && !zmq_connect(visitors->monitor, address))
        return MNS_OK;
    return mns_fail(error, MNS_E_MEMORY, "cannot watch the socket: %s", zmq_strerror(zmq_errno()));
}

void visitors_done(Visitors *visitors)
{
    if (!visitors->monitor) return;
    zmq_socket_monitor(visitors->socket, NULL, 0);
    zmq_close(visitors->monitor);
    *visitors = (Visitors){.n = 0};
}

static void note(Visitors *visitors, int event)
{
    switch (event) {
    case ZMQ_EVENT_ACCEPTED: visitors->n++; break;
    case ZMQ_EVENT_HANDSHAKE_FAILED_AUTH: visitors->failed[FAILED_KEY]++; break;
    case ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL: visitors->failed[FAILED_PROTOCOL]++; break;
    case ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL: visitors->failed[FAILED_SILENCE]++; break;
    default: visitors->n -= visitors->n > 0;
    }
}

/* An event is two frames: its number and value, and the address. */
void visitors_note(Visitors *visitors)
{
    uint16_t event;
    char data[6], where[256];
    while (zmq_recv(visitors->monitor, data, sizeof data, ZMQ_DONTWAIT) >= 0) {
        const int size = zmq_recv(visitors->monitor, where, sizeof where, 0);
        const bool aside =
            visitors->aside && size == (int)strlen(visitors->aside) && !memcmp(where, visitors->aside, (size_t)size);
        memcpy(&event, data, sizeof event);
        if (!aside) note(visitors, event);
    }
}

void visitors_see_off(Visitors *visitors, long milliseconds)
{
    const double until = clock_now() + 1e-3 * (double)milliseconds;
    zmq_pollitem_t item = {.socket = visitors->monitor, .events = ZMQ_POLLIN};
    visitors_note(visitors);
    for (double left; visitors->n > 0 && (left = until - clock_now()) > 0; visitors_note(visitors))
        zmq_poll(&item, 1, (long)(1e3 * left) + 1);
}
