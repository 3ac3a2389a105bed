/* SPDX-License-Identifier: BSD-3-Clause */
/* Messages of streams on their way out. */
#include "net/stream_post.h"

#include "base/clock.h"
#include "common/wire/frame.h"
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>
#include <zmq.h>

/* Bytes on their way for a stream at most; and items below this are shared with ZeroMQ. What it does not let go of, as whoever hangs reads nothing, is so
 * a part of a large item, not all of it. */
enum { WINDOW_MOST = 4 << 20, SHARED_MOST = 1 << 20 };

/* --- parcels ------------------------------------------------------------------------------------------------------------ */

/* Bytes on their way: of an item, which is shared, or a buffer of their own. */
typedef struct Parcel {
    StreamPost *post;
    Flight *flight;
    StreamItem *item;
    void *buffer;
    _Atomic size_t size; /* written last and read first, as ZeroMQ hands it over unseen by race detectors */
} Parcel;

static void let_go(void *data, void *hint)
{
    (void)data;
    Parcel *parcel = hint;
    const size_t size = parcel->size;
    StreamPost *post = parcel->post;
    post->bytes -= size;
    if (parcel->buffer) *post->memory -= size;
    flight_end(parcel->flight, size);
    stream_item_leave(parcel->item);
    free(parcel->buffer);
    free(parcel);
    eventfd_write(post->wake, 1);
}

/* What ZeroMQ and we need for one more frame, however short. */
static const size_t COST = sizeof(Parcel) + sizeof(zmq_msg_t);

size_t stream_post_window(size_t chunk)
{
    return 2 * (chunk + 2 * COST);
}

/* buffer: taken over if it is one; else the bytes are of the item, which is shared. */
static bool wrap(StreamPost *post, Flight *flight, StreamItem *item, const void *data, void *buffer, size_t size,
                 zmq_msg_t *ret)
{
    Parcel *parcel = malloc(sizeof *parcel);
    if (!parcel || zmq_msg_init_data(ret, (void *)data, size, let_go, parcel)) {
        free(parcel);
        free(buffer);
        return false;
    }
    parcel->post = post;
    parcel->flight = flight;
    parcel->item = buffer ? NULL : stream_item_share(item);
    parcel->buffer = buffer;
    flight_begin(flight, size + COST);
    post->bytes += size + COST;
    if (buffer) *post->memory += size + COST;
    parcel->size = size + COST;
    return true;
}

/* The bytes of the next message: of a file they are read now. False: there is no memory, or the file cannot be read. */
static bool load(StreamPost *post, Stream *stream, size_t n, zmq_msg_t *ret)
{
    const uint64_t offset = stream->books.offset;
    const bool shared = stream->file.fd < 0 && stream->item->size <= SHARED_MOST;
    const void *data = shared ? stream_item_bytes(stream->item, offset, n) : NULL;
    if (data) return wrap(post, stream->flight, stream->item, data, NULL, n, ret);
    char *buffer = malloc(n);
    if (!buffer) return false;
    if (stream->file.fd < 0) stream_item_copy(stream->item, offset, n, buffer);
    else if (pread(stream->file.fd, buffer, n, (off_t)offset) != (ssize_t)n) {
        free(buffer);
        return false;
    } else if (stream->file.sum) XXH64_update(stream->file.sum, buffer, n);
    return wrap(post, stream->flight, NULL, buffer, buffer, n, ret);
}

/* --- what is said of them ----------------------------------------------------------------------------------------------- */

/* NULL if there is no memory. */
static uint8_t *pack(const Meniscus__StreamItem *item, size_t *ret_size)
{
    Meniscus__StreamMessage message = MENISCUS__STREAM_MESSAGE__INIT;
    message.what_case = MENISCUS__STREAM_MESSAGE__WHAT_ITEM;
    message.item = (Meniscus__StreamItem *)item;
    *ret_size = meniscus__stream_message__get_packed_size(&message);
    uint8_t *packed = malloc(*ret_size + 1);
    if (packed) meniscus__stream_message__pack(&message, packed);
    return packed;
}

/* What comes with the first message of an item. */
static void describe(Meniscus__StreamItem *to, const StreamPost *post, const Stream *stream,
                     Meniscus__PackedArray *arrays[STREAM_FIELDS_MAX], Meniscus__FileBegin *file)
{
    const StreamItem *item = stream->item;
    to->has_skipped = to->has_daemon_epoch = true;
    to->skipped = stream->skipped;
    to->daemon_epoch = post->epoch;
    to->abandoned = stream->abandoned;
    if (stream->file.fd >= 0) {
        file->name = (char *)stream->file.name;
        file->has_size = true;
        file->size = stream->books.size;
        to->file = file;
        return;
    }
    if (!item) return;
    to->has_step = to->has_time = true;
    to->step = item->step;
    to->time = item->time;
    to->event = item->event;
    to->arrays = arrays;
    to->n_arrays = item->n;
    for (size_t k = 0; k < item->n; k++) arrays[k] = (Meniscus__PackedArray *)item->parts[k].packed->manifest;
}

