/* SPDX-License-Identifier: BSD-3-Clause */
/* What streams have next, and on with it: each gets one message in turn, so that none keeps others waiting. */
#include "net/streams_inside.h"

#include "base/clock.h"
#include "run/snapshots.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const double GONE_FOR = 30;    /* [s] that a stream is kept for a resume when nobody is there */
static const double STUCK_FOR = 1;    /* [s] without a byte taken, after which an item under way may be given up */
static const double PROBE_EVERY = 10; /* [s] without anything sent */
static const double LOOK_EVERY = 0.2; /* [s] for another snapshot file */

Stream *streams_find(Streams *streams, uint64_t id, const uint8_t *identity, size_t size)
{
    for (Stream *s = streams->first; s; s = s->next)
        if (s->id == id && (!identity || (s->identity_size == size && !memcmp(s->identity, identity, size)))) return s;
    return NULL;
}

void stream_close_item(Stream *stream)
{
    stream_item_leave(stream->item);
    stream->item = NULL;
    if (stream->file.fd >= 0) close(stream->file.fd);
    stream->file.fd = -1;
    XXH64_freeState(stream->file.sum);
    stream->file.sum = NULL;
}

void streams_drop(Streams *streams, Stream *stream, const MnsError *why)
{
    Tap *tap = run_tap(streams->options.run);
    Stream **at = &streams->first;
    while (*at != stream) at = &(*at)->next;
    *at = stream->next;
    streams->n--;
    streams->options.traffic->open[stream->spec.kind]--;
    if (why && !stream->gone)
        stream_post_end(&streams->post, stream, true, why->status, mns_status_name(why->status), why->text);
    stream_close_item(stream);
    stream_item_leave(stream->head);
    free(stream->abandoned);
    if (stream->first) tap_close(tap, stream->first);
    if (stream->channel) channel_leave(&streams->channels, tap, stream->channel);
    flight_leave(stream->flight);
    free(stream);
}

/* --- memory ------------------------------------------------------------------------------------------------------------- */

/* The one that has not moved for longest and holds an item: whole ones, kept for a resume, before those under way. */
static Stream *find_slowest(const Streams *streams, double now)
{
    Stream *found = NULL;
    for (Stream *s = streams->first; s; s = s->next) {
        if (!s->item || (s->books.under_way && !stream_is_latest(s->spec.kind)) ||
            (s->books.under_way && s->moved > now - STUCK_FOR))
            continue;
        const bool worse = found && found->books.under_way && !s->books.under_way;
        const bool as_bad = found && found->books.under_way == s->books.under_way && s->moved < found->moved;
        if (!found || worse || as_bad) found = s;
    }
    return found;
}

static void give_up_slow(Streams *streams, Stream *stream)
{
    if (subscription_cancel(&stream->books, 0)) {
        streams->options.traffic->too_slow++;
        if (!stream->gone)
            stream_post_end(&streams->post, stream, false, MNS_E_LIMIT, "too slow",
                            "nothing of this item was taken for a while, and streams hold all the memory they may; the "
                            "next one comes when there is credit");
    }
    stream_close_item(stream);
}

void streams_reclaim(Streams *streams, size_t bytes)
{
    const double now = clock_now();
    for (Stream *slow; streams->memory + bytes > streams->limit && (slow = find_slowest(streams, now));)
        give_up_slow(streams, slow);
}

/* --- what is new -------------------------------------------------------------------------------------------------------- */

static void refresh_events(Streams *streams, Channel *channel)
{
    pthread_mutex_lock(&streams->lock);
    const uint64_t told = streams->told;
    StreamItem *news = told > channel->due ? stream_item_share(streams->news) : NULL;
    pthread_mutex_unlock(&streams->lock);
    if (news) channel_put(channel, news, told);
    channel->due = told;
}

static void refresh_channels(Streams *streams)
{
    Tap *tap = run_tap(streams->options.run);
    for (Channel *c = streams->channels; c; c = c->next) {
        if (!c->feed) {
            refresh_events(streams, c);
            continue;
        }
        streams_reclaim(streams, 0);
        const size_t held = streams->memory;
        channel_refresh(c, tap, &streams->memory, held < streams->limit ? streams->limit - held : 0);
    }
}

