/* SPDX-License-Identifier: BSD-3-Clause */
/* Sockets of daemons on this machine, seen from outside. */
#include "client/cli/listener.h"
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

/* Its path; NULL if it has none. */
static const char *path_of(const char *endpoint)
{
    return strncmp(endpoint, "ipc://", 6) == 0 ? endpoint + 6 : NULL;
}

/* One who is stopped takes nobody from the queue, and where that is full, connecting would wait for ever: then somebody has the socket, and
 * says nothing. */
bool listener_is_gone(const char *endpoint)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    const char *path = path_of(endpoint);
    if (!path || strlen(path) >= sizeof address.sun_path) return false;
    memcpy(address.sun_path, path, strlen(path));
    const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    const bool refused = fd >= 0 && connect(fd, (const struct sockaddr *)&address, sizeof address) &&
                         (errno == ECONNREFUSED || errno == ENOENT);
    if (fd >= 0) close(fd);
    return refused;
}

/* The kernel lists the daemon's end of each connection under the path it listens at: number, count, protocol, flags, type, state,
 * inode, path. State 3 is connected. */
long listener_visitors(const char *endpoint)
{
    const char *path = path_of(endpoint);
    FILE *file = path ? fopen("/proc/net/unix", "re") : NULL;
    char line[PATH_MAX], found[512];
    unsigned state;
    long n = 0;
    if (!file) return -1;
    while (fgets(line, sizeof line, file))
        if (sscanf(line, "%*s %*s %*s %*s %*s %x %*s %511s", &state, found) == 2 && state == 3 && !strcmp(found, path))
            n++;
    fclose(file);
    return n;
}