/* What comes with the last one of a LOSSLESS stream. */
static void conclude(Meniscus__StreamItem *to, const Stream *stream, Meniscus__Cursor *next)
{
    const StreamCursor *cursor = &stream->cursor;
    if (stream_is_latest(stream->spec.kind)) return;
    next->has_line = true;
    next->line = cursor->line;
    next->has_row = stream->spec.kind == STREAM_SERIES;
    next->row = cursor->row;
    next->file = cursor->file[0] ? (char *)cursor->file : NULL;
    next->has_offset = cursor->file[0] != 0;
    next->offset = cursor->offset;
    to->next = next;
    to->has_xxh64 = stream->file.fd >= 0 && stream->file.sum;
    if (to->has_xxh64) to->xxh64 = XXH64_digest(stream->file.sum);
}

static uint8_t *header(const StreamPost *post, const Stream *stream, size_t n, size_t *ret_size)
{
    const Subscription *books = &stream->books;
    Meniscus__StreamItem item = MENISCUS__STREAM_ITEM__INIT;
    Meniscus__PackedArray *arrays[STREAM_FIELDS_MAX];
    Meniscus__FileBegin file = MENISCUS__FILE_BEGIN__INIT;
    Meniscus__Cursor next = MENISCUS__CURSOR__INIT;
    item.has_stream = item.has_sequence = item.has_offset = item.has_size = true;
    item.stream = stream->id;
    item.sequence = books->sequence;
    item.offset = books->offset;
    item.size = books->size;
    if (!books->opened) describe(&item, post, stream, arrays, &file);
    if (books->offset + n == books->size) conclude(&item, stream, &next);
    return pack(&item, ret_size);
}

/* --- sending ------------------------------------------------------------------------------------------------------------ */

/* Whether ZeroMQ takes more of this stream. One that has nothing on its way may always send: so nobody keeps others from it. */
static bool has_room(const StreamPost *post, Stream *stream, size_t n)
{
    const size_t own = stream->flight->bytes;
    if (!own) return true;
    if (post->bytes + n > post->limit) return false;
    if (own < stream->window / 2 && stream->window < WINDOW_MOST) stream->window *= 2;
    return own + n <= stream->window;
}

/* A message that is begun must be ended, or the next one would be taken for the rest of it: so all is there before. False, with zmq_errno(): it is not
 * begun. bytes NULL: there are none. Both are taken over. */
static bool send_parts(StreamPost *post, const uint8_t *identity, size_t size, zmq_msg_t *head, zmq_msg_t *bytes)
{
    const bool begun = zmq_send(post->socket, identity, size, ZMQ_SNDMORE | ZMQ_DONTWAIT) >= 0;
    const int why = zmq_errno();
    if (!begun || zmq_msg_send(head, post->socket, ZMQ_DONTWAIT | (bytes ? ZMQ_SNDMORE : 0)) < 0) zmq_msg_close(head);
    if (bytes && (!begun || zmq_msg_send(bytes, post->socket, ZMQ_DONTWAIT) < 0)) zmq_msg_close(bytes);
    errno = why;
    return begun;
}

/* Both frames of the next message. False: there is no memory, or the file cannot be read. How long the first frame is does not depend on the bytes; what
 * it says of the last ones of a file does. */
static bool load_both(StreamPost *post, Stream *stream, uint8_t *packed, size_t size, size_t n, zmq_msg_t *head,
                      zmq_msg_t *bytes)
{
    if (n && !load(post, stream, n, bytes)) {
        free(packed);
        return false;
    }
    if (stream->file.sum && stream->books.offset + n == stream->books.size) {
        free(packed);
        packed = header(post, stream, n, &size);
    }
    if (packed && wrap(post, stream->flight, NULL, packed, packed, size, head)) return true;
    if (n) zmq_msg_close(bytes);
    return false;
}

StreamSent stream_post_next(StreamPost *post, Stream *stream)
{
    Subscription *books = &stream->books;
    const size_t n = subscription_next(books);
    size_t size;
    zmq_msg_t head, bytes;
    if (books->credit < n || !has_room(post, stream, n)) return STREAM_WAITS;
    uint8_t *packed = header(post, stream, n, &size);
    if (!packed) return STREAM_FAILED;
    if (books->credit < size + n) {
        free(packed);
        return STREAM_WAITS;
    }
    if (!load_both(post, stream, packed, size, n, &head, &bytes)) return STREAM_FAILED;
    if (!send_parts(post, stream->identity, stream->identity_size, &head, n ? &bytes : NULL)) {
        const int why = errno;
        XXH64_freeState(stream->file.sum); /* it has bytes that nobody got */
        stream->file.sum = NULL;
        return why == EHOSTUNREACH ? STREAM_GONE : STREAM_WAITS;
    }
    subscription_pay(books, size + n);
    stream->moved = clock_now();
    post->traffic->bytes[stream->spec.kind] += size + n;
    return subscription_sent(books, n) ? STREAM_WHOLE : STREAM_MORE;
}

