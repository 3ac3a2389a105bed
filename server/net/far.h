/* SPDX-License-Identifier: BSD-3-Clause */
/* An address for those from afar: a socket of the operating system that listens. The daemon holds it, so that it is there whatever becomes of
 * the gate, and so that an address that cannot be had is known at the start; the gate takes connections from it. */
#ifndef NET_FAR_H
#define NET_FAR_H

#include "net/access.h"

/* Listen at "tcp://ADDRESS:PORT". One that another process has is tried again for a second, as the gate of a daemon that was killed lives a
 * moment longer than that. *ret_fd: closed by exec(). MNS_E_IO. */
MnsStatus far_listen(const char *address, int *ret_fd, MnsError *error);

/* Have as many descriptors as the operating system allows, up to 65536, as those from afar take some: each who knocks has one in the gate until the
 * handshake is over, and each who is let in one in the daemon, which must not leave the run without any for its files. How many there may be. */
int far_descriptors(void);

/* Let a socket of ZeroMQ take what comes there, of those who are let in. False: zmq_errno() says why not. */
bool far_take(const Access *access, void *socket, int fd);

#endif
