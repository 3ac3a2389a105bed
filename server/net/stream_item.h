/* SPDX-License-Identifier: BSD-3-Clause */
/* An item of a stream: arrays of a moment, packed once and shared by all who get them. Nobody changes one that is packed; who leaves it last,
 * on any thread, frees it. */
#ifndef NET_STREAM_ITEM_H
#define NET_STREAM_ITEM_H

#include "net/subscribe.h"
#include "run/note.h"
#include "run/tap.h"

/* What all items together hold, counted on any thread. */
typedef _Atomic size_t StreamMemory;

typedef struct StreamPart {
    PackingArray array; /* its name and unit are borrowed from tables or the document, or are literals */
    void *raw;          /* the numbers; NULL once they are packed otherwise */
    Packed *packed;     /* NULL until then */
} StreamPart;

typedef struct StreamItem {
    _Atomic unsigned users;
    StreamMemory *memory;
    size_t held;     /* of it */
    uint64_t number; /* of those that were due in its feed */
    uint64_t step;
    double time;
    size_t n, size; /* parts; bytes of all, once it is packed */
    bool packed;
    StreamPart parts[STREAM_FIELDS_MAX];
    Meniscus__Event *event; /* or NULL */
} StreamItem;

/* What of a shot the spec has, numbers as they are. MNS_E_LIMIT: it would take more than `limit` bytes of memory, namely *ret_needed;
 * MNS_E_MEMORY. */
MnsStatus stream_item_new(const StreamSpec *spec, const Shot *shot, StreamMemory *memory, size_t limit,
                          size_t *ret_needed, StreamItem **ret, MnsError *error);

/* Rows of a series: values is [rows][columns]. All three are taken over, in any case. */
MnsStatus stream_item_rows(const StreamSpec *spec, size_t rows, uint64_t *step, double *time, double *values,
                           StreamMemory *memory, StreamItem **ret, MnsError *error);

/* Something that happened to the run. NULL if there is no memory. */
StreamItem *stream_item_event(const Note *note, StreamMemory *memory);

/* Pack it as its spec says; nothing to do if it is. */
MnsStatus stream_item_pack(StreamItem *item, const StreamSpec *spec, MnsError *error);

/* Bytes of its numbers, as they are or were before they were packed. */
size_t stream_item_raw(const StreamItem *item);

StreamItem *stream_item_share(StreamItem *item);
void stream_item_leave(StreamItem *item); /* NULL is fine */

/* Bytes from offset on: where they are, if they lie together; else NULL. */
const void *stream_item_bytes(const StreamItem *item, size_t offset, size_t n);
void stream_item_copy(const StreamItem *item, size_t offset, size_t n, void *to);

#endif
