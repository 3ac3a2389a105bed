/* SPDX-License-Identifier: BSD-3-Clause */
/* Which requests were made, and what was replied: a tree by id, and a queue of those replied to, the oldest first. */
#include "net/ledger.h"
#include "base/clock.h"

#include <search.h>
#include <stdlib.h>
#include <string.h>
#include <sys/queue.h>

enum { UNDER_WAY = 4096 };

typedef struct Line {
    uint8_t id[ORDER_ID]; /* first: it is what lines are compared by */
    TAILQ_ENTRY(Line) beside;
    LedgerEntry entry;
} Line;

typedef TAILQ_HEAD(Lines, Line) Lines;

struct Ledger {
    void *by_id; /* of tsearch() */
    Lines replied;
    size_t n_replied, n_under_way, bytes, most, most_bytes;
};

Ledger *ledger_new(size_t most, size_t most_bytes)
{
    Ledger *ledger = calloc(1, sizeof *ledger);
    if (!ledger) return NULL;
    ledger->most = most;
    ledger->most_bytes = most_bytes;
    TAILQ_INIT(&ledger->replied);
    return ledger;
}

static int compare(const void *a, const void *b)
{
    return memcmp(a, b, ORDER_ID);
}

static Line *find(const Ledger *ledger, const uint8_t *id)
{
    Line *const *found = tfind(id, &ledger->by_id, compare);
    return found ? *found : NULL;
}

static void erase(Ledger *ledger, Line *line)
{
    tdelete(line, &ledger->by_id, compare);
    free((void *)line->entry.reply);
    free(line);
}

static void forget_oldest(Ledger *ledger)
{
    Line *line = TAILQ_FIRST(&ledger->replied);
    TAILQ_REMOVE(&ledger->replied, line, beside);
    ledger->n_replied--;
    ledger->bytes -= line->entry.size;
    erase(ledger, line);
}

static void free_line(void *line)
{
    free((void *)((Line *)line)->entry.reply);
    free(line);
}

void ledger_free(Ledger *ledger)
{
    if (!ledger) return;
    tdestroy(ledger->by_id, free_line);
    free(ledger);
}

bool ledger_find(const Ledger *ledger, const uint8_t id[static ORDER_ID], LedgerEntry *ret)
{
    const Line *line = find(ledger, id);
    if (line) *ret = line->entry;
    return line != NULL;
}

/* NULL if there is no memory. */
static Line *add(Ledger *ledger, const uint8_t *id)
{
    Line *line = calloc(1, sizeof *line);
    if (!line) return NULL;
    memcpy(line->id, id, ORDER_ID);
    if (tsearch(line, &ledger->by_id, compare)) return line;
    free(line);
    return NULL;
}

/* False if there is no memory for it. */
static bool keep(Ledger *ledger, Line *line, const uint8_t *reply, size_t size)
{
    uint8_t *copy = malloc(size + 1);
    if (!copy) return false;
    memcpy(copy, reply, size);
    line->entry = (LedgerEntry){.reply = copy, .size = size, .command = line->entry.command, .noted = clock_now()};
    TAILQ_INSERT_TAIL(&ledger->replied, line, beside);
    ledger->n_replied++;
    ledger->bytes += size;
    while (ledger->n_replied > ledger->most || ledger->bytes > ledger->most_bytes) forget_oldest(ledger);
    return true;
}

void ledger_forget(Ledger *ledger, double before)
{
    while (ledger->n_replied && TAILQ_FIRST(&ledger->replied)->entry.noted < before) forget_oldest(ledger);
}

void ledger_recall(Ledger *ledger, const uint8_t id[static ORDER_ID], uint64_t command, const uint8_t *reply,
                   size_t size)
{
    Line *line = find(ledger, id) ? NULL : add(ledger, id);
    if (line) line->entry.command = command;
    if (line && !keep(ledger, line, reply, size)) erase(ledger, line);
}

MnsStatus ledger_begin(Ledger *ledger, Exchange *exchange, MnsError *error)
{
    if (ledger->n_under_way == UNDER_WAY)
        return mns_fail(error, MNS_E_LIMIT, "%d commands are under way; wait for one, or cancel it", UNDER_WAY);
    Line *line = add(ledger, exchange->order.id);
    if (!line) return mns_fail(error, MNS_E_MEMORY, "no memory for the command; nothing was done");
    line->entry.under_way = exchange;
    line->entry.command = exchange->command;
    ledger->n_under_way++;
    return MNS_OK;
}

void ledger_end(Ledger *ledger, const Exchange *exchange, const uint8_t *reply, size_t size)
{
    Line *line = find(ledger, exchange->order.id);
    if (!line || line->entry.under_way != exchange) return;
    ledger->n_under_way--;
    if (!reply || !keep(ledger, line, reply, size)) erase(ledger, line);
}
