/* SPDX-License-Identifier: BSD-3-Clause */
/* Opening and closing a client, and what holds for all its commands. */
#include "client/lib/call.h"
#include <stdlib.h>
#include <string.h>

MnsStatus mns_client_open(const char *daemon, MnsClient **ret_client, MnsError *error)
{
    char endpoint[MNS_ENDPOINT_SIZE];
    MnsStatus status = mns_daemon_endpoint(daemon, endpoint, error);
    if (status != MNS_OK) return status;
    MnsClient *client = calloc(1, sizeof *client);
    if (!client) return mns_fail(error, MNS_E_MEMORY, "no memory for a client");
    client->timeout = -1;
    status = wire_open(&client->wire, endpoint, error);
    if (status == MNS_OK) status = call_greet(client, error);
    if (status == MNS_OK) *ret_client = client;
    else mns_client_close(client);
    return status;
}

void mns_client_close(MnsClient *client)
{
    if (!client) return;
    if (client->telemetry) zmq_close(client->telemetry);
    wire_close(&client->wire);
    free(client);
}

void mns_client_set_timeout(MnsClient *client, double seconds)
{
    client->timeout = seconds;
}

void mns_client_set_request_id(MnsClient *client, const uint8_t id[MNS_REQUEST_ID_SIZE])
{
    memcpy(client->next_id, id, MNS_REQUEST_ID_SIZE);
    client->has_id = true;
}

void mns_client_set_if_step(MnsClient *client, uint64_t step)
{
    client->if_step = step;
    client->has_if_step = true;
}

void mns_client_set_if_version(MnsClient *client, uint64_t version)
{
    client->if_version = version;
}

void mns_client_set_lease(MnsClient *client, uint64_t epoch)
{
    client->lease_epoch = epoch;
}
