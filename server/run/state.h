/* SPDX-License-Identifier: BSD-3-Clause */
/* The states of a run. */
#ifndef RUN_STATE_H
#define RUN_STATE_H

#include <stdbool.h>

/* Numbered as in the protocol. */
typedef enum RunState {
    RUN_EMPTY,
    RUN_LOADING,
    RUN_READY,
    RUN_RUNNING,
    RUN_PAUSED,
    RUN_DONE,
    RUN_FAULT,
    RUN_STOPPING,
    RUN_RECOVERING,
    RUN_STATES
} RunState;

/* Whether the runner computes in it, or makes or reads a state to go on from. */
bool run_state_moves(RunState state);

/* Does it take one step after the other? */
bool run_state_steps(RunState state);

/* "RUNNING". */
const char *run_state_name(RunState state);

#endif
