/* SPDX-License-Identifier: BSD-3-Clause */
/* Orders on their way to the runner: two lists, so that pause, stop and cancel overtake everything queued but the load that a daemon begins with. In the plain
 * one connections take turns. */
#include "run/mailbox.h"

#include <math.h>
#include <string.h>
#include <time.h>

/* A file takes a whole turn of its connection, as do so many other orders. */
enum { TURN = 64 };

void mailbox_init(Mailbox *box, size_t limit)
{
    *box = (Mailbox){.limit = limit};
    pthread_mutex_init(&box->lock, NULL);
    pthread_condattr_t attributes;
    pthread_condattr_init(&attributes);
    pthread_condattr_setclock(&attributes, CLOCK_MONOTONIC);
    pthread_cond_init(&box->filled, &attributes);
    pthread_condattr_destroy(&attributes);
}

void mailbox_done(Mailbox *box)
{
    pthread_cond_destroy(&box->filled);
    pthread_mutex_destroy(&box->lock);
}

static void append(Order **list, Order *order)
{
    order->next = NULL;
    while (*list) list = &(*list)->next;
    *list = order;
}

/* Behind all whose turn is the same or earlier: whoever has nothing waiting has its turn now, and what a connection sends beyond that comes after what
 * it takes to do the rest of it. So they stay in the order in which they came but where somebody wants many at once. */
static void line_up(Mailbox *box, Order *order)
{
    Order **place = &box->plain;
    order->turn = box->turn;
    order->heads = true;
    for (const Order *before = box->plain; before; before = before->next) {
        const uint64_t after = before->turn + (before->writes ? TURN : 1);
        if (before->from != order->from) continue;
        order->heads = false;
        if (order->turn < after) order->turn = after;
    }
    while (*place && (*place)->turn / TURN <= order->turn / TURN) place = &(*place)->next;
    order->next = *place;
    *place = order;
}

typedef struct Waiting {
    QuotaUse all, looks; /* looks: of all, those that only look */
} Waiting;

static void count_waiting(const Order *list, const Order *order, Waiting *ret)
{
    for (; list; list = list->next) {
        quota_count(&ret->all, &order->who, &list->who);
        if (list->looks) quota_count(&ret->looks, &order->who, &list->who);
    }
}

/* Those of this machine have the box to themselves, as far as it goes; for those with a key there is room besides. What is urgent finds room for as many again. */
static MnsStatus check_share(const Mailbox *box, const Order *order, MnsError *error)
{
    Waiting waiting = {.all = {0}};
    count_waiting(box->plain, order, &waiting);
    count_waiting(box->urgent, order, &waiting);
    QuotaUse all = waiting.all;
    if (order->urgent) all = (QuotaUse){all.own / 2, all.pool / 2};
    const bool local = quota_pool(&order->who) == POOL_LOCAL;
    const bool crowded = order->looks && !order->urgent && waiting.looks.pool >= box->limit / 2;
    if (local && (crowded || all.pool >= box->limit))
        return mns_fail(error, MNS_E_LIMIT, "%zu %s are waiting already; send this one again later",
                        crowded ? box->limit / 2 : box->limit, crowded ? "questions" : "commands");
    const MnsStatus status = quota_check(QUOTA_COMMANDS, &order->who, &all, error);
    if (status || !order->looks || order->urgent) return status;
    return quota_check(QUOTA_QUESTIONS, &order->who, &waiting.looks, error);
}

static bool wants_too_much(const Mailbox *box, const Order *order)
{
    size_t n = 0;
    for (const Order *other = box->plain; order->writes && other; other = other->next)
        n += other->writes && other->from == order->from;
    return n >= MAILBOX_FILES;
}

static MnsStatus check_room(const Mailbox *box, const Order *order, MnsError *error)
{
    if (!wants_too_much(box, order)) return check_share(box, order, error);
    return mns_fail(error, MNS_E_LIMIT,
                    "%d commands of this connection that write a file are waiting already; wait for an answer, then "
                    "send this one again",
                    MAILBOX_FILES);
}

MnsStatus mailbox_post(Mailbox *box, Order *order, MnsError *error)
{
    pthread_mutex_lock(&box->lock);
    const MnsStatus status = check_room(box, order, error);
    if (!status) {
        order->number = ++box->posted;
        if (order->urgent) append(&box->urgent, order);
        else line_up(box, order);
        box->n++;
        pthread_cond_signal(&box->filled);
    }
    pthread_mutex_unlock(&box->lock);
    return status;
}

