/* SPDX-License-Identifier: BSD-3-Clause */
/* Memory that is freed all at once: a reply and everything it points to. */
#ifndef CLIENT_ARENA_H
#define CLIENT_ARENA_H

#include <stddef.h>

typedef struct ArenaBlock ArenaBlock;

typedef struct Arena {
    ArenaBlock *blocks;
} Arena;

/* Zeroed memory for n items of `size` bytes, aligned for any type; NULL if there is none. n = 0 is fine. */
void *arena_take(Arena *arena, size_t n, size_t size);

/* Free all of it. */
void arena_done(Arena *arena);

#endif
