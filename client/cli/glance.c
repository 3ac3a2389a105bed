/* SPDX-License-Identifier: BSD-3-Clause */
/* A daemon answers at once whatever it computes, so one that takes longer is stopped, or hangs. */
#include "client/cli/glance.h"
#include "client/cli/listener.h"
#include <stddef.h>

static const double moment_s = 0.5;

Glance glance_at(const char *endpoint)
{
    Glance glance = {.is_silent = !listener_is_gone(endpoint), .clients = -1};
    const MnsClientOptions options = {.daemon = endpoint, .timeout = moment_s};
    MnsClient *client = NULL;
    if (!glance.is_silent || mns_client_open_with(&options, &client, NULL) != MNS_OK) return glance;
    mns_client_set_timeout(client, moment_s);
    if (mns_client_status(client, &glance.reply, NULL) == MNS_OK && glance.reply->info) {
        const long visitors = listener_visitors(endpoint);
        glance.info = glance.reply->info;
        glance.is_silent = false;
        glance.clients = visitors > 0 ? visitors - 1 : -1;
    }
    mns_client_close(client);
    return glance;
}

void glance_done(Glance *glance)
{
    mns_reply_free(glance->reply);
}

const char *glance_state(const Glance *glance)
{
    if (glance->info) return mns_state_name(glance->info->state);
    return glance->is_silent ? "silent" : "dead";
}