/* A frame that is taken over, counted where flight says; false as above, or if there is no memory. */
static bool send_one(StreamPost *post, Flight *flight, const uint8_t *identity, size_t identity_size, uint8_t *packed,
                     size_t size)
{
    zmq_msg_t message;
    errno = ENOMEM;
    return packed && wrap(post, flight, NULL, packed, packed, size, &message) &&
           send_parts(post, identity, identity_size, &message, NULL);
}

StreamSent stream_post_heartbeat(StreamPost *post, const Stream *stream)
{
    const bool sent = send_one(post, stream->flight, stream->identity, stream->identity_size, malloc(1), 0);
    return sent || errno != EHOSTUNREACH ? STREAM_WAITS : STREAM_GONE;
}

void stream_post_end(StreamPost *post, const Stream *stream, bool whole_stream, MnsStatus status, const char *reason,
                     const char *text)
{
    Meniscus__StreamItem item = MENISCUS__STREAM_ITEM__INIT;
    Meniscus__StreamEnd end = MENISCUS__STREAM_END__INIT;
    Meniscus__Cursor next = MENISCUS__CURSOR__INIT;
    size_t size;
    item.has_stream = item.has_sequence = true;
    item.stream = stream->id;
    item.sequence = stream->books.sequence;
    end.has_code = true;
    end.code = code_of(status);
    end.reason = (char *)reason;
    end.message = (char *)text;
    *(whole_stream ? &item.ended : &item.cancelled) = &end;
    if (!whole_stream) conclude(&item, stream, &next);
    item.has_xxh64 = false;
    uint8_t *packed = pack(&item, &size);
    send_one(post, stream->flight, stream->identity, stream->identity_size, packed, size);
}

/* --- replies ------------------------------------------------------------------------------------------------------------ */

enum { UNREAD_MOST = 1 << 20 };

struct StreamPeer {
    StreamPeer *next;
    uint8_t identity[STREAM_IDENTITY];
    size_t size;
    Flight *flight;
};

/* Those who have read all are forgotten on the way. */
static StreamPeer *find_peer(StreamPost *post, const uint8_t *identity, size_t size)
{
    StreamPeer *found = NULL;
    for (StreamPeer **at = &post->peers, *peer; (peer = *at);) {
        const bool same = peer->size == size && !memcmp(peer->identity, identity, size);
        if (same) found = peer;
        if (same || peer->flight->bytes) {
            at = &peer->next;
            continue;
        }
        *at = peer->next;
        flight_leave(peer->flight);
        free(peer);
    }
    return found;
}

static StreamPeer *new_peer(StreamPost *post, const uint8_t *identity, size_t size)
{
    StreamPeer *peer = calloc(1, sizeof *peer);
    if (!peer || !(peer->flight = flight_new())) {
        free(peer);
        return NULL;
    }
    memcpy(peer->identity, identity, size);
    peer->size = size;
    peer->next = post->peers;
    post->peers = peer;
    return peer;
}

bool stream_post_is_heard(StreamPost *post, const uint8_t *identity, size_t size)
{
    const StreamPeer *peer = find_peer(post, identity, size);
    return !peer || peer->flight->bytes < UNREAD_MOST;
}

void stream_post_done(StreamPost *post)
{
    for (StreamPeer *peer; (peer = post->peers);) {
        post->peers = peer->next;
        flight_leave(peer->flight);
        free(peer);
    }
}

void stream_post_reply(StreamPost *post, const uint8_t *identity, size_t size, const Meniscus__StreamReply *reply)
{
    Meniscus__StreamMessage message = MENISCUS__STREAM_MESSAGE__INIT;
    message.what_case = MENISCUS__STREAM_MESSAGE__WHAT_REPLY;
    message.reply = (Meniscus__StreamReply *)reply;
    const size_t whole = meniscus__stream_message__get_packed_size(&message);
    StreamPeer *peer = find_peer(post, identity, size);
    if (!peer) peer = new_peer(post, identity, size);
    uint8_t *packed = peer ? malloc(whole + 1) : NULL;
    if (!packed) return;
    meniscus__stream_message__pack(&message, packed);
    send_one(post, peer->flight, identity, size, packed, whole);
}
