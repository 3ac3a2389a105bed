/* SPDX-License-Identifier: BSD-3-Clause */
/* Open connections of this machine, by the process at their other end. Where there are too many, the process that has most of them loses one. Any thread. */
#ifndef NET_PEERS_H
#define NET_PEERS_H

#include <stdbool.h>

/* Groups in place of a process: over loopback TCP it is not known which process connects; browsers and monitoring systems use HTTP; connections of the gate are
 * bounded by quotas, and are not kept here. */
enum { PEER_TCP = 0, PEER_HTTP = -1, PEER_GATE = -2 };

/* files: as many as the process may open; 0: no connection is kept here. */
void peers_begin(int files);

/* A connection has come, of a process by its number or of one of the groups above. */
void peers_add(int fd, int process);

/* A message has come over a connection. */
void peers_heard(int fd);

/* The descriptor is about to be closed; it need not be that of a connection. */
void peers_remove(int fd);

/* How many connections have a higher descriptor. */
int peers_beyond(int fd);

/* End one connection so that another of this process can come: among those of the processes that have most, the one that never sent a message and came first, else
 * the one that has been silent longest. False if this process has as many as any other, or all are too new. The connection is closed a moment later, by the
 * library that has it. */
bool peers_make_room(int process);

/* The process that has most connections, or a group, and their number. */
int peers_largest(int *ret_n);

#endif
