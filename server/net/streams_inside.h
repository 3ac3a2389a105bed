/* SPDX-License-Identifier: BSD-3-Clause */
/* The inside of the streams' thread, for the files that make it up: streams.c, stream_requests.c, stream_pump.c, stream_latest.c, stream_lossless.c,
 * stream_memory.c. */
#ifndef NET_STREAMS_INSIDE_H
#define NET_STREAMS_INSIDE_H

#include "net/channel.h"
#include "net/pace.h"
#include "net/stream_post.h"
#include "net/streams.h"
#include "run/quota.h"
#include "run/snapshots.h"
#include <pthread.h>

/* Of one connection; run/quota.c has those of a key. */
enum { STREAMS_EACH = 256 };

struct Streams {
    StreamsOptions options;
    pthread_t thread;
    void *socket, *monitor;
    int wake;                    /* eventfd: something below is to be looked at */
    _Atomic bool leaving, steps; /* the daemon is; the run takes steps */

    /* Of the thread alone: */
    Stream *first;
    Channel *channels;
    StreamPost post;
    StreamMemory memory;
    size_t limit; /* of it                                 */
    Pace pace;    /* of requests but for credit */
    SnapshotIndex snapshots;
    TapCase now; /* the case, with a share of its document */

    /* The newest event: whoever tells of it puts it here. */
    pthread_mutex_t lock;
    StreamItem *news;
    uint64_t told; /* events so far */
};

/* stream_requests.c: take what has come, at most a few. */
void streams_receive(Streams *streams);

/* stream_requests.c: a message of so many parts, of which this is the first, from one who may ask. */
void streams_take(Streams *streams, Sender *from, zmq_msg_t *frame, uint64_t parts);

/* stream_pump.c: take note of connections that have ended. Before a message is taken: its descriptor may have been another's. */
void streams_see_off(Streams *streams);

/* stream_pump.c: another case, new shots and events; then a message of each stream that may have one, false if there was none. */
void streams_refresh(Streams *streams);
bool streams_pump(Streams *streams);

/* stream_latest.c, stream_lossless.c: begin the next item with its first message; STREAM_WAITS if there is none, or no credit for that. */
StreamSent stream_begin_latest(Streams *streams, Stream *stream);
StreamSent stream_begin_lossless(Streams *streams, Stream *stream);

/* Find one of this connection; identity NULL: of any. */
Stream *streams_find(Streams *streams, uint64_t id, const uint8_t *identity, size_t size);

/* Forget a stream. why: told to who has it; NULL: nobody asks. */
void streams_drop(Streams *streams, Stream *stream, const MnsError *why);

/* stream_memory.c: make room for so many bytes of an item, at the cost of those who have not taken any for longest. channel: for its next item, which
 * takes the place of its newest; or NULL. False: there is none, or so much is more than all may hold. */
bool streams_reclaim(Streams *streams, size_t needed, Channel *channel);

/* An item of a shot, with room made for it as above. MNS_E_LIMIT, MNS_E_MEMORY: it is counted that there is none. */
MnsStatus streams_make(Streams *streams, const StreamSpec *spec, const Shot *shot, Channel *channel, StreamItem **ret);

/* Does somebody take what the channel has, as it comes? */
bool channel_is_lively(const Channel *channel);

/* stream_latest.c: is all as it was when the first message of an item could not be sent? */
bool stream_is_blocked(const Stream *stream);

/* stream_requests.c: for one item at once. */
void streams_open_first(Streams *streams, Stream *stream);

/* The item or file under way is over. */
void stream_close_item(Stream *stream);

#endif
