/* SPDX-License-Identifier: BSD-3-Clause */
/* Where a daemon listens. The lock comes first, because binding takes a socket's path from whoever has it. */
#include "net/endpoint.h"

#include "base/clock.h"
#include "common/case/name.h"
#include "common/host/places.h"
#include "common/wire/address.h"
#include "run/lock.h"
#include <arpa/inet.h>
#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

static const double FAREWELL = 10; /* [s] that a daemon may take to leave */
static const size_t PATH_LONGEST = sizeof((struct sockaddr_un *)NULL)->sun_path - 1;

static MnsStatus check_name(const char *name, MnsError *error)
{
    if (is_name(name) && strlen(name) <= 64) return MNS_OK;
    return mns_fail_at(
        error, MNS_E_INVALID, "name",
        "the name of a daemon has 1 to 64 letters, digits, dots, dashes and underscores and does not begin "
        "with a dot or a dash; found \"%.80s\"",
        name);
}

/* The directory of this daemon; *ret_own: ours to make, with the one above it. */
static MnsStatus choose(const char *name, char ret[static 256], bool *ret_own, MnsError *error)
{
    const char *given = getenv("RUNTIME_DIRECTORY");
    char base[256];
    int n;
    *ret_own = !(given && *given);
    places_sockets(base, sizeof base);
    if (!*ret_own) n = snprintf(ret, 256, "%s", given);
    else n = snprintf(ret, 256, "%s/%s", base, name);
    const size_t whole = (size_t)n + strlen("/telemetry.ipc");
    if (whole <= PATH_LONGEST) return MNS_OK;
    return mns_fail(
        error, MNS_E_LIMIT,
        "the path of the socket, %.200s/telemetry.ipc, has %zu bytes, and a socket's path may have %zu; choose a "
        "shorter --name or XDG_RUNTIME_DIR",
        ret, whole, PATH_LONGEST);
}

/* A directory for us alone. One that belongs to somebody else is a trap: they could put their socket in our place. */
static MnsStatus make_private(const char *path, MnsError *error)
{
    if (mkdir(path, 0700) && errno != EEXIST)
        return mns_fail(error, MNS_E_IO, "cannot make the directory %s: %s; %s", path, strerror(errno),
                        errno == ENOENT ? "unset XDG_RUNTIME_DIR, or set it to a directory of your own that is there"
                                        : mns_refusal_hint(errno));
    const Place place = places_look(path);
    if (place == PLACE_STRANGE)
        return mns_fail(error, MNS_E_IO, "%s is not a directory of this user; remove it or set XDG_RUNTIME_DIR", path);
    if (place != PLACE_PRIVATE && chmod(path, 0700))
        return mns_fail(error, MNS_E_IO, "cannot make %s private: %s; %s", path, strerror(errno),
                        mns_refusal_hint(errno));
    return MNS_OK;
}

static MnsStatus make(char *path, MnsError *error)
{
    char *slash = strrchr(path, '/');
    *slash = 0;
    MnsStatus status = make_private(path, error);
    *slash = '/';
    return status ? status : make_private(path, error);
}

/* One that was told to leave answers first, and takes leave of its visitors: who starts the next at once must not be refused for that. */
static MnsStatus lock(Endpoint *endpoint, const char *name, MnsError *error)
{
    const double until = clock_now() + FAREWELL;
    char path[ENDPOINT_SIZE + 8], holder[LOCK_HOLDER];
    snprintf(path, sizeof path, "%s/lock", endpoint->directory);
    MnsStatus status = lock_take(path, &endpoint->lock, holder, error);
    while (status == MNS_E_STATE && lock_is_leaving(holder) && clock_now() < until) {
        nanosleep(&(struct timespec){.tv_nsec = 20000000}, NULL);
        status = lock_take(path, &endpoint->lock, holder, error);
    }
    if (status != MNS_E_STATE) return status;
    return mns_fail(error, MNS_E_STATE, "a daemon \"%s\" is running already, as %s (%s is locked); %s", name, holder,
                    path, lock_is_leaving(holder) ? "wait until it is gone" : "give this one another --name");
}

void endpoint_leave(const Endpoint *endpoint)
{
    lock_leave(endpoint->lock);
}

/* A port with two after it, for telemetry and data; 0 if the text is none. */
static long port_of(const char *digits)
{
    char *end;
    const long port = strtol(digits, &end, 10);
    return *digits >= '0' && *digits <= '9' && !*end && port >= 1 && port <= 65533 ? port : 0;
}

static void set_ports(const char *host, size_t size, long port, char control[ENDPOINT_SIZE],
                      char telemetry[ENDPOINT_SIZE], char data[ENDPOINT_SIZE])
{
    snprintf(control, ENDPOINT_SIZE, "tcp://%.*s:%ld", (int)size, host, port);
    snprintf(telemetry, ENDPOINT_SIZE, "tcp://%.*s:%ld", (int)size, host, port + 1);
    snprintf(data, ENDPOINT_SIZE, "tcp://%.*s:%ld", (int)size, host, port + 2);
}

