/* SPDX-License-Identifier: BSD-3-Clause */
/* Items put together from messages. What does not fit is no longer believed: the stream begins anew behind what was handed out. */
#include "client/lib/call.h"
#include "client/lib/stream_inside.h"
#include "common/wire/packing.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { HEADER = 512 }; /* bytes of a message beside those of the item, at most, but for the first one */

static const char *text(const char *maybe)
{
    return maybe ? maybe : "";
}

void stream_drop_parts(MnsStream *stream)
{
    Parts *parts = &stream->parts;
    if (parts->first) meniscus__stream_message__free_unpacked(parts->first, NULL);
    free(parts->bytes);
    *parts = (Parts){.first = NULL};
}

void stream_drop_item(MnsStream *stream)
{
    arena_done(&stream->arena);
    zmq_msg_close(&stream->file.held);
    zmq_msg_init(&stream->file.held);
    if (stream->parts.whole) stream_drop_parts(stream);
    stream->item = (MnsStreamItem){.what = "", .text = ""};
}

void stream_start_over(MnsStream *stream)
{
    stream_drop_parts(stream);
    stream->attached = stream->heard = false;
    stream->number = 0;
}

/* Begin anew, as what comes of this stream cannot be used. */
static MnsStatus leave(MnsStream *stream, MnsStatus status)
{
    if (stream->attached) stream_unsubscribe(stream, stream->number);
    stream_start_over(stream);
    return status;
}

MnsStatus stream_distrust(MnsStream *stream, const char *what, MnsError *error)
{
    return leave(stream, mns_fail(error, MNS_E_CORRUPT, "an item of the stream came damaged: %s", what));
}

static void take_cursor(const Meniscus__Cursor *from, MnsCursor *to)
{
    *to = (MnsCursor){.line = from->line, .row = from->row, .offset = from->offset};
    snprintf(to->file, sizeof to->file, "%s", text(from->file));
}

/* What all items tell. */
static void fill_item(MnsStream *stream, const Meniscus__StreamItem *first)
{
    MnsStreamItem *item = &stream->item;
    item->sequence = first->sequence;
    item->skipped = first->skipped;
    item->daemon_epoch = first->daemon_epoch;
    item->step = first->step;
    item->time = first->time;
    stream->stats.items++;
    stream->stats.skipped += first->skipped;
}

static void advance(MnsStream *stream, const MnsCursor *next)
{
    stream->cursor = *next;
    stream->has_cursor = true;
    stream->item.cursor = &stream->cursor;
}

/* --- arrays ------------------------------------------------------------------------------------------------------------- */

/* Do the arrays have just the bytes of the item, and is there room for them? Before any memory is taken. */
static MnsStatus check_arrays(MnsStream *stream, const Meniscus__StreamItem *first, MnsError *error)
{
    uint64_t packed = 0;
    size_t left = stream->memory;
    for (size_t k = 0; k < first->n_arrays; k++) {
        size_t size;
        const MnsStatus status = packing_check(first->arrays[k], left, &size, error);
        if (status == MNS_E_LIMIT && stream_is_lossless(stream)) stream->over = *error;
        else if (status == MNS_E_LIMIT) mns_stream_cancel(stream, NULL);
        if (status) return status == MNS_E_LIMIT ? status : leave(stream, status);
        left -= size;
        packed += first->arrays[k]->packed_bytes;
    }
    if (packed != first->size) return stream_distrust(stream, "its arrays do not have the bytes of the item", error);
    return MNS_OK;
}

/* Unpacked into memory of its own. */
static MnsStatus unpack(MnsStream *stream, const Meniscus__PackedArray *manifest, const uint8_t *bytes, MnsArray *ret,
                        MnsError *error)
{
    size_t size = 0;
    MnsStatus status = packing_check(manifest, stream->memory, &size, error);
    void *data = status ? NULL : arena_take(&stream->arena, 1, size);
    if (!status && !data) status = mns_fail(error, MNS_E_MEMORY, "no memory for an array of %zu bytes", size);
    if (!status) status = packing_unpack(manifest, bytes, manifest->packed_bytes, data, size, error);
    if (status) return status;
    *ret = (MnsArray){.name = text(manifest->name),
                      .unit = text(manifest->unit),
                      .type = manifest->type,
                      .n_dims = manifest->n_shape,
                      .size = size,
                      .data = data};
    for (size_t d = 0; d < manifest->n_shape; d++) ret->shape[d] = manifest->shape[d];
    stream->stats.raw_bytes += size;
    return MNS_OK;
}

