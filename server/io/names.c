/* SPDX-License-Identifier: BSD-3-Clause */
/* The names of numbered files. */
#include "io/names.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void name_numbered(const char *begin, uint64_t step, char ret[static NUMBERED_NAME])
{
    snprintf(ret, NUMBERED_NAME, "%s%010" PRIu64 "%s", begin, step, NUMBERED_END);
}

/* Written back, a number says whether the name is as we write it. */
static bool is_numbered(const char *name, const char *begin, uint64_t *ret_step)
{
    char again[NUMBERED_NAME];
    if (strncmp(name, begin, strlen(begin)) != 0) return false;
    const uint64_t step = strtoull(name + strlen(begin), NULL, 10);
    name_numbered(begin, step, again);
    if (strcmp(name, again) != 0) return false;
    *ret_step = step;
    return true;
}

bool name_step(const char *name, uint64_t *ret_step)
{
    return is_numbered(name, CHECKPOINT_BEGIN, ret_step) || is_numbered(name, SNAPSHOT_BEGIN, ret_step);
}
