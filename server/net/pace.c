/* SPDX-License-Identifier: BSD-3-Clause */
/* A bucket of credit for each pool of clients, and fair queueing by connection for those that find it empty. */
#include "net/pace.h"

#include "common/wire/frame.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double SPAN = 0.25; /* [s] whose questions may come at once */

static const int rates[POOLS] = {
    [POOL_VIEWERS] = PACE_VIEWERS, [POOL_STEERERS] = PACE_STEERERS, [POOL_LOCAL] = PACE_LOCAL};

/* What one connection has waiting: never nothing. */
typedef struct PaceQueue {
    struct PaceQueue *next;
    Held *first, *last;
    size_t n, bytes;
} PaceQueue;

static struct PaceLine *line_of(Pace *pace, const Sender *sender)
{
    return &pace->lines[quota_pool(&sender->who)];
}

static void spend(struct PaceLine *line, size_t pool, double now)
{
    line->spent = fmax(line->spent, now - SPAN) + 1.0 / rates[pool];
}

static bool is_of(const PaceQueue *queue, const uint8_t identity[], size_t size)
{
    const Sender *own = &queue->first->sender;
    return own->size == size && !memcmp(own->identity, identity, size);
}

static bool has_id(Held *held, const ProtobufCBinaryData *id)
{
    const ProtobufCBinaryData own = request_id(zmq_msg_data(&held->frame), zmq_msg_size(&held->frame));
    return own.len == id->len && !memcmp(own.data, id->data, id->len);
}

/* --- queues ------------------------------------------------------------------------------------------------------------- */

/* Where the queue of a connection hangs, or would. */
static PaceQueue **queue_of(struct PaceLine *line, const uint8_t identity[], size_t size)
{
    PaceQueue **at = &line->first;
    while (*at && !is_of(*at, identity, size)) at = &(*at)->next;
    return at;
}

static void unhang(struct PaceLine *line, PaceQueue **at)
{
    PaceQueue *queue = *at;
    *at = queue->next;
    line->queues--;
    free(queue);
}

/* Take a question out of the queue that hangs here; before: the one before it, NULL: it is the first. */
static Held *take(struct PaceLine *line, PaceQueue **at, Held *before)
{
    PaceQueue *queue = *at;
    Held **link = before ? &before->next : &queue->first, *held = *link;
    const size_t size = zmq_msg_size(&held->frame);
    *link = held->next;
    if (!held->next) queue->last = before;
    held->next = NULL;
    queue->n--, line->n--;
    queue->bytes -= size, line->bytes -= size;
    if (!queue->n) unhang(line, at);
    return held;
}

/* The first of the queue that hangs here, which then is the last of its line. */
static Held *take_turn(struct PaceLine *line, PaceQueue **at)
{
    PaceQueue *queue = *at, **end = at;
    const bool stays = queue->n > 1;
    Held *held = take(line, at, NULL);
    if (!stays) return held;
    *at = queue->next;
    while (*end) end = &(*end)->next;
    *end = queue;
    queue->next = NULL;
    return held;
}

static void forget(struct PaceLine *line, PaceQueue **at)
{
    for (size_t n = (*at)->n; n > 0; n--) held_free(take(line, at, NULL));
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
        while (pace->lines[pool].first) forget(&pace->lines[pool], &pace->lines[pool].first);
}

/* --- who comes ---------------------------------------------------------------------------------------------------------- */

bool pace_rests(const Pace *pace, double now)
{
    return pace->read > now;
}

void pace_note_read(Pace *pace, double now)
{
    pace->read = fmax(pace->read, now - 1) + 1.0 / PACE_READ;
}

bool pace_admits(Pace *pace, const Sender *sender, double now)
{
    struct PaceLine *line = line_of(pace, sender);
    if (line->first || line->spent > now) return false;
    spend(line, quota_pool(&sender->who), now);
    return true;
}

/* Has a connection as much as it may of what it has, or of a pool that has as much as it may? */
static bool is_full(size_t own, size_t each, size_t all, size_t pool, size_t queues)
{
    return own >= each || (all >= pool && own * queues >= pool);
}

/* queue: NULL: it has none yet. */
static MnsStatus check(const struct PaceLine *line, const PaceQueue *queue, MnsError *error)
{
    if (!queue || (!is_full(queue->n, PACE_EACH, line->n, PACE_POOL, line->queues) &&
                   !is_full(queue->bytes, PACE_EACH_BYTES, line->bytes, PACE_POOL_BYTES, line->queues)))
        return MNS_OK;
    return mns_fail(
        error, MNS_E_LIMIT,
        "%zu questions of this connection (%zu KiB), and %zu of others, wait for their answers, as the run takes "
        "steps; ask again when some have come",
        queue->n, queue->bytes >> 10, line->n - queue->n);
}

