/* SPDX-License-Identifier: BSD-3-Clause */
/* What happened to a run before anybody listened: the last lines of the log in its directory. */
#ifndef DASHBOARD_DIARY_H
#define DASHBOARD_DIARY_H

#include "client/dashboard/hub.h"

enum { DIARY_LINES = 100 };

/* Tell the browsers of it, as events with the time of day. Returns an array of their texts, the caller's, or NULL. A log that is not
 * there, as that of a daemon on another machine, tells of nothing. */
json_t *diary_tell(Hub *hub, const char *directory);

/* "2026-11-25T23:13:57Z step 12 t 0.5 running: started", which is taken apart; NULL if it is no such line. */
json_t *diary_event(char *line);

#endif
