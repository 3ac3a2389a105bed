/* SPDX-License-Identifier: BSD-3-Clause */
/* What a LATEST stream has next: the newest item of its channel, or one that was asked for at once. */
#include "net/streams_inside.h"

#include "base/clock.h"

static const double ASK_EVERY = 0.2; /* [s] again for an item at once */

/* The item of a stream that asked for one at once; NULL if it is not there yet. It is asked for again, as there may have been no room. */
static StreamItem *take_first(Streams *streams, Stream *stream)
{
    Run *run = streams->options.run;
    const double now = clock_now();
    uint64_t due;
    StreamItem *item = NULL;
    const Shot *shot = tap_take(run_tap(run), stream->first, &due);
    if (!shot) {
        if (now > stream->looked + ASK_EVERY) run_ask(run, stream->first);
        if (now > stream->looked + ASK_EVERY) stream->looked = now;
        return NULL;
    }
    const MnsStatus status = streams_make(streams, &stream->spec, shot, NULL, &item);
    tap_leave(run_tap(run), shot);
    stream->looked = now;
    if (status) return NULL;
    tap_close(run_tap(run), stream->first);
    stream->first = NULL;
    return item;
}

/* What a LATEST stream has next, or NULL. *ret_number: as subscription_take() has it. */
static StreamItem *next_item(Streams *streams, Stream *stream, uint64_t *ret_number)
{
    Channel *channel = stream->channel;
    *ret_number = 0;
    if (stream->head) return stream_item_share(stream->head);
    if (stream->first) {
        stream->head = take_first(streams, stream);
        return stream_item_share(stream->head);
    }
    if (!channel->newest || !subscription_wants(&stream->books, channel->newest->number)) return NULL;
    *ret_number = channel->newest->number;
    return stream_item_share(channel->newest);
}

/* Is it of the boundary that the item at once was of? Then the stream has it. */
static bool has_it(Stream *stream, const StreamItem *item, uint64_t number)
{
    if (!number || stream->at_once != item->step + 1) return false;
    stream->books.taken = number;
    return true;
}

bool stream_is_blocked(const Stream *stream)
{
    const StreamBlock *block = &stream->block;
    return block->is && stream->books.credit <= block->credit && stream->flight->bytes >= block->flight;
}

/* To pack an item takes long, and is in vain if none of it can be sent. How large it will be is not known before: so it is done once, and again when there is
 * more credit, fewer bytes on their way, or an item that is smaller to begin with. */
static bool is_in_vain(const Stream *stream, const StreamItem *item)
{
    return !item->packed && stream_is_blocked(stream) && stream_item_raw(item) >= stream->block.raw;
}

StreamSent stream_begin_latest(Streams *streams, Stream *stream)
{
    uint64_t number;
    StreamItem *item = next_item(streams, stream, &number), *before = stream->item;
    if (!item) return STREAM_WAITS;
    const bool pack = !item->packed;
    if (has_it(stream, item, number) || is_in_vain(stream, item) || stream_item_pack(item, &stream->spec, NULL)) {
        stream_item_leave(item);
        return STREAM_WAITS;
    }
    streams->options.traffic->packed += pack;
    const StreamBlock block = {
        .credit = stream->books.credit, .flight = stream->flight->bytes, .raw = stream_item_raw(item)};
    stream->item = item;
    stream->skipped = subscription_take(&stream->books, number, item->size);
    const StreamSent sent = stream_post_next(&streams->post, stream);
    stream->block = block;
    stream->block.is = sent == STREAM_WAITS;
    if (sent == STREAM_MORE || sent == STREAM_WHOLE) {
        stream_item_leave(before);
        stream->at_once = number ? 0 : item->step + 1;
        if (!number) stream_item_leave(stream->head);
        if (!number) stream->head = NULL;
        return sent;
    }
    subscription_put_back(&stream->books, stream->skipped);
    stream_item_leave(item);
    stream->item = before;
    return sent;
}
