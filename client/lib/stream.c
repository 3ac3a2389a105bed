/* SPDX-License-Identifier: BSD-3-Clause */
/* Streams as callers see them. More is granted when an item is done with, and for the rest of one that is longer than what was granted. */
#include "client/lib/call.h"
#include "client/lib/endpoint.h"
#include "client/lib/stream_inside.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum {
    CHUNK_SMALL = 4096,
    CHUNK_LARGE = 262144,
    SPARE = 16384,
    FILE_WINDOW = 8 << 20,
    ROWS_WINDOW = 1 << 20,
    AGAIN_US = 200000
};

/* Of what is LATEST little more than one message, as what waits on the way is old when it comes. */
static void choose_window(MnsStream *stream, MnsStreamKind kind)
{
    static const size_t windows[] = {[MNS_STREAM_PROBES] = CHUNK_SMALL + SPARE,
                                     [MNS_STREAM_FIELDS] = CHUNK_LARGE + SPARE,
                                     [MNS_STREAM_EVENTS] = CHUNK_SMALL + SPARE,
                                     [MNS_STREAM_SERIES] = ROWS_WINDOW,
                                     [MNS_STREAM_SNAPSHOTS] = FILE_WINDOW};
    stream->window = windows[kind];
    stream->wish->has_chunk_bytes = true;
    stream->wish->chunk_bytes = windows[kind] < CHUNK_LARGE ? CHUNK_SMALL : CHUNK_LARGE;
}

/* Subscribing answers what the options have wrong; who was refused later is told by mns_stream_next(). */
MnsStatus mns_stream_open(const MnsClient *client, const MnsStreamOptions *options, MnsStream **ret_stream,
                          MnsError *error)
{
    char endpoint[MNS_ENDPOINT_SIZE];
    MnsStatus status = endpoint_data(client->wire.endpoint, endpoint, error);
    if (status) return status;
    MnsStream *stream = calloc(1, sizeof *stream);
    if (!stream) return mns_fail(error, MNS_E_MEMORY, "no memory for a stream");
    stream->memory = options->memory ? options->memory : (size_t)1 << 30;
    stream->file.hash = XXH64_createState();
    zmq_msg_init(&stream->file.held);
    if (options->from) {
        stream->cursor = *options->from;
        stream->has_cursor = options->from->line || options->from->row || *options->from->file;
    }
    status = stream->file.hash ? stream_wish(options, &stream->wish, error)
                               : mns_fail(error, MNS_E_MEMORY, "no memory for a stream");
    if (!status) choose_window(stream, options->kind);
    if (!status)
        status = wire_open(&stream->wire, endpoint, *client->wire.keys.public_key ? &client->wire.keys : NULL,
                           wire_clock() + WIRE_OPENING_S, error);
    if (!status) status = stream_attach(stream, client->timeout < 0 ? INFINITY : wire_clock() + client->timeout, error);
    if (!status) *ret_stream = stream;
    else mns_stream_close(stream);
    return status;
}

const MnsStreamColumn *mns_stream_columns(const MnsStream *stream, size_t *ret_n)
{
    *ret_n = stream->reply_message->reply->n_columns;
    return stream->columns;
}

/* Some message: an item of this stream, or why something was refused that nobody waited for. */
static MnsStatus read_frames(MnsStream *stream, Frames *frames, bool *ret_ready, MnsError *error)
{
    Meniscus__StreamMessage *message =
        meniscus__stream_message__unpack(NULL, zmq_msg_size(&frames->frame[0]), zmq_msg_data(&frames->frame[0]));
    MnsStatus status = MNS_OK;
    if (!message) status = stream_distrust(stream, "a message cannot be read", error);
    else if (message->what_case == MENISCUS__STREAM_MESSAGE__WHAT_ITEM && message->item->stream == stream->number)
        return stream_take(stream, message, frames, ret_ready, error);
    else if (message->what_case == MENISCUS__STREAM_MESSAGE__WHAT_REPLY &&
             message->reply->code == MENISCUS__CODE__NOT_FOUND)
        stream_start_over(stream); /* forgotten, as nothing was taken for long */
    if (message) meniscus__stream_message__free_unpacked(message, NULL);
    frames_done(frames);
    return status;
}

