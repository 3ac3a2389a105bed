/* SPDX-License-Identifier: BSD-3-Clause */
/* Notes on their way from the runner (and the writer) to whoever talks to people. Answers, events and log lines always get
 * in; when nobody fetches them, old live samples and progress give way to new ones and are counted. Any thread may put, one
 * takes. */
#ifndef RUN_OUTBOX_H
#define RUN_OUTBOX_H

#include "run/order.h"
#include <pthread.h>

typedef struct Outbox {
    pthread_mutex_t lock;
    Note *first, *last;
    _Atomic size_t live;                       /* droppable ones inside; looked at without the lock */
    _Atomic uint64_t dropped[NOTE_PROBES + 1]; /* by kind; the same */
    int wake;                                  /* eventfd: readable while something is inside */
} Outbox;

MnsStatus outbox_init(Outbox *box, MnsError *error);

/* Frees what is inside but orders, which belong to whoever made them. */
void outbox_done(Outbox *box);

/* Hand over a note; that of an answer is for whoever takes it to free, with its order. */
void outbox_put(Outbox *box, Note *note);

/* The oldest note, now the caller's; NULL if there is none. */
Note *outbox_take(Outbox *box);

/* How many live notes were dropped so far. */
uint64_t outbox_dropped(Outbox *box);

#endif
