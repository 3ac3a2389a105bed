/* SPDX-License-Identifier: BSD-3-Clause */
/* The dialogue of a stream with its daemon. Only subscribe and resume are waited for; what else goes wrong comes as an item that ends, or as a
 * refusal between items. */
#include "client/lib/call.h"
#include "client/lib/stream_inside.h"
#include "common/wire/frame.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double reply_s = 15;                      /* the state is looked at between two steps */
static const uint64_t CREDIT_MOST = UINT64_C(1) << 30; /* bytes: what is granted beyond counts as that much */

bool stream_is_lossless(const MnsStream *stream)
{
    return stream->wish->delivery == MENISCUS__DELIVERY__LOSSLESS;
}

static MnsStatus send(MnsStream *stream, Meniscus__StreamRequest *request, uint8_t id[MNS_REQUEST_ID_SIZE],
                      MnsError *error)
{
    MnsStatus status = call_random(id, MNS_REQUEST_ID_SIZE, error);
    if (status) return status;
    request->has_major = request->has_id = true;
    request->major = MENISCUS__PROTOCOL_VERSION__PROTOCOL_MAJOR;
    request->id = (ProtobufCBinaryData){.len = MNS_REQUEST_ID_SIZE, .data = id};
    const size_t size = meniscus__stream_request__get_packed_size(request);
    status = wire_check_size(size, FRAME_STREAM, error);
    uint8_t *packed = status ? NULL : malloc(size);
    if (packed) meniscus__stream_request__pack(request, packed);
    request->id = (ProtobufCBinaryData){.len = 0}; /* which was borrowed */
    if (status) return status;
    if (!packed) return mns_fail(error, MNS_E_MEMORY, "no memory for a request of %zu bytes", size);
    status = wire_send(&stream->wire, packed, size, error);
    free(packed);
    return status;
}

MnsStatus stream_tell(MnsStream *stream, Meniscus__StreamRequest *request, MnsError *error)
{
    uint8_t id[MNS_REQUEST_ID_SIZE];
    return send(stream, request, id, error);
}

void stream_unsubscribe(MnsStream *stream, uint64_t number)
{
    Meniscus__StreamRequest request = MENISCUS__STREAM_REQUEST__INIT;
    Meniscus__Unsubscribe what = MENISCUS__UNSUBSCRIBE__INIT;
    if (!stream->wire.connected) return; /* the daemon finds out */
    what.has_stream = true;
    what.stream = number;
    request.command_case = MENISCUS__STREAM_REQUEST__COMMAND_UNSUBSCRIBE;
    request.unsubscribe = &what;
    stream_tell(stream, &request, NULL);
}

MnsStatus stream_grant(MnsStream *stream, uint64_t open, MnsError *error)
{
    if (open > CREDIT_MOST) open = CREDIT_MOST;
    if (stream->open >= open || !stream->attached || !stream->wire.connected) return MNS_OK;
    Meniscus__StreamRequest request = MENISCUS__STREAM_REQUEST__INIT;
    Meniscus__Credit credit = MENISCUS__CREDIT__INIT;
    credit.has_stream = credit.has_bytes = true;
    credit.stream = stream->number;
    credit.bytes = open - stream->open;
    request.command_case = MENISCUS__STREAM_REQUEST__COMMAND_CREDIT;
    request.credit = &credit;
    const MnsStatus status = stream_tell(stream, &request, error);
    if (!status) stream->open = open;
    return status;
}

/* A code that is absent reads as OK, and is none. */
static bool accepts(const Meniscus__StreamReply *reply)
{
    return reply->has_code && reply->code == MENISCUS__CODE__OK;
}

