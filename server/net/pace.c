/* SPDX-License-Identifier: BSD-3-Clause */
/* A bucket of credit for each pool of clients, and fair queueing by connection for those that find it empty. */
#include "net/pace.h"

#include "proto/frame.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double SPAN = 0.25; /* [s] whose questions may come at once */

static const int rates[POOLS] = {
    [POOL_VIEWERS] = PACE_VIEWERS, [POOL_STEERERS] = PACE_STEERERS, [POOL_LOCAL] = PACE_LOCAL};

void pace_spend(double *spent, int rate, double now)
{
    *spent = fmax(*spent, now - SPAN) + 1.0 / rate;
}

static bool has_credit(const struct PaceLine *line, double now)
{
    return line->spent <= now;
}

static bool is_of(const Held *held, const Sender *sender)
{
    return held->sender.size == sender->size && !memcmp(held->sender.identity, sender->identity, sender->size);
}

static bool has_id(const Held *held, const ProtobufCBinaryData *id)
{
    return held->id_size == id->len && !memcmp(held->id, id->data, id->len);
}

static Held *take(Held **at)
{
    Held *held = *at;
    *at = held->next;
    held->next = NULL;
    return held;
}

void pace_done(Pace *pace)
{
    for (size_t pool = 0; pool < POOLS; pool++)
        while (pace->lines[pool].first) {
            Held *held = take(&pace->lines[pool].first);
            request_free(held->request);
            free(held);
        }
}

bool pace_admits(Pace *pace, const Sender *sender, double now)
{
    const QuotaPool pool = quota_pool(&sender->who);
    struct PaceLine *line = &pace->lines[pool];
    if (line->first || !has_credit(line, now)) return false;
    pace_spend(&line->spent, rates[pool], now);
    return true;
}

/* One more than the last of the same connection, so that each has one question in every round. */
static uint64_t next_turn(const struct PaceLine *line, const Sender *sender)
{
    uint64_t last = line->turn;
    for (const Held *held = line->first; held; held = held->next)
        if (is_of(held, sender)) last = held->turn;
    return last + 1;
}

static void insert(struct PaceLine *line, Held *held)
{
    Held **at = &line->first;
    while (*at && (*at)->turn <= held->turn) at = &(*at)->next;
    held->next = *at;
    *at = held;
}

MnsStatus pace_hold(Pace *pace, const Sender *sender, ProtobufCBinaryData id, Meniscus__Request *request,
                    const MnsError *why, MnsError *error)
{
    struct PaceLine *line = &pace->lines[quota_pool(&sender->who)];
    QuotaUse use = {0};
    for (const Held *held = line->first; held; held = held->next) quota_count(&use, &sender->who, &held->sender.who);
    const MnsStatus status = quota_check(QUOTA_QUESTIONS, &sender->who, &use, error);
    if (status) return status;
    Held *held = malloc(sizeof *held);
    if (!held) return mns_fail(error, MNS_E_MEMORY, "no memory for the question");
    *held = (Held){.turn = next_turn(line, sender), .sender = *sender, .request = request};
    held->id_size = id.len < PACE_ID ? id.len : PACE_ID;
    if (id.len) memcpy(held->id, id.data, held->id_size);
    if (why) held->why = *why;
    insert(line, held);
    return MNS_OK;
}

Held *pace_next(Pace *pace, bool hurried, double now)
{
    for (size_t pool = 0; pool < POOLS; pool++) {
        struct PaceLine *line = &pace->lines[pool];
        if (!line->first || !(hurried || has_credit(line, now))) continue;
        if (!hurried) pace_spend(&line->spent, rates[pool], now);
        line->turn = line->first->turn;
        return take(&line->first);
    }
    return NULL;
}

Held *pace_pull(Pace *pace, const Sender *sender, const ProtobufCBinaryData *id)
{
    for (size_t pool = 0; pool < POOLS; pool++)
        for (Held **at = &pace->lines[pool].first; *at; at = &(*at)->next)
            if (sender ? is_of(*at, sender) : has_id(*at, id)) return take(at);
    return NULL;
}

double pace_due(const Pace *pace)
{
    double due = INFINITY;
    for (size_t pool = 0; pool < POOLS; pool++)
        if (pace->lines[pool].first) due = fmin(due, pace->lines[pool].spent);
    return due;
}
