/* SPDX-License-Identifier: BSD-3-Clause */
/* The threads that talk to the daemon: one listens, one fetches particles, and one more for each command under way. They are never joined,
 * as any of them may wait for the daemon; they end with the process. */
#ifndef DASHBOARD_WATCHER_H
#define DASHBOARD_WATCHER_H

#include "client/dashboard/ask.h"
#include "client/dashboard/hub.h"

/* Listen: telemetry, a status every second, what the daemon can do whenever that may have changed. */
MnsStatus watcher_start(Hub *hub, MnsError *error);

/* Is there a run with particles that can be looked at, rather than one that comes or goes? */
bool watcher_is_settled(MnsState state);

/* Fetch frames that browsers want, at most so many a second in all. */
MnsStatus painter_start(Hub *hub, double frames_per_second, MnsError *error);

/* Fetch what the probes of a run measured before `until` [s], and put it before the history. Without memory or a thread for it, the history
 * begins where it was listened to. */
void backlog_start(Hub *hub, double until);

/* Give a command, or read the journal, on a thread of its own; the answer goes to the browser. Takes the ask, also on failure.
 * MNS_E_LIMIT: too many are under way; MNS_E_MEMORY: there is no memory or no thread for it. */
MnsStatus worker_start(Hub *hub, uint64_t browser, Ask *ask, MnsError *error);

/* The failure of what a browser has asked under this id. */
json_t *worker_refusal(uint64_t id, const MnsError *error);

#endif
