/* SPDX-License-Identifier: BSD-3-Clause */
/* The gate, as the daemon sees it: started, listened to, started again. */
#include "net/gate.h"

#include "base/clock.h"
#include "base/log.h"
#include "common/host/children.h"
#include "net/far.h"
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

enum { FARS = 3, FAREWELL_MS = 1000 };

/* One that ends soon after it began is started again after a while that doubles: [s]. */
static const double SOON = 2, FIRST_WAIT = 0.05, LONGEST_WAIT = 1;

/* One that is silent for so long hangs; it may take longer until the first word, as a program has to be loaded for that: [s]. */
static const double SILENCE = 3, FIRST_SILENCE = 20;

struct Gate {
    const Endpoint *at;
    int listening[FARS];
    Child process;
    int line;
    bool renewed; /* it was ended by us */
    bool heard;   /* it has given a sign of life */
    bool hangs;   /* it was ended for giving none */
    double began, due, wait;
    double looked,
        silence;         /* clock_now() at the last look; seconds without a sign, as far as we were there to hear one */
    GateNews news, past; /* of this one; of all before, in sums */
    uint64_t restarts;
};

MnsStatus gate_new(const Endpoint *at, Gate **ret, MnsError *error)
{
    Gate *gate = calloc(1, sizeof *gate);
    if (!gate) return mns_fail(error, MNS_E_MEMORY, "no memory for the gate");
    *gate = (Gate){.at = at, .listening = {-1, -1, -1}, .line = -1, .due = -INFINITY};
    const char *const addresses[FARS] = {at->far_control, at->far_telemetry, at->far_data};
    MnsStatus status = MNS_OK;
    for (int k = 0; k < FARS && !status; k++) status = far_listen(addresses[k], &gate->listening[k], error);
    if (status) gate_free(gate);
    else *ret = gate;
    return status;
}

/* --- a process ------------------------------------------------------------------------------------------------------------ */

/* Those that it begins with lie above all that they become, so that none takes the place of another that has not moved yet. */
static bool lift(const Gate *gate, int line, int ret[FARS + 1])
{
    bool all = true;
    ret[0] = fcntl(line, F_DUPFD_CLOEXEC, GATE_REST);
    for (int k = 0; k < FARS; k++) ret[1 + k] = fcntl(gate->listening[k], F_DUPFD_CLOEXEC, GATE_REST);
    for (int k = 0; k <= FARS; k++) all &= ret[k] >= 0;
    return all;
}

/* Without fork(), which would have to copy the tables of all memory, and make the solver wait for each page that it writes after that. 0 or errno. */
static int spawn(Gate *gate, int line)
{
    const Endpoint *at = gate->at;
    char level[4] = {(char)('0' + log_level()), 0};
    char *const words[GATE_WORDS + 1] = {
        (char *)log_program(), GATE_WORD, level, (char *)at->keys, (char *)at->gate_control, (char *)at->gate_telemetry,
        (char *)at->gate_data};
    posix_spawn_file_actions_t actions;
    int fds[FARS + 1];
    const bool lifted = lift(gate, line, fds);
    int why = lifted ? posix_spawn_file_actions_init(&actions) : errno;
    if (!why) {
        for (int k = 0; k <= FARS; k++) posix_spawn_file_actions_adddup2(&actions, fds[k], GATE_LINE + k);
        posix_spawn_file_actions_addclosefrom_np(&actions, GATE_REST);
        why = children_start(&gate->process, "/proc/self/exe", &actions, words);
        posix_spawn_file_actions_destroy(&actions);
    }
    for (int k = 0; k <= FARS; k++)
        if (fds[k] >= 0) close(fds[k]);
    return why;
}

static void start(Gate *gate)
{
    int line[2];
    int why = socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, line) ? errno : 0;
    gate->began = gate->looked = clock_now();
    gate->heard = gate->hangs = false;
    gate->silence = 0;
    if (!why) {
        why = spawn(gate, line[1]);
        close(line[1]);
        if (why) close(line[0]);
        else gate->line = line[0];
    }
    gate->wait = gate->wait > 0 ? fmin(2 * gate->wait, LONGEST_WAIT) : FIRST_WAIT;
    gate->due = why ? gate->began + gate->wait : INFINITY;
    if (why) log_line(LOG_ERROR, "cannot start the gate for those from afar: %s; trying on", strerror(why));
}

/* --- what becomes of it --------------------------------------------------------------------------------------------------- */

