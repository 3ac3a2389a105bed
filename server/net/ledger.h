/* SPDX-License-Identifier: BSD-3-Clause */
/* Which requests were made, and what was replied: a request that comes again gets the same reply and does nothing. Memory
 * is bounded; the oldest replies are forgotten first. What changed or wrote something has a ledger of its own, and so have questions and
 * refusals, so that nobody who only asks, or is refused, can have others forgotten. */
#ifndef NET_LEDGER_H
#define NET_LEDGER_H

#include "net/exchange.h"

/* How many replies are remembered, and of how many bytes: of deeds; of questions, and as many refusals. */
enum { LEDGER_DEEDS = 1 << 16, LEDGER_DEEDS_BYTES = 32 << 20, LEDGER_OTHERS = 4096, LEDGER_OTHERS_BYTES = 8 << 20 };

typedef struct Ledger Ledger;

/* For so many replies, of so many bytes. NULL if there is no memory. */
Ledger *ledger_new(size_t most, size_t most_bytes);
void ledger_free(Ledger *ledger);

/* What is known of a request id. */
typedef struct LedgerEntry {
    Exchange *under_way;  /* not replied to yet, or NULL                     */
    const uint8_t *reply; /* the packed reply [size], borrowed; or NULL      */
    size_t size;
    uint64_t command; /* hash of what was asked for (Exchange); 0: there was no memory to find it */
    double noted;     /* clock_now() of the reply */
} LedgerEntry;

/* False if nothing is known of it. */
bool ledger_find(const Ledger *ledger, const uint8_t id[static ORDER_ID], LedgerEntry *ret);

/* Note that an exchange is under way, whose id is not in the ledger. MNS_E_LIMIT: too many are; MNS_E_MEMORY. */
MnsStatus ledger_begin(Ledger *ledger, Exchange *exchange, MnsError *error);

/* Note a request that is over, and its reply. */
void ledger_recall(Ledger *ledger, const uint8_t id[static ORDER_ID], uint64_t command, const uint8_t *reply,
                   size_t size);

/* Forget what was replied to before then [clock_now()]. */
void ledger_forget(Ledger *ledger, double before);

/* Note its reply; reply NULL: do not remember that the request was made. */
void ledger_end(Ledger *ledger, const Exchange *exchange, const uint8_t *reply, size_t size);

#endif
