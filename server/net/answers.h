/* SPDX-License-Identifier: BSD-3-Clause */
/* Answers to requests, each of which is carried out once however often it is sent. Of one thread. */
#ifndef NET_ANSWERS_H
#define NET_ANSWERS_H

#include "net/exchange.h"
#include "net/ledger.h"
#include "net/outgoing.h"
#include "net/pace.h"
#include "net/publish.h"

/* Begins as zeros. */
typedef struct Answers {
    Run *run;
    Outgoing outgoing;
    Pace *pace;       /* borrowed; what ended connections have waiting there is dropped */
    Traffic *traffic; /* borrowed; counted in */
    /* Of what changed or wrote something, or is about to; of what looked; of what was refused. */
    Ledger *deeds, *questions, *refusals;
    RunStatus status; /* looked at last: room that is there when there is no memory */
    double replied;   /* clock_now() of the latest reply */
    RunState state;   /* of the run, as the latest reply or note has it */
    uint64_t epoch;
} Answers;

/* socket: a ROUTER of ZeroMQ; run: borrowed. MNS_OK or MNS_E_MEMORY; answers_done() in any case. */
MnsStatus answers_init(Answers *answers, void *socket, Run *run, uint64_t epoch, MnsError *error);

/* When ZeroMQ has let go of all replies. */
void answers_done(Answers *answers);

/* Refuse what has no order. id: as far as it is known. */
void answers_refuse(Answers *answers, const Sender *sender, ProtobufCBinaryData id, const MnsError *why);

/* Take a request: carry it out, or post it to the run, or answer as before if it was there before. It is taken over.
 *  id       as its frame has it
 *  lineage  of the run in which it had set out; borrowed; NULL: it has just come */
void answers_take(Answers *answers, const Sender *from, const Who *who, ProtobufCBinaryData id,
                  Meniscus__Request *request, const Lineage *lineage);

/* As from a connection that has ended; a client that sends it again gets the reply. */
void answers_take_alone(Answers *answers, const Who *who, Meniscus__Request *request, const Lineage *lineage);

/* Remember what was replied to a request, which has an id, before this daemon was started. */
void answers_recall(Answers *answers, const Meniscus__Request *request, const uint8_t *reply, size_t size);

/* The order of an exchange has come back: reply, remember, free it. */
void answers_reply(Answers *answers, Exchange *exchange);

/* An exchange is scheduled, and would outlive a crash: tell those who do not wait for what comes of it. */
void answers_scheduled(Answers *answers, Exchange *exchange);

#endif
