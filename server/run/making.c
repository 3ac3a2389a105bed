/* SPDX-License-Identifier: BSD-3-Clause */
/* Making a simulation takes memory and time: no more than there is, and no longer than somebody wants it. */
#include "run/inside.h"

#include "base/clock.h"
#include "run/memory.h"

/* Who waits for it. */
typedef struct Client {
    Run *run;
    const Order *order;
} Client;

/* On any thread of the solver. It also shows that the solver is at work. */
static bool given_up(void *arg)
{
    const Client *client = arg;
    run_beat(client->run);
    const Order *order = client->order;
    return order->deadline < clock_now() || mailbox_ends(&client->run->mailbox, order->id, order->lineage != NULL);
}

MnsStatus run_make(Run *run, const Order *order, const MnsCase *c, const MnsCapture *state, MnsSim **ret,
                   MnsError *error)
{
    Client client = {run, order};
    MnsMaking making = {.given_up = given_up, .arg = &client};
    making.memory = memory_free("", &making.memory_is);
    const MnsStatus status = mns_sim_make(c, state, &making, ret, error);
    if (!status) mns_sim_watch(*ret, run_beat, run);
    if (status != MNS_E_INTERRUPTED) return status;
    if (order->deadline < clock_now())
        return mns_fail(error, MNS_E_TIMEOUT, "the deadline passed before the particles were placed; nothing was done");
    return mns_fail(error, MNS_E_INTERRUPTED, "called off while the particles were placed; nothing was done");
}