/* Out of its list, with the lock held. Of the plain ones the next of the same connection becomes its first, which is behind it. */
static Order *take(Mailbox *box, Order **list)
{
    Order *order = *list, *next = order->next;
    *list = next;
    box->n--;
    while (order->heads && next && next->from != order->from) next = next->next;
    if (order->heads && next) next->heads = true;
    return order;
}

/* With the lock held: the first, but none that must wait, and of its connection none then. NULL if there is none. */
static Order *first(Mailbox *box, bool looks, bool writes)
{
    Order **list = &box->plain;
    if (box->urgent && !(box->plain && box->plain->leads)) return take(box, &box->urgent);
    while (*list && (!(*list)->heads || (looks && (*list)->looks) || (writes && (*list)->writes)))
        list = &(*list)->next;
    if (!*list) return NULL;
    box->turn = (*list)->turn;
    return take(box, list);
}

Order *mailbox_take_but(Mailbox *box, bool looks, bool writes)
{
    pthread_mutex_lock(&box->lock);
    Order *order = first(box, looks, writes);
    pthread_mutex_unlock(&box->lock);
    return order;
}

Order *mailbox_take(Mailbox *box, double until)
{
    pthread_mutex_lock(&box->lock);
    const struct timespec moment = {.tv_sec = (time_t)fmin(until, 1e15),
                                    .tv_nsec = isfinite(until) ? (long)(1e9 * (until - floor(until))) : 0};
    int waited = 0;
    while (!box->urgent && !box->plain && !box->woken && !waited && until > 0)
        waited = pthread_cond_timedwait(&box->filled, &box->lock, &moment);
    box->woken = false;
    Order *order = first(box, false, false);
    pthread_mutex_unlock(&box->lock);
    return order;
}

void mailbox_wake(Mailbox *box)
{
    pthread_mutex_lock(&box->lock);
    box->woken = true;
    pthread_cond_signal(&box->filled);
    pthread_mutex_unlock(&box->lock);
}

static bool ends_in(Order *list, const uint8_t *id, bool recovering)
{
    bool found = false;
    for (Order *order = list; order; order = order->next) {
        if (!order->ends || (recovering && !order->meanwhile)) continue;
        if (!order->ends_any && memcmp(order->ends_id, id, ORDER_ID)) continue;
        found = order->ended = true;
    }
    return found;
}

bool mailbox_ends(Mailbox *box, const uint8_t id[static ORDER_ID], bool recovering)
{
    pthread_mutex_lock(&box->lock);
    const bool urgent = ends_in(box->urgent, id, recovering), plain = ends_in(box->plain, id, recovering);
    pthread_mutex_unlock(&box->lock);
    return urgent || plain;
}

static bool has_id(const Order *order, const void *arg)
{
    return !memcmp(order->id, arg, ORDER_ID);
}

static bool is_motion(const Order *order, const void *arg)
{
    return order->motion && order->number < *(const uint64_t *)arg;
}

static Order *take_first(Mailbox *box, Order **list, bool (*is)(const Order *, const void *), const void *arg)
{
    while (*list && !is(*list, arg)) list = &(*list)->next;
    return *list ? take(box, list) : NULL;
}

static Order *remove_first(Mailbox *box, bool (*is)(const Order *, const void *), const void *arg)
{
    pthread_mutex_lock(&box->lock);
    Order *order = take_first(box, &box->plain, is, arg);
    if (!order) order = take_first(box, &box->urgent, is, arg);
    pthread_mutex_unlock(&box->lock);
    return order;
}

static bool is_meanwhile(const Order *order, const void *arg)
{
    (void)arg;
    return order->meanwhile;
}

static bool is_late(const Order *order, const void *arg)
{
    return order->deadline < *(const double *)arg;
}

Order *mailbox_take_meanwhile(Mailbox *box)
{
    return remove_first(box, is_meanwhile, NULL);
}

Order *mailbox_remove_late(Mailbox *box, double now)
{
    return remove_first(box, is_late, &now);
}

Order *mailbox_remove(Mailbox *box, const uint8_t id[static ORDER_ID])
{
    return remove_first(box, has_id, id);
}

Order *mailbox_remove_motion(Mailbox *box, uint64_t before)
{
    return remove_first(box, is_motion, &before);
}
