/* SPDX-License-Identifier: BSD-3-Clause */
/* What clients of streams ask for. */
#include "net/streams_inside.h"

#include "base/clock.h"
#include "common/wire/frame.h"
#include "net/pace.h"
#include "net/peers.h"
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <zmq.h>

enum { AT_ONCE = 256 };

/* Who has sent a request, and its answer as far as it is known. */
typedef struct Asked {
    uint8_t identity[STREAM_IDENTITY];
    size_t size;
    Who who;
    int fd;
    Meniscus__StreamReply reply;
    MnsError error;
} Asked;

/* --- answers ------------------------------------------------------------------------------------------------------------ */

static void answer(Streams *streams, Asked *asked, MnsStatus status)
{
    Meniscus__StreamReply *reply = &asked->reply;
    reply->has_code = reply->has_daemon_epoch = true;
    reply->code = code_of(status);
    reply->daemon_epoch = streams->options.epoch;
    if (status) {
        streams->options.traffic->refused++;
        reply->message = asked->error.text;
        reply->path = asked->error.path[0] ? asked->error.path : NULL;
        reply->reason = (char *)mns_status_name(status);
    }
    stream_post_reply(&streams->post, asked->identity, asked->size, reply);
}

static MnsStatus fail_unknown(Asked *asked)
{
    return mns_fail_at(&asked->error, MNS_E_NOT_FOUND, "stream",
                       "there is no such stream on this connection: it is over, or of an earlier start of the daemon; "
                       "resume one of another connection, or subscribe");
}

/* --- subscribe ---------------------------------------------------------------------------------------------------------- */

static const char *numpy_of(const PackingHow *how, MnsType type)
{
    return type == MNS_F64 && how->exactness == PACKING_F32 ? "<f4" : selection_numpy(type);
}

static void describe_column(const StreamSpec *spec, size_t k, const MnsCase *c, Meniscus__StreamColumn *ret)
{
    const bool field = spec->kind == STREAM_FIELDS;
    const MnsFieldInfo *info = &mns_fields()[field ? spec->columns[k] : 0];
    const MnsProbe *probe = field ? NULL : &c->probes[spec->columns[k]];
    meniscus__stream_column__init(ret);
    ret->name = (char *)(field ? info->name : probe->name);
    ret->unit = (char *)(field ? info->unit : mns_probe_unit(probe));
    ret->type = (char *)numpy_of(&spec->how[field ? k : 0], field ? info->type : MNS_F64);
    ret->has_components = true;
    ret->components = field && info->components > 1 ? (uint32_t)c->dim : 1;
}

static void answer_subscribe(Streams *streams, Asked *asked, const Stream *stream)
{
    Meniscus__StreamColumn columns[MNS_MAX_PROBES], *list[MNS_MAX_PROBES];
    const StreamSpec *spec = &stream->spec;
    for (size_t k = 0; k < spec->n; k++) {
        describe_column(spec, k, streams->now.document->c, &columns[k]);
        list[k] = &columns[k];
    }
    asked->reply.n_columns = spec->n;
    asked->reply.columns = list;
    asked->reply.has_stream = asked->reply.has_chunk_bytes = true;
    asked->reply.stream = stream->id;
    asked->reply.chunk_bytes = (uint32_t)spec->chunk;
    answer(streams, asked, MNS_OK);
}

static bool is_from(const Stream *stream, const Asked *asked)
{
    return stream->identity_size == asked->size && !memcmp(stream->identity, asked->identity, asked->size);
}

/* One connection leaves room for others. */
static MnsStatus check_share(const Streams *streams, Asked *asked)
{
    size_t n = 0;
    for (const Stream *s = streams->first; s; s = s->next) n += is_from(s, asked);
    if (n < STREAMS_EACH) return MNS_OK;
    return mns_fail(
        &asked->error, MNS_E_LIMIT,
        "this connection has %d streams, and one has no more; end one, or take others over another connection",
        STREAMS_EACH);
}

/* The stream without a connection whose bytes moved first: of this key, or of all in its pool. NULL if there is none. */
static Stream *oldest_gone(const Streams *streams, const Who *who, bool own)
{
    Stream *oldest = NULL;
    for (Stream *s = streams->first; s; s = s->next) {
        const bool counts = own ? quota_same(&s->who, who) : quota_pool(&s->who) == quota_pool(who);
        if (counts && s->gone && (!oldest || s->moved < oldest->moved)) oldest = s;
    }
    return oldest;
}

