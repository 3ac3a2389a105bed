/* SPDX-License-Identifier: BSD-3-Clause */
/* How long the solver stands still for a capture of its state, as the daemon takes them, beside a memcpy() of as many bytes: by one
 * thread, into memory that is there. As a JSON line; the median of so many of each, in turns, and the first capture, for which the
 * system must find the memory.
 *
 * usage: capture [THREADS [TURNS [DIMENSIONS RESOLUTION]]] */
#include "base/clock.h"
#include "run/environment.h"
#include "sim/sim.h"
#include "tests/support/cases.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TURNS_MAX = 1000 };

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values, int n)
{
    qsort(values, (size_t)n, sizeof *values, ascending);
    return values[n / 2];
}

typedef struct Turns {
    double capture[TURNS_MAX], copy[TURNS_MAX];
    double first;
} Turns;

/* Into the room of the one before, which the writer gives back when it has written it. */
static MnsStatus capture_again(const MnsSim *sim, MnsCapture **capture, MnsError *error)
{
    const uint64_t fields = mns_sim_state_fields(sim);
    return *capture ? mns_sim_recapture(sim, fields, *capture, error) : mns_sim_capture(sim, fields, capture, error);
}

static MnsStatus take_turns(MnsSim *sim, int n, size_t size, Turns *ret, MnsError *error)
{
    char *from = malloc(size), *to = malloc(size);
    MnsCapture *capture = NULL;
    MnsStatus status = from && to ? MNS_OK : mns_fail(error, MNS_E_MEMORY, "no memory for %zu bytes", size);
    if (!status) memset(from, 1, size), memset(to, 2, size);
    for (int k = 0; k <= n && !status; k++) {
        status = mns_sim_step(sim, INFINITY, error); /* so that caches are as they are in a run */
        const double began = clock_now();
        if (!status) status = capture_again(sim, &capture, error);
        const double captured = clock_now();
        memcpy(to, from, size);
        if (k) ret->copy[k - 1] = clock_now() - captured;
        if (k) ret->capture[k - 1] = captured - began;
        else ret->first = captured - began;
        from[k % 64] = to[(k + 1) % 64]; /* or the copy could be left out */
    }
    mns_capture_free(capture);
    free(from);
    free(to);
    return status;
}

int main(int argc, char **argv)
{
    environment_waiting(argv);
    const int threads = argc > 1 ? atoi(argv[1]) : 1, turns = argc > 2 ? atoi(argv[2]) : 20;
    const int dim = argc > 4 ? atoi(argv[3]) : 3;
    const double resolution = argc > 4 ? atof(argv[4]) : 20;
    static Turns times;
    MnsError error;
    MnsSim *sim = NULL;
    if (threads < 1 || turns < 1 || turns > TURNS_MAX) {
        fprintf(stderr, "usage: capture [THREADS [TURNS [DIMENSIONS RESOLUTION]]]; at most %d turns\n", TURNS_MAX);
        return 2;
    }
    MnsCase *c = case_dam_break(dim, resolution);
    c->threads = (unsigned)threads;
    MnsStatus status = mns_sim_new(c, &sim, &error);
    const size_t size = status ? 0 : mns_sim_capture_size(sim, mns_sim_state_fields(sim));
    if (!status) status = take_turns(sim, turns, size, &times, &error);
    if (status) fprintf(stderr, "capture: %s\n", error.text);
    else {
        const double capture = median(times.capture, turns), copy = median(times.copy, turns);
        printf("{\"bytes\": %zu, \"turns\": %d, \"capture_ms\": %.4f, \"memcpy_ms\": %.4f, \"ratio\": %.3f, "
               "\"first_ms\": %.4f}\n",
               size, turns, 1e3 * capture, 1e3 * copy, capture / copy, 1e3 * times.first);
    }
    mns_sim_free(sim);
    mns_case_free(c);
    return status ? 1 : 0;
}
