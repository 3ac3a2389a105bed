/* SPDX-License-Identifier: BSD-3-Clause */
/* Where each entry of a case file stands. Lookups walk the whole list: they happen once, for a complaint. */
#include "common/case/mark.h"
#include <ctype.h>
#include <stdlib.h>
#include <string.h>

uint32_t marks_add(Marks *marks, Mark mark)
{
    if (marks->n == marks->room) {
        const uint32_t room = marks->room ? 2 * marks->room : 64;
        Mark *grown = reallocarray(marks->list, room, sizeof *grown);
        if (!grown) return MARK_NONE;
        marks->list = grown;
        marks->room = room;
    }
    marks->list[marks->n] = mark;
    return marks->n++;
}

static const char *index_step(const char *path, size_t *ret_index)
{
    size_t index = 0;
    const char *p = path;
    for (; isdigit((unsigned char)*p); p++) {
        if (index > (UINT32_MAX - 9) / 10) return NULL;
        index = 10 * index + (size_t)(*p - '0');
    }
    if (p == path || *p != ']') return NULL;
    *ret_index = index;
    return p + 1;
}

const char *path_step(const char *path, const char **ret_name, size_t *ret_length, size_t *ret_index)
{
    *ret_name = NULL;
    if (*path == '[') return index_step(path + 1, ret_index);
    const char *name = path + (*path == '.');
    const size_t length = strcspn(name, ".[");
    if (!length) return NULL;
    *ret_name = name;
    *ret_length = length;
    return name + length;
}

static uint32_t child(const Marks *marks, uint32_t parent, const char *name, size_t length, size_t index)
{
    for (uint32_t k = 0; k < marks->n; k++) {
        const Mark *mark = &marks->list[k];
        if (mark->parent != parent || !mark->name != !name) continue;
        if (name ? strlen(mark->name) == length && !memcmp(mark->name, name, length) : mark->index == index) return k;
    }
    return MARK_NONE;
}

uint32_t marks_find(const Marks *marks, const char *path, size_t *ret_depth)
{
    uint32_t found = MARK_ROOT;
    const char *rest = path, *name;
    size_t length = 0, index = 0;
    *ret_depth = 0;
    while ((rest = path_step(rest, &name, &length, &index))) {
        const uint32_t next = child(marks, found, name, length, index);
        if (next == MARK_NONE) break;
        found = next;
        *ret_depth = (size_t)(rest - path);
    }
    return found;
}

void marks_drop(Marks *marks, const char *path)
{
    size_t depth;
    const uint32_t found = marks_find(marks, path, &depth);
    if (found != MARK_ROOT && !path[depth]) marks->list[found].parent = MARK_NONE;
}

void marks_done(Marks *marks)
{
    free(marks->list);
    *marks = (Marks){0};
}
