/* SPDX-License-Identifier: BSD-3-Clause */
/* What others see of a run: its status, and notes of what happens. */
#include "run/inside.h"

#include "base/clock.h"
#include "base/log.h"
#include "common/host/text.h"
#include "io/atomic_file.h"
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static const double PROGRESS_INTERVAL = 0.2; /* [s], of the notes for people */

bool run_state_moves(RunState state)
{
    return state == RUN_RUNNING || state == RUN_LOADING || state == RUN_RECOVERING;
}

bool run_state_steps(RunState state)
{
    return state == RUN_RUNNING || state == RUN_RECOVERING;
}

const char *run_state_name(RunState state)
{
    static const char *const names[RUN_STATES] = {"EMPTY", "LOADING", "READY",    "RUNNING",   "PAUSED",
                                                  "DONE",  "FAULT",   "STOPPING", "RECOVERING"};
    return (unsigned)state < RUN_STATES ? names[state] : "UNKNOWN";
}

void run_beat(void *run)
{
    ((Run *)run)->beat++;
}

uint64_t run_heartbeat(Run *run)
{
    return run->beat;
}

void run_status(Run *run, RunStatus *ret)
{
    pthread_mutex_lock(&run->lock);
    *ret = run->status;
    pthread_mutex_unlock(&run->lock);
    ret->samples_dropped = outbox_dropped(&run->outbox);
}

Document *run_document(Run *run)
{
    pthread_mutex_lock(&run->lock);
    Document *document = document_share(run->published);
    pthread_mutex_unlock(&run->lock);
    return document;
}

uint64_t run_version(const Run *run)
{
    return run->sim && run->state != RUN_RECOVERING ? run->versions.number : 0;
}

static void add_timer(RunStatus *status, MnsTimer timer)
{
    if (status->n_timers < RUN_TIMERS) status->timers[status->n_timers++] = timer;
}

/* Of all the time in motion: the solver's, that of the outputs, and what is left: orders, the journal, news for those who watch. */
static void fill_timers(const Run *run, RunStatus *status)
{
    size_t n;
    const MnsTimer *timers = mns_sim_timers(run->sim, &n);
    double between = status->wall - status->stepping;
    status->n_timers = 0;
    for (size_t k = 0; k < n; k++) add_timer(status, timers[k]);
    for (size_t k = 0; k < OUTPUTS_TIMERS; k++) {
        add_timer(status, run->outputs.timers[k]);
        between -= run->outputs.timers[k].seconds;
    }
    add_timer(status, (MnsTimer){"between steps", fmax(between, 0), run->meter.steps});
}

/* With the lock held, and a simulation. */
static void fill_numbers(const Run *run, RunStatus *status)
{
    status->progress = mns_sim_progress(run->sim);
    status->uncorrected = mns_sim_uncorrected(run->sim);
    status->energy_excess = mns_sim_energy_excess(run->sim);
    status->losses = mns_sim_losses(run->sim);
    const double now = clock_now();
    status->steps_per_second = run->state == RUN_RUNNING ? meter_rate(&run->meter) : NAN;
    status->eta = run->state == RUN_RUNNING ? meter_eta(&run->meter, status->progress.t, status->end_time) : NAN;
    status->ns_per_particle_step = meter_ns(&run->meter);
    status->stepping = run->meter.stepping;
    status->wall = meter_ran(&run->meter, now);
    status->age = now - run->loaded;
    fill_timers(run, status);
}

void run_publish_step(Run *run)
{
    pthread_mutex_lock(&run->lock);
    fill_numbers(run, &run->status);
    pthread_mutex_unlock(&run->lock);
}

static void fill_scheduled(const Run *run, RunStatus *status)
{
    for (const Order *order = run->agenda.first; order; order = order->next) {
        if (!order->announced) continue; /* not on the disk yet */
        RunScheduled *item = &status->scheduled[status->n_scheduled++];
        memcpy(item->id, order->id, sizeof item->id);
        item->at = order->at;
        snprintf(item->who, sizeof item->who, "%s", order->who.name);
        run_describe_scheduled(order, item->what, sizeof item->what);
    }
}

static void fill_case(const Run *run, RunStatus *status)
{
    const MnsCase *c = run->document->c;
    snprintf(status->case_name, sizeof status->case_name, "%s", run->document->name);
    snprintf(status->title, sizeof status->title, "%s", c->title);
    memcpy(status->directory, run->outputs.directory, sizeof status->directory);
    status->end_time = c->end_time;
    status->version = run_version(run);
    status->threads = (unsigned)mns_sim_threads(run->sim);
    status->particles = mns_sim_particles(run->sim);
    status->fluid_particles = mns_sim_fluid_particles(run->sim);
    status->bytes = mns_sim_bytes(run->sim);
    status->fields = tap_fields_of(run->sim);
    breakpoints_list(run->breakpoints, status->breakpoints, &status->n_breakpoints);
    fill_scheduled(run, status);
    fill_numbers(run, status);
}

static bool stands_still(const Run *run)
{
    return run->sim && !run_state_moves(run->state);
}

static bool is_hash_due(const Run *run)
{
    return stands_still(run) && !run->hashed && run->state != RUN_STOPPING;
}

/* With the lock held. */
static void fill_hash(const Run *run, RunStatus *status)
{
    status->hash = stands_still(run) && run->hashed ? run->hash : 0;
    status->hash_due = is_hash_due(run);
}

void run_hash(Run *run)
{
    if (run->hashed) return;
    run->hash = mns_sim_hash(run->sim);
    run->hashed = true;
    run_note_hash(run);
}

