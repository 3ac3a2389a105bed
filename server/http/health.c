/* SPDX-License-Identifier: BSD-3-Clause */
/* Is the daemon well? */
#include "http/health.h"
#include "common/host/text.h"

#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Takes over the object. */
static char *print(json_t *object)
{
    char *text = object ? json_dumps(object, JSON_COMPACT) : NULL;
    json_decref(object);
    return text;
}

char *health_alive(const View *view)
{
    return print(json_pack("{s:s, s:s, s:s}", "status", "ok", "name", view->from->name, "version", MENISCUS_VERSION));
}

/* May a run be asked for, or mended? What is commanded while a case is loaded waits for that, or ends it. */
static bool takes_commands(RunState state)
{
    return state != RUN_RECOVERING && state != RUN_STOPPING;
}

/* Why there is no run, and what to do; empty if there is one that is well. */
static void find_reason(const View *view, char *text, size_t size)
{
    *text = 0;
    switch (view->run->state) {
    case RUN_EMPTY:
        snprintf(text, size, "%s",
                 view->run->fault.status ? view->run->fault.text : "there is no run; load one: meniscus load CASE");
        return;
    case RUN_LOADING: snprintf(text, size, "a case is being loaded; ask again"); return;
    case RUN_RECOVERING: snprintf(text, size, "the run is being brought back to where it was; ask again"); return;
    case RUN_STOPPING: snprintf(text, size, "the daemon is leaving"); return;
    case RUN_FAULT: snprintf(text, size, "%s", view->run->fault.text); return;
    default: return;
    }
}

static void find_refusal(const View *view, char *text, size_t size)
{
    if (view->disk.refused)
        snprintf(text, size, "nothing can be written to '%.300s': %s; mend that, or the next output stops the run",
                 view->from->directory, strerror(view->disk.refused));
}

char *health_ready(const View *view, bool loaded, bool *ret_ready)
{
    char reason[1024];
    const RunFigures *run = view->run;
    find_reason(view, reason, sizeof reason);
    const bool good = !*reason || (!loaded && takes_commands(run->state));
    if (good) find_refusal(view, reason, sizeof reason);
    *ret_ready = good && !view->disk.refused;
    if (*ret_ready && !run->fault.status) *reason = 0; /* as it was about to say that there is no run */
    json_t *object = json_pack("{s:b, s:s}", "ready", *ret_ready, "state", run_state_name(run->state));
    if (run->document) json_object_set_new(object, "case", json_string(run->document->name));
    char *valid = text_valid(reason); /* there may be names of files in it */
    if (*reason && valid) json_object_set_new(object, "reason", json_string(valid));
    free(valid);
    if (run->fault.status) json_object_set_new(object, "fault_reason", json_string(mns_status_name(run->fault.status)));
    return print(object);
}