/* Plain text, so only loopback: on other addresses anybody could listen and steer. */
static MnsStatus set_tcp(const char *tcp, Endpoint *endpoint, MnsError *error)
{
    if (!strncmp(tcp, "tcp://", 6)) tcp += 6;
    const char *colon = strrchr(tcp, ':');
    const size_t host = colon ? (size_t)(colon - tcp) : 0;
    char given[128] = "127.0.0.1", near[ADDRESS_HOST];
    if (colon) snprintf(given, sizeof given, "%.*s", (int)host, tcp);
    if (host >= sizeof given || !address_of_near(given, near) || *near == '[')
        return mns_fail_at(
            error, MNS_E_INVALID, "tcp",
            "--tcp is plain text and for this machine only, as anybody who reaches the port could steer: use 127.0.0.1 "
            "instead of \"%.*s\", or make keys with `meniscus keys new NAME --role operator` and give --listen "
            "tcp://%.*s:%.20s",
            (int)host, tcp, (int)host, tcp, colon + 1);
    const char *digits = colon ? colon + 1 : tcp;
    const long port = port_of(digits);
    if (!port)
        return mns_fail_at(
            error, MNS_E_INVALID, "tcp",
            "--tcp takes a port from 1 to 65533 (telemetry and data are at the two after it); found \"%.60s\"", digits);
    set_ports(near, strlen(near), port, endpoint->tcp_control, endpoint->tcp_telemetry, endpoint->tcp_data);
    return MNS_OK;
}

/* Numbers only: a name may mean another address tomorrow, and some systems ask the network for it. */
static bool is_address(const char *host, size_t size)
{
    char text[INET6_ADDRSTRLEN] = "";
    struct in6_addr room;
    const bool six = size > 2 && host[0] == '[' && host[size - 1] == ']';
    if (six) host++, size -= 2;
    if (size == 1 && *host == '*') return !six;
    if (size >= sizeof text) return false;
    memcpy(text, host, size);
    return inet_pton(six ? AF_INET6 : AF_INET, text, &room) == 1;
}

/* With keys, so any address. */
static MnsStatus set_listen(const EndpointOptions *options, Endpoint *endpoint, MnsError *error)
{
    const char *text = options->listen, *host = strncmp(text, "tcp://", 6) ? text : text + 6,
               *colon = strrchr(host, ':');
    const size_t size = colon ? (size_t)(colon - host) : 0;
    const long port = colon ? port_of(colon + 1) : 0;
    if (!port || !is_address(host, size))
        return mns_fail_at(
            error, MNS_E_INVALID, "listen",
            "--listen takes tcp://ADDRESS:PORT: the number of an address of this machine, as 192.0.2.7 or "
            "[2001:db8::7], or * for all, and a port from 1 to 65533 (telemetry and data are at the two after it); "
            "found "
            "\"%.80s\"",
            text);
    set_ports(host, size, port, endpoint->far_control, endpoint->far_telemetry, endpoint->far_data);
    if (!options->keys) return keys_directory(endpoint->keys, error);
    if (!*options->keys || strlen(options->keys) >= KEYS_PATH - KEY_NAME_SIZE - 16)
        return mns_fail_at(error, MNS_E_INVALID, "keys", "--keys must name a directory; found \"%.80s\"",
                           options->keys);
    memcpy(endpoint->keys, options->keys, strlen(options->keys) + 1);
    return MNS_OK;
}

static void remove_sockets(const Endpoint *endpoint)
{
    unlink(endpoint->control + strlen("ipc://"));
    unlink(endpoint->telemetry + strlen("ipc://"));
    unlink(endpoint->data + strlen("ipc://"));
    unlink(endpoint->gate_control + strlen("ipc://"));
    unlink(endpoint->gate_telemetry + strlen("ipc://"));
    unlink(endpoint->gate_data + strlen("ipc://"));
}

MnsStatus endpoint_open(const EndpointOptions *options, Endpoint *ret, MnsError *error)
{
    char directory[256];
    bool own;
    Endpoint endpoint = {.lock = -1};
    const char *name = options->name;
    MnsStatus status = check_name(name, error);
    if (!status && options->tcp) status = set_tcp(options->tcp, &endpoint, error);
    if (!status && options->listen) status = set_listen(options, &endpoint, error);
    if (!status) status = choose(name, directory, &own, error);
    if (!status && own) status = make(directory, error);
    if (status) return status;
    snprintf(endpoint.directory, ENDPOINT_SIZE, "%.107s", directory);
    snprintf(endpoint.control, ENDPOINT_SIZE, "ipc://%.107s/control.ipc", directory);
    snprintf(endpoint.telemetry, ENDPOINT_SIZE, "ipc://%.107s/telemetry.ipc", directory);
    snprintf(endpoint.data, ENDPOINT_SIZE, "ipc://%.107s/data.ipc", directory);
    snprintf(endpoint.gate_control, ENDPOINT_SIZE, "ipc://%.107s/gate-ctrl.ipc", directory);
    snprintf(endpoint.gate_telemetry, ENDPOINT_SIZE, "ipc://%.107s/gate-news.ipc", directory);
    snprintf(endpoint.gate_data, ENDPOINT_SIZE, "ipc://%.107s/gate-data.ipc", directory);
    status = lock(&endpoint, name, error);
    if (status) return status;
    remove_sockets(&endpoint);
    *ret = endpoint;
    return MNS_OK;
}

void endpoint_close(Endpoint *endpoint)
{
    remove_sockets(endpoint);
    close(endpoint->lock);
}