/* use: zeros, counted here. */
static MnsStatus check_key(const Streams *streams, Asked *asked, QuotaUse *use)
{
    for (const Stream *s = streams->first; s; s = s->next) quota_count(use, &asked->who, &s->who);
    return quota_check(QUOTA_STREAMS, &asked->who, use, &asked->error);
}

/* Streams whose connection is gone make room for new ones of the same key, and of the same pool. */
static MnsStatus make_place(Streams *streams, Asked *asked)
{
    QuotaUse use = {0};
    MnsStatus status = check_share(streams, asked);
    if (status) return status;
    status = check_key(streams, asked, &use);
    if (!status) return MNS_OK;
    const bool own = use.own >= quota_each(QUOTA_STREAMS, quota_pool(&asked->who));
    Stream *oldest = oldest_gone(streams, &asked->who, own);
    if (!oldest) return status;
    streams_drop(streams, oldest, NULL);
    return MNS_OK;
}

/* For one item at once. The run is asked for it when there is credit: a shot that nobody takes would keep its room from others. */
void streams_open_first(Streams *streams, Stream *stream)
{
    Wish wish = stream->spec.wish;
    wish.when = (When){.every_steps = UINT64_MAX};
    stream->first = tap_open(run_tap(streams->options.run), stream->generation, &wish);
    stream->looked = 0;
}

static MnsStatus join(Streams *streams, Stream *stream, const Meniscus__Subscribe *asked, MnsError *error)
{
    Tap *tap = run_tap(streams->options.run);
    const StreamSpec *spec = &stream->spec;
    if (!stream_is_latest(spec->kind)) return MNS_OK;
    const MnsStatus status = channel_join(&streams->channels, tap, asked, stream, error);
    if (status) return status;
    if (!stream->channel->feed && !stream->beside) stream->channel->due = streams->told;
    if (spec->first && stream->channel->feed) streams_open_first(streams, stream);
    return MNS_OK;
}

static MnsStatus subscribe(Streams *streams, Asked *asked, const Meniscus__Subscribe *request)
{
    MnsError *error = &asked->error;
    Stream *stream = calloc(1, sizeof *stream);
    Flight *flight = stream ? flight_new() : NULL;
    if (!flight) {
        free(stream);
        return mns_fail(error, MNS_E_MEMORY, "no memory for another stream");
    }
    streams_refresh(streams); /* who was just told of a load may ask before the news of it is here */
    MnsStatus status = subscribe_read(request, &streams->now, streams->limit, &stream->spec, error);
    stream->generation = streams->now.generation;
    if (!status) status = make_place(streams, asked);
    if (!status) status = join(streams, stream, request, error);
    if (status) {
        flight_leave(flight);
        free(stream);
        return status;
    }
    while (!stream->id) getrandom(&stream->id, sizeof stream->id, 0);
    stream->flight = flight;
    memcpy(stream->identity, asked->identity, asked->size);
    stream->identity_size = asked->size;
    stream->who = asked->who;
    stream->fd = asked->fd;
    stream->file.fd = -1;
    stream->window = stream_post_window(stream->spec.chunk);
    stream->cursor = stream->spec.from;
    stream->moved = clock_now();
    subscription_begin(&stream->books, stream->spec.chunk, stream->spec.credit,
                       stream->channel ? stream->channel->due : 0);
    stream->next = streams->first;
    streams->first = stream;
    streams->options.traffic->open[stream->spec.kind]++;
    if (stream->spec.kind == STREAM_SERIES) run_follow(streams->options.run, 1);
    answer_subscribe(streams, asked, stream);
    return MNS_OK;
}

/* --- the others --------------------------------------------------------------------------------------------------------- */

/* Go back to where the bytes ended that came, as far as the item is still there: false if it is not, or another is meant. A client that names none had none under
 * way: so if the item begun last was sent whole there is nothing to go back to, and else it begins anew. */
static bool go_back(Stream *stream, const Meniscus__ResumeStream *request)
{
    Subscription *books = &stream->books;
    const bool item = stream->item || stream->file.fd >= 0;
    if (request->has_sequence) return item && subscription_resume(books, request->sequence, request->offset);
    if (stream_is_latest(stream->spec.kind)) return false;
    return !books->under_way || (item && subscription_resume(books, books->sequence, 0));
}

