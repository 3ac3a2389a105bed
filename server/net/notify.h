/* SPDX-License-Identifier: BSD-3-Clause */
/* What the service manager hears: ready, status, signs of life. Without one, nothing happens. */
#ifndef NET_NOTIFY_H
#define NET_NOTIFY_H

#include "run/run.h"

typedef struct Notify {
    double watchdog; /* [s] within which a sign of life is expected; 0: none is */
    double next;     /* clock_now() of the next look                            */
    double status;   /* clock_now() of the last status line                     */
    uint64_t beat;   /* of the run, at the last sign of life                    */
} Notify;

/* How the service manager wants it, from the environment. */
void notify_begin(Notify *notify);

void notify_ready(void);

/* A status line; not more than one in a second unless it is important. */
void notify_status(Notify *notify, bool important, const char *text);

void notify_stopping(void);

/* To be called now and then: a sign of life if the run gave one. A daemon that is
 * stopping asks for more time while it writes. */
void notify_look(Notify *notify, Run *run);

#endif
