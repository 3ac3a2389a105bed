/* SPDX-License-Identifier: BSD-3-Clause */
/* What streams take of a run. At a step boundary the runner looks which feeds are due, and copies what they want, once for all of them, into a
 * *shot*, which nobody changes any longer. It never waits for whoever takes shots: where all its room is in use, there is none, and the
 * feeds count one that was due all the same. */
#ifndef RUN_TAP_H
#define RUN_TAP_H

#include "run/document.h"
#include "run/due.h"
#include <meniscus/sim.h>

enum { TAP_ROOMS = 4, TAP_PROBE_WORDS = MNS_MAX_PROBES / 64 };

typedef struct Tap Tap;
typedef struct Feed Feed;

/* What a feed has, and when. */
typedef struct Wish {
    When when;
    uint64_t fields;                  /* bits, of mns_fields()             */
    uint64_t probes[TAP_PROBE_WORDS]; /* bits, of the probes of the case */
} Wish;

/* A step boundary, as far as somebody wanted it. */
typedef struct Shot {
    MnsProgress progress;
    const MnsCapture *capture; /* NULL: no fields                          */
    const double *values;      /* by number of the probe; NULL: none is wanted */
} Shot;

/* Bytes of one number of a field, wherever it is copied to. */
size_t tap_number_size(MnsType type);

/* The simulation that is there now. */
typedef struct TapCase {
    uint64_t generation; /* rises with each case that is loaded or left; feeds of another one give nothing more */
    uint64_t fields;     /* that there are; 0: there is no case                */
    size_t particles;    /* fluid and wall */
    Document *document;  /* a share, or NULL */
} TapCase;

/* Fields that a simulation keeps, bit k for field k of mns_fields(). The runner's thread only. */
uint64_t tap_fields_of(const MnsSim *sim);

/* limit: bytes that copies may take in all. NULL if there is no memory, or no eventfd. */
Tap *tap_new(size_t limit);
void tap_free(Tap *tap);

/* --- for one thread that watches --------------------------------------------------------------------------------------- */

/* Readable when there are new shots, or another case. */
int tap_wake(const Tap *tap);
void tap_woken(Tap *tap);

/* Leave the document when done. */
void tap_case(Tap *tap, TapCase *ret);

/* NULL if there is no memory, or the case is not that of the generation any longer. */
Feed *tap_open(Tap *tap, uint64_t generation, const Wish *wish);
void tap_close(Tap *tap, Feed *feed);

/* Have a shot of the state as it is, also if nothing moves; mailbox_wake() is the caller's. */
void tap_ask(Tap *tap, Feed *feed);

/* The newest shot of a feed since the last one that was taken, now the caller's; NULL if there is none. *ret_due: how many were due so
 * far, that one the last of them, or without one also those for which there was no room. */
const Shot *tap_take(Tap *tap, Feed *feed, uint64_t *ret_due);
void tap_leave(Tap *tap, const Shot *shot);

/* --- for the runner ---------------------------------------------------------------------------------------------------- */

/* Another simulation, or none. document NULL: none; same: it is the same case, further on or further back. */
void tap_place(Tap *tap, const MnsSim *sim, Document *document, bool same);

/* The same simulation after a change of its case: options bring fields and take them away. The document stays that of its files. */
void tap_renew(Tap *tap, const MnsSim *sim);

/* A step boundary. stepped: a step led there; else only what is asked for is taken. known: the values of all probes there, or NULL. */
void tap_look(Tap *tap, const MnsSim *sim, bool stepped, const double *known);

/* --- for any thread ---------------------------------------------------------------------------------------------------- */

typedef struct TapTally {
    _Atomic uint64_t shots, without_room; /* boundaries of which there is a shot; at which there was no room for one */
    _Atomic size_t bytes;                 /* of room for copies                                                      */
    _Atomic double seconds;               /* of the runner's time                                                    */
} TapTally;
const TapTally *tap_tally(const Tap *tap);
size_t tap_limit(const Tap *tap);

#endif
