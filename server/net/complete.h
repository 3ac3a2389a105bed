/* SPDX-License-Identifier: BSD-3-Clause */
/* What replies say besides that a command was done: the values, the file, the lease. Called when it has had its effect. */
#ifndef NET_COMPLETE_H
#define NET_COMPLETE_H

#include "net/exchange.h"

/* MNS_E_MEMORY. */
MnsStatus complete_set(Exchange *x, MnsError *error);
MnsStatus complete_file(Exchange *x, MnsError *error);
MnsStatus complete_directory(Exchange *x, MnsError *error);
MnsStatus complete_lease(Exchange *x, MnsError *error);
MnsStatus complete_wait(Exchange *x, MnsError *error);

#endif
