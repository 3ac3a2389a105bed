/* SPDX-License-Identifier: BSD-3-Clause */
/* A bound on connections, in accept() itself: libzmq 4.3.4 accepts whatever comes to a socket file, and ends the process where that fails for
 * want of files. The functions below take the place of the C library's for all libraries of the program. */
#include "net/crowd.h"

#include "base/clock.h"
#include "base/log.h"
#include <errno.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <unistd.h>

/* Files for the run: its own are about thirty, and `status` and the metrics read some. As many connections again are for commands. */
enum { KEPT = 64 };

static const double TELL_AGAIN = 60; /* [s] */

static struct {
    const Endpoint *at;
    int most;  /* files; 0: nothing is kept back */
    int spare; /* an open file, given up to take a connection that cannot be had otherwise; or -1 */
    double told;
    pthread_mutex_t lock;
} crowd = {.spare = -1, .lock = PTHREAD_MUTEX_INITIALIZER};

void crowd_begin(const Endpoint *at, int most)
{
    crowd.at = at;
    crowd.spare = open("/dev/null", O_RDONLY | O_CLOEXEC);
    crowd.told = -TELL_AGAIN;
    crowd.most = most;
}

/* Does the socket that listens take commands? */
static bool takes_commands(int listener)
{
    union {
        struct sockaddr any;
        struct sockaddr_un file;
        struct sockaddr_in port;
    } name = {.any = {.sa_family = AF_UNSPEC}};
    socklen_t size = sizeof name - 1;
    if (!crowd.at || getsockname(listener, &name.any, &size)) return false;
    if (name.any.sa_family == AF_UNIX)
        return !strcmp(name.file.sun_path, crowd.at->control + strlen("ipc://")) ||
               !strcmp(name.file.sun_path, crowd.at->gate_control + strlen("ipc://"));
    const char *port = strrchr(crowd.at->tcp_control, ':');
    return name.any.sa_family == AF_INET && port && strtol(port + 1, NULL, 10) == ntohs(name.port.sin_port);
}

/* The system gives the lowest number that is free, so a high one says that all below are in use. */
static bool is_too_many(int listener, int fd)
{
    const int kept = crowd.most / 8 < KEPT ? crowd.most / 8 : KEPT;
    if (fd < crowd.most - 2 * kept) return false;
    return fd >= crowd.most - kept || !takes_commands(listener);
}

static void tell(void)
{
    const double now = clock_now();
    pthread_mutex_lock(&crowd.lock);
    const bool due = now >= crowd.told + TELL_AGAIN;
    if (due) crowd.told = now;
    pthread_mutex_unlock(&crowd.lock);
    if (due)
        log_line(LOG_WARNING,
                 "connections are closed, as this process may have %d files open and keeps some for the run; raise its "
                 "limit (`ulimit -n`, LimitNOFILE=) or end some clients",
                 crowd.most);
}

/* Without a free file a connection cannot even be closed, and would wake its socket for ever. */
static void clear_one(int listener)
{
    pthread_mutex_lock(&crowd.lock);
    if (crowd.spare >= 0) close(crowd.spare);
    const int fd = (int)syscall(SYS_accept4, listener, NULL, NULL, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (fd >= 0) close(fd);
    crowd.spare = open("/dev/null", O_RDONLY | O_CLOEXEC);
    pthread_mutex_unlock(&crowd.lock);
}

/* ECONNABORTED: the connection was ended before it was accepted, which every library takes for what it is. */
static int refuse(void)
{
    tell();
    errno = ECONNABORTED;
    return -1;
}

int accept4(int listener, __SOCKADDR_ARG address, socklen_t *restrict size, int flags)
{
    const int fd = (int)syscall(SYS_accept4, listener, address.__sockaddr__, size, flags);
    const bool full = fd < 0 && (errno == EMFILE || errno == ENFILE);
    if (full && crowd.most) clear_one(listener);
    if (full && crowd.most) return refuse();
    if (fd < 0 || !crowd.most || !is_too_many(listener, fd)) return fd;
    close(fd);
    return refuse();
}

int accept(int listener, __SOCKADDR_ARG address, socklen_t *restrict size)
{
    return accept4(listener, address, size, 0);
}
