/* SPDX-License-Identifier: BSD-3-Clause */
/* Orders on their way to the runner: two lists, so that pause, stop and cancel overtake everything queued but the load that a daemon begins with. */
#include "run/mailbox.h"

#include <math.h>
#include <string.h>
#include <time.h>

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

MnsStatus mailbox_post(Mailbox *box, Order *order, MnsError *error)
{
    pthread_mutex_lock(&box->lock);
    const bool crowded = order->looks && !order->urgent && box->looking >= box->limit / 2;
    const bool full = crowded || box->n >= (order->urgent ? 2 * box->limit : box->limit);
    if (!full) {
        box->looking += order->looks;
        order->number = ++box->posted;
        append(order->urgent ? &box->urgent : &box->plain, order);
        box->n++;
        pthread_cond_signal(&box->filled);
    }
    pthread_mutex_unlock(&box->lock);
    if (!full) return MNS_OK;
    return mns_fail(error, MNS_E_LIMIT, "%zu %s are waiting already; send this one again later",
                    crowded ? box->limit / 2 : box->limit, crowded ? "questions" : "commands");
}

/* With the lock held. */
static Order *first(Mailbox *box)
{
    const bool led = box->plain && box->plain->leads;
    Order **list = box->urgent && !led ? &box->urgent : &box->plain, *order = *list;
    if (!order) return NULL;
    *list = order->next;
    box->n--;
    box->looking -= order->looks;
    return order;
}

Order *mailbox_take_but(Mailbox *box, bool looks, bool writes)
{
    pthread_mutex_lock(&box->lock);
    const Order *plain = box->plain;
    const bool waits = plain && ((looks && plain->looks) || (writes && plain->writes));
    Order *order = box->urgent || !waits ? first(box) : NULL;
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
    Order *order = first(box);
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

static Order *unlink_first(Order **list, bool (*is)(const Order *, const void *), const void *arg)
{
    for (; *list; list = &(*list)->next) {
        Order *order = *list;
        if (!is(order, arg)) continue;
        *list = order->next;
        return order;
    }
    return NULL;
}

static Order *remove_first(Mailbox *box, bool (*is)(const Order *, const void *), const void *arg)
{
    pthread_mutex_lock(&box->lock);
    Order *order = unlink_first(&box->plain, is, arg);
    if (!order) order = unlink_first(&box->urgent, is, arg);
    if (order) box->n--;
    if (order) box->looking -= order->looks;
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
