/* SPDX-License-Identifier: BSD-3-Clause */
/* Many subscribers of the telemetry in one process, so that one SIGSTOP stops them all.
 *
 * usage: subscribers ENDPOINT COUNT SECONDS [TOPIC]
 * Prints "ready" when each has heard something, and at the end, as a JSON line, how many frames came. It ends by itself, also with
 * whoever started it. */
#include "base/clock.h"
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>
#include <zmq.h>

enum { MOST = 4096, ROUND_US = 50000 };

static void *sockets[MOST];
static unsigned long heard[MOST];

static void raise_limit(void)
{
    struct rlimit limit;
    if (getrlimit(RLIMIT_NOFILE, &limit)) return;
    limit.rlim_cur = limit.rlim_max;
    setrlimit(RLIMIT_NOFILE, &limit);
}

/* Sockets that cannot be had end the program: a test with fewer would say too much. */
static void *subscribe(void *context, const char *endpoint, const char *topic)
{
    static const int none = 0;
    void *socket = zmq_socket(context, ZMQ_SUB);
    if (socket && !zmq_setsockopt(socket, ZMQ_LINGER, &none, sizeof none) &&
        !zmq_setsockopt(socket, ZMQ_SUBSCRIBE, topic, strlen(topic)) && !zmq_connect(socket, endpoint))
        return socket;
    fprintf(stderr, "subscribers: %s\n", zmq_strerror(zmq_errno()));
    exit(1);
}

static void take(size_t k, size_t *silent)
{
    char part[1 << 14];
    while (zmq_recv(sockets[k], part, sizeof part, ZMQ_DONTWAIT) >= 0)
        if (!heard[k]++) --*silent;
}

/* Twenty times a second, as to be woken for each message would take more of the processors than all that is measured. */
static unsigned long listen_to_all(size_t n, double until)
{
    unsigned long sum = 0;
    bool told = false;
    for (size_t silent = n; clock_now() < until; usleep(ROUND_US)) {
        for (size_t k = 0; k < n; k++) take(k, &silent);
        if (silent || told) continue;
        told = true;
        puts("ready");
        fflush(stdout);
    }
    for (size_t k = 0; k < n; k++) sum += heard[k];
    return sum;
}

int main(int argc, char **argv)
{
    const long n = argc > 3 ? atol(argv[2]) : 0;
    const double seconds = argc > 3 ? atof(argv[3]) : 0;
    if (n < 1 || n > MOST || !(seconds > 0)) {
        fprintf(stderr, "usage: subscribers ENDPOINT COUNT SECONDS [TOPIC]; at most %d\n", MOST);
        return 2;
    }
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    raise_limit();
    void *context = zmq_ctx_new();
    zmq_ctx_set(context, ZMQ_MAX_SOCKETS, MOST);
    for (long k = 0; k < n; k++) sockets[k] = subscribe(context, argv[1], argc > 4 ? argv[4] : "");
    const unsigned long frames = listen_to_all((size_t)n, clock_now() + seconds);
    printf("{\"subscribers\": %ld, \"frames\": %lu}\n", n, frames);
    for (long k = 0; k < n; k++) zmq_close(sockets[k]);
    zmq_ctx_term(context);
    return 0;
}