/* Wait for the reply to a request of this id. *ret = NULL: the connection was made anew meanwhile. */
static MnsStatus await(MnsStream *stream, const uint8_t id[MNS_REQUEST_ID_SIZE], double deadline,
                       Meniscus__StreamMessage **ret, MnsError *error)
{
    for (;;) {
        Frames frames;
        const MnsStatus status = wire_receive(&stream->wire, deadline, &frames, error);
        *ret = NULL;
        if (status || !frames.n) return status;
        *ret = meniscus__stream_message__unpack(NULL, zmq_msg_size(&frames.frame[0]), zmq_msg_data(&frames.frame[0]));
        frames_done(&frames);
        const Meniscus__StreamReply *reply =
            *ret && (*ret)->what_case == MENISCUS__STREAM_MESSAGE__WHAT_REPLY ? (*ret)->reply : NULL;
        if (reply && reply->id.len == MNS_REQUEST_ID_SIZE && !memcmp(reply->id.data, id, MNS_REQUEST_ID_SIZE))
            return MNS_OK;
        if (!*ret)
            return mns_fail(error, MNS_E_VERSION, "cannot read what %s sends; is it a meniscusd of this version?",
                            stream->wire.endpoint);
        /* Of a stream that is over, or an answer nobody waits for: what was begun for nobody is ended. */
        if (reply && accepts(reply) && reply->has_chunk_bytes) stream_unsubscribe(stream, reply->stream);
        meniscus__stream_message__free_unpacked(*ret, NULL);
        if (wire_clock() > deadline)
            return mns_fail(error, MNS_E_TIMEOUT, "no answer from %s in time", stream->wire.endpoint);
    }
}

/* Send, and again over each new connection, until there is a reply, which may be a refusal. What was not answered by the deadline may still be:
 * that answer is waited for when this is called again, as another stream would be one more than is read. */
static MnsStatus ask(MnsStream *stream, Meniscus__StreamRequest *request, double deadline,
                     Meniscus__StreamMessage **ret, MnsError *error)
{
    MnsStatus status = MNS_OK;
    for (*ret = NULL; !status && !*ret;) {
        if (!stream->asking || stream->asked_over != stream->wire.connections) {
            stream->asking = false;
            status = send(stream, request, stream->asked, error);
            if (status) return status;
            stream->asking = true;
            stream->asked_over = stream->wire.connections;
        }
        status = await(stream, stream->asked, deadline, ret, error);
    }
    if (status != MNS_E_TIMEOUT) stream->asking = false;
    return status;
}

static MnsStatus refusal(const Meniscus__StreamReply *reply, MnsError *error)
{
    if (!reply->has_code)
        return mns_fail(error, MNS_E_VERSION, "the reply says neither yes nor no; is it a meniscusd of this version?");
    const char *text = reply->message && *reply->message ? reply->message : "the daemon refused without a reason";
    return mns_fail_at(error, call_status(reply->code, reply->reason), reply->path ? reply->path : "", "%s", text);
}

/* --- subscribe ---------------------------------------------------------------------------------------------------------- */

static const char *text(const char *maybe)
{
    return maybe ? maybe : "";
}

/* Where a LOSSLESS stream goes on: within a file, if the line of the cursor is that of this file; else bytes that came before are passed over
 * when they come again. */
static Meniscus__Cursor *place(const MnsStream *stream, Meniscus__Cursor *to)
{
    const MnsCursor *cursor = &stream->cursor;
    if (!stream_is_lossless(stream) || !stream->has_cursor) return NULL;
    const bool within = *stream->file.name && !strcmp(stream->file.name, cursor->file);
    meniscus__cursor__init(to);
    to->has_line = true;
    to->line = cursor->line;
    if (stream->wish->what_case == MENISCUS__SUBSCRIBE__WHAT_PROBES) {
        to->has_row = true;
        to->row = cursor->row;
        return to;
    }
    to->file = (char *)(within ? stream->file.name : cursor->file);
    to->has_offset = true;
    to->offset = within ? stream->file.got : cursor->offset;
    return to;
}

static MnsStatus keep_columns(MnsStream *stream, Meniscus__StreamMessage *message, MnsError *error)
{
    const Meniscus__StreamReply *reply = message->reply;
    MnsStreamColumn *columns = calloc(reply->n_columns + 1, sizeof *columns);
    if (!columns) {
        meniscus__stream_message__free_unpacked(message, NULL);
        return mns_fail(error, MNS_E_MEMORY, "no memory for %zu columns", reply->n_columns);
    }
    for (size_t k = 0; k < reply->n_columns; k++) {
        const Meniscus__StreamColumn *from = reply->columns[k];
        columns[k] = (MnsStreamColumn){.name = text(from->name),
                                       .unit = text(from->unit),
                                       .type = text(from->type),
                                       .components = from->has_components ? from->components : 1};
    }
    free(stream->columns);
    if (stream->reply_message) meniscus__stream_message__free_unpacked(stream->reply_message, NULL);
    stream->columns = columns;
    stream->reply_message = message;
    return MNS_OK;
}

