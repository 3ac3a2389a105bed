/* SPDX-License-Identifier: BSD-3-Clause */
/* What is answered to a request: what comes of it, that it waits for its time, that it is refused and why; and the same again if it is sent again. */
#include "net/answers.h"

#include "base/clock.h"
#include "common/wire/frame.h"
#include "net/handlers.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

/* How long [s] a refusal is kept: longer than clients take to ask again for an answer that was lost. */
enum { REFUSED_S = 60 };

MnsStatus answers_init(Answers *answers, void *socket, Run *run, uint64_t epoch, MnsError *error)
{
    outgoing_init(&answers->outgoing, socket, epoch);
    answers->run = run;
    answers->epoch = epoch;
    answers->replied = -INFINITY;
    answers->deeds = ledger_new(LEDGER_DEEDS, LEDGER_DEEDS_BYTES);
    answers->questions = ledger_new(LEDGER_OTHERS, LEDGER_OTHERS_BYTES);
    answers->refusals = ledger_new(LEDGER_OTHERS, LEDGER_OTHERS_BYTES);
    if (answers->deeds && answers->questions && answers->refusals) return MNS_OK;
    return mns_fail(error, MNS_E_MEMORY, "no memory for answers");
}

void answers_done(Answers *answers)
{
    outgoing_done(&answers->outgoing);
    ledger_free(answers->deeds);
    ledger_free(answers->questions);
    ledger_free(answers->refusals);
}

/* --- replies ----------------------------------------------------------------------------------------------------------- */

static void send_parts(Answers *answers, const Recipient *to, size_t n, void *const parts[], const size_t sizes[])
{
    answers->replied = clock_now();
    if (outgoing_send(&answers->outgoing, to, n, parts, sizes))
        pace_forget(answers->pace, to->identity, to->identity_size);
}

static Recipient recipient(const Sender *sender, ProtobufCBinaryData id)
{
    return (Recipient){sender->identity, sender->size, &sender->who, id.len == ORDER_ID ? id.data : NULL};
}

void answers_refuse(Answers *answers, const Sender *sender, ProtobufCBinaryData id, const MnsError *why)
{
    Meniscus__Reply reply = MENISCUS__REPLY__INIT;
    const Recipient to = recipient(sender, id);
    answers->traffic->refused++;
    answers->traffic->denied += why->status == MNS_E_DENIED;
    run_status(answers->run, &answers->status);
    reply.has_id = id.len > 0;
    reply.id = id;
    reply.has_code = reply.has_daemon_epoch = reply.has_state = true;
    reply.code = code_of(why->status);
    reply.message = (char *)why->text;
    reply.path = why->path[0] ? (char *)why->path : NULL;
    reply.reason = (char *)mns_status_name(why->status);
    reply.daemon_epoch = answers->epoch;
    reply.state = (Meniscus__State)answers->status.state;
    const size_t size = meniscus__reply__get_packed_size(&reply);
    uint8_t *packed = malloc(size + 1);
    if (packed) meniscus__reply__pack(&reply, packed);
    send_parts(answers, &to, 1, (void *[]){packed}, &size);
}

/* Returns NULL if data is NULL, or if memory runs out. */
static void *copy_of(const void *data, size_t size)
{
    void *copy = data ? malloc(size + 1) : NULL;
    if (copy) memcpy(copy, data, size);
    return copy;
}

/* Send the reply to one of its senders: the original or a copy. packed: NULL if there was no memory for it. One whose share of unread replies is used up gets a
 * refusal in place of arrays. */
static void send_to(Answers *answers, Exchange *exchange, const Sender *sender, uint8_t *packed, size_t size,
                    bool original)
{
    const Recipient to = {sender->identity, sender->size, &sender->who, exchange->order.id};
    MnsError why;
    if (packed && exchange->reply->n_arrays && outgoing_check(&answers->outgoing, &to, &why)) {
        answers_refuse(answers, sender, (ProtobufCBinaryData){ORDER_ID, exchange->order.id}, &why);
        if (original) free(packed);
        return;
    }
    void *parts[OUTGOING_PARTS] = {original ? packed : copy_of(packed, size)};
    const size_t n = parts[0] ? exchange->reply->n_arrays : 0;
    size_t sizes[OUTGOING_PARTS] = {size};
    for (size_t k = 0; k < n; k++) {
        parts[1 + k] = original ? exchange->arrays[k] : copy_of(exchange->arrays[k], exchange->sizes[k]);
        sizes[1 + k] = exchange->sizes[k];
        if (original) exchange->arrays[k] = NULL;
    }
    send_parts(answers, &to, 1 + n, parts, sizes);
}

