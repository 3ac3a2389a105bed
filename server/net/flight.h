/* SPDX-License-Identifier: BSD-3-Clause */
/* Bytes handed to ZeroMQ for somebody that it has not let go of. Its thread counts them down, and may do so when whoever it was for is gone: so each
 * message holds a share. */
#ifndef NET_FLIGHT_H
#define NET_FLIGHT_H

#include <stddef.h>

typedef struct Flight {
    _Atomic unsigned users;
    _Atomic size_t bytes;
} Flight;

/* With one share, the caller's; NULL if there is no memory. */
Flight *flight_new(void);

/* A message of so many bytes sets out, and takes a share. */
void flight_begin(Flight *flight, size_t bytes);

/* It is let go of. Any thread. */
void flight_end(Flight *flight, size_t bytes);

/* The caller's share goes; NULL is fine. */
void flight_leave(Flight *flight);

#endif
