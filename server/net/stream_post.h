/* SPDX-License-Identifier: BSD-3-Clause */
/* Messages of streams on their way out. Nothing here waits: what ZeroMQ has not let go of is counted by bytes, for each stream and in all. */
#ifndef NET_STREAM_POST_H
#define NET_STREAM_POST_H

#include "http/traffic.h"
#include "net/stream.h"

/* A client, as long as there are replies that it has not read. */
typedef struct StreamPeer StreamPeer;

typedef struct StreamPost {
    void *socket;
    uint64_t epoch;
    int wake;             /* eventfd: readable when ZeroMQ has let go of something */
    size_t limit;         /* bytes that may be in flight for all, but for the first message of each stream */
    _Atomic size_t bytes; /* in flight                                                */
    StreamPeer *peers;
    StreamMemory *memory;
    StreamTraffic *traffic;
} StreamPost;

/* What became of it. */
typedef enum StreamSent {
    STREAM_MORE,  /* a message is sent, and there is more of this item      */
    STREAM_WHOLE, /* the item is whole with it                              */
    STREAM_WAITS, /* for credit, or for ZeroMQ                              */
    STREAM_GONE,  /* nobody is there                                        */
    STREAM_FAILED /* the file cannot be read, or there is no memory         */
} StreamSent;

/* An answer to whoever asked. */
void stream_post_reply(StreamPost *post, const uint8_t *identity, size_t size, const Meniscus__StreamReply *reply);

/* Does the client read replies? One that has left more than a MiB of them unread gets no more. */
bool stream_post_is_heard(StreamPost *post, const uint8_t *identity, size_t size);

void stream_post_done(StreamPost *post);

/* Bytes that may be on their way for a stream at first: two messages, so that more follow only where they are taken meanwhile. */
size_t stream_post_window(size_t chunk);

/* The next message of the item or file under way, if it is covered. */
StreamSent stream_post_next(StreamPost *post, Stream *stream);

/* An empty message: STREAM_GONE if the connection is, or STREAM_WAITS. */
StreamSent stream_post_heartbeat(StreamPost *post, const Stream *stream);

/* No more of the item, or of the stream. */
void stream_post_end(StreamPost *post, const Stream *stream, bool whole_stream, MnsStatus status, const char *reason,
                     const char *text);

#endif
