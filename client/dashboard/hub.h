/* SPDX-License-Identifier: BSD-3-Clause */
/* Where the threads that talk to the daemon meet the one that serves browsers. It remembers what a browser that comes later must know. */
#ifndef DASHBOARD_HUB_H
#define DASHBOARD_HUB_H

#include "client/dashboard/history.h"
#include "client/dashboard/session.h"

enum { HUB_BROWSERS = 32, HUB_EVENTS = 200, HUB_COMMANDS = 16 };

typedef struct Hub Hub;

/* What is said to all browsers. Of those before TELL_EVENT the latest is remembered, of events the last HUB_EVENTS; what is passing is
 * said again for as long as it holds. */
typedef enum TellKind {
    TELL_DAEMON,
    TELL_ABOUT,
    TELL_STATUS,
    TELL_PROGRESS,
    TELL_EVENT,
    TELL_SAMPLES,
    TELL_PASSING
} TellKind;

/* daemon: as mns_client_open() takes it; borrowed. NULL if there is no memory. */
Hub *hub_new(const char *daemon);
const char *hub_daemon(const Hub *hub);

/* Is the daemon on another machine, for all we know? The path of its run says nothing here, where another run may have the same. */
bool hub_is_far(const Hub *hub);

/* wake(arg) is called, on any thread, when there is something to take. */
void hub_set_wake(Hub *hub, void (*wake)(void *arg), void *arg);

/* --- from the daemon's side: any thread -------------------------------------------------------------------------------- */

/* Say something to all browsers; takes the object, also NULL, which says nothing. */
void hub_tell(Hub *hub, TellKind kind, json_t *object);

/* Say something to one browser. */
void hub_answer(Hub *hub, uint64_t browser, json_t *object);

/* A sample of the probes for the history. */
void hub_sample(Hub *hub, double t, size_t n, const MnsValue *values);

/* What was before the first sample, taken over if the history is still the one of that version; browsers then get all of it again. */
void hub_precede(Hub *hub, uint64_t version, History *past);
uint64_t hub_history_version(Hub *hub);

/* Another run, or another start of the daemon: what was told of the last one is forgotten. */
void hub_forget(Hub *hub);

/* Something may have changed at the same step: the next frame has another key. */
void hub_renew(Hub *hub);
uint64_t hub_generation(Hub *hub);

/* A frame for whoever wants it; taken. */
void hub_show(Hub *hub, Frame *frame);

/* A wish of some browser, and the newest frame there is of it. */
typedef struct Demand {
    Wish wish;
    bool has;
    FrameKey have;
} Demand;

/* Wait, at most half a second, until browsers want frames. How many there are in ret. */
size_t hub_await_demands(Hub *hub, Demand ret[static HUB_BROWSERS]);

/* May one more command be under way? Each true is followed by one hub_end_command(). */
bool hub_begin_command(Hub *hub);
void hub_end_command(Hub *hub);

/* The run directory of the latest status, "" if there is none. */
void hub_set_directory(Hub *hub, const char *directory);
void hub_directory(Hub *hub, char ret[static 4096]);

/* --- from the browsers' side: one thread ------------------------------------------------------------------------------- */

/* The next text, for *ret_browser or for all if that is 0; NULL if there is none. */
Text *hub_take_text(Hub *hub, uint64_t *ret_browser);

/* The next frame, or NULL. */
Frame *hub_take_frame(Hub *hub);

void hub_set_demands(Hub *hub, size_t n, const Demand *demands);

/* Queue for a browser all that is remembered, of the history the first piece. @return false as session_send(). */
bool hub_recall(Hub *hub, Session *session);

/* Begin with the history alone, unless it is on its way already. */
bool hub_recall_history(Hub *hub, Session *session);

/* Queue the next piece of the history, if one is due and none waits. Another history is sent without being asked for. */
bool hub_recall_more(Hub *hub, Session *session);

#endif
