/* SPDX-License-Identifier: BSD-3-Clause */
/* A run: one simulation, its thread, and what it writes. Everybody else posts orders, which are served between two steps,
 * and reads notes from the outbox. Nothing here knows a socket; daemon and batch mode use the same. */
#ifndef RUN_RUN_H
#define RUN_RUN_H

#include "run/agenda.h"
#include "run/breakpoint.h"
#include "run/document.h"
#include "run/figures.h"
#include "run/lease.h"
#include "run/lineage.h"
#include "run/outbox.h"
#include "run/outputs.h"
#include "run/rundir.h"
#include "run/tap.h"

typedef struct Run Run;

typedef struct RunOptions {
    const char *parent;    /* directory in which each run gets one of its own                                      */
    const char *directory; /* or the directory of the only run; files of an earlier one in it are moved aside       */
    int nice;              /* of the solver's threads: what serves people must come first while every core computes */
    int threads;           /* for cases that do not say; -1: their default                                          */
    double beat_interval;  /* [s] run_heartbeat() rises at least as often while idle; 0: only with the steps        */
    const char *asked;     /* the case that the command line asks for, noted with the current run; NULL: for none   */
    size_t stream_memory;  /* bytes that copies for streams may take in all                                         */
    Figures *figures;      /* where the runner's thread puts them, borrowed until run_free(); NULL: nobody looks     */
} RunOptions;

enum { RUN_TIMERS = FIGURES_TIMERS };

/* What is scheduled. */
typedef struct RunScheduled {
    uint8_t id[ORDER_ID];
    Moment at;
    char who[KEY_NAME_SIZE], what[200]; /* "set gravity = [0, -2], at step 5000" */
} RunScheduled;

/* A look at the run, as it was at the last step boundary. */
typedef struct RunStatus {
    RunState state;
    char case_name[128], title[256];
    char directory[RUNDIR_PATH]; /* empty without a case */
    MnsProgress progress;
    double end_time; /* [s] */
    size_t particles, fluid_particles, bytes;
    uint64_t fields;                                    /* that a simulation of the case has, as in tap.h */
    uint64_t uncorrected;                               /* as mns_sim_uncorrected() */
    double energy_excess;                               /* as mns_sim_energy_excess(); NAN: not known */
    MnsLosses losses;                                   /* as mns_sim_losses() */
    uint64_t recovery_step;                             /* to which it goes on its way back; 0: it is not on it   */
    double steps_per_second, ns_per_particle_step, eta; /* [1/s], [ns], [s]; NAN: not known */
    double stepping, wall;                              /* wall-clock time in steps, and while RUNNING [s] */
    double age;                                         /* wall-clock time since the case was loaded, pauses too [s] */
    uint64_t version;                                   /* of the case; 0 without one                          */
    Lease lease;                                        /* the last one: it may be over by now                 */
    uint64_t samples_dropped;                           /* live ones that nobody fetched in time */
    uint64_t hash;                                      /* of the state, when it stands still with a case; else 0 */
    bool hash_due;                                      /* it stands still, and is known before the next order    */
    unsigned threads;
    MnsError fault; /* in FAULT */
    size_t n_timers, n_breakpoints, n_scheduled;
    MnsTimer timers[RUN_TIMERS];
    Breakpoint breakpoints[BREAKPOINTS];
    RunScheduled scheduled[AGENDA_LIMIT];
} RunStatus;

/* Start the threads; the strings are borrowed until run_free(). MNS_OK, MNS_E_MEMORY, MNS_E_LIMIT. */
MnsStatus run_new(const RunOptions *options, Run **ret, MnsError *error);

/* Wait for the runner's thread, which ends after an order of run_leave(). Orders still waiting are answered: look into the
 * outbox once more. */
void run_join(Run *run);

/* Free all, after run_join(). NULL is fine. */
void run_free(Run *run);

/* --- for any thread ---------------------------------------------------------------------------------------------------- */

/* MNS_OK: the order comes back in a NOTE_ANSWER. MNS_E_LIMIT: too many are waiting, and it is still the caller's. */
MnsStatus run_post(Run *run, Order *order, MnsError *error);

Outbox *run_outbox(Run *run);
void run_status(Run *run, RunStatus *ret);

/* A share of the present case; NULL if there is none. */
Document *run_document(Run *run);

/* What streams take. tap_ask() through this, so that a run that stands still wakes up for it. */
Tap *run_tap(Run *run);
void run_ask(Run *run, Feed *feed);
void run_follow(Run *run,
                int by); /* one more, or one less, waits for rows of the series: they get to the disk sooner */
