/* SPDX-License-Identifier: BSD-3-Clause */
/* Which requests were made, and what was replied: a request that comes again gets the same reply and does nothing. Memory
 * is bounded; the oldest replies are forgotten first. What changes or writes something has a ledger of its own, so that nobody who
 * only asks can have it forgotten. */
#ifndef NET_LEDGER_H
#define NET_LEDGER_H

#include "net/exchange.h"

enum { LEDGER_ENTRIES = 4096 }; /* that are remembered */

typedef struct Ledger Ledger;

/* NULL if there is no memory. */
Ledger *ledger_new(void);
void ledger_free(Ledger *ledger);

/* What is known of a request id. */
typedef struct LedgerEntry {
    Exchange *under_way;  /* not replied to yet, or NULL                     */
    const uint8_t *reply; /* the packed reply [size], borrowed; or NULL      */
    size_t size;
} LedgerEntry;

/* False if nothing is known of it. */
bool ledger_find(const Ledger *ledger, const uint8_t id[static ORDER_ID], LedgerEntry *ret);

/* Note that an exchange is under way. MNS_E_LIMIT: too many are. */
MnsStatus ledger_begin(Ledger *ledger, Exchange *exchange, MnsError *error);

/* Note a request of before this program was started, and its reply. */
void ledger_recall(Ledger *ledger, const uint8_t id[static ORDER_ID], const uint8_t *reply, size_t size);

/* Note its reply; reply NULL: do not remember that the request was made. */
void ledger_end(Ledger *ledger, const Exchange *exchange, const uint8_t *reply, size_t size);

#endif
