/* SPDX-License-Identifier: BSD-3-Clause */
/* How long a client waits for `status`, as a JSON line: median, 99 and 99.9 per cent, the longest.
 *
 * usage: round_trips ENDPOINT|echo SECONDS [PAUSE_MS [KEY_FILE]]
 * echo: for the echo of a process that does nothing else, through ZeroMQ as to a daemon: what this machine gives at best. Between two questions it waits at random, PAUSE_MS in the mean, so as not to fall into step with the solver. */
#include "base/clock.h"
#include <meniscus/client.h>
#include <meniscus/status.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <unistd.h>
#include <zmq.h>

enum { MOST = 1 << 20, REQUEST_BYTES = 32, REPLY_BYTES = 512 }; /* of a status */

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Whom the questions go to: a daemon, or else the socket of an echo. */
typedef struct Peer {
    MnsClient *client;
    void *context, *socket;
    pid_t echo;
} Peer;

static MnsStatus ask(const Peer *peer, double *ret_s, MnsError *error)
{
    char question[REQUEST_BYTES] = "", answer[REPLY_BYTES];
    MnsReply *reply = NULL;
    MnsStatus status = MNS_OK;
    const double began = clock_now();
    if (peer->client) status = mns_client_status(peer->client, &reply, error);
    else if (zmq_send(peer->socket, question, sizeof question, 0) < 0 ||
             zmq_recv(peer->socket, answer, sizeof answer, 0) < 0)
        status = mns_fail(error, MNS_E_IO, "the echo: %s", zmq_strerror(zmq_errno()));
    *ret_s = clock_now() - began;
    mns_reply_free(reply);
    return status;
}

static void echo(const char *endpoint)
{
    char identity[256], question[REQUEST_BYTES];
    static const char answer[REPLY_BYTES];
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    void *socket = zmq_socket(zmq_ctx_new(), ZMQ_ROUTER);
    if (!socket || zmq_bind(socket, endpoint)) _exit(1);
    for (;;) {
        const int size = zmq_recv(socket, identity, sizeof identity, 0);
        if (size < 0 || zmq_recv(socket, question, sizeof question, 0) < 0) _exit(1);
        zmq_send(socket, identity, (size_t)size, ZMQ_SNDMORE);
        zmq_send(socket, answer, sizeof answer, 0);
    }
}

static MnsStatus open_echo(Peer *peer, MnsError *error)
{
    char endpoint[64];
    snprintf(endpoint, sizeof endpoint, "ipc://@meniscus-echo-%ld", (long)getpid());
    peer->echo = fork();
    if (peer->echo < 0) return mns_fail(error, MNS_E_MEMORY, "no process for the echo: %m");
    if (!peer->echo) echo(endpoint);
    peer->context = zmq_ctx_new();
    peer->socket = zmq_socket(peer->context, ZMQ_DEALER);
    if (peer->socket && !zmq_connect(peer->socket, endpoint)) return MNS_OK;
    return mns_fail(error, MNS_E_IO, "the echo: %s", zmq_strerror(zmq_errno()));
}

static void close_peer(const Peer *peer)
{
    mns_client_close(peer->client);
    if (peer->echo > 0) kill(peer->echo, SIGKILL);
    if (peer->socket) zmq_close(peer->socket);
    if (peer->context) zmq_ctx_term(peer->context);
}

static void print_waits(double *waits, size_t n)
{
    qsort(waits, n, sizeof *waits, ascending);
    const double last = (double)(n - 1);
    printf("{\"n\": %zu, \"p50_ms\": %.4f, \"p99_ms\": %.4f, \"p999_ms\": %.4f, \"max_ms\": %.4f}\n", n,
           1e3 * waits[(size_t)(0.5 * last)], 1e3 * waits[(size_t)(0.99 * last)], 1e3 * waits[(size_t)(0.999 * last)],
           1e3 * waits[n - 1]);
}

int main(int argc, char **argv)
{
    const double seconds = argc > 2 ? atof(argv[2]) : 0, pause_ms = argc > 3 ? atof(argv[3]) : 1;
    if (!(seconds > 0)) {
        fputs("usage: round_trips ENDPOINT|echo SECONDS [PAUSE_MS [KEY_FILE]]\n", stderr);
        return 2;
    }
    static double waits[MOST];
    size_t n = 0;
    Peer peer = {.echo = 0};
    MnsError error;
    const MnsClientOptions options = {.daemon = argv[1], .key_file = argc > 4 ? argv[4] : NULL};
    MnsStatus status =
        strcmp(argv[1], "echo") ? mns_client_open_with(&options, &peer.client, &error) : open_echo(&peer, &error);
    double first;
    if (!status) status = ask(&peer, &first, &error); /* not counted: the connection is made with it */
    for (const double until = clock_now() + seconds; !status && n < MOST && clock_now() < until; n++) {
        status = ask(&peer, &waits[n], &error);
        if (pause_ms > 0) usleep((useconds_t)(2e3 * pause_ms * drand48()));
    }
    close_peer(&peer);
    if (status) fprintf(stderr, "round_trips: %s\n", error.text);
    else print_waits(waits, n);
    return status ? 1 : 0;
}
