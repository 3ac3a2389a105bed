/* SPDX-License-Identifier: BSD-3-Clause */
/* A bound on connections, in accept() itself: libzmq 4.3.4 accepts whatever comes to a socket file, and ends the process where that fails for
 * want of files. accept() and close() below take the place of the C library's for all libraries of the program. */
#include "net/crowd.h"

#include "base/clock.h"
#include "base/log.h"
#include "net/peers.h"
#include <errno.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <unistd.h>

/* Files for the run: its own are about thirty, and `status` and the metrics read some. As many connections again are for commands, and some for HTTP. */
enum { KEPT = 64, KEPT_HTTP = 96 };

static const double TELL_AGAIN = 60; /* [s] */

static struct {
    const Endpoint *at;
    int most;  /* files; 0: nothing is kept back */
    int spare; /* an open file, given up to take a connection that cannot be had otherwise; or -1 */
    double told;
    pthread_mutex_t lock;
} crowd = {.spare = -1, .lock = PTHREAD_MUTEX_INITIALIZER};

/* What a socket that listens is for. */
typedef enum Purpose { FOR_COMMANDS, FOR_COMMANDS_OF_GATE, FOR_DATA, FOR_DATA_OF_GATE, FOR_HTTP } Purpose;

void crowd_begin(const Endpoint *at, int most)
{
    crowd.at = at;
    crowd.spare = open("/dev/null", O_RDONLY | O_CLOEXEC);
    crowd.told = -TELL_AGAIN;
    crowd.most = most;
    peers_begin(at ? most : 0);
}

static bool is_file(const struct sockaddr_un *name, const char *endpoint)
{
    return !strcmp(name->sun_path, endpoint + strlen("ipc://"));
}

static Purpose purpose_of_file(const struct sockaddr_un *name)
{
    const Endpoint *at = crowd.at;
    if (is_file(name, at->control)) return FOR_COMMANDS;
    if (is_file(name, at->gate_control)) return FOR_COMMANDS_OF_GATE;
    const bool gate = is_file(name, at->gate_telemetry) || is_file(name, at->gate_data);
    return gate ? FOR_DATA_OF_GATE : FOR_DATA;
}

static bool is_port(const struct sockaddr_in *name, const char *endpoint)
{
    const char *port = strrchr(endpoint, ':');
    return port && strtol(port + 1, NULL, 10) == ntohs(name->sin_port);
}

static Purpose purpose_of_port(const struct sockaddr_in *name)
{
    const Endpoint *at = crowd.at;
    if (is_port(name, at->tcp_control)) return FOR_COMMANDS;
    return is_port(name, at->tcp_telemetry) || is_port(name, at->tcp_data) ? FOR_DATA : FOR_HTTP;
}

static Purpose purpose_of(int listener)
{
    union {
        struct sockaddr any;
        struct sockaddr_un file;
        struct sockaddr_in port;
        struct sockaddr_storage room;
    } name = {.any = {.sa_family = AF_UNSPEC}};
    socklen_t size = sizeof name - 1;
    if (!crowd.at || getsockname(listener, &name.any, &size)) return FOR_DATA;
    if (name.any.sa_family == AF_UNIX) return purpose_of_file(&name.file);
    return name.any.sa_family == AF_INET ? purpose_of_port(&name.port) : FOR_HTTP;
}

/* The process at the other end, or a group of net/peers.h in its place. */
static int process_of(int fd, Purpose purpose)
{
    struct ucred cred = {.pid = 0};
    socklen_t size = sizeof cred;
    if (purpose == FOR_HTTP) return PEER_HTTP;
    if (purpose == FOR_COMMANDS_OF_GATE || purpose == FOR_DATA_OF_GATE) return PEER_GATE;
    return getsockopt(fd, SOL_SOCKET, SO_PEERCRED, &cred, &size) || cred.pid <= 0 ? PEER_TCP : (int)cred.pid;
}

static int share(int part, int most)
{
    return part < most ? part : most;
}

/* Files that may be in use when one more is opened for this purpose. */
static int places(Purpose purpose)
{
    const int kept = share(crowd.most / 8, KEPT), http = crowd.at ? share(crowd.most / 8, KEPT_HTTP) : 0;
    switch (purpose) {
    case FOR_HTTP: return crowd.most - kept;
    case FOR_COMMANDS:
    case FOR_COMMANDS_OF_GATE: return crowd.most - kept - http;
    default: return crowd.most - 2 * kept - http;
    }
}

static void tell(void)
{
    const double now = clock_now();
    pthread_mutex_lock(&crowd.lock);
    const bool due = now >= crowd.told + TELL_AGAIN;
    if (due) crowd.told = now;
    pthread_mutex_unlock(&crowd.lock);
    if (!due) return;
    char whose[96] = "";
    int n;
    const int process = peers_largest(&n);
    if (n && process == PEER_TCP) snprintf(whose, sizeof whose, "; %d of them came by --tcp", n);
    else if (n) snprintf(whose, sizeof whose, "; process %d has %d of them", process, n);
    log_line(LOG_WARNING,
             "connections are closed, as this process may have %d files open and keeps some for the run%s; raise its "
             "limit (`ulimit -n`, LimitNOFILE=) or end some clients",
             crowd.most, whose);
}

/* The system gives the lowest number that is free, so all files below this one are in use, and connections may be beyond it. One that is ended to make room is closed a moment later: until then the new one takes from what is kept for the run, which may lack half of it for so long. */
static bool has_place(int fd, Purpose purpose, int process)
{
    const int most = places(purpose), kept = share(crowd.most / 8, KEPT);
    if (fd + peers_beyond(fd) < most) return true;
    tell();
    return peers_make_room(process) && fd < crowd.most - kept / 2;
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
    errno = ECONNABORTED;
    return -1;
}

int accept4(int listener, __SOCKADDR_ARG address, socklen_t *restrict size, int flags)
{
    const int fd = (int)syscall(SYS_accept4, listener, address.__sockaddr__, size, flags);
    const bool full = fd < 0 && (errno == EMFILE || errno == ENFILE);
    if (full && crowd.most) {
        tell();
        clear_one(listener);
        return refuse();
    }
    if (fd < 0 || !crowd.most) return fd;
    const Purpose purpose = purpose_of(listener);
    const int process = process_of(fd, purpose);
    if (has_place(fd, purpose, process)) {
        if (process != PEER_GATE) peers_add(fd, process);
        return fd;
    }
    close(fd);
    return refuse();
}

int accept(int listener, __SOCKADDR_ARG address, socklen_t *restrict size)
{
    return accept4(listener, address, size, 0);
}

int close(int fd)
{
    peers_remove(fd);
    return (int)syscall(SYS_close, fd);
}
