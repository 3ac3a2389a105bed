/* SPDX-License-Identifier: BSD-3-Clause */
/* Where daemons listen: names to endpoints, and the list of those on this host. */
#include "client/lib/endpoint.h"
#include "common/case/name.h"
#include "common/host/places.h"
#include "common/wire/address.h"
#include <dirent.h>
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/un.h>
#include <unistd.h>

enum { DIRECTORY_COUNT = 3, DIRECTORY_SIZE = 256 };

/* The directories that hold one directory per daemon, in the order in which they are searched; empty if it does not
 * apply. */
static void directories(char ret[DIRECTORY_COUNT][DIRECTORY_SIZE])
{
    const char *runtime = places_variable("XDG_RUNTIME_DIR");
    ret[0][0] = 0;
    if (runtime) snprintf(ret[0], DIRECTORY_SIZE, "%s/meniscus", runtime);
    snprintf(ret[1], DIRECTORY_SIZE, PLACES_SYSTEM);
    snprintf(ret[2], DIRECTORY_SIZE, "/tmp/meniscus-%u", (unsigned)getuid());
}

static bool begins(const char *text, const char *with)
{
    return strncmp(text, with, strlen(with)) == 0;
}

static MnsStatus ipc_endpoint(const char *path, char ret[MNS_ENDPOINT_SIZE], MnsError *error)
{
    const size_t longest = sizeof((struct sockaddr_un *)NULL)->sun_path - 1;
    if (!*path || strlen(path) > longest)
        return mns_fail(error, MNS_E_INVALID, "socket path \"%s\" has %zu characters; a Unix socket may have 1 to %zu",
                        path, strlen(path), longest);
    snprintf(ret, MNS_ENDPOINT_SIZE, "ipc://%s", path);
    return MNS_OK;
}