static MnsStatus fill_arrays(MnsStream *stream, const Meniscus__StreamItem *first, MnsError *error)
{
    MnsArray *arrays = arena_take(&stream->arena, first->n_arrays, sizeof *arrays);
    const uint8_t *at = stream->parts.bytes;
    if (!arrays) return mns_fail(error, MNS_E_MEMORY, "no memory for %zu arrays", first->n_arrays);
    for (size_t k = 0; k < first->n_arrays; k++) {
        const MnsStatus status = unpack(stream, first->arrays[k], at, &arrays[k], error);
        if (status) return status;
        at += first->arrays[k]->packed_bytes;
    }
    stream->item.arrays = arrays;
    stream->item.n_arrays = first->n_arrays;
    stream->stats.packed_bytes += first->size;
    return MNS_OK;
}

/* The item is whole: make what the caller sees of it. */
static MnsStatus hand_out(MnsStream *stream, MnsError *error)
{
    Parts *parts = &stream->parts;
    const Meniscus__StreamItem *first = parts->first->item;
    MnsStreamItem *item = &stream->item;
    parts->whole = true;
    const MnsStatus status = fill_arrays(stream, first, error);
    if (status) return leave(stream, status);
    fill_item(stream, first);
    if (first->event) {
        item->state = (MnsState)first->event->state;
        item->what = text(first->event->what);
        item->text = text(first->event->text);
    }
    if (first->abandoned) {
        item->abandoned = true;
        item->row = first->abandoned->row;
        item->file = first->abandoned->file;
    }
    if (item->file) *stream->file.name = 0; /* which may come again, as another */
    if (parts->has_next) advance(stream, &parts->next);
    stream->done = true;
    return MNS_OK;
}

static MnsStatus begin(MnsStream *stream, Meniscus__StreamMessage *message, MnsError *error)
{
    Parts *parts = &stream->parts;
    const Meniscus__StreamItem *item = message->item;
    stream_drop_parts(stream);
    parts->first = message;
    parts->size = item->size;
    MnsStatus status = check_arrays(stream, item, error);
    if (!status && !(parts->bytes = malloc(parts->size + 1)))
        status = leave(stream, mns_fail(error, MNS_E_MEMORY, "no memory for an item of %zu bytes", (size_t)item->size));
    if (status) stream_drop_parts(stream);
    return status;
}

/* A piece of an item of arrays, or of one without bytes. Takes over the message. */
static MnsStatus take_piece(MnsStream *stream, Meniscus__StreamMessage *message, const void *data, size_t size,
                            bool *ret_ready, MnsError *error)
{
    Parts *parts = &stream->parts;
    const Meniscus__StreamItem *item = message->item;
    const bool has_next = item->next;
    MnsCursor next = {0};
    if (has_next) take_cursor(item->next, &next);
    const uint64_t offset = item->offset;
    MnsStatus status = MNS_OK;
    const bool known = parts->first && parts->first->item->sequence == item->sequence && parts->size == item->size;
    if (!offset) status = begin(stream, message, error);
    else meniscus__stream_message__free_unpacked(message, NULL);
    if (status) return status;
    if (offset && !known) return MNS_OK; /* of an item that was given up */
    if (offset != parts->got || size > parts->size - parts->got)
        return stream_distrust(stream, "its bytes do not follow one another", error);
    if (size) memcpy(parts->bytes + offset, data, size);
    parts->got += size;
    stream->offset = parts->got;
    const uint64_t rest = parts->size - parts->got;
    if (rest) return stream_grant(stream, rest + (rest / stream->chunk + 1) * HEADER, error);
    parts->next = next;
    parts->has_next = has_next;
    status = hand_out(stream, error);
    *ret_ready = !status;
    return status;
}

/* --- files -------------------------------------------------------------------------------------------------------------- */

static MnsStatus begin_file(MnsStream *stream, const Meniscus__StreamItem *item, MnsError *error)
{
    FileParts *file = &stream->file;
    const char *name = text(item->file->name);
    if (!*name || *name == '.' || strlen(name) >= sizeof file->name || strchr(name, '/'))
        return stream_distrust(stream, "a file has a name that it cannot have", error);
    if (!strcmp(name, file->name) && item->offset <= file->got && item->size == file->size)
        return MNS_OK; /* once more */
    snprintf(file->name, sizeof file->name, "%s", name);
    file->size = item->size;
    file->got = item->offset;
    file->hashed = !item->offset;
    XXH64_reset(file->hash, 0);
    return MNS_OK;
}