void run_settle(Run *run)
{
    if (!is_hash_due(run)) return;
    run_commit(run);
    run_hash(run);
    pthread_mutex_lock(&run->lock);
    fill_hash(run, &run->status);
    pthread_mutex_unlock(&run->lock);
}

void run_publish(Run *run)
{
    run->to_publish = run->withheld;
    if (run->withheld) return;
    pthread_mutex_lock(&run->lock);
    RunStatus *status = &run->status;
    memset(status, 0, sizeof *status);
    status->steps_per_second = status->ns_per_particle_step = status->eta = status->end_time = NAN;
    status->state = run->state;
    fill_hash(run, status);
    if (run->state == RUN_FAULT || run->state == RUN_EMPTY) status->fault = run->fault;
    if (run->sim) fill_case(run, status);
    if (run->state == RUN_RECOVERING && run->recovery.lineage) {
        const uint64_t known = run->recovery.lineage->step, checkpoint = run->recovery.checkpoint;
        status->recovery_step = known > checkpoint ? known : checkpoint;
    }
    status->lease = run->lease;
    document_leave(run->published);
    run->published = document_share(run->document);
    pthread_mutex_unlock(&run->lock);
    run_show(run);
}

static void send(Run *run, Note *note)
{
    if (!run->withheld) {
        outbox_put(&run->outbox, note);
        return;
    }
    note->next = NULL;
    if (run->last_unsent) run->last_unsent->next = note;
    else run->unsent = note;
    run->last_unsent = note;
}

void run_reveal(Run *run)
{
    run->withheld = false;
    if (run->to_publish) run_publish(run);
    for (Note *note = run->unsent, *next; note; note = next) {
        next = note->next;
        outbox_put(&run->outbox, note);
    }
    run->unsent = run->last_unsent = NULL;
}

static Note *note_now(const Run *run, NoteKind kind)
{
    Note *note = note_new(kind, 0);
    if (!note) return NULL;
    const MnsProgress now = run->sim ? mns_sim_progress(run->sim) : (MnsProgress){.t = 0};
    note->state = run->state;
    note->step = now.step;
    note->t = now.t;
    return note;
}

/* A line in the log of the run directory; a full disk must not stop a run because of its log. @return 0 or an errno. */
static int write_log(const Run *run, const char *word, const char *text)
{
    char moment[32];
    const time_t now = time(NULL);
    struct tm parts;
    if (!run->log || !run->sim) return 0;
    strftime(moment, sizeof moment, "%Y-%m-%dT%H:%M:%SZ", gmtime_r(&now, &parts));
    const MnsProgress at = mns_sim_progress(run->sim);
    char *shown = text_escaped(text); /* one line for each event, whatever a text has */
    if (shown) fprintf(run->log, "%s step %lu t %.9g %s: %s\n", moment, (unsigned long)at.step, at.t, word, shown);
    free(shown);
    return fflush(run->log) ? errno : 0;
}

/* Once for a log. */
static void tell_lacking(Run *run, int number)
{
    char path[4096], text[768];
    MnsError error;
    if (!number || run->log_lacks) return;
    run->log_lacks = true;
    snprintf(path, sizeof path, "%s/log", run->outputs.directory);
    file_fail(&error, number, "write", path);
    snprintf(text, sizeof text, "the log of this run lacks lines: %.600s", error.text);
    run_tell(run, NOTE_LOG, LOG_WARNING, "log", text);
}

void run_tell(Run *run, NoteKind kind, int level, const char *word, const char *text)
{
    log_line((LogLevel)level, "%s: %s", word, text);
    tell_lacking(run, write_log(run, word, text));
    Note *note = note_now(run, kind);
    if (!note) return;
    note->level = level;
    snprintf(note->word, sizeof note->word, "%s", word);
    snprintf(note->text, sizeof note->text, "%s", text);
    send(run, note);
}

void run_tell_warnings(Run *run)
{
    for (const char *text; (text = mns_sim_warning(run->sim, run->warned)); run->warned++)
        run_tell(run, NOTE_LOG, LOG_WARNING, "case", text);
}

void run_tell_progress(Run *run)
{
    Note *note = note_now(run, NOTE_PROGRESS);
    run->progress = clock_now();
    if (!note) return;
    note->end_time = run->document->c->end_time;
    note->fraction = note->end_time > 0 ? fmin(note->t / note->end_time, 1) : 1;
    note->dt = mns_sim_progress(run->sim).dt;
    note->eta = meter_eta(&run->meter, note->t, note->end_time);
    note->steps_per_second = meter_rate(&run->meter);
    send(run, note);
}

void run_tell_progress_at_times(Run *run)
{
    if (clock_now() - run->progress >= PROGRESS_INTERVAL) run_tell_progress(run);
}

void run_enter(Run *run, RunState state, const char *text)
{
    const bool in_vain =
        state == RUN_EMPTY && run->state == RUN_LOADING; /* a load: why there is no run is as true as before */
    run->state = state;
    if (state != RUN_RUNNING) meter_halt(&run->meter, clock_now());
    if (state != RUN_FAULT && state != RUN_STOPPING && state != RUN_LOADING && !in_vain)
        run->fault = (MnsError){.status = MNS_OK};
    run_publish(run);
    char word[24];
    snprintf(word, sizeof word, "%s", run_state_name(state));
    for (char *c = word; *c; c++) *c = (char)(*c >= 'A' && *c <= 'Z' ? *c + 'a' - 'A' : *c);
    run_tell(run, NOTE_EVENT, state == RUN_FAULT ? LOG_ERROR : LOG_INFORMATION, word, text);
    if (run->sim && state != RUN_LOADING) run_tell_progress(run);
    run_answer_waiters(run);
}
