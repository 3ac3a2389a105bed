/* SPDX-License-Identifier: BSD-3-Clause */
/* The directories abandoned, abandoned.2 ... of a run directory, where rundir_abandon() keeps what a run left behind. */
#ifndef RUN_ABANDONED_H
#define RUN_ABANDONED_H

#include <meniscus/status.h>
#include <stddef.h>
#include <stdint.h>

typedef struct Abandoned {
    size_t n;       /* directories */
    uint64_t bytes; /* of the files in them */
} Abandoned;

/* Visit each of a run directory by its name in it. */
void abandoned_each(const char *dir, void (*visit)(void *arg, const char *name), void *arg);

/* What there is in a run directory, as far as it can be read. */
Abandoned abandoned_count(const char *dir);

/* Delete one of them: the outputs in it, and itself if nothing else is in it. MNS_E_IO. */
MnsStatus abandoned_delete(const char *aside, MnsError *error);

#endif
