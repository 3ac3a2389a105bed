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

static struct PaceLine *line_of(Pace *pace, const Sender *sender)
{
    return &pace->lines[quota_pool(&sender->who)];
}

static void spend(struct PaceLine *line, size_t pool, double now)
{
    line->spent = fmax(line->spent, now - SPAN) + 1.0 / rates[pool];
}

static bool is_of(const Held *held, const Sender *sender)
{
    return held->sender.size == sender->size && !memcmp(held->sender.identity, sender->identity, sender->size);
}

static bool has_id(Held *held, const ProtobufCBinaryData *id)
{
    const ProtobufCBinaryData own = request_id(zmq_msg_data(&held->frame), zmq_msg_size(&held->frame));
    return own.len == id->len && !memcmp(own.data, id->data, id->len);
}

static Held *take(Pace *pace, Held **at)
{
    Held *held = *at;
    *at = held->next;
    held->next = NULL;
    pace->n--;
    return held;
}

void held_free(Held *held)
{
    if (!held) return;
    zmq_msg_close(&held->frame);
    free(held);
}

void pace_done(Pace *pace)
{
    for (size_t pool = 0; pool < POOLS; pool++)
        while (pace->lines[pool].first) held_free(take(pace, &pace->lines[pool].first));
}

bool pace_admits(Pace *pace, const Sender *sender, double now)
{
    struct PaceLine *line = line_of(pace, sender);
    if (line->first || line->spent > now) return false;
    spend(line, quota_pool(&sender->who), now);
    return true;
}

bool pace_is_full(const Pace *pace, const Sender *sender)
{
    size_t n = 0;
    for (const Held *held = pace->lines[quota_pool(&sender->who)].first; held; held = held->next)
        n += is_of(held, sender);
    return n >= PACE_EACH || pace->n >= PACE_ALL;
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

bool pace_hold(Pace *pace, const Sender *sender, zmq_msg_t *frame, uint64_t parts, double deadline)
{
    struct PaceLine *line = line_of(pace, sender);
    if (zmq_msg_size(frame) > PACE_BYTES || pace_is_full(pace, sender)) return false;
    Held *held = malloc(sizeof *held);
    if (!held) return false;
    *held = (Held){.turn = next_turn(line, sender), .sender = *sender, .parts = parts, .deadline = deadline};
    zmq_msg_init(&held->frame);
    zmq_msg_move(&held->frame, frame);
    insert(line, held);
    pace->n++;
    return true;
}

static Held **find_late(struct PaceLine *line, double now)
{
    for (Held **at = &line->first; *at; at = &(*at)->next)
        if ((*at)->deadline <= now) return at;
    return NULL;
}

Held *pace_next(Pace *pace, bool hurried, double now)
{
    for (size_t pool = 0; pool < POOLS; pool++) {
        struct PaceLine *line = &pace->lines[pool];
        Held **late = find_late(line, now);
        if (late) return take(pace, late);
        if (!line->first || !(hurried || line->spent <= now)) continue;
        if (!hurried) spend(line, pool, now);
        line->turn = line->first->turn;
        return take(pace, &line->first);
    }
    return NULL;
}

Held *pace_pull(Pace *pace, const Sender *sender, const ProtobufCBinaryData *id)
{
    for (size_t pool = 0; pool < POOLS; pool++)
        for (Held **at = &pace->lines[pool].first; *at; at = &(*at)->next)
            if (sender ? is_of(*at, sender) : has_id(*at, id)) return take(pace, at);
    return NULL;
}

void pace_forget(Pace *pace, int fd)
{
    for (size_t pool = 0; pool < POOLS; pool++)
        for (Held **at = &pace->lines[pool].first; *at;) {
            if (zmq_msg_get(&(*at)->frame, ZMQ_SRCFD) == fd) held_free(take(pace, at));
            else at = &(*at)->next;
        }
}

double pace_due(const Pace *pace)
{
    double due = INFINITY;
    for (size_t pool = 0; pool < POOLS; pool++) {
        const struct PaceLine *line = &pace->lines[pool];
        if (line->first) due = fmin(due, line->spent);
        for (const Held *held = line->first; held; held = held->next) due = fmin(due, held->deadline);
    }
    return due;
}
