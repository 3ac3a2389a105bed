/* SPDX-License-Identifier: BSD-3-Clause */
/* A look at a daemon of this machine that takes a moment at most, also where the daemon hangs. */
#ifndef CLI_GLANCE_H
#define CLI_GLANCE_H

#include <meniscus/client.h>

typedef struct Glance {
    MnsReply *reply;        /* NULL if it does not answer */
    const MnsRunInfo *info; /* of the reply; NULL without one */
    bool is_silent;         /* its socket is open, and does not answer */
    long clients;           /* that are connected besides us; -1 if that is not known */
} Glance;

Glance glance_at(const char *endpoint);
void glance_done(Glance *glance);

/* What stands for the state in tables. */
const char *glance_state(const Glance *glance);

#endif
