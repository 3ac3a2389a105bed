/* SPDX-License-Identifier: BSD-3-Clause */
/* The log of a run directory. */
#include "client/dashboard/diary.h"

#include "client/cli/output.h"
#include "common/host/disk.h"
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TAIL = 1 << 16 }; /* bytes that are read of it */

json_t *diary_event(char *line)
{
    char when[32];
    uint64_t step;
    double t;
    int head = 0;
    line[strcspn(line, "\n")] = 0;
    if (sscanf(line, "%31s step %" SCNu64 " t %lf %n", when, &step, &t, &head) != 3 || !head) return NULL;
    char *word = line + head, *text = strstr(word, ": ");
    if (!text) return NULL;
    *text = 0;
    text += 2;
    return json_pack("{ss sn ss so sI so so}", "topic", "event", "state", "what", word, "text", output_text(text),
                     "step", (json_int_t)step, "time", output_number(t), "when", output_text(when));
}

/* The last lines, the oldest first: [n], of which each is in `tail`. */
static size_t last_lines(char *tail, char *ret[static DIARY_LINES])
{
    size_t n = 0;
    for (char *line = tail, *next; *line; line = next) {
        next = line + strcspn(line, "\n");
        if (*next) *next++ = 0;
        if (n == DIARY_LINES) memmove(ret, ret + 1, --n * sizeof *ret);
        ret[n++] = line;
    }
    return n;
}

json_t *diary_tell(Hub *hub, const char *directory)
{
    static char tail[TAIL + 1];
    char path[4200], *lines[DIARY_LINES];
    snprintf(path, sizeof path, "%s/log", directory);
    FILE *file = *directory ? disk_open(path, "r") : NULL;
    if (!file) return NULL;
    const bool cut = !fseek(file, -TAIL, SEEK_END); /* else it is shorter, and read from its beginning */
    const size_t size = fread(tail, 1, TAIL, file);
    fclose(file);
    tail[size] = 0;
    json_t *texts = json_array();
    const size_t n = last_lines(tail, lines);
    for (size_t k = cut; k < n; k++) { /* where it is cut, so is a line */
        json_t *event = diary_event(lines[k]);
        if (!event) continue;
        json_array_append(texts, json_object_get(event, "text"));
        hub_tell(hub, TELL_EVENT, event);
    }
    return texts;
}
