/* SPDX-License-Identifier: BSD-3-Clause */
/* When an item of a stream is due at a step boundary. */
#ifndef RUN_DUE_H
#define RUN_DUE_H

#include <stdbool.h>
#include <stdint.h>

/* 0 sets no condition. */
typedef struct When {
    uint64_t every_steps; /* at steps that are multiples of it                                            */
    double interval;      /* at the first boundary at or after each multiple of it, of simulated time [s] */
    double gap;           /* wall-clock time that passes at least between two [s]                         */
} When;

/* What is remembered from one boundary to the next. */
typedef struct DueState {
    bool begun;
    double before; /* time of the boundary before [s]              */
    double last;   /* wall-clock time when one was due [s]; -INFINITY: none yet */
} DueState;

DueState due_begin(void);

/* Is one due at this boundary? To be asked at each. dt: the time step that led there; wall: clock_now() */
bool due_now(const When *when, DueState *state, uint64_t step, double t, double dt, double wall);

#endif