/* A name or a number of a machine, an IPv6 number in brackets. */
static bool is_host(const char *host, size_t size)
{
    static const char letters[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789.-";
    if (size > 2 && host[0] == '[' && host[size - 1] == ']')
        return strspn(host + 1, "0123456789abcdefABCDEF:.") == size - 2;
    return size > 0 && size <= 100 && strspn(host, letters) == size;
}

/* Telemetry is at PORT + 1 and data at PORT + 2, so the last ports have no place for them. */
static MnsStatus tcp_endpoint(const char *endpoint, char ret[MNS_ENDPOINT_SIZE], MnsError *error)
{
    const char *host = endpoint + strlen("tcp://"), *colon = strrchr(host, ':');
    char *end = NULL;
    const long port = colon && colon[1] >= '0' && colon[1] <= '9' ? strtol(colon + 1, &end, 10) : 0;
    char given[128] = "", near[ADDRESS_HOST];
    if (colon) snprintf(given, sizeof given, "%.*s", (int)(colon - host), host);
    const bool is_port = port >= 1 && port <= 65533 && !*end;
    if (is_port && address_is_all(given))
        return mns_fail(
            error, MNS_E_INVALID,
            "\"%.200s\" stands for all addresses of a machine, where a daemon may listen; a client connects "
            "to one of them: write tcp://127.0.0.1:%ld for this machine, or the name or address of another",
            endpoint, port);
    if (!is_port || !is_host(host, (size_t)(colon - host)))
        return mns_fail(error, MNS_E_INVALID,
                        "\"%.200s\" is not an endpoint; allowed is tcp://HOST:PORT with 1 <= PORT <= 65533", endpoint);
    /* The name is not resolved again when the socket connects, so plain text goes nowhere else. */
    snprintf(ret, MNS_ENDPOINT_SIZE, "tcp://%s:%ld", address_of_near(given, near) ? near : given, port);
    return MNS_OK;
}

bool endpoint_is_far(const char *endpoint)
{
    char host[ADDRESS_HOST] = "", near[ADDRESS_HOST];
    if (begins(endpoint, "ipc://")) return false;
    const char *start = endpoint + strlen("tcp://"), *colon = strrchr(endpoint, ':');
    if (!begins(endpoint, "tcp://") || colon < start || (size_t)(colon - start) >= sizeof host) return true;
    memcpy(host, start, (size_t)(colon - start));
    return !address_of_near_number(host, near);
}

/* The first daemon that there is, for who asked for another. */
typedef struct Another {
    char name[CASE_NAME_SIZE];
} Another;

static bool note_another(void *arg, const char *name, const char *endpoint)
{
    Another *another = arg;
    (void)endpoint;
    snprintf(another->name, sizeof another->name, "%s", name);
    return false;
}

static MnsStatus fail_name(const char *name, char base[DIRECTORY_COUNT][DIRECTORY_SIZE], const char *but,
                           const char *why, MnsError *error)
{
    Another another = {""};
    char there[2 * CASE_NAME_SIZE + 64] = "";
    mns_daemon_list(note_another, &another);
    if (*another.name)
        snprintf(there, sizeof there, "; there is \"%s\", as in MENISCUS_DAEMON=%s", another.name, another.name);
    return mns_fail(error, MNS_E_UNAVAILABLE,
                    "no daemon \"%s\": there is no %s/control.ipc in %s%s%s or %s%s%s%s%s; start one "
                    "with `meniscusd --name %s`",
                    name, name, base[0], *base[0] ? ", " : "", base[1], base[2], *but ? " (" : "", but, why, there,
                    name);
}

static MnsStatus named_endpoint(const char *name, char ret[MNS_ENDPOINT_SIZE], MnsError *error)
{
    if (!*name || *name == '.' || strpbrk(name, "/:"))
        return mns_fail(error, MNS_E_INVALID,
                        "\"%s\" is neither the name of a daemon (no slash, no colon, no leading "
                        "dot) nor ipc://PATH nor tcp://HOST:PORT",
                        name);
    char base[DIRECTORY_COUNT][DIRECTORY_SIZE];
    char path[PATH_MAX];
    const char *but = "", *why = "";
    directories(base);
    for (int k = 0; k < DIRECTORY_COUNT; k++) {
        if (!*base[k]) continue;
        snprintf(path, sizeof path, "%s/%s/control.ipc", base[k], name);
        const bool there = access(path, F_OK) == 0;
        if (there && places_is_safe(base[k], name)) return ipc_endpoint(path, ret, error);
        if (*but || (!there && errno != EACCES)) continue;
        but = base[k];
        why = there ? " has one that is not asked, as others may write there)"
                    : " is closed to this user; `sudo -u meniscus` reaches daemons that systemd started)";
    }
    return fail_name(name, base, but, why, error);
}

MnsStatus mns_daemon_endpoint(const char *daemon, char ret_endpoint[MNS_ENDPOINT_SIZE], MnsError *error)
{
    const char *chosen = daemon ? daemon : getenv("MENISCUS_DAEMON");
    if (!chosen || !*chosen) chosen = "default";
    if (begins(chosen, "ipc://")) return ipc_endpoint(chosen + strlen("ipc://"), ret_endpoint, error);
    if (begins(chosen, "tcp://")) return tcp_endpoint(chosen, ret_endpoint, error);
    return named_endpoint(chosen, ret_endpoint, error);
}

/* `ports` on from that of the control socket, or a file beside it. */
static MnsStatus beside(const char *control, int ports, const char *file, char ret[MNS_ENDPOINT_SIZE], MnsError *error)
{
    if (begins(control, "tcp://")) {
        const char *colon = strrchr(control, ':');
        snprintf(ret, MNS_ENDPOINT_SIZE, "%.*s:%ld", (int)(colon - control), control,
                 strtol(colon + 1, NULL, 10) + ports);
        return MNS_OK;
    }
    const char *path = control + strlen("ipc://"), *slash = strrchr(path, '/');
    char whole[MNS_ENDPOINT_SIZE + 16];
    snprintf(whole, sizeof whole, "%.*s%s", slash ? (int)(slash - path + 1) : 0, path, file);
    return ipc_endpoint(whole, ret, error);
}

MnsStatus endpoint_telemetry(const char *control, char ret[MNS_ENDPOINT_SIZE], MnsError *error)
{
    return beside(control, 1, "telemetry.ipc", ret, error);
}

MnsStatus endpoint_data(const char *control, char ret[MNS_ENDPOINT_SIZE], MnsError *error)
{
    return beside(control, 2, "data.ipc", ret, error);
}

/* Visit the daemons below one directory. @return false if the visitor has had enough. */
static bool list_directory(const char *base, bool (*visit)(void *, const char *, const char *), void *arg)
{
    DIR *directory = *base ? opendir(base) : NULL;
    if (!directory) return true;
    bool more = true;
    for (struct dirent *entry; more && (entry = readdir(directory));) {
        char path[PATH_MAX], endpoint[MNS_ENDPOINT_SIZE];
        snprintf(path, sizeof path, "%s/%s/control.ipc", base, entry->d_name);
        if (!is_name(entry->d_name) || access(path, F_OK) != 0 || !places_is_safe(base, entry->d_name)) continue;
        if (ipc_endpoint(path, endpoint, NULL) == MNS_OK) more = visit(arg, entry->d_name, endpoint);
    }
    closedir(directory);
    return more;
}

void mns_daemon_list(bool (*visit)(void *arg, const char *name, const char *endpoint), void *arg)
{
    char base[DIRECTORY_COUNT][DIRECTORY_SIZE];
    directories(base);
    for (int k = 0; k < DIRECTORY_COUNT; k++)
        if (!list_directory(base[k], visit, arg)) return;
}
