/* SPDX-License-Identifier: BSD-3-Clause */
/* The format of a journal, for the two files that write and read it. All numbers are little-endian.
 *
 *     file:    "MNSJRNL1" | record | record | ...
 *     record:  mark u32 | size u32 | number u64 | check u64 | chain 16 bytes | payload [size]
 *     check    XXH64 of mark, size and number: whether the size can be believed
 *     chain    XXH3 (128 bits, canonical) of the chain of the record before, then mark, size, number and payload; before the first
 *              record stand 16 zeros */
#ifndef IO_JOURNAL_FRAME_H
#define IO_JOURNAL_FRAME_H

#include "io/journal.h"
#include <endian.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <xxhash.h>

enum { JOURNAL_CHAIN = 16 };

static const char journal_magic[JOURNAL_HEAD] = {'M', 'N', 'S', 'J', 'R', 'N', 'L', '1'};

typedef struct JournalFrame {
    uint32_t mark, size;
    uint64_t number, check;
    uint8_t chain[JOURNAL_CHAIN];
} JournalFrame;

_Static_assert(sizeof(JournalFrame) == 40, "the frame is a file format");

static const uint32_t journal_mark = 0x4352534d;

static inline uint64_t journal_frame_check(const JournalFrame *frame)
{
    return htole64(XXH64(frame, offsetof(JournalFrame, check), 0));
}

/* Of a chain, as a JournalPlace has it. */
static inline uint64_t journal_sum(const uint8_t chain[static JOURNAL_CHAIN])
{
    uint64_t sum;
    memcpy(&sum, chain, sizeof sum);
    return be64toh(sum);
}

/* False if there is no memory. */
static inline bool journal_frame_chain(const uint8_t before[static JOURNAL_CHAIN], const JournalFrame *frame,
                                       const void *data, size_t size, uint8_t ret[static JOURNAL_CHAIN])
{
    XXH128_canonical_t canonical;
    XXH3_state_t *state = XXH3_createState();
    if (!state) return false;
    XXH3_128bits_reset(state);
    XXH3_128bits_update(state, before, JOURNAL_CHAIN);
    XXH3_128bits_update(state, frame, offsetof(JournalFrame, check));
    XXH3_128bits_update(state, data, size);
    XXH128_canonicalFromHash(&canonical, XXH3_128bits_digest(state));
    XXH3_freeState(state);
    memcpy(ret, canonical.digest, JOURNAL_CHAIN);
    return true;
}

/* As journal_read(), of a file that is open. On MNS_E_CORRUPT and what visit returns, *ret tells of the records before.
 *  ret_chain  of the last whole record */
MnsStatus journal_scan(int fd, const char *path, JournalVisit *visit, void *arg, JournalReport *ret,
                       uint8_t ret_chain[static JOURNAL_CHAIN], MnsError *error);

#endif
