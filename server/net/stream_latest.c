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
    streams_reclaim(streams, 0);
    const size_t held = streams->memory, left = held < streams->limit ? streams->limit - held : 0;
    const MnsStatus status = stream_item_new(&stream->spec, shot, &streams->memory, left, &item, NULL);
    tap_leave(run_tap(run), shot);
    tap_close(run_tap(run), stream->first); /* without memory for it, those that are due come all the same */
    stream->first = NULL;
    return status ? NULL : item;
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

StreamSent stream_begin_latest(Streams *streams, Stream *stream)
{
    uint64_t number;
    StreamItem *item = next_item(streams, stream, &number), *before = stream->item;
    if (!item) return STREAM_WAITS;
    if (has_it(stream, item, number) || stream_item_pack(item, &stream->spec, NULL)) {
        stream_item_leave(item);
        return STREAM_WAITS;
    }
    stream->item = item;
    stream->skipped = subscription_take(&stream->books, number, item->size);
    const StreamSent sent = stream_post_next(&streams->post, stream);
    if (sent == STREAM_MORE || sent == STREAM_WHOLE) {
        stream_item_leave(before);
        stream->at_once = number ? 0 : item->step + 1;
        if (!number) stream_item_leave(stream->head);
        if (!number) stream->head = NULL;
        streams->options.traffic->skipped[stream->spec.kind] += stream->skipped;
        return sent;
    }
    subscription_put_back(&stream->books, stream->skipped);
    stream_item_leave(item);
    stream->item = before;
    return sent;
}
