/* SPDX-License-Identifier: BSD-3-Clause */
/* Orders that wait until the run is at a step or a time. */
#include "run/agenda.h"

#include <math.h>
#include <string.h>

MnsStatus agenda_add(Agenda *agenda, Order *order, MnsError *error)
{
    Order **end = &agenda->first;
    QuotaUse use = {0};
    for (const Order *other = agenda->first; other; other = other->next) quota_count(&use, &order->who, &other->who);
    const bool accepted = order->lineage && agenda->n < AGENDA_LIMIT; /* before a crash, perhaps by other quotas */
    const MnsStatus status = accepted ? MNS_OK : quota_check(QUOTA_SCHEDULED, &order->who, &use, error);
    if (status) return status;
    while (*end) end = &(*end)->next;
    order->next = NULL;
    *end = order;
    agenda->n++;
    return MNS_OK;
}

static Order *take(Agenda *agenda, bool (*is)(const Order *, const void *), const void *arg)
{
    for (Order **list = &agenda->first; *list; list = &(*list)->next) {
        Order *order = *list;
        if (!is(order, arg)) continue;
        *list = order->next;
        agenda->n--;
        return order;
    }
    return NULL;
}

static bool is_due(const Order *order, const void *arg)
{
    const MnsProgress *now = arg;
    return now->step >= order->at.step || now->t >= order->at.t;
}

static bool has_id(const Order *order, const void *arg)
{
    return !memcmp(order->id, arg, ORDER_ID);
}

static bool is_late(const Order *order, const void *arg)
{
    return order->deadline < *(const double *)arg;
}

static bool is_any(const Order *order, const void *arg)
{
    (void)order, (void)arg;
    return true;
}

const Order *agenda_due(const Agenda *agenda, MnsProgress now)
{
    const Order *order = agenda->first;
    while (order && !is_due(order, &now)) order = order->next;
    return order;
}

Order *agenda_take_due(Agenda *agenda, MnsProgress now)
{
    return take(agenda, is_due, &now);
}

Order *agenda_take_id(Agenda *agenda, const uint8_t id[static ORDER_ID])
{
    return take(agenda, has_id, id);
}

Order *agenda_take_late(Agenda *agenda, double now)
{
    return take(agenda, is_late, &now);
}

Order *agenda_take_first(Agenda *agenda)
{
    return take(agenda, is_any, NULL);
}

double agenda_limit(const Agenda *agenda)
{
    double limit = INFINITY;
    for (const Order *order = agenda->first; order; order = order->next) limit = fmin(limit, order->at.t);
    return limit;
}

double agenda_deadline(const Agenda *agenda)
{
    double deadline = INFINITY;
    for (const Order *order = agenda->first; order; order = order->next) deadline = fmin(deadline, order->deadline);
    return deadline;
}
