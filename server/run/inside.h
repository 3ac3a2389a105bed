/* SPDX-License-Identifier: BSD-3-Clause */
/* The inside of a run, for the files of this folder that make it up: run.c, go.c, load.c, making.c, resumed.c, steer.c, publish.c, watch.c, answer.c,
 * chronicle.c, recover.c, appoint.c. */
#ifndef RUN_INSIDE_H
#define RUN_INSIDE_H

#include "io/journal.h"
#include "run/agenda.h"
#include "run/history.h"
#include "run/mailbox.h"
#include "run/meter.h"
#include "run/outputs.h"
#include "run/quota.h"
#include "run/run.h"
#include "run/versions.h"
#include <stdio.h>

/* What a step or run_until is after; on while it is. */
typedef struct Goal {
    bool on, exact;
    double t; /* [s]; INFINITY: no matter */
    uint64_t step;
    Order *order;
} Goal;

typedef struct Waiter {
    struct Waiter *next;
    RunWait wait;
    Order *order;
    size_t nth; /* of those that its identity had when it came */
} Waiter;

/* The way back to where the run was before a crash. */
typedef struct Recovery {
    const Lineage *lineage; /* borrowed; NULL: the run is where it was, or there was none */
    size_t next;            /* of its entries                                             */
    uint64_t checkpoint;    /* the step it goes on from                                   */
    double limit;           /* time to which a step is shortened [s]                      */
    Order *held;            /* what comes behind the way back, while that is held up      */
} Recovery;

struct Run {
    RunOptions options;
    pthread_t thread;
    Mailbox mailbox;
    Outbox outbox;
    Tap *tap;
    _Atomic uint64_t beat;

    /* Of the runner's thread alone: */
    RunState state;
    bool leaving;
    bool output_failed; /* why it is in FAULT, if it is not the solver */
    MnsError fault;
    MnsSim *sim;       /* NULL without a case, as are the two documents */
    const char *level; /* it is computed with; for good */
    Document *document;
    Versions versions;
    Lease lease, lease_before; /* lease_before: as it was before one that is not on the disk yet, */
    bool lease_unsettled;      /* if there is such                                                */
    Document *original;        /* the case as it was loaded, before anybody steered */
    int directory_lock;        /* -1 without a run                                  */
    Breakpoints *breakpoints;
    Outputs outputs;
    uint64_t hash; /* of the state, if it is known */
    bool hashed;
    Goal goal;
    Recovery recovery;
    bool astray; /* it did not come back to where it was: to go on would lose what was commanded since the checkpoint */
    Waiter *waiters;
    Agenda agenda;
    Meter meter;
    double looks_from; /* meter.stepping from which on orders that only look are served [s] */
    size_t warned;     /* how many of the simulation's warnings have been told */
    double loaded;     /* clock_now() when the case was loaded     */
    double progress;   /* clock_now() of the last progress note    */
    FILE *log;         /* of the run directory; NULL: it could not be opened */
    bool log_lacks;    /* lines, and that was told                  */
    Journal *journal;  /* the same                                    */
    Order *unsaid;   /* answered, and not on the disk yet, or after such: nobody hears of it before. The latest first */
    bool withheld;   /* what others see of the run is as it was before the orders that are not on the disk yet; */
    bool to_publish; /* then: something has changed,                                                            */
    Note *unsent, *last_unsent; /* and what is to be told of it */
    Order *
        filed; /* the latest first: their files are written, or could not be; under the lock, as the writer adds them */
    Document *before;   /* the case before the order that is being answered changed it; NULL if it did not */
    bool current_due;   /* this run is to be noted as the current one, once its journal is on the disk     */
    bool uncommitted;   /* the journal has something that is to be on the disk before the run goes on */
    size_t noted;       /* bytes of commands since the last checkpoint, which one record of a way back is to hold */
    size_t noted_here;  /* the same, at the boundary at which the run stands                             */
    MnsError unwritten; /* what could not even be added to it; MNS_OK: nothing                        */
    RunFigures figures; /* to be put where others look; its document is not a share */

    /* For everybody: */
    pthread_mutex_t lock;
    RunStatus status;
    Document *published;
    struct {
        _Atomic uint64_t records, failures;
        _Atomic double seconds;
    } journal_tally; /* as RunJournal; this thread counts */
};