static void tell_end(const Gate *gate, int how)
{
    const double wait = fmax(gate->due - clock_now(), 0);
    if (WIFSIGNALED(how))
        log_line(LOG_WARNING,
                 "the gate for those from afar was ended by signal %d (%s); the run goes on, and another one begins in "
                 "%.1f s",
                 WTERMSIG(how), strsignal(WTERMSIG(how)), wait);
    else
        log_line(
            LOG_WARNING,
            "the gate for those from afar has ended with code %d; the run goes on, and another one begins in %.1f s",
            WEXITSTATUS(how), wait);
}

/* It has let go of the line, and so has ended or will at once. */
static void bury(Gate *gate)
{
    kill(gate->process.pid, SIGKILL);
    const int how = children_wait(&gate->process);
    close(gate->line);
    const double now = clock_now();
    for (int k = 0; k < TRAFFIC_FAILURES; k++) gate->past.failures[k] += gate->news.failures[k];
    gate->past.shown_out += gate->news.shown_out;
    gate->news = (GateNews){.listeners = 0};
    gate->line = -1;
    if (gate->renewed || now > gate->began + SOON) gate->wait = 0;
    gate->due = gate->wait > 0 ? now + gate->wait : now;
    if (!gate->renewed) {
        gate->restarts++;
        tell_end(gate, how);
    }
    gate->renewed = false;
}

/* False: the line is cut. */
static bool listen_to(Gate *gate)
{
    GateNews news;
    for (;;) {
        const ssize_t size = recv(gate->line, &news, sizeof news, 0);
        if (size == sizeof news) {
            gate->news = news;
            gate->heard = true;
            gate->silence = 0;
        } else if (size == 0 || (size < 0 && errno != EAGAIN && errno != EINTR)) return false;
        else if (size < 0) return true;
    }
}

/* Between two looks no more is counted than the time in which a sign is due: where the machine slept, or this process was stopped or got no processor,
 * the gate may have been no better off. So one that hangs has let several looks pass. Its end is told by the line, as of any other, and waited for there. */
static void mind_silence(Gate *gate)
{
    const double now = clock_now();
    gate->silence += fmin(now - gate->looked, GATE_SIGN);
    gate->looked = now;
    if (gate->hangs || gate->silence < (gate->heard ? SILENCE : FIRST_SILENCE)) return;
    gate->hangs = true;
    log_line(LOG_WARNING, "the gate for those from afar hangs: it has given no sign of life for %.0f s, and is ended",
             gate->silence);
    kill(gate->process.pid, SIGKILL);
}

double gate_look(Gate *gate, Traffic *traffic)
{
    if (!gate) return INFINITY;
    if (gate->process.pid && !listen_to(gate)) bury(gate);
    if (!gate->process.pid && clock_now() >= gate->due) start(gate);
    if (gate->process.pid) mind_silence(gate);
    for (int k = 0; k < TRAFFIC_FAILURES; k++)
        traffic->gate_failures[k] = gate->past.failures[k] + gate->news.failures[k];
    traffic->shown_out = gate->past.shown_out + gate->news.shown_out;
    traffic->gate_restarts = gate->restarts;
    return gate->process.pid ? gate->looked + GATE_SIGN : gate->due;
}

int gate_line(const Gate *gate)
{
    return gate ? gate->line : -1;
}

long gate_listeners(const Gate *gate)
{
    return gate && gate->news.listeners > 0 ? (long)gate->news.listeners : 0;
}

void gate_renew(Gate *gate)
{
    if (!gate || !gate->process.pid) return;
    gate->renewed = true;
    kill(gate->process.pid, SIGKILL);
}

/* What is written to the line is nothing, and its end: that is the sign to leave. */
static void see_off(Gate *gate)
{
    const double until = clock_now() + 1e-3 * FAREWELL_MS;
    struct pollfd line = {.fd = gate->line, .events = POLLIN};
    shutdown(gate->line, SHUT_WR);
    for (double left; listen_to(gate) && (left = until - clock_now()) > 0;) poll(&line, 1, (int)(1e3 * left) + 1);
    gate->renewed = true;
    bury(gate);
}

void gate_free(Gate *gate)
{
    if (!gate) return;
    if (gate->process.pid) see_off(gate);
    for (int k = 0; k < FARS; k++)
        if (gate->listening[k] >= 0) close(gate->listening[k]);
    free(gate);
}
