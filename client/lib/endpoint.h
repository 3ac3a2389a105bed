/* SPDX-License-Identifier: BSD-3-Clause */
/* Where a daemon's other socket is, and whether it is on this machine. */
#ifndef CLIENT_ENDPOINT_H
#define CLIENT_ENDPOINT_H

#include <meniscus/client.h>

/* The telemetry socket that belongs to a control endpoint: telemetry.ipc beside it, or the next port.
 * MNS_OK; MNS_E_INVALID if its path would be too long. */
MnsStatus endpoint_telemetry(const char *control, char ret[MNS_ENDPOINT_SIZE], MnsError *error);

/* The socket of streams: data.ipc beside it, or the port after the next. */
MnsStatus endpoint_data(const char *control, char ret[MNS_ENDPOINT_SIZE], MnsError *error);

/* May others read what goes there? Then it takes a key. Of what mns_daemon_endpoint() has made: there, this machine is a number. */
bool endpoint_is_far(const char *endpoint);

#endif