static MnsStatus subscribe(MnsStream *stream, double deadline, MnsError *error)
{
    Meniscus__StreamRequest request = MENISCUS__STREAM_REQUEST__INIT;
    Meniscus__Cursor from;
    Meniscus__StreamMessage *answer;
    stream_start_over(stream);
    stream->wish->from = place(stream, &from);
    stream->wish->has_credit = true;
    stream->wish->credit = stream->window;
    request.command_case = MENISCUS__STREAM_REQUEST__COMMAND_SUBSCRIBE;
    request.subscribe = stream->wish;
    MnsStatus status = ask(stream, &request, deadline, &answer, error);
    stream->wish->from = NULL;
    if (status) return status;
    const Meniscus__StreamReply *reply = answer->reply;
    if (!accepts(reply)) {
        status = refusal(reply, error);
        meniscus__stream_message__free_unpacked(answer, NULL);
        const bool passes = status == MNS_E_UNAVAILABLE || status == MNS_E_LIMIT || status == MNS_E_STATE;
        if (stream->reply_message && !passes) stream->over = *error;
        return status;
    }
    stream->number = reply->stream;
    stream->chunk = reply->has_chunk_bytes && reply->chunk_bytes ? reply->chunk_bytes : 1;
    stream->open = stream->window;
    stream->heard = false;
    stream->attached = true;
    return keep_columns(stream, answer, error);
}

/* --- resume ------------------------------------------------------------------------------------------------------------- */

/* False in *ret: there is no such stream any more, or not this item. */
static MnsStatus resume(MnsStream *stream, double deadline, bool *ret, MnsError *error)
{
    Meniscus__StreamRequest request = MENISCUS__STREAM_REQUEST__INIT;
    Meniscus__ResumeStream from = MENISCUS__RESUME_STREAM__INIT;
    Meniscus__StreamMessage *answer;
    const uint64_t rest = stream->parts.first ? stream->parts.size - stream->parts.got : 0;
    const uint64_t credit = stream->window + rest + rest / stream->chunk * 512;
    from.has_stream = from.has_credit = true;
    from.has_sequence = from.has_offset = stream->heard;
    from.stream = stream->number;
    from.sequence = stream->sequence;
    from.offset = stream->offset;
    from.credit = credit < CREDIT_MOST ? credit : CREDIT_MOST;
    request.command_case = MENISCUS__STREAM_REQUEST__COMMAND_RESUME;
    request.resume = &from;
    const MnsStatus status = ask(stream, &request, deadline, &answer, error);
    if (status) return status;
    const Meniscus__StreamReply *reply = answer->reply;
    *ret = accepts(reply);
    const bool same = reply->sequence == stream->sequence && reply->offset == stream->offset;
    if (*ret && !same) stream_drop_parts(stream);
    if (*ret) {
        stream->open = from.credit;
        stream->attached = true;
    }
    meniscus__stream_message__free_unpacked(answer, NULL);
    return MNS_OK;
}

MnsStatus stream_attach(MnsStream *stream, double deadline, MnsError *error)
{
    bool resumed = false;
    const double until = fmin(deadline, wire_clock() + reply_s);
    const bool again = stream->reply_message;
    MnsStatus status = stream->number ? resume(stream, until, &resumed, error) : MNS_OK;
    if (!status && !resumed) status = subscribe(stream, until, error);
    if (status == MNS_E_TIMEOUT && until < deadline)
        return mns_fail(error, MNS_E_UNAVAILABLE, "%s is open, but nobody answers there", stream->wire.endpoint);
    if (!status) {
        stream->connections = stream->wire.connections;
        stream->stats.reconnects += again;
    }
    return status;
}

void stream_sign_off(MnsStream *stream, double deadline)
{
    Meniscus__StreamMessage *answer = NULL;
    uint64_t number = stream->attached || stream->asking ? stream->number : 0;
    if (stream->asking && !number) {
        await(stream, stream->asked, deadline, &answer, NULL);
        if (answer && accepts(answer->reply)) number = answer->reply->stream;
        if (answer) meniscus__stream_message__free_unpacked(answer, NULL);
    }
    if (number) stream_unsubscribe(stream, number);
}
