/* SPDX-License-Identifier: BSD-3-Clause */
/* What streams have next, and on with it: each gets one message in turn, so that none keeps others waiting. */
#include "net/streams_inside.h"

#include "base/clock.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <zmq.h>

static const double GONE_FOR = 30; /* [s] that a stream is kept for a resume when nobody is there */
static const double HEARTBEAT = 3; /* [s] without anything sent: proto/README.md says it */

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
    streams->options.traffic->open[stream->spec.kind]--;
    if (stream->spec.kind == STREAM_SERIES) run_follow(streams->options.run, -1);
    if (why && !stream->gone)
        stream_post_end(&streams->post, stream, true, why->status, mns_status_name(why->status), why->text);
    stream_close_item(stream);
    if (stream->channel && !stream->gone) /* the newest, too */
        streams->options.traffic->skipped[stream->spec.kind] +=
            subscription_skips(&stream->books, stream->channel->due + 1, stream->channel->due);
    stream_item_leave(stream->head);
    free(stream->abandoned);
    if (stream->first) tap_close(tap, stream->first);
    if (stream->channel) channel_leave(&streams->channels, tap, stream);
    flight_leave(stream->flight);
    free(stream);
}

/* --- what is new -------------------------------------------------------------------------------------------------------- */

/* What has given way to newer items is counted then, as who takes none may never hear of it. Of who is not there nothing is, unless it comes back. */
static void count_skips(Streams *streams, const Channel *channel)
{
    const uint64_t newest = channel->newest ? channel->newest->number : 0;
    for (Stream *stream = channel->users; stream; stream = stream->beside)
        if (!stream->gone)
            streams->options.traffic->skipped[stream->spec.kind] +=
                subscription_skips(&stream->books, newest, channel->due);
}

static void refresh_events(Streams *streams, Channel *channel)
{
    pthread_mutex_lock(&streams->lock);
    const uint64_t told = streams->told;
    StreamItem *news = told > channel->due ? stream_item_share(streams->news) : NULL;
    pthread_mutex_unlock(&streams->lock);
    if (news) channel_put(channel, news, told);
    channel->due = told;
}

static void refresh_feed(Streams *streams, Channel *channel)
{
    Tap *tap = run_tap(streams->options.run);
    StreamItem *item;
    const Shot *shot = tap_take(tap, channel->feed, &channel->due);
    if (!shot) return;
    const MnsStatus status = streams_make(streams, &channel->spec, shot, channel, &item);
    tap_leave(tap, shot);
    if (!status) channel_put(channel, item, channel->due);
    channel->starved = status == MNS_E_LIMIT;
}

/* Who takes what comes is served before who does not, and of those first the ones that had to do without the last time: or others would take the memory
 * from them again and again. A feed that was served has nothing more for a later turn. */
static void refresh_channels(Streams *streams)
{
    for (int turn = 0; turn < 3; turn++)
        for (Channel *c = streams->channels; c; c = c->next) {
            if (!c->feed && !turn) refresh_events(streams, c);
            if (c->feed && (turn == 2 || ((turn || c->starved) && channel_is_lively(c)))) refresh_feed(streams, c);
        }
    for (const Channel *c = streams->channels; c; c = c->next) count_skips(streams, c);
}

/* Streams of a case that is gone have nothing more to say. Those who left without a word are forgotten after a while. */
static void drop_over(Streams *streams)
{
    MnsError over, slow;
    const double now = clock_now();
    mns_fail(&slow, MNS_E_LIMIT,
             "nothing was taken for a while, and streams hold all the memory they may; subscribe "
             "again with `from` to go on");
    mns_fail(&over, MNS_E_INTERRUPTED, "the run was ended or another case was loaded; subscribe again");
    for (Stream *s = streams->first, *next; s; s = next) {
        next = s->next;
        const bool other = s->spec.kind != STREAM_EVENTS && s->generation != streams->now.generation;
        if (other) streams_drop(streams, s, &over);
        else if (s->too_slow) streams_drop(streams, s, &slow);
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

static StreamSent advance(Streams *streams, Stream *stream)
{
    if (stream->books.under_way) return stream_post_next(&streams->post, stream);
    if (!stream->books.credit) return STREAM_WAITS;
    return stream_is_latest(stream->spec.kind) ? stream_begin_latest(streams, stream)
                                               : stream_begin_lossless(streams, stream);
}

/* A file that cannot be read, or no memory for a message. */
static void give_up(Streams *streams, Stream *stream)
{
    if (stream->file.fd < 0 || !subscription_cancel(&stream->books, 0)) return;
    stream_post_end(&streams->post, stream, false, MNS_E_IO, "input/output error",
                    "the file could not be read to its end; the next one follows");
    stream_close_item(stream);
}

/* A client that hears nothing knows by it that the connection is lost, also where ZeroMQ has made another one in its place, and a client that left without a
 * word, as a machine that is switched off, is found out only by sending something. One for all streams of a connection. */
static StreamSent beat(Streams *streams, Stream *stream)
{
    const double now = clock_now();
    if (now < fmax(stream->moved, stream->beaten) + HEARTBEAT || stream->flight->bytes) return STREAM_WAITS;
    for (Stream *s = streams->first; s; s = s->next)
        if (s->identity_size == stream->identity_size && !memcmp(s->identity, stream->identity, s->identity_size))
            s->beaten = now;
    return stream_post_heartbeat(&streams->post, stream);
}

/* Nobody is there: what the run may have for it is not kept from others. */
static void leave_alone(Streams *streams, Stream *stream)
{
    stream->gone = true;
    stream->fd = -1;
    stream->moved = clock_now();
    stream->first_due = stream->first != NULL;
    if (stream->first) tap_close(run_tap(streams->options.run), stream->first);
    stream->first = NULL;
}

/* An event is two frames: its number and value, which is the descriptor, and the address. */
void streams_see_off(Streams *streams)
{
    char data[sizeof(uint16_t) + sizeof(int32_t)], where[256];
    int32_t fd;
    while (streams->monitor && zmq_recv(streams->monitor, data, sizeof data, ZMQ_DONTWAIT) >= 0) {
        zmq_recv(streams->monitor, where, sizeof where, 0);
        memcpy(&fd, data + sizeof(uint16_t), sizeof fd);
        for (Stream *s = streams->first; s; s = s->next)
            if (!s->gone && s->fd == fd) leave_alone(streams, s);
        pace_forget_fd(&streams->pace, fd);
    }
}

static bool pump(Streams *streams, Stream *stream)
{
    if (stream->gone || stream->too_slow) return false;
    StreamSent sent = advance(streams, stream);
    if (sent == STREAM_WAITS) sent = beat(streams, stream);
    switch (sent) {
    case STREAM_WHOLE:
        streams->options.traffic->items[stream->spec.kind]++;
        free(stream->abandoned);
        stream->abandoned = NULL;
        stream->looked = 0;
        return true;
    case STREAM_MORE: return true;
    case STREAM_GONE: leave_alone(streams, stream); return false;
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
