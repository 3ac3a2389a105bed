/* SPDX-License-Identifier: BSD-3-Clause */
/* Telemetry: notes of the run as numbered messages, topic by topic, for whoever subscribes. A subscriber that does not read
 * loses messages, sees so from the numbers, and disturbs nobody. */
#ifndef NET_PUBLISH_H
#define NET_PUBLISH_H

#include "http/traffic.h"
#include "run/outbox.h"
#include <meniscus/sim.h>

typedef struct Publisher Publisher;

/* socket: an XPUB of ZeroMQ, borrowed, as are the topics that it counts: [TRAFFIC_TOPICS]. NULL if there is no memory. */
Publisher *publisher_new(void *socket, uint64_t epoch, TopicTraffic *traffic);
void publisher_free(Publisher *publisher);

/* So many are connected: each message costs each of them, and the daemon for each, so very many get fewer of what is live: the newest of a topic,
 * after so many milliseconds, a second at most. What is left out is seen from the numbers, and counted. */
void publisher_crowd(Publisher *publisher, long n);

/* Send what was held back and may go now; returns when there is more of that (clock_now()), INFINITY if there is none. */
double publisher_flush(Publisher *publisher);

/* Send a note, but answers. */
void publisher_send(Publisher *publisher, const Note *note);

/* Somebody subscribed: the last message of each topic that begins with this is to go out again, under its old number. */
void publisher_welcome(Publisher *publisher, const char *prefix, size_t size);

/* Send those: each once, to all who are subscribed, however many came. */
void publisher_greet(Publisher *publisher);

/* Names of all topics, then NULL. */
const char *const *publisher_topics(void);

#endif
