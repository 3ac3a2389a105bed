/* SPDX-License-Identifier: BSD-3-Clause */
/* Notes on their way from the runner (and the writer) to whoever talks to people. Answers, events and log lines always get
 * in; live samples and progress are dropped and counted when nobody fetches them. Any thread may put, one takes. */
#ifndef RUN_OUTBOX_H
#define RUN_OUTBOX_H

#include "run/document.h"
#include "run/order.h"
#include <pthread.h>
#include <stddef.h>

typedef enum NoteKind {
    NOTE_ANSWER,   /* order                                             */
    NOTE_EVENT,    /* word, text: something happened to the run         */
    NOTE_LOG,      /* level, text                                       */
    NOTE_PROGRESS, /* fraction, eta, steps_per_second, dt, end_time     */
    NOTE_PROBES    /* document, values [document->c->n_probes]          */
} NoteKind;

typedef struct Note {
    struct Note *next;
    NoteKind kind;
    RunState state;
    uint64_t step;
    double t; /* [s] */
    Order *order;
    Document *document; /* a share of it */
    int level;
    char word[24];
    char text[640];
    double fraction, eta, steps_per_second, dt, end_time; /* 1, [s] or NAN if unknown, [1/s], [s], [s] */
    double values[];
} Note;

typedef struct Outbox {
    pthread_mutex_t lock;
    Note *first, *last;
    size_t live; /* droppable ones inside */
    uint64_t skipped;
    int wake; /* eventfd: readable while something is inside */
} Outbox;

MnsStatus outbox_init(Outbox *box, MnsError *error);

/* Frees what is inside but orders, which belong to whoever made them. */
void outbox_done(Outbox *box);

/* An empty note with room for n values; NULL if there is no memory. */
Note *note_new(NoteKind kind, size_t n);

/* Free a note, not its order; NULL is fine. */
void note_free(Note *note);

/* Hand over a note. */
void outbox_put(Outbox *box, Note *note);

/* The oldest note, now the caller's; NULL if there is none. */
Note *outbox_take(Outbox *box);

/* How many samples were dropped so far. */
uint64_t outbox_skipped(Outbox *box);

#endif
