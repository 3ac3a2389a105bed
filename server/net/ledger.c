/* SPDX-License-Identifier: BSD-3-Clause */
/* Which requests were made, and what was replied. */
#include "net/ledger.h"

#include <stdlib.h>
#include <string.h>

enum { ENTRIES = LEDGER_ENTRIES, BYTES = 8 << 20 };

typedef struct Slot {
    uint8_t id[ORDER_ID];
    uint64_t age; /* 0: free; else the larger, the younger */
    LedgerEntry entry;
} Slot;

struct Ledger {
    Slot slots[ENTRIES];
    uint64_t age;
    size_t bytes;
};

Ledger *ledger_new(void)
{
    return calloc(1, sizeof(Ledger));
}

static void forget(Ledger *ledger, Slot *slot)
{
    ledger->bytes -= slot->entry.size;
    free((void *)slot->entry.reply);
    memset(slot, 0, sizeof *slot);
}

void ledger_free(Ledger *ledger)
{
    for (size_t k = 0; ledger && k < ENTRIES; k++) forget(ledger, &ledger->slots[k]);
    free(ledger);
}

static const Slot *find(const Ledger *ledger, const uint8_t *id)
{
    for (size_t k = 0; k < ENTRIES; k++)
        if (ledger->slots[k].age && !memcmp(ledger->slots[k].id, id, ORDER_ID)) return &ledger->slots[k];
    return NULL;
}

bool ledger_find(const Ledger *ledger, const uint8_t id[static ORDER_ID], LedgerEntry *ret)
{
    const Slot *slot = find(ledger, id);
    if (slot) *ret = slot->entry;
    return slot != NULL;
}

/* The oldest that has been replied to; NULL if there is none. */
static Slot *oldest(Ledger *ledger)
{
    Slot *found = NULL;
    for (size_t k = 0; k < ENTRIES; k++) {
        Slot *slot = &ledger->slots[k];
        if (slot->age && !slot->entry.under_way && (!found || slot->age < found->age)) found = slot;
    }
    return found;
}

static Slot *free_slot(Ledger *ledger)
{
    for (size_t k = 0; k < ENTRIES; k++)
        if (!ledger->slots[k].age) return &ledger->slots[k];
    Slot *slot = oldest(ledger);
    if (slot) forget(ledger, slot);
    return slot;
}

static void keep(Ledger *ledger, Slot *slot, const uint8_t *reply, size_t size)
{
    uint8_t *copy = reply ? malloc(size + 1) : NULL;
    slot->entry.under_way = NULL;
    if (!copy) {
        forget(ledger, slot);
        return;
    }
    memcpy(copy, reply, size);
    slot->entry.reply = copy;
    slot->entry.size = size;
    ledger->bytes += size;
    while (ledger->bytes > BYTES) forget(ledger, oldest(ledger));
}

void ledger_recall(Ledger *ledger, const uint8_t id[static ORDER_ID], const uint8_t *reply, size_t size)
{
    Slot *slot = find(ledger, id) ? NULL : free_slot(ledger);
    if (!slot) return;
    memcpy(slot->id, id, ORDER_ID);
    slot->age = ++ledger->age;
    keep(ledger, slot, reply, size);
}

MnsStatus ledger_begin(Ledger *ledger, Exchange *exchange, MnsError *error)
{
    Slot *slot = free_slot(ledger);
    if (!slot) return mns_fail(error, MNS_E_LIMIT, "%d commands are under way; wait for one, or cancel it", ENTRIES);
    memcpy(slot->id, exchange->order.id, ORDER_ID);
    slot->age = ++ledger->age;
    slot->entry.under_way = exchange;
    return MNS_OK;
}

void ledger_end(Ledger *ledger, const Exchange *exchange, const uint8_t *reply, size_t size)
{
    Slot *slot = (Slot *)find(ledger, exchange->order.id);
    if (slot) keep(ledger, slot, reply, size);
}
