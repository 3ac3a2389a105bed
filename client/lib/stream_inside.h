/* SPDX-License-Identifier: BSD-3-Clause */
/* The inside of a stream, for the files that make it up: stream_wish.c says what is wanted, stream_item.c puts items together,
 * stream_link.c is the dialogue with the daemon, stream.c what callers see. */
#ifndef CLIENT_STREAM_INSIDE_H
#define CLIENT_STREAM_INSIDE_H

#include "client/lib/arena.h"
#include "client/lib/wire.h"
#include "stream.pb-c.h"
#include <meniscus/stream.h>
#include <xxhash.h>

/* The item that is under way. */
typedef struct Parts {
    Meniscus__StreamMessage *first; /* its first message, which tells what it is; NULL: none is under way */
    uint8_t *bytes;                 /* [size] of arrays                       */
    uint64_t size, got;
    bool whole; /* to be handed out */
    MnsCursor next;
    bool has_next;
} Parts;

/* The file that is under way, over several connections if need be. */
typedef struct FileParts {
    char name[MNS_STREAM_FILE_SIZE]; /* "": none */
    uint64_t size, got;
    bool hashed; /* from its first byte on */
    XXH64_state_t *hash;
    zmq_msg_t held; /* the piece that the caller has */
} FileParts;

struct MnsStream {
    Wire wire;
    Meniscus__Subscribe *wish; /* owned, but for `from` */
    size_t memory, window;
    unsigned connections; /* that there had been when it was attached */
    bool attached;        /* the daemon knows this connection: else it is to be told */
    bool asking;          /* a subscribe or resume was sent, and is not answered yet */
    uint8_t asked[MNS_REQUEST_ID_SIZE];
    unsigned asked_over; /* connections there had been by then */
    uint64_t number;     /* of the stream, at the daemon; 0: to be subscribed */
    uint64_t chunk;
    uint64_t open;             /* bytes that were granted, and have not come */
    bool heard;                /* the two below are of an item */
    bool done;                 /* all of it was handed out */
    uint64_t sequence, offset; /* of the item that came last, and the first byte of it that did not come */
    Parts parts;
    FileParts file;
    MnsCursor cursor; /* LOSSLESS: behind what was handed out */
    bool has_cursor;
    MnsStreamItem item;
    Arena arena;                            /* of the item */
    Meniscus__StreamMessage *reply_message; /* of subscribe: has the columns */
    MnsStreamColumn *columns;
    MnsStreamStats stats;
    MnsError over; /* status MNS_OK: it is not */
};

/* What to subscribe to, with all it points to; free with meniscus__subscribe__free_unpacked(). MNS_E_INVALID, MNS_E_MEMORY. */
MnsStatus stream_wish(const MnsStreamOptions *options, Meniscus__Subscribe **ret, MnsError *error);
bool stream_is_lossless(const MnsStream *stream);

/* Have the daemon know this connection: resume, or subscribe. Until the deadline, or a few seconds. MNS_E_TIMEOUT: it was asked, and the answer is
 * still waited for when this is called again. */
MnsStatus stream_attach(MnsStream *stream, double deadline, MnsError *error);

/* Say that no more is wanted of a stream, which the daemon sends over this connection. Nobody waits for the answer. */
void stream_unsubscribe(MnsStream *stream, uint64_t number);

/* The same of this one; if its number is not told yet, until the deadline. */
void stream_sign_off(MnsStream *stream, double deadline);

/* Send a command that is answered only if it is refused. */
MnsStatus stream_tell(MnsStream *stream, Meniscus__StreamRequest *request, MnsError *error);

/* Let the daemon send so many bytes in all, if it may not yet; of more than 1 GiB only that, and the rest when some of it came. */
MnsStatus stream_grant(MnsStream *stream, uint64_t open, MnsError *error);

/* A message of this stream came: note what is to be noted. Takes over the message and the frames. True in *ret_ready: stream->item is there.
 * error is not NULL. */
MnsStatus stream_take(MnsStream *stream, Meniscus__StreamMessage *message, Frames *frames, bool *ret_ready,
                      MnsError *error);

/* Begin anew, as what came cannot be right: the daemon is told, so that it keeps nothing for who does not listen. MNS_E_CORRUPT. */
MnsStatus stream_distrust(MnsStream *stream, const char *what, MnsError *error);

/* Forget what is under way of arrays; what the caller has. */
void stream_drop_parts(MnsStream *stream);
void stream_drop_item(MnsStream *stream);

/* As it was before, but for the cursor: nobody knows what of it is true. */
void stream_start_over(MnsStream *stream);

#endif