/* What comes a second time was handed out already. */
static MnsStatus take_file(MnsStream *stream, const Meniscus__StreamItem *item, Frames *frames, bool *ret_ready,
                           MnsError *error)
{
    FileParts *file = &stream->file;
    const MnsStatus status = item->file ? begin_file(stream, item, error) : MNS_OK;
    if (status) return status;
    if (frames->n > 1) zmq_msg_move(&file->held, &frames->frame[1]);
    const uint8_t *data = zmq_msg_data(&file->held);
    const uint64_t size = zmq_msg_size(&file->held);
    if (!*file->name || item->offset > file->got || item->size != file->size || size > file->size - item->offset)
        return stream_distrust(stream, "the bytes of a file do not follow one another", error);
    const uint64_t old = file->got - item->offset < size ? file->got - item->offset : size;
    const uint64_t fresh = size - old, before = file->got;
    if (file->hashed && fresh) XXH64_update(file->hash, data + old, fresh);
    file->got += fresh;
    stream->offset = item->offset + size;
    const bool whole = stream->offset == file->size;
    if (whole && file->hashed && item->has_xxh64 && XXH64_digest(file->hash) != item->xxh64) {
        *file->name = 0;
        return stream_distrust(stream, "the checksum of a file does not match", error);
    }
    if (!fresh && !whole) return MNS_OK;
    MnsStreamItem *to = &stream->item;
    fill_item(stream, item);
    stream->stats.items -= !whole;
    stream->stats.packed_bytes += fresh;
    stream->stats.raw_bytes += fresh;
    to->file = arena_take(&stream->arena, 1, sizeof file->name);
    if (!to->file) return mns_fail(error, MNS_E_MEMORY, "no memory for the name of a file");
    memcpy((char *)to->file, file->name, sizeof file->name);
    to->file_size = file->size;
    to->offset = before;
    to->data = fresh ? data + old : NULL;
    to->size = fresh;
    to->whole = whole;
    if (whole) *file->name = 0;
    MnsCursor next;
    if (whole && item->next) {
        take_cursor(item->next, &next);
        advance(stream, &next);
    }
    stream->done = whole;
    *ret_ready = true;
    return MNS_OK;
}

/* --- any ---------------------------------------------------------------------------------------------------------------- */

static MnsStatus end(MnsStream *stream, const Meniscus__StreamEnd *end, MnsError *error)
{
    MnsError why;
    const MnsStatus status = call_status(end->code, end->reason);
    mns_fail(&why, status, "%s", end->message ? end->message : "the daemon has ended the stream");
    stream_start_over(stream);
    if (status == MNS_E_UNAVAILABLE || status == MNS_E_LIMIT)
        return MNS_OK; /* it leaves, or we were slow: begin anew */
    stream->over = why;
    return mns_fail(error, status, "%s", why.text);
}

/* A LOSSLESS stream tells what the daemon gave up by itself, as it leaves a gap. */
static MnsStatus give_up_item(MnsStream *stream, const Meniscus__StreamItem *item, MnsError *error)
{
    const Meniscus__StreamEnd *why = item->cancelled;
    stream_drop_parts(stream);
    *stream->file.name = 0;
    stream->stats.cancelled++;
    if (item->next) {
        take_cursor(item->next, &stream->cursor);
        stream->has_cursor = true;
    }
    if (!stream_is_lossless(stream) || !strcmp(text(why->reason), "cancelled")) return MNS_OK;
    return mns_fail(error, call_status(why->code, why->reason), "%s",
                    why->message ? why->message : "the daemon has given up an item");
}

MnsStatus stream_take(MnsStream *stream, Meniscus__StreamMessage *message, Frames *frames, bool *ret_ready,
                      MnsError *error)
{
    const Meniscus__StreamItem *item = message->item;
    MnsStatus status = MNS_OK;
    size_t cost = 0;
    for (int k = 0; k < frames->n; k++) cost += zmq_msg_size(&frames->frame[k]);
    stream->open -= cost < stream->open ? cost : stream->open;
    const bool same = stream->heard && item->sequence == stream->sequence;
    const bool old = stream->heard && (item->sequence < stream->sequence || (same && stream->done));
    const bool files = stream->wish->what_case == MENISCUS__SUBSCRIBE__WHAT_SNAPSHOTS;
    const bool piece = !item->ended && !item->cancelled && !old && frames->n <= 2;
    if (piece) {
        if (!same) stream->offset = 0;
        stream->heard = true;
        stream->sequence = item->sequence;
        stream->done = false;
    }
    if (item->ended) status = end(stream, item->ended, error);
    else if (item->cancelled) status = give_up_item(stream, item, error);
    else if (piece && files && !item->abandoned) status = take_file(stream, item, frames, ret_ready, error);
    else if (piece) {
        zmq_msg_t *bytes = frames->n > 1 ? &frames->frame[1] : NULL;
        status = take_piece(stream, message, bytes ? zmq_msg_data(bytes) : NULL, bytes ? zmq_msg_size(bytes) : 0,
                            ret_ready, error);
        message = NULL;
    }
    if (message) meniscus__stream_message__free_unpacked(message, NULL);
    frames_done(frames);
    return status;
}