/* NULL: no memory. */
static PaceQueue *hang(struct PaceLine *line, PaceQueue **at)
{
    PaceQueue *queue = calloc(1, sizeof *queue);
    if (!queue) return NULL;
    if (!line->first) line->soonest = INFINITY;
    *at = queue;
    line->queues++;
    return queue;
}

static void append(struct PaceLine *line, PaceQueue *queue, Held *held)
{
    const size_t size = zmq_msg_size(&held->frame);
    *(queue->last ? &queue->last->next : &queue->first) = held;
    queue->last = held;
    queue->n++, line->n++;
    queue->bytes += size, line->bytes += size;
    line->soonest = fmin(line->soonest, held->deadline);
}

MnsStatus pace_hold(Pace *pace, const Sender *sender, zmq_msg_t *frame, uint64_t parts, double deadline,
                    MnsError *error)
{
    struct PaceLine *line = line_of(pace, sender);
    PaceQueue **at = queue_of(line, sender->identity, sender->size);
    const MnsStatus status = check(line, *at, error);
    if (status) return status;
    Held *held = malloc(sizeof *held);
    PaceQueue *queue = *at ? *at : hang(line, at);
    if (!held || !queue) {
        if (queue && !queue->n) unhang(line, at);
        free(held);
        return mns_fail(error, MNS_E_MEMORY, "no memory for a question that waits");
    }
    *held = (Held){.sender = *sender, .parts = parts, .deadline = deadline};
    zmq_msg_init(&held->frame);
    zmq_msg_move(&held->frame, frame);
    append(line, queue, held);
    return MNS_OK;
}

/* --- who is next -------------------------------------------------------------------------------------------------------- */

/* One that waits no longer; NULL: none, and then the soonest deadline is known again. */
static Held *take_late(struct PaceLine *line, double now)
{
    double soonest = INFINITY;
    if (!line->first || line->soonest > now) return NULL;
    for (PaceQueue **at = &line->first; *at; at = &(*at)->next) {
        Held *before = NULL;
        for (Held *held = (*at)->first; held; before = held, held = held->next) {
            if (held->deadline <= now) return take(line, at, before);
            soonest = fmin(soonest, held->deadline);
        }
    }
    line->soonest = soonest;
    return NULL;
}

Held *pace_next(Pace *pace, bool hurried, double now)
{
    for (size_t pool = 0; pool < POOLS; pool++) {
        struct PaceLine *line = &pace->lines[pool];
        Held *late = take_late(line, now);
        if (late) return late;
        if (!line->first || !(hurried || line->spent <= now)) continue;
        if (!hurried) spend(line, pool, now);
        return take_turn(line, &line->first);
    }
    return NULL;
}

static Held *pull_by_id(struct PaceLine *line, const ProtobufCBinaryData *id)
{
    for (PaceQueue **at = &line->first; *at; at = &(*at)->next) {
        Held *before = NULL;
        for (Held *held = (*at)->first; held; before = held, held = held->next)
            if (has_id(held, id)) return take(line, at, before);
    }
    return NULL;
}

Held *pace_pull(Pace *pace, const Sender *sender, const ProtobufCBinaryData *id)
{
    for (size_t pool = 0; pool < POOLS; pool++) {
        struct PaceLine *line = &pace->lines[pool];
        PaceQueue **at = sender ? queue_of(line, sender->identity, sender->size) : NULL;
        if (at && *at) return take(line, at, NULL);
        Held *held = id ? pull_by_id(line, id) : NULL;
        if (held) return held;
    }
    return NULL;
}

void pace_forget(Pace *pace, const uint8_t identity[], size_t size)
{
    for (size_t pool = 0; pool < POOLS; pool++) {
        PaceQueue **at = queue_of(&pace->lines[pool], identity, size);
        if (*at) forget(&pace->lines[pool], at);
    }
}

/* Those of the queue that hangs here that came through this descriptor. Does the queue stay? */
static bool forget_of(struct PaceLine *line, PaceQueue **at, int fd)
{
    PaceQueue *queue = *at;
    Held *before = NULL;
    for (size_t left = queue->n; left > 0; left--) {
        Held *held = before ? before->next : queue->first;
        if (zmq_msg_get(&held->frame, ZMQ_SRCFD) == fd) held_free(take(line, at, before));
        else before = held;
    }
    return before != NULL;
}

void pace_forget_fd(Pace *pace, int fd)
{
    for (size_t pool = 0; pool < POOLS; pool++)
        for (PaceQueue **at = &pace->lines[pool].first; *at;)
            if (forget_of(&pace->lines[pool], at, fd)) at = &(*at)->next;
}

double pace_due(const Pace *pace)
{
    double due = INFINITY;
    for (size_t pool = 0; pool < POOLS; pool++) {
        const struct PaceLine *line = &pace->lines[pool];
        if (line->first) due = fmin(due, fmin(line->spent, line->soonest));
    }
    return due;
}
