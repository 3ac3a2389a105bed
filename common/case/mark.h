/* SPDX-License-Identifier: BSD-3-Clause */
/* Where each entry of a case file stands: a tree of marks, one for each mapping, list and value. */
#ifndef COMMON_CASE_MARK_H
#define COMMON_CASE_MARK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { MARK_ROOT = 0, MARK_NONE = UINT32_MAX };

typedef struct Mark {
    const char *name;      /* of the entry, from the schema; NULL for an item of a list */
    uint32_t index;        /* of the item */
    uint32_t parent;       /* MARK_NONE for the root and for what --set has replaced */
    uint32_t line, column; /* from 1 */
} Mark;

typedef struct Marks {
    uint32_t n, room;
    Mark *list; /* [room] */
} Marks;

/* Add a mark and return its number, MARK_NONE if there is no memory; the first one is the root. */
uint32_t marks_add(Marks *marks, Mark mark);

/* Deepest mark on the way to a path. *ret_depth: how many bytes of the path it stands for. There must be a root. */
uint32_t marks_find(const Marks *marks, const char *path, size_t *ret_depth);

/* Forget the entry of exactly this path and what is in it. */
void marks_drop(Marks *marks, const char *path);

void marks_done(Marks *marks);

/* One step of a path: a name, or an index if *ret_name is NULL. Returns what follows it; NULL if the path is at its
 * end or malformed there. */
const char *path_step(const char *path, const char **ret_name, size_t *ret_length, size_t *ret_index);

#endif
