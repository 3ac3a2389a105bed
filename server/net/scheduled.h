/* SPDX-License-Identifier: BSD-3-Clause */
/* Requests with at_step or at_time: what they must say, and whether the command could be done. */
#ifndef NET_SCHEDULED_H
#define NET_SCHEDULED_H

#include "net/handlers.h"

/* Take the moment that a request names, if it does, into its order. MNS_E_INVALID: this command takes none, or it is no moment. */
MnsStatus scheduled_read(const Handler *handler, Exchange *exchange, MnsError *error);

#endif
