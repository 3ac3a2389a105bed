/* SPDX-License-Identifier: BSD-3-Clause */
/* An address for those from afar. */
#include "net/far.h"

#include "base/clock.h"
#include "common/host/open_files.h"
#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

enum { BACKLOG = 100, RETRY_MS = 20 };

static const double PATIENCE = 1; /* [s] */

/* Room for an address of either kind. */
typedef union Place {
    struct sockaddr any;
    struct sockaddr_in four;
    struct sockaddr_in6 six;
} Place;

/* Of the text that endpoint_open() has checked: "tcp://192.0.2.7:5555", "tcp://[2001:db8::7]:5555" or "tcp://" and a star. */
static socklen_t read_place(const char *address, Place *ret)
{
    const char *host = address + strlen("tcp://"), *colon = strrchr(host, ':');
    const in_port_t port = htons((uint16_t)strtol(colon + 1, NULL, 10));
    char text[INET6_ADDRSTRLEN] = "";
    const bool six = *host == '[';
    const size_t size = (size_t)(colon - host) - (six ? 2 : 0);
    if (size < sizeof text) memcpy(text, host + six, size);
    if (six) {
        *ret = (Place){.six = {.sin6_family = AF_INET6, .sin6_port = port}};
        inet_pton(AF_INET6, text, &ret->six.sin6_addr);
        return sizeof ret->six;
    }
    *ret = (Place){.four = {.sin_family = AF_INET, .sin_port = port}};
    if (*host != '*') inet_pton(AF_INET, text, &ret->four.sin_addr);
    return sizeof ret->four;
}

static bool bind_patiently(int fd, const Place *place, socklen_t size)
{
    const double until = clock_now() + PATIENCE;
    while (bind(fd, &place->any, size)) {
        if (errno != EADDRINUSE || clock_now() > until) return false;
        nanosleep(&(struct timespec){.tv_nsec = RETRY_MS * 1000000L}, NULL);
    }
    return true;
}

MnsStatus far_listen(const char *address, int *ret_fd, MnsError *error)
{
    Place place;
    const int yes = 1, no = 0;
    const socklen_t size = read_place(address, &place);
    const int fd = socket(place.any.sa_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    bool done = fd >= 0 && !setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    if (done && place.any.sa_family == AF_INET6) setsockopt(fd, IPPROTO_IPV6, IPV6_V6ONLY, &no, sizeof no);
    done = done && bind_patiently(fd, &place, size) && !listen(fd, BACKLOG);
    if (done) {
        *ret_fd = fd;
        return MNS_OK;
    }
    mns_fail(error, MNS_E_IO, "cannot listen at %s: %s", address, strerror(errno));
    if (fd >= 0) close(fd);
    return MNS_E_IO;
}

/* The soft limit is often 1024, and the hard one far beyond what can knock in the time that a handshake may take. */
int far_descriptors(void)
{
    enum { ENOUGH = 65536 };
    return open_files_raise(ENOUGH);
}

/* What is encrypted is a little longer than what is in it, and frames of the handshake are longer than some sockets allow. */
static void make_room(void *socket)
{
    enum { ENVELOPE = 64, HANDSHAKE = 1024 };
    int64_t largest;
    size_t size = sizeof largest;
    zmq_getsockopt(socket, ZMQ_MAXMSGSIZE, &largest, &size);
    largest = largest + ENVELOPE < HANDSHAKE ? HANDSHAKE : largest + ENVELOPE;
    zmq_setsockopt(socket, ZMQ_MAXMSGSIZE, &largest, sizeof largest);
}

/* ZeroMQ does not look at the address where it is given a socket that listens. */
bool far_take(const Access *access, void *socket, int fd)
{
    make_room(socket);
    access_guard_remote(access, socket);
    zmq_setsockopt(socket, ZMQ_USE_FD, &fd, sizeof fd);
    return !zmq_bind(socket, "tcp://127.0.0.1:*");
}