/* publish.c: what others see. */
void run_beat(void *run);
void run_publish_step(Run *run);      /* the numbers that change with every step           */
void run_publish(Run *run);           /* all                                               */
void run_reveal(Run *run);            /* what was withheld                                 */
uint64_t run_version(const Run *run); /* of the case; 0: none, or it is not known before all is done again */

/* The hash of the state takes all particles. Where it stops by itself it is known at once; whoever makes it stop is answered
 * first, and then it is settled, before the next order. */
void run_hash(Run *run);
void run_settle(Run *run);
void run_enter(Run *run, RunState state, const char *text); /* a new state: published, told, and who waits answered */
void run_tell_progress(Run *run);
void run_tell_progress_at_times(Run *run); /* not more often than people look */

/* An event or a line of the log. */
void run_tell_warnings(Run *run); /* of the simulation, those that are new */
void run_tell(Run *run, NoteKind kind, int level, const char *word, const char *text);

/* chronicle.c: the journal. Refuse what could not be written down, note what has set out, what is done, the hash of the state. */
MnsStatus run_journal_open(Run *run, const char *directory, Journal **ret, bool *ret_made, MnsError *error);
MnsStatus run_journal_ready(Run *run, const Order *order, MnsError *error);
void run_note_begun(Run *run, Order *order);
void run_note_scheduled(Run *run, Order *order);
void run_note_done(Run *run, Order *order);
bool run_keep(Run *run,
              Order *order); /* an order that is answered; true: it is kept until what was noted is on the disk */
void run_note_halted(Run *run, RunState state);              /* with no order under way that tells */
bool run_leaves_unended(const Run *run, const Order *order); /* a shutdown that ends no run: the next start goes on */
void run_note_hash(Run *run);

/* After a step: a checkpoint, if a way back would otherwise have too much to tell. */
MnsStatus run_bound_way_back(Run *run, MnsError *error);

/* From here on nobody sees what an order does before the journal has it on the disk: neither in the status nor as an event, nor by an
 * answer to who waits for it. A load, reset or restore takes long, and shows that it does. */
void run_withhold(Run *run, const Order *order);

/* Before a run goes: write what waits to be written, and run_commit(). */
void run_close_books(Run *run);

/* Have it all on the disk, then let the answers go. If that fails, they tell so and the run is in FAULT. */
void run_commit(Run *run);
void run_sync(Run *run); /* the first half of it, and the second */
void run_release(Run *run);

/* recover.c: RECOVERING. One step on the way back, and what was commanded at the boundary. */
void run_recover_on(Run *run);
bool run_is_held_up(const Run *run);                               /* on it, by a file that could not be written */
void run_hold(Run *run, Order *order);                             /* what is to be served when the run is back */
Order *run_take_held(Run *run, const uint8_t id[static ORDER_ID]); /* NULL if it is not among that */
void run_release_held(Run *run);                                   /* into the mailbox */
void run_drop_held(Run *run, const char *why);                     /* it is called off */
MnsStatus run_refuse_held_up(const Order *order, MnsError *error); /* what would change the case meanwhile */
void run_recover_again(Run *run, Order *order);                    /* resume */
/* run.c: a step boundary, for streams. */
void run_offer(Run *run, bool stepped);

/* watch.c: for whoever watches from outside. */
void run_count_step(Run *run, double seconds); /* that it took                              */
void run_count_phases(Run *run);               /* of the simulation that was just put there */
void run_show(Run *run);                       /* all that is published, and the counts     */

/* making.c: a simulation for whoever gave this order; state: to go on from, or NULL. As mns_sim_make(); MNS_E_TIMEOUT if the deadline
 * of the order passes meanwhile, MNS_E_INTERRUPTED if another one ends it. */
MnsStatus run_make(Run *run, const Order *order, const MnsCase *c, const MnsCapture *state, MnsSim **ret,
                   MnsError *error);

/* resumed.c: the case with which a run goes on from a checkpoint of this path. MNS_E_INVALID if the one given differs in more than what
 * can be steered, with its entry. And, once it is in place, a line for each entry that is not as stored, or not as given. */
MnsStatus resumed_case(Document *stored, const char *checkpoint, const Document *given, const RunLoad *load,
                       Document **ret, MnsError *error);

/* resumed.c: may the run, whose case is this now, be restored from a checkpoint with that one? MNS_E_INVALID if they differ in more than what can be steered. */
MnsStatus resumed_restore(const Document *stored, const char *checkpoint, const Document *now, MnsError *error);

