/* SPDX-License-Identifier: BSD-3-Clause */
/* The connections of a socket, each known by its descriptor: that is what ZeroMQ tells of one that comes or goes, and notes with each message. So who has
 * sent a message is known to be there or gone, and can be shown out. Of one thread. */
#ifndef NET_LINKS_H
#define NET_LINKS_H

#include "http/traffic.h"
#include <meniscus/status.h>
#include <stdbool.h>
#include <stdint.h>

/* A connection that is open, or a place for one. */
typedef struct Link {
    bool open;
    bool shown_out;
    double refused; /* clock_now() when it was refused, and is to end a moment later; 0: it was not */
    double began;   /* clock_now() when it came */
    uint64_t taken; /* bytes of it that are known to have been the end of a message, or are forgiven */
    void *user;     /* whoever it was given to; NULL: nobody yet                      */
} Link;

typedef struct Links {
    void *socket, *monitor;
    Link *links;                       /* [size], by descriptor */
    int size, end;                     /* end: beyond the highest that was ever open */
    long n;                            /* that are open */
    uint64_t failed[TRAFFIC_FAILURES]; /* handshakes, by why: see net/visitors.h */
    uint64_t shown_out;
    void (*gone)(void *user); /* called for whoever a connection was given to, when it has ended */
} Links;

/* Before the socket is bound. address: "inproc://NAME", of its own in the context. gone may be NULL. MNS_E_MEMORY. */
MnsStatus links_init(Links *links, void *context, void *socket, const char *address, void (*gone)(void *user),
                     MnsError *error);
void links_done(Links *links);

/* Take note of who came and went; must be called whenever the monitor is readable. */
void links_note(Links *links);

/* The connection of this descriptor; NULL if it is not open. */
Link *links_find(Links *links, int fd);

/* A message of it has been read to its end. */
void links_took(Links *links, int fd);

/* Show out whoever has sent more than a message may have since the last one that came to its end: ZeroMQ would keep all parts of one that has none. Where very
 * many have said nothing yet, show out those among them that came a while ago: they hold descriptors, and nobody knows whose they are. To be called every so many
 * seconds. */
void links_watch(Links *links, double seconds);

/* End a connection. */
void links_show_out(Links *links, int fd);

/* End a connection when its client has had time to read what was sent: ZeroMQ drops that with the connection. */
void links_refuse(Links *links, int fd);

#endif
