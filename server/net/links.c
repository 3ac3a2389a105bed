/* SPDX-License-Identifier: BSD-3-Clause */
/* The connections of a socket. A descriptor is told of as closed before it is, so it is never that of the next one by mistake. */
#include "net/links.h"

#include "base/clock.h"
#include "net/far.h"
#include "net/visitors.h"
#include <linux/tcp.h>
#include <netinet/in.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <zmq.h>

/* Bytes on the wire, encrypted, between the ends of two messages: the longest request has one MiB. What keeps a connection alive is counted too, and
 * so some are forgiven as time goes by. */
enum { ENDLESS = 4 << 20, FORGIVEN = 2048 /* [1/s] */ };

/* One in so many descriptors may be of connections that say nothing; beyond that, each has so long [s] to say its first word. */
enum { SILENT_SHARE = 16 };
static const double FIRST_WORD = 1;

static const double LAST_WORD =
    0.2; /* [s] for which a connection that is refused stays, so that its client reads why */

MnsStatus links_init(Links *links, void *context, void *socket, const char *address, void (*gone)(void *user),
                     MnsError *error)
{
    const int none = 0, events = ZMQ_EVENT_ACCEPTED | ZMQ_EVENT_DISCONNECTED | ZMQ_EVENT_HANDSHAKE_FAILED_AUTH |
                                 ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL | ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL;
    *links = (Links){.socket = socket, .size = far_descriptors(), .gone = gone};
    links->links = calloc((size_t)links->size, sizeof *links->links);
    links->monitor = zmq_socket(context, ZMQ_PAIR);
    if (links->monitor) zmq_setsockopt(links->monitor, ZMQ_LINGER, &none, sizeof none);
    if (links->links && links->monitor) zmq_setsockopt(links->monitor, ZMQ_RCVHWM, &none, sizeof none);
    if (links->links && links->monitor && !zmq_socket_monitor(socket, address, events) &&
        !zmq_connect(links->monitor, address))
        return MNS_OK;
    return mns_fail(error, MNS_E_MEMORY, "cannot watch the socket: %s", zmq_strerror(zmq_errno()));
}

void links_done(Links *links)
{
    if (links->monitor) zmq_socket_monitor(links->socket, NULL, 0);
    if (links->monitor) zmq_close(links->monitor);
    free(links->links);
    *links = (Links){.n = 0};
}

static void begin(Links *links, int fd)
{
    if (fd < 0 || fd >= links->size) return;
    if (fd >= links->end) links->end = fd + 1;
    links->n += !links->links[fd].open;
    links->links[fd] = (Link){.open = true, .began = clock_now()};
}

static void end(Links *links, int fd)
{
    Link *link = links_find(links, fd);
    if (!link) return;
    void *user = link->user;
    *link = (Link){.open = false};
    links->n--;
    if (user && links->gone) links->gone(user);
}

/* An event is two frames: its number and value, and the address. */
void links_note(Links *links)
{
    uint16_t event;
    int32_t value;
    char data[6], where[256];
    while (zmq_recv(links->monitor, data, sizeof data, ZMQ_DONTWAIT) >= 0) {
        zmq_recv(links->monitor, where, sizeof where, 0);
        memcpy(&event, data, sizeof event);
        memcpy(&value, data + sizeof event, sizeof value);
        switch (event) {
        case ZMQ_EVENT_ACCEPTED: begin(links, value); break;
        case ZMQ_EVENT_DISCONNECTED: end(links, value); break;
        case ZMQ_EVENT_HANDSHAKE_FAILED_AUTH: links->failed[FAILED_KEY]++; break;
        case ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL: links->failed[FAILED_PROTOCOL]++; break;
        default: links->failed[FAILED_SILENCE]++;
        }
    }
}

Link *links_find(Links *links, int fd)
{
    return fd >= 0 && fd < links->size && links->links[fd].open ? &links->links[fd] : NULL;
}

/* 0 if it is no connection any more. */
static uint64_t received(int fd)
{
    struct tcp_info info = {.tcpi_state = 0};
    socklen_t size = sizeof info;
    return getsockopt(fd, IPPROTO_TCP, TCP_INFO, &info, &size) ? 0 : info.tcpi_bytes_received;
}

void links_took(Links *links, int fd)
{
    Link *link = links_find(links, fd);
    if (link) link->taken = received(fd);
}

static void watch_silent(Links *links)
{
    const double since = clock_now() - FIRST_WORD;
    int silent = 0;
    for (int fd = 0; fd < links->end; fd++) silent += links->links[fd].open && !links->links[fd].user;
    for (int fd = 0; fd < links->end && silent > links->size / SILENT_SHARE; fd++) {
        const Link *link = links_find(links, fd);
        if (link && !link->user && link->began < since) links_show_out(links, fd);
    }
}

static void watch_refused(Links *links)
{
    const double since = clock_now() - LAST_WORD;
    for (int fd = 0; fd < links->end; fd++) {
        const Link *link = links_find(links, fd);
        if (link && link->refused > 0 && link->refused < since) links_show_out(links, fd);
    }
}

void links_watch(Links *links, double seconds)
{
    if (links->n) watch_silent(links);
    if (links->n) watch_refused(links);
    const uint64_t forgiven = (uint64_t)(FORGIVEN * seconds);
    for (int fd = 0; links->n && fd < links->end; fd++) {
        Link *link = links_find(links, fd);
        const uint64_t now = link ? received(fd) : 0;
        if (!link || now <= link->taken) continue;
        if (now - link->taken > ENDLESS) links_show_out(links, fd);
        link->taken = now - link->taken > forgiven ? link->taken + forgiven : now;
    }
}

void links_refuse(Links *links, int fd)
{
    Link *link = links_find(links, fd);
    if (link) link->refused = clock_now();
}

void links_show_out(Links *links, int fd)
{
    Link *link = links_find(links, fd);
    if (!link || link->shown_out || !received(fd)) return;
    link->shown_out = true;
    links->shown_out++;
    shutdown(fd, SHUT_RDWR);
}
