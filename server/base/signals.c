/* SPDX-License-Identifier: BSD-3-Clause */
/* Signals are read, not delivered: what they ask for is done between other things, by a thread that may. */
#include "base/signals.h"

#include "base/clock.h"
#include <signal.h>
#include <sys/signalfd.h>
#include <unistd.h>

static const double INSISTENCE = 0.5; /* [s] after which a second signal is meant as one */

/* nohup(1) has it ignored, so that the closing of the terminal changes nothing. */
static bool is_ignored(int number)
{
    struct sigaction now;
    return !sigaction(number, NULL, &now) && now.sa_handler == SIG_IGN;
}

void signals_catch(Signals *signals)
{
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGTERM);
    sigaddset(&set, SIGINT);
    sigaddset(&set, SIGUSR1);
    if (!is_ignored(SIGHUP)) sigaddset(&set, SIGHUP);
    pthread_sigmask(SIG_BLOCK, &set, NULL);
    signal(SIGPIPE, SIG_IGN);
    *signals = (Signals){.fd = signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK)};
}

void signals_done(Signals *signals)
{
    close(signals->fd);
}

SignalWish signals_take(Signals *signals)
{
    struct signalfd_siginfo info;
    if (read(signals->fd, &info, sizeof info) != sizeof info) return SIGNAL_NOTHING;
    if (info.ssi_signo == SIGUSR1) return SIGNAL_CHECKPOINT;
    if (signals->leaving) return clock_now() - signals->asked_at > INSISTENCE ? SIGNAL_INSIST : SIGNAL_NOTHING;
    signals->leaving = true;
    signals->asked_at = clock_now();
    return SIGNAL_LEAVE;
}