static void send_exchange(Answers *answers, Exchange *exchange, uint8_t *packed, size_t size)
{
    const size_t n = exchange->n_senders;
    for (size_t k = 0; k < n; k++) send_to(answers, exchange, &exchange->senders[k], packed, size, k + 1 == n);
    if (!n) free(packed);
}

static Ledger *ledger_of(const Answers *answers, const Handler *handler)
{
    return handler && handler->traits & LOOKS ? answers->questions : answers->deeds;
}

/* packed: NULL: not to be remembered. */
static void note_reply(Answers *answers, const Exchange *exchange, const uint8_t *packed, size_t size)
{
    Ledger *ledger = ledger_of(answers, exchange->handler);
    const bool refused = ledger == answers->deeds && exchange->order.status && !exchange->order.begun;
    ledger_end(ledger, exchange, refused ? NULL : packed, size);
    if (refused && packed) ledger_recall(answers->refusals, exchange->order.id, exchange->command, packed, size);
}

void answers_reply(Answers *answers, Exchange *exchange)
{
    if (!exchange->sealed) exchange_seal(exchange);
    if (exchange->order.status) answers->traffic->refused++;
    answers->state = exchange->order.state;
    const Meniscus__Reply *reply = exchange->reply;
    const bool whole = reply && reply->has_id; /* else memory ran out; without its id no client can tell which it is */
    const size_t size = whole ? meniscus__reply__get_packed_size(reply) : 0;
    uint8_t *packed = whole ? malloc(size + 1) : NULL;
    if (packed) meniscus__reply__pack(reply, packed);
    note_reply(answers, exchange, packed && !reply->n_arrays ? packed : NULL, size);
    send_exchange(answers, exchange, packed, size);
    exchange_free(exchange);
}

/* --- requests ---------------------------------------------------------------------------------------------------------- */

/* To one who does not wait for what comes of a scheduled command. */
static void acknowledge(Answers *answers, const Exchange *exchange, const Sender *sender)
{
    Meniscus__Reply reply = MENISCUS__REPLY__INIT;
    char text[sizeof exchange->order.notice.text + 16];
    const Recipient to = {sender->identity, sender->size, &sender->who, exchange->order.id};
    snprintf(text, sizeof text, "scheduled: %s", exchange->order.notice.text);
    run_status(answers->run, &answers->status);
    reply.has_id = reply.has_code = reply.has_daemon_epoch = reply.has_state = true;
    reply.id = (ProtobufCBinaryData){.len = ORDER_ID, .data = (uint8_t *)exchange->order.id};
    reply.code = MENISCUS__CODE__OK;
    reply.message = text;
    reply.daemon_epoch = answers->epoch;
    reply.state = (Meniscus__State)answers->status.state;
    reply.has_step = reply.has_time = true;
    reply.step = answers->status.progress.step;
    reply.time = answers->status.progress.t;
    reply.has_case_version = answers->status.version > 0;
    reply.case_version = answers->status.version;
    const size_t size = meniscus__reply__get_packed_size(&reply);
    uint8_t *packed = malloc(size + 1);
    if (packed) meniscus__reply__pack(&reply, packed);
    send_parts(answers, &to, 1, (void *[]){packed}, &size);
}

void answers_scheduled(Answers *answers, Exchange *exchange)
{
    size_t n = 0;
    exchange->scheduled = true;
    for (size_t k = 0; k < exchange->n_senders; k++) {
        if (exchange->senders[k].no_wait) acknowledge(answers, exchange, &exchange->senders[k]);
        else exchange->senders[n++] = exchange->senders[k];
    }
    exchange->n_senders = n;
}

/* One more who wants the reply. Connections that were lost are among them, so there is an end: the first is told to ask again. */
static void add_sender(Answers *answers, Exchange *exchange, const Sender *sender, ProtobufCBinaryData id)
{
    MnsError why;
    if (exchange->n_senders == EXCHANGE_SENDERS) {
        mns_fail(&why, MNS_E_LIMIT, "the command is under way, and %d others wait for the same reply; ask again later",
                 EXCHANGE_SENDERS);
        answers_refuse(answers, &exchange->senders[0], id, &why);
        memmove(exchange->senders, exchange->senders + 1, --exchange->n_senders * sizeof *exchange->senders);
    }
    exchange->senders[exchange->n_senders++] = *sender;
}

