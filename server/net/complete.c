/* SPDX-License-Identifier: BSD-3-Clause */
/* What replies say besides that a command was done. */
#include "net/complete.h"

#include "net/here.h"
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The entry keeps what was asked for, as a restart on another machine may have it. */
static void note_threads(Exchange *x)
{
    char text[80];
    const Order *order = &x->order;
    const unsigned wanted = order->document->c->threads;
    if (wanted <= order->threads || x->reply->message) return;
    snprintf(text, sizeof text, "of %u threads asked for, %u are used", wanted, order->threads);
    x->reply->message = strdup(text);
}

/* The values as this change left them, whatever has been changed since. */
MnsStatus complete_set(Exchange *x, MnsError *error)
{
    const Meniscus__Set *set = x->request->set;
    const char *paths[ENTRIES_MAX];
    for (size_t k = 0; k < set->n_assignments; k++) {
        paths[k] = set->assignments[k]->path;
        if (!strcmp(paths[k], "threads")) note_threads(x);
    }
    return here_entries(x->order.document, x, set->n_assignments, paths, error);
}

MnsStatus complete_file(Exchange *x, MnsError *error)
{
    Meniscus__OutputFile *file = malloc(sizeof *file);
    if (!file) return mns_fail(error, MNS_E_MEMORY, "no memory for the reply");
    meniscus__output_file__init(file);
    file->path = strdup(x->order.path);
    file->has_step = true;
    file->step = order_effect(&x->order);
    file->has_time = true;
    file->time = x->order.effect_t;
    x->reply->result_case = MENISCUS__REPLY__RESULT_OUTPUT;
    x->reply->output = file;
    return MNS_OK;
}

/* Where the files of the run are, or were. */
MnsStatus complete_directory(Exchange *x, MnsError *error)
{
    const Order *order = &x->order;
    char text[240];
    if (!order->path[0]) return MNS_OK; /* there was none */
    snprintf(
        text, sizeof text,
        "on its way back after a crash, to step %" PRIu64
        ", which it had not reached; what had been written since its checkpoint is in the newest `abandoned` there",
        order->short_of);
    x->reply->message = strdup(order->short_of ? text : order->path);
    return complete_file(x, error);
}

MnsStatus complete_lease(Exchange *x, MnsError *error)
{
    const Lease *lease = &x->order.lease;
    if (!lease->epoch) return MNS_OK; /* given back */
    Meniscus__LeaseGrant *grant = malloc(sizeof *grant);
    if (!grant) return mns_fail(error, MNS_E_MEMORY, "no memory for the reply");
    meniscus__lease_grant__init(grant);
    grant->has_epoch = grant->has_ttl_ms = true;
    grant->epoch = lease->epoch;
    grant->ttl_ms = lease->ttl_ms;
    grant->holder = strdup(lease->holder);
    x->reply->result_case = MENISCUS__REPLY__RESULT_LEASE;
    x->reply->lease = grant;
    return MNS_OK;
}

MnsStatus complete_wait(Exchange *x, MnsError *error)
{
    const Meniscus__Wait *wait = x->request->wait;
    Meniscus__WaitResult *result = malloc(sizeof *result);
    if (!result) return mns_fail(error, MNS_E_MEMORY, "no memory for the reply");
    meniscus__wait_result__init(result);
    result->has_state_reached = true;
    for (size_t k = 0; k < wait->n_states; k++)
        if ((unsigned)wait->states[k] == (unsigned)x->order.state) result->state_reached = true;
    x->reply->result_case = MENISCUS__REPLY__RESULT_WAIT;
    x->reply->wait = result;
    return MNS_OK;
}
