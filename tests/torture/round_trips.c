/* SPDX-License-Identifier: BSD-3-Clause */
/* How long a client waits for `status`, as a JSON line: median, 99 and 99.9 per cent, the longest.
 *
 * usage: round_trips ENDPOINT SECONDS [PAUSE_MS [KEY_FILE]]
 * Between two questions it waits at random, PAUSE_MS in the mean, so as not to fall into step with the solver. */
#include "base/clock.h"
#include <meniscus/client.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

enum { MOST = 1 << 20 };

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static MnsStatus ask(MnsClient *client, double *ret_s, MnsError *error)
{
    MnsReply *reply = NULL;
    const double began = clock_now();
    const MnsStatus status = mns_client_status(client, &reply, error);
    *ret_s = clock_now() - began;
    mns_reply_free(reply);
    return status;
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
        fputs("usage: round_trips ENDPOINT SECONDS [PAUSE_MS [KEY_FILE]]\n", stderr);
        return 2;
    }
    static double waits[MOST];
    size_t n = 0;
    MnsClient *client = NULL;
    MnsError error;
    const MnsClientOptions options = {.daemon = argv[1], .key_file = argc > 4 ? argv[4] : NULL};
    MnsStatus status = mns_client_open_with(&options, &client, &error);
    for (const double until = clock_now() + seconds; !status && n < MOST && clock_now() < until; n++) {
        status = ask(client, &waits[n], &error);
        if (pause_ms > 0) usleep((useconds_t)(2e3 * pause_ms * drand48()));
    }
    mns_client_close(client);
    if (status) fprintf(stderr, "round_trips: %s\n", error.text);
    else print_waits(waits, n);
    return status ? 1 : 0;
}
