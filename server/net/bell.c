/* SPDX-License-Identifier: BSD-3-Clause */
/* ZMQ_FD and ZMQ_EVENTS, as they are meant to be used. */
#include "net/bell.h"

#include <zmq.h>

void bell_init(Bell *bell, void *socket)
{
    size_t size = sizeof bell->fd;
    *bell = (Bell){.socket = socket, .fd = -1, .rings = true};
    if (socket) zmq_getsockopt(socket, ZMQ_FD, &bell->fd, &size);
}

void bell_ask(Bell *bell)
{
    int events = 0;
    size_t size = sizeof events;
    if (!bell->rings && !zmq_getsockopt(bell->socket, ZMQ_EVENTS, &events, &size)) bell->rings = events & ZMQ_POLLIN;
}
