/* SPDX-License-Identifier: BSD-3-Clause */
/* Opening and closing a client, and what holds for all its commands. */
#include "client/lib/call.h"
#include "client/lib/endpoint.h"
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { STARTING_MS = 300, LOOK_MS = 20 };

static const char *given_or(const char *given, const char *variable)
{
    const char *value = given ? given : getenv(variable);
    return value && *value ? value : NULL;
}

/* The keys to use at an endpoint; *ret_plain: none. */
static MnsStatus choose_keys(const MnsClientOptions *options, const char *endpoint, KeyPair *ret, bool *ret_plain,
                             MnsError *error)
{
    const char *file = given_or(options->key_file, "MENISCUS_KEY");
    const char *server = given_or(options->server_key, "MENISCUS_SERVER_KEY");
    const bool far = endpoint_is_far(endpoint);
    *ret_plain = strncmp(endpoint, "ipc://", 6) == 0 || (!far && !file);
    if (*ret_plain) return MNS_OK;
    if (!file)
        return mns_fail(
            error, MNS_E_DENIED,
            "%s is no loopback address, so it takes a key: set MENISCUS_KEY to its file (or give it to `meniscus` with "
            "--key), which `meniscus keys new` writes on the daemon's machine; on that machine a daemon has a name, or "
            "listens at tcp://127.0.0.1:PORT",
            endpoint);
    if (server && !key_is_valid(server))
        return mns_fail(error, MNS_E_INVALID,
                        "\"%.80s\" is no server key: it has 40 letters, as `meniscus keys list` prints it", server);
    const MnsStatus status = key_file_read(file, ret, error);
    if (status == MNS_OK && server) memcpy(ret->server_key, server, KEY_TEXT);
    if (status != MNS_OK || *ret->server_key) return status;
    return mns_fail(
        error, MNS_E_INVALID,
        "%s does not say the daemon's public key: set MENISCUS_SERVER_KEY to it (or give it to `meniscus` with "
        "--server-key)",
        file);
}

/* A daemon that was started in the line before has no socket yet. */
static MnsStatus await_endpoint(const char *daemon, char ret[MNS_ENDPOINT_SIZE], MnsError *error)
{
    const double deadline = wire_clock() + 1e-3 * STARTING_MS;
    MnsStatus status = mns_daemon_endpoint(daemon, ret, error);
    while (status == MNS_E_UNAVAILABLE && wire_clock() < deadline) {
        nanosleep(&(struct timespec){.tv_nsec = LOOK_MS * 1000000L}, NULL);
        status = mns_daemon_endpoint(daemon, ret, error);
    }
    return status;
}

MnsStatus mns_client_open_with(const MnsClientOptions *options, MnsClient **ret_client, MnsError *error)
{
    char endpoint[MNS_ENDPOINT_SIZE];
    KeyPair keys = {.public_key = ""};
    bool plain = true;
    MnsStatus status = await_endpoint(options->daemon, endpoint, error);
    if (status == MNS_OK) status = choose_keys(options, endpoint, &keys, &plain, error);
    if (status != MNS_OK) return status;
    MnsClient *client = calloc(1, sizeof *client);
    if (!client) return mns_fail(error, MNS_E_MEMORY, "no memory for a client");
    client->next = (Meniscus__Request)MENISCUS__REQUEST__INIT;
    client->timeout = -1;
    const double deadline = wire_clock() + (options->timeout > 0 ? options->timeout : WIRE_OPENING_S);
    status = wire_open(&client->wire, endpoint, plain ? NULL : &keys, deadline, error);
    explicit_bzero(&keys, sizeof keys);
    if (status == MNS_OK) status = call_greet(client, deadline, error);
    if (status == MNS_OK) *ret_client = client;
    else mns_client_close(client);
    return status;
}

MnsStatus mns_client_open(const char *daemon, MnsClient **ret_client, MnsError *error)
{
    return mns_client_open_with(&(MnsClientOptions){.daemon = daemon}, ret_client, error);
}

MnsStatus mns_key_pair(char ret_public[MNS_KEY_SIZE], char ret_secret[MNS_KEY_SIZE], MnsError *error)
{
    if (zmq_curve_keypair(ret_public, ret_secret) == 0) return MNS_OK;
    return mns_fail(error, MNS_E_UNAVAILABLE, "cannot make keys: %s; libzmq must be built with libsodium",
                    zmq_strerror(zmq_errno()));
}

void mns_client_close(MnsClient *client)
{
    if (!client) return;
    if (client->telemetry) zmq_close(client->telemetry);
    wire_close(&client->wire);
    free(client);
}

double mns_client_away(MnsClient *client)
{
    return wire_away(&client->wire);
}

void mns_client_set_reconnect(MnsClient *client, double seconds)
{
    client->wire.reconnect_s = seconds;
}

void mns_client_set_timeout(MnsClient *client, double seconds)
{
    client->timeout = seconds;
}

void mns_client_set_request_id(MnsClient *client, const uint8_t id[MNS_REQUEST_ID_SIZE])
{
    memcpy(client->next_id, id, MNS_REQUEST_ID_SIZE);
    client->next.has_id = true;
}

void mns_client_set_if_step(MnsClient *client, uint64_t step)
{
    client->next.if_step = step;
    client->next.has_if_step = true;
}

void mns_client_set_at_step(MnsClient *client, uint64_t step)
{
    client->next.at_step = step;
    client->next.has_at_step = true;
}

void mns_client_set_at_time(MnsClient *client, double time)
{
    client->next.at_time = time;
    client->next.has_at_time = true;
}

void mns_client_set_no_wait(MnsClient *client)
{
    client->next.has_no_wait = client->next.no_wait = true;
}

void mns_client_set_if_version(MnsClient *client, uint64_t version)
{
    client->next.if_version = version;
    client->next.has_if_version = version > 0;
}

void mns_client_set_lease(MnsClient *client, uint64_t epoch)
{
    client->lease_epoch = epoch;
}