/* The bytes of a file that come twice would be summed twice: those that come anew from the first one are summed anew, and of others there is no sum. */
static void restart_sum(Stream *stream)
{
    XXH64_freeState(stream->file.sum);
    stream->file.sum = NULL;
    if (stream->file.fd < 0 || !stream->books.under_way || stream->books.offset) return;
    stream->file.sum = XXH64_createState();
    if (stream->file.sum) XXH64_reset(stream->file.sum, 0);
}

static MnsStatus resume(Streams *streams, Asked *asked, const Meniscus__ResumeStream *request)
{
    if (!request->has_sequence && request->offset)
        return mns_fail_at(&asked->error, MNS_E_INVALID, "offset",
                           "offset %" PRIu64 " is of no item, as the request has no sequence: give the sequence of the "
                           "item that was under way, or leave out both",
                           request->offset);
    Stream *stream = streams_find(streams, request->stream, NULL, 0);
    if (!stream) return fail_unknown(asked);
    MnsStatus status = is_from(stream, asked) ? MNS_OK : check_share(streams, asked);
    if (!status && !quota_same(&stream->who, &asked->who)) status = check_key(streams, asked, &(QuotaUse){0});
    if (status) return status;
    const bool kept = go_back(stream, request);
    if (!kept && !stream_is_latest(stream->spec.kind))
        return mns_fail_at(&asked->error, MNS_E_STATE, "sequence",
                           "the item begun last is number %" PRIu64 ", of which %" PRIu64
                           " bytes were sent: this is beyond them, or another; subscribe with `from`",
                           stream->books.sequence, stream->books.offset);
    if (!kept) subscription_cancel(&stream->books, 0);
    restart_sum(stream);
    memcpy(stream->identity, asked->identity, asked->size);
    stream->identity_size = asked->size;
    stream->who = asked->who;
    stream->fd = asked->fd;
    stream->gone = false;
    if (stream->first_due) streams_open_first(streams, stream);
    stream->first_due = false;
    stream->moved = clock_now();
    stream->books.credit = 0;
    subscription_grant(&stream->books, request->credit);
    asked->reply.has_stream = asked->reply.has_sequence = asked->reply.has_offset = true;
    asked->reply.stream = stream->id;
    asked->reply.sequence = stream->books.sequence + !(kept && (stream->books.under_way || request->has_sequence));
    asked->reply.offset = kept ? request->offset : 0;
    answer(streams, asked, MNS_OK);
    return MNS_OK;
}

static MnsStatus cancel(Streams *streams, Asked *asked, const Meniscus__CancelItem *request)
{
    Stream *stream = streams_find(streams, request->stream, asked->identity, asked->size);
    if (!stream) return fail_unknown(asked);
    if (stream->spec.kind == STREAM_SERIES)
        return mns_fail_at(&asked->error, MNS_E_STATE, "stream",
                           "no row of a series can be left out; unsubscribe, and subscribe with `from` later");
    if (!subscription_cancel(&stream->books, request->sequence)) return MNS_OK; /* it is whole, or over, already */
    streams->options.traffic->cancelled[stream->spec.kind]++;
    stream_post_end(&streams->post, stream, false, MNS_E_INTERRUPTED, "cancelled", "cancelled, as asked");
    stream_close_item(stream);
    return MNS_OK;
}

static MnsStatus unsubscribe(Streams *streams, Asked *asked, const Meniscus__Unsubscribe *request)
{
    Stream *stream = streams_find(streams, request->stream, asked->identity, asked->size);
    if (!stream) return fail_unknown(asked);
    streams_drop(streams, stream, NULL);
    asked->reply.has_stream = true;
    asked->reply.stream = request->stream;
    answer(streams, asked, MNS_OK);
    return MNS_OK;
}

static MnsStatus grant(Streams *streams, Asked *asked, const Meniscus__Credit *request)
{
    Stream *stream = streams_find(streams, request->stream, asked->identity, asked->size);
    if (!stream) return fail_unknown(asked);
    subscription_grant(&stream->books, request->bytes);
    return MNS_OK;
}

static MnsStatus serve(Streams *streams, Asked *asked, const Meniscus__StreamRequest *request)
{
    switch (request->command_case) {
    case MENISCUS__STREAM_REQUEST__COMMAND_SUBSCRIBE: return subscribe(streams, asked, request->subscribe);
    case MENISCUS__STREAM_REQUEST__COMMAND_CREDIT: return grant(streams, asked, request->credit);
    case MENISCUS__STREAM_REQUEST__COMMAND_CANCEL: return cancel(streams, asked, request->cancel);
    case MENISCUS__STREAM_REQUEST__COMMAND_UNSUBSCRIBE: return unsubscribe(streams, asked, request->unsubscribe);
    default: return resume(streams, asked, request->resume);
    }
}

