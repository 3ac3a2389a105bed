/* SPDX-License-Identifier: BSD-3-Clause */
/* Memory that is freed all at once: a chain of blocks. */
#include "client/lib/arena.h"
#include <stdint.h>
#include <stdlib.h>

struct ArenaBlock {
    ArenaBlock *next;
    max_align_t data[];
};

void *arena_take(Arena *arena, size_t n, size_t size)
{
    if (size && n > (SIZE_MAX - sizeof(ArenaBlock)) / size) return NULL;
    ArenaBlock *block = calloc(1, sizeof *block + n * size);
    if (!block) return NULL;
    block->next = arena->blocks;
    arena->blocks = block;
    return block->data;
}

void arena_done(Arena *arena)
{
    for (ArenaBlock *block = arena->blocks, *next; block; block = next) {
        next = block->next;
        free(block);
    }
    arena->blocks = NULL;
}
