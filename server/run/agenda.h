/* SPDX-License-Identifier: BSD-3-Clause */
/* Orders that wait until the run is at a step or a time, in the order in which they were accepted. (When outputs are due is in schedule.h.) */
#ifndef RUN_AGENDA_H
#define RUN_AGENDA_H

#include "run/quota.h"
#include <meniscus/sim.h>

/* Room for all that run/quota.c lets clients schedule. */
enum { AGENDA_LIMIT = 112 };

/* Begins as zeros. The orders are linked by their `next`. */
typedef struct Agenda {
    Order *first;
    size_t n;
} Agenda;

/* MNS_E_LIMIT: as many are waiting as its identity may have, and the order stays the caller's. */
MnsStatus agenda_add(Agenda *agenda, Order *order, MnsError *error);

/* The one that agenda_take_due() would take, which stays in. */
const Order *agenda_due(const Agenda *agenda, MnsProgress now);

/* Each takes one out, the first that was accepted; NULL if there is none: one whose moment has come, at this boundary; that of an id; one
 * whose deadline lies before now; whichever. */
Order *agenda_take_due(Agenda *agenda, MnsProgress now);
Order *agenda_take_id(Agenda *agenda, const uint8_t id[static ORDER_ID]);
Order *agenda_take_late(Agenda *agenda, double now);
Order *agenda_take_first(Agenda *agenda);

/* The earliest time that one of them is for, to which a step is shortened [s]; INFINITY: none. */
double agenda_limit(const Agenda *agenda);

/* The earliest deadline, of clock_now(); INFINITY: none. */
double agenda_deadline(const Agenda *agenda);

#endif