/* --- frames ------------------------------------------------------------------------------------------------------------- */

static Meniscus__StreamRequest *read_frame(zmq_msg_t *frame, uint64_t parts, MnsError *why)
{
    Meniscus__StreamRequest *request = NULL;
    MnsStatus status =
        parts == 1 ? MNS_OK : mns_fail(why, MNS_E_INVALID, "a request is one frame; these are %" PRIu64, parts);
    if (!status) status = stream_request_read(zmq_msg_data(frame), zmq_msg_size(frame), &request, why);
    if (!status) return request;
    stream_request_free(request);
    return NULL;
}

static bool is_credit(const Meniscus__StreamRequest *request)
{
    return request && request->command_case == MENISCUS__STREAM_REQUEST__COMMAND_CREDIT;
}

/* request: NULL: it could not be read, asked->error says why. */
static void hear(Streams *streams, Asked *asked, const Sender *from, zmq_msg_t *frame,
                 const Meniscus__StreamRequest *request)
{
    asked->size = from->size;
    asked->who = from->who;
    asked->fd = zmq_msg_get(frame, ZMQ_SRCFD);
    memcpy(asked->identity, from->identity, from->size);
    asked->reply = (Meniscus__StreamReply)MENISCUS__STREAM_REPLY__INIT;
    asked->reply.id = request_id(zmq_msg_data(frame), zmq_msg_size(frame));
    asked->reply.has_id = asked->reply.id.len > 0;
    MnsStatus status = request ? MNS_OK : asked->error.status;
    const bool heard = stream_post_is_heard(&streams->post, from->identity, from->size), credit = is_credit(request);
    if (!status && (heard || credit)) status = serve(streams, asked, request);
    if (!heard && (status || !credit)) streams->options.traffic->unheard++;
    else if (status) answer(streams, asked, status);
}

static void hear_held(Streams *streams, Held *held)
{
    Asked asked;
    if (!held) return;
    Meniscus__StreamRequest *request = read_frame(&held->frame, held->parts, &asked.error);
    hear(streams, &asked, &held->sender, &held->frame, request);
    stream_request_free(request);
    held_free(held);
}

void streams_take(Streams *streams, Sender *from, zmq_msg_t *frame, uint64_t parts)
{
    Asked asked;
    Held *held;
    from->came = clock_now();
    Meniscus__StreamRequest *request = read_frame(frame, parts, &asked.error);
    const bool credit = is_credit(request);
    if (credit || !streams->steps || pace_admits(&streams->pace, from, from->came)) {
        while (!credit && (held = pace_pull(&streams->pace, from, NULL))) hear_held(streams, held);
        hear(streams, &asked, from, frame, request);
    } else if (zmq_msg_size(frame) > FRAME_STREAM ||
               pace_hold(&streams->pace, from, frame, parts, INFINITY, &asked.error))
        hear(streams, &asked, from, frame, NULL);
    stream_request_free(request);
}

/* A message arrives whole: who it is from, and its parts, of which there should be one. */
static bool receive_one(Streams *streams)
{
    Sender from = {.size = 0};
    zmq_msg_t first, rest;
    uint64_t parts = 0;
    const int size = zmq_recv(streams->socket, from.identity, sizeof from.identity, ZMQ_DONTWAIT);
    if (size < 0) return false;
    from.size = (size_t)size < sizeof from.identity ? (size_t)size : sizeof from.identity;
    zmq_msg_init(&first);
    for (bool more = true; more; parts++) {
        zmq_msg_t *to = parts ? &rest : &first;
        if (parts) zmq_msg_init(&rest);
        if (zmq_msg_recv(to, streams->socket, ZMQ_DONTWAIT) < 0) break;
        more = zmq_msg_more(to);
        if (parts) zmq_msg_close(&rest);
    }
    streams_see_off(streams);
    peers_heard(zmq_msg_get(&first, ZMQ_SRCFD));
    if (parts && access_who(streams->options.access, &first, &from.who)) streams_take(streams, &from, &first, parts);
    zmq_msg_close(&first);
    return true;
}

void streams_receive(Streams *streams)
{
    for (Held *held; (held = pace_next(&streams->pace, !streams->steps, clock_now()));) hear_held(streams, held);
    for (int k = 0; k < AT_ONCE && receive_one(streams); k++) continue;
}