/* resumed.c: may the run in this directory, of which the journal tells this, go on from the checkpoint? As history_owns(), and what can be done. */
MnsStatus resumed_owned(const History *history, const char *directory, const Checkpoint *checkpoint, MnsError *error);

/* resumed.c: read the newest checkpoint in the directory that the journal leads to; of others it is told that they are passed over. One that does not tell
 * whose it is is taken where there is no other, with `silent_too`; any is, where there is no record yet. As checkpoint_newest(). */
MnsStatus resumed_newest(Run *run, const History *history, const char *directory, bool silent_too, Checkpoint *ret,
                         MnsError *error);

void run_tell_resumed(Run *run, const Document *stored, const Document *given);

/* load.c: a file that cannot be read. */
void run_tell_file(void *run, const char *text);

/* answer.c: those who wait; run_answer() and run_wait() are there too. */
void run_filed(Run *run, Order *order, MnsStatus status, const MnsError *error); /* on the writer's thread */
void run_answer_filed(Run *run);            /* all whose files are written, or could not be     */
void run_hand_back(Run *run, Order *order); /* an answer, to whoever gave the order */
void run_answer_unserved(Run *run, Order *order, MnsStatus status,
                         const MnsError *error); /* that was taken out of the queue */
void run_answer_waiters(Run *run);               /* those whose wait is over, unless something scheduled comes first */
void run_answer_late(Run *run, double now);      /* those whose deadline has passed  */
void run_answer_all_waiters(Run *run, const MnsError *error);
double run_next_deadline(const Run *run); /* of clock_now(); INFINITY: none */

/* Those of that id; whether there are any. */
bool run_answer_cancelled(Run *run, const uint8_t id[static ORDER_ID], const MnsError *error);

/* run.c: may an order be served at this boundary, or, if it is scheduled, be accepted? */
MnsStatus run_check_moment(const Run *run, const Order *order, MnsError *error);

/* appoint.c: scheduled orders. Accept one, or answer why not; tell those who want to know, once it is on the disk; describe it in a few words. */
void run_appoint(Run *run, Order *order);
const Order *run_due(const Run *run); /* the next one for this boundary; NULL: none, or the run is in no state for it */
bool run_announces(const Run *run);   /* is there any to tell of? */
void run_announce(Run *run);
void run_describe_scheduled(const Order *order, char *ret, size_t size);
void run_tell_undone(Run *run, const Order *order, const MnsError *why);

/* That of the id is answered so, and whether there is one; those whose deadline has passed; all of them, as the run for which they are goes. */
bool run_cancel_appointment(Run *run, const uint8_t id[static ORDER_ID], const MnsError *why);
void run_expire_appointments(Run *run, double now);
void run_drop_appointments(Run *run, const char *text);

/* go.c: goals. */
void run_goal_end(Run *run, MnsStatus status, const MnsError *error); /* answers who is after it */
void run_expire(Run *run);                    /* waiters and goals whose deadline has passed        */
void run_call_off(Run *run, const Order *by); /* orders that would set it in motion, older than this one */
void run_fault(Run *run, const MnsError *error, bool output);
bool run_is_broken(
    const Run *run); /* its state is none to go on from: not whole, or astray; else a formula or a file is to blame */
const char *run_broken_why(const Run *run); /* in words */
void run_advance(Run *run);                 /* one step and all that hangs on it                  */

/* One step, cut at the time `limit`, and the outputs that are due after it. *ret_output: it is one of them that failed, not the step. */
MnsStatus run_step_once(Run *run, double limit, bool *ret_output, MnsError *error);

/* go.c: of a run that is broken, what leads on. */
MnsStatus run_refuse_broken(const Run *run, MnsError *error);

/* steer.c: what has been commanded before, without an answer. */
MnsStatus run_set_again(Run *run, const Meniscus__Set *set, MnsError *error);
MnsStatus run_adopt_again(Run *run, const Meniscus__Case *message, MnsError *error);
/* steer.c: on the way back. there: the file is, and is only known again */
MnsStatus run_snapshot_again(Run *run, const Meniscus__SnapshotNow *request, bool there, MnsError *error);
void run_breakpoint_again(Run *run, const Meniscus__SetBreakpoint *request, uint64_t step); /* that it was set at */

/* All versions of the case that a lineage tells of. */
MnsStatus run_remember(Run *run, const Lineage *lineage, MnsError *error);

#endif
