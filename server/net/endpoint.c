/* SPDX-License-Identifier: BSD-3-Clause */
/* Where a daemon listens. The lock comes first, because binding takes a socket's path from whoever has it. */
#include "net/endpoint.h"

#include "proto/case_name.h"
#include "run/lock.h"
#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

static const size_t PATH_LONGEST = sizeof((struct sockaddr_un *)NULL)->sun_path - 1;

static MnsStatus check_name(const char *name, MnsError *error)
{
    if (is_name(name) && strlen(name) <= 64) return MNS_OK;
    return mns_fail_at(
        error, MNS_E_INVALID, "name",
        "the name of a daemon has 1 to 64 letters, digits, dots, dashes and underscores and does not begin "
        "with a dot; found \"%.80s\"",
        name);
}

/* The directory of this daemon; *ret_own: ours to make, with the one above it. */
static MnsStatus choose(const char *name, char ret[static 256], bool *ret_own, MnsError *error)
{
    const char *given = getenv("RUNTIME_DIRECTORY"), *user = getenv("XDG_RUNTIME_DIR");
    int n;
    *ret_own = !(given && *given);
    if (!*ret_own) n = snprintf(ret, 256, "%s", given);
    else if (user && *user) n = snprintf(ret, 256, "%s/meniscus/%s", user, name);
    else n = snprintf(ret, 256, "/tmp/meniscus-%u/%s", (unsigned)getuid(), name);
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
    struct stat info;
    if (mkdir(path, 0700) && errno != EEXIST)
        return mns_fail(error, MNS_E_IO, "cannot make the directory %s: %s", path, strerror(errno));
    if (lstat(path, &info) || !S_ISDIR(info.st_mode) || info.st_uid != geteuid())
        return mns_fail(error, MNS_E_IO, "%s is not a directory of this user; remove it or set XDG_RUNTIME_DIR", path);
    if (info.st_mode & 077 && chmod(path, 0700))
        return mns_fail(error, MNS_E_IO, "cannot make %s private: %s", path, strerror(errno));
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

static MnsStatus lock(Endpoint *endpoint, const char *name, MnsError *error)
{
    char path[ENDPOINT_SIZE + 8], holder[LOCK_HOLDER];
    snprintf(path, sizeof path, "%s/lock", endpoint->directory);
    const MnsStatus status = lock_take(path, &endpoint->lock, holder, error);
    if (status != MNS_E_STATE) return status;
    return mns_fail(error, MNS_E_STATE,
                    "a daemon \"%s\" is running already, as %s (%s is locked); give this one another --name", name,
                    holder, path);
}

/* Only loopback: on other addresses anybody could steer. */
static MnsStatus set_tcp(const char *tcp, Endpoint *endpoint, MnsError *error)
{
    char *end;
    const char *colon = strrchr(tcp, ':');
    const size_t host = colon ? (size_t)(colon - tcp) : 0;
    if (colon && strncmp(tcp, "127.0.0.1:", host + 1) != 0 && strncmp(tcp, "localhost:", host + 1) != 0)
        return mns_fail_at(
            error, MNS_E_INVALID, "tcp",
            "commands are taken from this machine only, as anybody who reaches the port could steer: use "
            "127.0.0.1 instead of \"%.*s\", and a tunnel from elsewhere",
            (int)host, tcp);
    const char *digits = colon ? colon + 1 : tcp;
    const long port = strtol(digits, &end, 10);
    if (*digits < '0' || *digits > '9' || *end || port < 1 || port > 65534)
        return mns_fail_at(error, MNS_E_INVALID, "tcp",
                           "--tcp takes a port from 1 to 65534 (telemetry is at the next one); found \"%.60s\"",
                           digits);
    snprintf(endpoint->tcp_control, ENDPOINT_SIZE, "tcp://127.0.0.1:%ld", port);
    snprintf(endpoint->tcp_telemetry, ENDPOINT_SIZE, "tcp://127.0.0.1:%ld", port + 1);
    return MNS_OK;
}

static void remove_sockets(const Endpoint *endpoint)
{
    unlink(endpoint->control + strlen("ipc://"));
    unlink(endpoint->telemetry + strlen("ipc://"));
}

MnsStatus endpoint_open(const char *name, const char *tcp, Endpoint *ret, MnsError *error)
{
    char directory[256];
    bool own;
    Endpoint endpoint = {.lock = -1};
    MnsStatus status = check_name(name, error);
    if (!status && tcp) status = set_tcp(tcp, &endpoint, error);
    if (!status) status = choose(name, directory, &own, error);
    if (!status && own) status = make(directory, error);
    if (status) return status;
    snprintf(endpoint.directory, ENDPOINT_SIZE, "%.107s", directory);
    snprintf(endpoint.control, ENDPOINT_SIZE, "ipc://%.107s/control.ipc", directory);
    snprintf(endpoint.telemetry, ENDPOINT_SIZE, "ipc://%.107s/telemetry.ipc", directory);
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