MnsStatus run_rows(Run *run, const Document *document, uint64_t line, uint64_t first, size_t most, size_t n_columns,
                   const int *columns, SeriesRows *ret, MnsError *error); /* as outputs_rows() */

/* A number that rises with every step and with all that is done within one (mns_sim_watch()), and while the run has nothing to do; it stands
 * still if the solver hangs. */
uint64_t run_heartbeat(Run *run);

/* --- for Order.serve, on the runner's thread. Each of these answers the order, now or when done -------------------------- */

/* An entry set by hand. */
typedef struct RunSetting {
    const char *path, *value;
} RunSetting;

typedef struct RunLoad {
    const Meniscus__Case *message; /* copied */
    const char *name;
    const char *directory; /* of a run that is gone on with; NULL: chosen by the name                        */
    bool resume;           /* from the newest whole checkpoint in the run directory, if there is one */
    bool overwrite;        /* delete the files of the run that was in the directory, once this one is loaded */
    size_t n_settings;
    const RunSetting
        *settings; /* [n_settings] the message has them already; on resuming they are made to the checkpoint's too */
} RunLoad;

void run_load(Run *run, Order *order, const RunLoad *load);

/* After a crash: load the case from the newest whole checkpoint of its directory, answer, and do again what the journal has from there on.
 * The state is RECOVERING meanwhile, and only orders that may be served then are; the run stands in the end where the last command left it,
 * READY or PAUSED. The order has its lineage, which is borrowed until the run is left. */
void run_recover(Run *run, Order *order);

/* There was a run, which cannot be read: EMPTY, and the status says why, until another one is there. */
void run_unread(Run *run, Order *order, const MnsError *why);
bool run_is_unread(const Run *run); /* the runner's */

void run_reset(Run *run, Order *order);                     /* to t = 0 of the same case                              */
void run_restore(Run *run, Order *order, const char *name); /* of a file in the run directory; NULL: the newest whole */
void run_stop(Run *run, Order *order, bool checkpoint);     /* to EMPTY, files kept                                   */
void run_leave(Run *run, Order *order, bool checkpoint);    /* the last order: the thread ends                        */

void run_go(Run *run, Order *order); /* start or resume: run to the end */
void run_pause(Run *run, Order *order);
void run_step(Run *run, Order *order, uint64_t n);
void run_until(Run *run, Order *order, double t, bool exact); /* exact: the last step is shortened                    */

/* Until a state of the set (bit 1 << state), a time [s] or a step is reached; INFINITY and UINT64_MAX for no matter. */
typedef struct RunWait {
    unsigned states;
    double t;
    uint64_t step;
} RunWait;
void run_wait(Run *run, Order *order, const RunWait *wait);

/* End the step, run_until or wait of that id; or take an order out of the queue, or of those that are scheduled. */
void run_cancel(Run *run, Order *order, const uint8_t id[static ORDER_ID]);

void run_checkpoint(Run *run, Order *order);
void run_snapshot(Run *run, Order *order, size_t n, char *const *fields);

/* Change all these entries of the case, or none. The answer has a share of the changed case, which is the order's owner's. */
void run_set(Run *run, Order *order, const Meniscus__Set *set);

/* Would these be done now? Nothing is. For Order.check. */
MnsStatus run_check_set(const Run *run, const Meniscus__Set *set, MnsError *error);
MnsStatus run_check_rollback(const Run *run, uint64_t version, MnsError *error);
MnsStatus run_check_fields(size_t n, char *const *fields, MnsError *error);

/* Back to the case as it was at a version, which makes one more. The answer is as that of a set. */
void run_rollback(Run *run, Order *order, uint64_t version);

/* Give a lease, renew it or end it. */
void run_lease(Run *run, Order *order, const LeaseWish *wish);

/* Set a breakpoint, or remove that of its name. */
void run_breakpoint(Run *run, Order *order, const Meniscus__SetBreakpoint *request);

/* Answer an order. What it changed is on the disk before anybody hears of it, and answers go out in the order in which they are given. */
void run_answer(Run *run, Order *order, MnsStatus status, const MnsError *error);

/* On any thread: answer one that changed nothing, at once. */
void run_answer_now(Run *run, Order *order, MnsStatus status, const MnsError *error);

RunState run_state(const Run *run);
const MnsSim *run_sim(const Run *run); /* NULL without a case */

#endif
