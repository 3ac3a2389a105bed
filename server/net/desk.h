/* SPDX-License-Identifier: BSD-3-Clause */
/* The desk: owns the sockets of commands and news, and never waits for physics. Requests in, replies and telemetry out. The data socket is its
 * streams', which have a thread of their own. */
#ifndef NET_DESK_H
#define NET_DESK_H

#include "net/answers.h"
#include "net/endpoint.h"
#include "net/publish.h"

typedef struct Desk Desk;

/* Bind the sockets. run is borrowed. MNS_OK; MNS_E_IO if an address cannot be bound; MNS_E_MEMORY. */
MnsStatus desk_new(const Endpoint *endpoint, Run *run, Desk **ret, MnsError *error);

/* Give clients half a second at most to read the latest replies; close. NULL is fine. */
void desk_free(Desk *desk);

/* Wait until a socket or one of two file descriptors is readable, or a time has passed [ms]. Bit k of the result: fds[k]. */
unsigned desk_poll(Desk *desk, const int fds[2], long timeout);

/* Take the requests and subscriptions that are there. */
void desk_receive(Desk *desk);

/* What is answered to requests. */
Answers *desk_answers(Desk *desk);

/* Something happened to the run: out with it. */
void desk_tell(Desk *desk, const Note *note);

/* End the streams, before the run is freed. */
void desk_end_streams(Desk *desk);

/* What has gone over the sockets, for any thread to look at. */
const Traffic *desk_traffic(const Desk *desk);

#endif