static MnsStatus receive(MnsStream *stream, double deadline, bool *ret_ready, MnsError *error)
{
    Frames frames;
    if (stream->wire.connections != stream->connections) stream->attached = false;
    if (!stream->attached && stream->wire.connected) {
        const MnsStatus status = stream_attach(stream, deadline, error);
        if (status != MNS_E_STATE) return status;
        /* A daemon that was started again has no case for a while. */
        usleep((useconds_t)fmin(AGAIN_US, fmax(0, 1e6 * (deadline - wire_clock()))));
        return MNS_OK;
    }
    const MnsStatus status = wire_receive(&stream->wire, deadline, &frames, error);
    if (status) return status;
    if (frames.n) return read_frames(stream, &frames, ret_ready, error);
    stream->attached = false;
    return MNS_OK;
}

static MnsStatus explain(MnsStream *stream, MnsStatus status, double timeout_s, MnsError *error)
{
    if (status == MNS_E_TIMEOUT) return mns_fail(error, status, "no item within %g s", timeout_s);
    if (status != MNS_E_UNAVAILABLE) return status;
    stream->wire.lost_since = wire_clock(); /* whoever asks again waits again */
    stream->attached = false;
    return mns_fail(error, status, "the daemon at %s is away; ask again, and the stream goes on when it is back",
                    stream->wire.endpoint);
}

/* In each turn, as what came may have used credit and made no item. The rest of an item that is under way was granted with its pieces. */
static MnsStatus pay(MnsStream *stream, MnsError *error)
{
    const bool lossless = stream_is_lossless(stream);
    if (lossless ? stream->open > stream->window / 2 : stream->parts.first != NULL) return MNS_OK;
    return stream_grant(stream, stream->window, error);
}

MnsStatus mns_stream_next(MnsStream *stream, double timeout_s, const MnsStreamItem **ret_item, MnsError *error)
{
    const double deadline = timeout_s < 0 ? INFINITY : wire_clock() + timeout_s;
    MnsError unwanted;
    bool ready = false;
    if (!error) error = &unwanted;
    stream_drop_item(stream);
    if (stream->over.status) return mns_fail_at(error, stream->over.status, stream->over.path, "%s", stream->over.text);
    MnsStatus status = MNS_OK;
    while (!status && !ready) {
        status = pay(stream, error);
        if (!status) status = receive(stream, deadline, &ready, error);
        if (!status && !ready && wire_clock() > deadline) status = MNS_E_TIMEOUT;
    }
    if (status) return explain(stream, status, timeout_s, error);
    *ret_item = &stream->item;
    return MNS_OK;
}

MnsStatus mns_stream_cancel(MnsStream *stream, MnsError *error)
{
    Meniscus__StreamRequest request = MENISCUS__STREAM_REQUEST__INIT;
    Meniscus__CancelItem item = MENISCUS__CANCEL_ITEM__INIT;
    if (stream_is_lossless(stream) && stream->wish->what_case == MENISCUS__SUBSCRIBE__WHAT_PROBES)
        return mns_fail(error, MNS_E_STATE,
                        "no row of a series can be left out; close the stream, and open one at its cursor later");
    if (!stream->attached) return MNS_OK;
    item.has_stream = true;
    item.stream = stream->number;
    request.command_case = MENISCUS__STREAM_REQUEST__COMMAND_CANCEL;
    request.cancel = &item;
    return stream_tell(stream, &request, error);
}

MnsStreamStats mns_stream_stats(const MnsStream *stream)
{
    return stream->stats;
}

void mns_stream_close(MnsStream *stream)
{
    static const int linger_ms = 200;
    if (!stream) return;
    if (stream->wire.connected) {
        zmq_setsockopt(stream->wire.dealer, ZMQ_LINGER, &linger_ms, sizeof linger_ms);
        stream_sign_off(stream, wire_clock() + 1e-3 * linger_ms);
    }
    stream_drop_item(stream);
    stream_drop_parts(stream);
    zmq_msg_close(&stream->file.held);
    XXH64_freeState(stream->file.hash);
    if (stream->wish) meniscus__subscribe__free_unpacked(stream->wish, NULL);
    if (stream->reply_message) meniscus__stream_message__free_unpacked(stream->reply_message, NULL);
    free(stream->columns);
    wire_close(&stream->wire);
    free(stream);
}