/* Streams of a case that is gone have nothing more to say. Those who left without a word are forgotten after a while. */
static void drop_over(Streams *streams)
{
    MnsError over;
    const double now = clock_now();
    mns_fail(&over, MNS_E_INTERRUPTED, "the run was ended or another case was loaded; subscribe again");
    for (Stream *s = streams->first, *next; s; s = next) {
        next = s->next;
        const bool other = s->spec.kind != STREAM_EVENTS && s->generation != streams->now.generation;
        if (other) streams_drop(streams, s, &over);
        else if (s->gone && now > s->moved + GONE_FOR) streams_drop(streams, s, NULL);
    }
}

void streams_refresh(Streams *streams)
{
    document_leave(streams->now.document);
    tap_case(run_tap(streams->options.run), &streams->now);
    drop_over(streams);
    refresh_channels(streams);
}

/* --- one stream --------------------------------------------------------------------------------------------------------- */

/* The item of a stream that asked for one at once; NULL if it is not there yet. It is asked for again, as there may have been no room. */
static StreamItem *take_first(Streams *streams, Stream *stream)
{
    Run *run = streams->options.run;
    const double now = clock_now();
    uint64_t due;
    StreamItem *item = NULL;
    const Shot *shot = tap_take(run_tap(run), stream->first, &due);
    if (!shot) {
        if (now > stream->looked + LOOK_EVERY) run_ask(run, stream->first);
        if (now > stream->looked + LOOK_EVERY) stream->looked = now;
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

/* Begin the next item with its first message; without credit for that it waits, and a newer one takes its place. */
static StreamSent begin_latest(Streams *streams, Stream *stream)
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

/* --- LOSSLESS ----------------------------------------------------------------------------------------------------------- */

/* What was taken belongs to a past that was undone. */
static bool leave_line(Stream *stream, const StreamCursor *now)
{
    Meniscus__Abandoned *left = malloc(sizeof *left);
    if (!left) return false;
    meniscus__abandoned__init(left);
    left->has_line = true;
    left->line = stream->cursor.line;
    left->has_row = stream->spec.kind == STREAM_SERIES;
    left->row = now->row;
    stream->abandoned = left;
    stream->looked = 0;
    stream->cursor = *now;
    stream->skipped = 0;
    stream_close_item(stream);
    subscription_take(&stream->books, 0, 0);
    return true;
}

/* The next rows, as many as are on the disk and paid for. */
static bool begin_rows(Streams *streams, Stream *stream)
{
    enum { HEAD = 1024 }; /* more than is said of three arrays */
    const StreamSpec *spec = &stream->spec;
    const size_t width = (2 + spec->n) * sizeof(double);
    StreamCursor *cursor = &stream->cursor;
    SeriesRows rows;
    StreamItem *item;
    if (stream->books.credit < HEAD + width || streams->memory >= streams->limit) return false;
    const uint64_t paid = stream->books.credit - HEAD, room = paid < spec->chunk ? paid : spec->chunk;
    const size_t most = room / width ? room / width : 1;
    if (run_rows(streams->options.run, cursor->given ? cursor->line : 0, cursor->row, most, spec->n, spec->columns,
                 &rows, NULL))
        return false;
    const StreamCursor next = {.line = rows.line, .row = rows.first + rows.n, .given = true};
    if (rows.left) return leave_line(stream, &next);
    if (!rows.n || stream_item_rows(spec, rows.n, rows.step, rows.time, rows.values, &streams->memory, &item, NULL))
        return false;
    if (stream_item_pack(item, spec, NULL)) {
        stream_item_leave(item);
        return false;
    }
    stream_close_item(stream);
    stream->item = item;
    stream->cursor = next;
    stream->skipped = subscription_take(&stream->books, 0, item->size);
    return true;
}

static SnapshotPlace place_of(const StreamCursor *cursor)
{
    SnapshotPlace place = {.written = cursor->line, .offset = cursor->offset};
    snprintf(place.name, sizeof place.name, "%.*s", NUMBERED_NAME - 1, cursor->file);
    return place;
}

/* offset: where to go on in the file. */
static StreamCursor cursor_at(const SnapshotPlace *place, uint64_t offset)
{
    StreamCursor cursor = {.line = place->written, .offset = offset, .given = true};
    snprintf(cursor.file, sizeof cursor.file, "%s", place->name);
    return cursor;
}

/* The next file, or the rest of one. */
static bool begin_file(Streams *streams, Stream *stream)
{
    const double now = clock_now();
    const SnapshotPlace from = place_of(&stream->cursor);
    SnapshotNext next;
    RunStatus status;
    if (now < stream->looked + LOOK_EVERY) return false;
    stream->looked = now;
    run_status(streams->options.run, &status);
    if (!status.directory[0] || snapshots_next(status.directory, &from, &next, NULL)) return false;
    const StreamCursor here = cursor_at(&next.place, next.place.offset);
    if (next.left) return leave_line(stream, &here);
    if (!next.there) return false;
    stream_close_item(stream);
    stream->file.fd = next.fd;
    snprintf(stream->file.name, sizeof stream->file.name, "%s", next.place.name);
    if (!next.place.offset) stream->file.sum = XXH64_createState();
    if (stream->file.sum) XXH64_reset(stream->file.sum, 0);
    stream->cursor = cursor_at(&next.place, next.size);
    stream->skipped = subscription_take(&stream->books, 0, next.size);
    stream->books.offset = next.place.offset;
    return true;
}

static StreamSent begin_lossless(Streams *streams, Stream *stream)
{
    const bool series = stream->spec.kind == STREAM_SERIES;
    const bool begun = series ? begin_rows(streams, stream) : begin_file(streams, stream);
    return begun ? stream_post_next(&streams->post, stream) : STREAM_WAITS;
}

static StreamSent advance(Streams *streams, Stream *stream)
{
    if (stream->books.under_way) return stream_post_next(&streams->post, stream);
    if (!stream->books.credit) return STREAM_WAITS;
    return stream_is_latest(stream->spec.kind) ? begin_latest(streams, stream) : begin_lossless(streams, stream);
}

/* A file that cannot be read, or no memory for a message. */
static void give_up(Streams *streams, Stream *stream)
{
    if (stream->file.fd < 0 || !subscription_cancel(&stream->books, 0)) return;
    stream_post_end(&streams->post, stream, false, MNS_E_IO, "input/output error",
                    "the file could not be read to its end; the next one follows");
    stream_close_item(stream);
}

/* Whoever left without a word is found out only by sending something, and without credit there is nothing to send. */
static StreamSent probe(Streams *streams, Stream *stream)
{
    const double now = clock_now();
    if (now < fmax(stream->moved, stream->probed) + PROBE_EVERY || stream->flight->bytes) return STREAM_WAITS;
    stream->probed = now;
    return stream_post_probe(&streams->post, stream);
}

static bool pump(Streams *streams, Stream *stream)
{
    if (stream->gone) return false;
    StreamSent sent = advance(streams, stream);
    if (sent == STREAM_WAITS) sent = probe(streams, stream);
    switch (sent) {
    case STREAM_WHOLE:
        streams->options.traffic->items[stream->spec.kind]++;
        free(stream->abandoned);
        stream->abandoned = NULL;
        stream->looked = 0;
        return true;
    case STREAM_MORE: return true;
    case STREAM_GONE:
        stream->gone = true;
        stream->moved = clock_now();
        return false;
    case STREAM_FAILED: give_up(streams, stream); break;
    case STREAM_WAITS: break;
    }
    return false;
}

bool streams_pump(Streams *streams)
{
    bool any = false;
    for (Stream *s = streams->first, *next; s; s = next) {
        next = s->next;
        any = pump(streams, s) || any;
    }
    return any;
}
