/* SPDX-License-Identifier: BSD-3-Clause */
/* Signals as something to read, and what whoever sends them wants. */
#ifndef BASE_SIGNALS_H
#define BASE_SIGNALS_H

#include <stdbool.h>

typedef struct Signals {
    int fd;       /* signalfd: readable while there is a signal */
    bool leaving; /* somebody has asked                         */
    double asked_at;
} Signals;

typedef enum SignalWish {
    SIGNAL_NOTHING, /* there was none, or a child has ended, or the same again at once, as timeout(1) and others send each twice */
    SIGNAL_CHECKPOINT, /* SIGUSR1                                                                             */
    SIGNAL_LEAVE,      /* SIGTERM, SIGINT, or SIGHUP unless it is ignored                                     */
    SIGNAL_INSIST,     /* either again: whoever sent it will not wait for a checkpoint                        */
} SignalWish;

/* Block the signals above for this thread and those it makes, so call it before there are any. SIGPIPE is ignored. */
void signals_catch(Signals *signals);
void signals_done(Signals *signals);

/* Read one signal; never waits. */
SignalWish signals_take(Signals *signals);

#endif
