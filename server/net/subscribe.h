/* SPDX-License-Identifier: BSD-3-Clause */
/* What a client asks for in a `subscribe`, checked against the case that is there. Pure: no socket, no thread. */
#ifndef NET_SUBSCRIBE_H
#define NET_SUBSCRIBE_H

#include "common/wire/packing.h"
#include "net/selection.h"
#include "run/tap.h"
#include "stream.pb-c.h"

enum {
    STREAM_FIELDS_MAX = 16,
    STREAM_CHUNK_LEAST = 4096,
    STREAM_CHUNK = 256 << 10,
    STREAM_CHUNK_MOST = 1 << 20,
    STREAM_FILE_NAME = 64
};

typedef enum StreamKind { STREAM_PROBES, STREAM_FIELDS, STREAM_EVENTS, STREAM_SERIES, STREAM_SNAPSHOTS } StreamKind;

/* A place in the files of the run, as of Meniscus__Cursor. */
typedef struct StreamCursor {
    uint64_t line, row, offset;
    char file[STREAM_FILE_NAME]; /* empty: from the first */
    bool given;                  /* else from the beginning, whatever the line is */
} StreamCursor;

typedef struct StreamSpec {
    StreamKind kind;
    Wish wish;
    bool first; /* an item at once */
    size_t n;   /* columns: numbers of fields or probes */
    int columns[MNS_MAX_PROBES];
    PackingHow how[STREAM_FIELDS_MAX]; /* of each field; of probes and series the first for all */
    Selection where;
    size_t chunk;
    uint64_t credit;
    StreamCursor from;
} StreamSpec;

/* Is it one of which only the newest counts? Then it has a feed. */
bool stream_is_latest(StreamKind kind);

/* now: the case, with a document, or none: then only refusals come of it. limit: bytes that an item may have.
 * MNS_OK; MNS_E_INVALID, MNS_E_NOT_FOUND, MNS_E_STATE, MNS_E_LIMIT with the entry to blame. */
MnsStatus subscribe_read(const Meniscus__Subscribe *asked, const TapCase *now, size_t limit, StreamSpec *ret,
                         MnsError *error);

#endif
