/* SPDX-License-Identifier: BSD-3-Clause */
/* The gate, from within: the whole program, where it is begun with GATE_WORD. */
#ifndef NET_GATE_KEEPER_H
#define NET_GATE_KEEPER_H

#include <stdbool.h>

/* Are these the words of a daemon that begins its gate? */
bool gate_keeper_is(int argc, char **argv);

/* Carry what comes until the daemon lets go of the line. Returns an exit code; whatever does not fit into the memory that it may have ends it before that. */
int gate_keeper_run(char **argv);

#endif
