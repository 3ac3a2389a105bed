/* SPDX-License-Identifier: BSD-3-Clause */
/* What the service manager hears. Signs of life come from the run's own heart: a helper thread that sent them by itself
 * would hide a solver that hangs. It beats with each pass of a step and each iteration of a solve, as a step can take longer than the
 * watchdog has patience; on the way back and while particles are placed too. */
#include "net/notify.h"

#include "base/clock.h"
#include <stdlib.h>
#include <systemd/sd-daemon.h>

static const double STATUS_INTERVAL = 1, STOPPING_INTERVAL = 5; /* [s] */

void notify_begin(Notify *notify)
{
    uint64_t microseconds = 0;
    *notify = (Notify){.watchdog = 0};
    if (sd_watchdog_enabled(0, &microseconds) > 0) notify->watchdog = 1e-6 * (double)microseconds;
}

void notify_ready(void)
{
    sd_notify(0, "READY=1");
}

void notify_status(Notify *notify, bool important, const char *text)
{
    const double now = clock_now();
    if (!important && now - notify->status < STATUS_INTERVAL) return;
    notify->status = now;
    sd_notifyf(0, "STATUS=%s", text);
}

void notify_stopping(void)
{
    sd_notify(0, "STOPPING=1");
}

void notify_look(Notify *notify, Run *run)
{
    const double now = clock_now();
    if (now < notify->next) return;
    const uint64_t beat = run_heartbeat(run);
    RunStatus *status = malloc(sizeof *status);
    if (!status) return;
    run_status(run, status);
    const RunState state = status->state;
    free(status);
    notify->next = now + (notify->watchdog > 0 ? notify->watchdog / 4 : STOPPING_INTERVAL);
    const bool alive = beat != notify->beat; /* it beats while it places particles, too, and on its way back */
    notify->beat = beat;
    if (alive && notify->watchdog > 0) sd_notify(0, "WATCHDOG=1");
    if (alive && state == RUN_STOPPING) sd_notifyf(0, "EXTEND_TIMEOUT_USEC=%d", (int)(4e6 * STOPPING_INTERVAL));
}