/* The same request again: its reply again, or when it comes. */
static void repeat(Answers *answers, const Sender *sender, ProtobufCBinaryData id, const LedgerEntry *entry)
{
    if (entry->under_way && entry->under_way->scheduled && sender->no_wait) {
        acknowledge(answers, entry->under_way, sender);
        return;
    }
    if (entry->under_way) {
        add_sender(answers, entry->under_way, sender, id);
        return;
    }
    const Recipient to = recipient(sender, id);
    send_parts(answers, &to, 1, (void *[]){copy_of(entry->reply, entry->size)}, &entry->size);
}

static MnsStatus begin(Answers *answers, Exchange *exchange, MnsError *error)
{
    const Meniscus__Request *request = exchange->request;
    const Handler *handler = handler_find(request->command_case);
    const Sender *sender = exchange->n_senders ? &exchange->senders[0] : NULL;
    const double came = sender ? sender->came : clock_now();
    if (request->has_deadline_ms) exchange->order.deadline = came + 1e-3 * (double)request->deadline_ms;
    if (handler && handler->traits & LARGE && sender) {
        const Recipient to = {sender->identity, sender->size, &sender->who, exchange->order.id};
        const MnsStatus status = outgoing_check(&answers->outgoing, &to, error);
        if (status) return status;
    }
    const bool noted = handler && handler->where == AT_STEP;
    Ledger *ledger = ledger_of(answers, handler);
    MnsStatus status = noted ? ledger_begin(ledger, exchange, error) : MNS_OK;
    if (status) return status;
    status = handle(answers->run, exchange, error);
    if (status && noted) ledger_end(ledger, exchange, NULL, 0);
    return status;
}

/* Of a request by its id. A refusal has done nothing: it is kept for who has not heard it and asks again at once, and then tried anew. */
static bool find_answer(Answers *answers, ProtobufCBinaryData id, LedgerEntry *ret)
{
    ledger_forget(answers->refusals, clock_now() - REFUSED_S);
    return ledger_find(answers->deeds, id.data, ret) || ledger_find(answers->questions, id.data, ret) ||
           ledger_find(answers->refusals, id.data, ret);
}

/* Who may not give a command is not told what came of it either. */
static void repeat_or_refuse(Answers *answers, const Sender *sender, const Who *who, ProtobufCBinaryData id,
                             const LedgerEntry *entry, const Meniscus__Request *request)
{
    MnsError error;
    const bool same = !entry->command || entry->command == exchange_command(request);
    const MnsStatus status = handler_check_role(handler_find(request->command_case), who, &error);
    if (!status && same) {
        repeat(answers, sender, id, entry);
        return;
    }
    if (!status)
        mns_fail(&error, MNS_E_INVALID,
                 "the id is that of another request, which was answered or is under way; each needs an id of its own");
    answers_refuse(answers, sender, id, &error);
}

void answers_take(Answers *answers, const Sender *from, const Who *who, ProtobufCBinaryData id,
                  Meniscus__Request *request, const Lineage *lineage)
{
    LedgerEntry entry;
    MnsError error;
    Sender sender = *from;
    sender.no_wait = request->has_no_wait && request->no_wait;
    if (find_answer(answers, request->id, &entry)) {
        repeat_or_refuse(answers, &sender, who, id, &entry, request);
        request_free(request);
        return;
    }
    Exchange *exchange = exchange_new(request, who);
    if (!exchange) {
        mns_fail(&error, MNS_E_MEMORY, "no memory for the command; nothing was done");
        answers_refuse(answers, &sender, id, &error);
        return;
    }
    exchange->epoch = answers->epoch;
    exchange->streams = &answers->traffic->streams;
    exchange->order.lineage = lineage;
    exchange->order.begun = lineage != NULL;
    exchange->order.from = sender.size ? XXH64(sender.identity, sender.size, 0) : 0;
    if (sender.size) exchange->senders[exchange->n_senders++] = sender;
    if (!begin(answers, exchange, &error)) return;
    answers_refuse(answers, &sender, id, &error);
    exchange_free(exchange);
}

void answers_recall(Answers *answers, const Meniscus__Request *request, const uint8_t *reply, size_t size)
{
    ledger_recall(answers->deeds, request->id.data, exchange_command(request), reply, size);
}

void answers_take_alone(Answers *answers, const Who *who, Meniscus__Request *request, const Lineage *lineage)
{
    const Sender gone = {.size = 0};
    answers_take(answers, &gone, who, request->id, request, lineage);
}
