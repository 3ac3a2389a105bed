/* SPDX-License-Identifier: BSD-3-Clause */
/* What the runner has to say: an answer, or what happens to the run. */
#ifndef RUN_NOTE_H
#define RUN_NOTE_H

#include "run/document.h"
#include "run/state.h"
#include <stddef.h>
#include <stdint.h>

typedef enum NoteKind {
    NOTE_ANSWER,    /* order, of which it is a part                      */
    NOTE_SCHEDULED, /* the same: it waits for its moment, and outlives a crash */
    NOTE_EVENT,     /* word, text: something happened to the run         */
    NOTE_LOG,       /* level, text                                       */
    NOTE_PROGRESS,  /* fraction, eta, steps_per_second, dt, end_time     */
    NOTE_PROBES     /* document, values [document->c->n_probes]          */
} NoteKind;

struct Order;

typedef struct Note {
    struct Note *next;
    NoteKind kind;
    RunState state;
    uint64_t step;
    double t; /* [s] */
    struct Order *order;
    Document *document; /* a share of it */
    int level;
    char word[24];
    char text[640];
    double fraction, eta, steps_per_second, dt, end_time; /* 1, [s] or NAN if unknown, [1/s], [s], [s] */
    double *values;
} Note;

/* An empty note with room for n values; NULL if there is no memory. */
Note *note_new(NoteKind kind, size_t n);

/* Free a note; NULL is fine. Those that are part of an order go with it: for them this does nothing, and must not be called once the
 * order is gone. */
void note_free(Note *note);

#endif
