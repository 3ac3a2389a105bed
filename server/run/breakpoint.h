/* SPDX-License-Identifier: BSD-3-Clause */
/* Where a run shall pause: at a step, at a time, or when a condition on the probes becomes true. */
#ifndef RUN_BREAKPOINT_H
#define RUN_BREAKPOINT_H

#include <meniscus/sim.h>

enum { BREAKPOINTS = 32, BREAKPOINT_NAME = 64, BREAKPOINT_TEXT = 256 };

/* As people set it; what is not wanted is empty, 0 or NAN. */
typedef struct Breakpoint {
    char name[BREAKPOINT_NAME];
    char condition[BREAKPOINT_TEXT];
    double t; /* [s]; NAN: none */
    uint64_t step;
} Breakpoint;

typedef struct Breakpoints Breakpoints;

Breakpoints *breakpoints_new(void);
void breakpoints_free(Breakpoints *points);

/* Remove all of them, as when their case goes. */
void breakpoints_clear(Breakpoints *points);

/* Add one, or replace that of the same name. The condition is a formula of t, step, the constants of c and its probes: dots
 * and dashes of their names become underscores, and one goes before a name that begins with a digit, is t or step, or means
 * something to Lua, as `end` does. A probe hides a constant or function of its name. MNS_E_INVALID, MNS_E_LIMIT,
 * MNS_E_MEMORY; nothing is changed then. */
MnsStatus breakpoints_set(Breakpoints *points, const MnsCase *c, const Breakpoint *point, MnsError *error);

/* MNS_E_NOT_FOUND if there is none of that name. */
MnsStatus breakpoints_remove(Breakpoints *points, const char *name, MnsError *error);

/* All of them; *ret_n of BREAKPOINTS at most. */
void breakpoints_list(const Breakpoints *points, Breakpoint ret[static BREAKPOINTS], size_t *ret_n);

/* Look after a step. before: progress at the boundary before. The first that is reached, or NULL. A step or time is reached
 * at the first boundary at or after it; a condition when it becomes true, so that the run can go on from there. */
const Breakpoint *breakpoints_reached(Breakpoints *points, const MnsSim *sim, MnsProgress before);

/* One that was there already when the run came to this boundary, before a crash: its condition pauses nothing as long as it stays true. */
void breakpoints_note(Breakpoints *points, const char *name, const MnsSim *sim);

#endif
