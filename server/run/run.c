/* SPDX-License-Identifier: BSD-3-Clause */
/* The whole life of the solver's thread: serve orders, step, and again. */
#include "run/inside.h"

#include "base/clock.h"
#include "run/environment.h"
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <unistd.h>

/* How many orders wait at most, and how many are served between two steps. */
enum { MAILBOX_LIMIT = 2048, SERVED_AT_ONCE = 64 };

/* Commands that only look take at most this share of the time of steps from a run in motion. At one boundary they take as much of one step, or so many
 * seconds where steps are short. */
static const double LOOKS_SHARE = 0.1, LOOKS_LEAST = 5e-4;

/* A version that is to come may be there when a scheduled order takes effect. */
static bool is_version(const Order *order, uint64_t version)
{
    const bool early = order->scheduled && !order->appointed;
    return !order->if_version || order->if_version == version || (early && order->if_version > version);
}

MnsStatus run_check_moment(const Run *run, const Order *order, MnsError *error)
{
    const uint64_t step = run->sim ? mns_sim_progress(run->sim).step : 0;
    if (order->deadline < clock_now())
        return mns_fail(error, MNS_E_TIMEOUT,
                        "the deadline passed before the command could take effect; nothing was done");
    const MnsStatus status =
        order->leased && !order->lineage ? lease_admits(&run->lease, order->lease_epoch, clock_now(), error) : MNS_OK;
    if (status) return status;
    if (!is_version(order, run->versions.number))
        return mns_fail_at(error, MNS_E_STATE, "if_version",
                           "the case is at version %" PRIu64 ", not %" PRIu64 "; nothing was done",
                           run->versions.number, order->if_version);
    if (!order->conditional || (run->sim && order->if_step == step)) return MNS_OK;
    if (!run->sim)
        return mns_fail_at(error, MNS_E_STATE, "if_step",
                           "there is no run, so none at step %" PRIu64 "; nothing was done", order->if_step);
    return mns_fail_at(error, MNS_E_STATE, "if_step",
                       "the run is at step %" PRIu64 ", not %" PRIu64 "; nothing was done", step, order->if_step);
}

static void serve(Run *run, Order *order)
{
    MnsError error;
    const MnsProgress now = run->sim ? mns_sim_progress(run->sim) : (MnsProgress){.t = 0};
    const Lineage *ahead = run_is_held_up(run) ? NULL : run->recovery.lineage;
    if (run_is_held_up(run) && order->lineage) {
        run_hold(run, order);
        return;
    }
    order->effect_step = ahead ? ahead->step : now.step; /* on the way back the run is, for the journal, where it was */
    order->effect_t = now.t;
    if (order->scheduled && !order->appointed) {
        run_appoint(run, order);
        return;
    }
    MnsStatus status = run_check_moment(run, order, &error);
    if (!status && order->request && run_is_held_up(run)) status = run_refuse_held_up(order, &error);
    if (!status && order->request) status = run_journal_ready(run, order, &error);
    if (!order->request) run_commit(run); /* what it sees is not undone by a crash */
    else run_withhold(run, order);
    if (status) run_answer(run, order, status, &error);
    else order->serve(run, order);
}

/* A scheduled file is answered at its boundary, so nothing that may fail is before it with the writer. */
static bool ready_for(Run *run, const Order *order)
{
    const Meniscus__Request__CommandCase command = order->request->command_case;
    MnsError error;
    if (command != MENISCUS__REQUEST__COMMAND_CHECKPOINT && command != MENISCUS__REQUEST__COMMAND_SNAPSHOT) return true;
    if (!outputs_settle(&run->outputs, &error)) return true;
    run_fault(run, &error, true);
    return false;
}

/* Those whose moment this boundary is, before whoever wanted the run to come here is answered: then the case is as it was to be from here on.
 * What they see or write is on the disk before, so that no crash undoes it. */
static void keep_appointments(Run *run)
{
    bool any = false;
    for (const Order *next; !run->leaving && (next = run_due(run)); any = true) {
        run_sync(run);
        if (!ready_for(run, next)) break;
        serve(run, agenda_take_due(&run->agenda, mns_sim_progress(run->sim)));
    }
    if (any) run_publish(run);
    run_answer_waiters(run);
}

/* Does somebody wait to hear of what has been served? */
static bool has_to_tell(const Run *run)
{
    return run->unsaid || run->withheld || run_announces(run);
}

/* Until when to sleep if nobody wants anything: a paused run uses no processor. The OpenMP team does not either: both
 * runtimes put their threads to sleep after a short spin. */
static double wake_time(const Run *run)
{
    if (run->state == RUN_RUNNING || has_to_tell(run)) return 0;
    const double beat = run->options.beat_interval > 0 ? clock_now() + run->options.beat_interval : INFINITY;
    return fmin(beat, run_next_deadline(run));
}

/* For those who only look, at one boundary [s]. */
static double patience(const Run *run)
{
    const Meter *meter = &run->meter;
    return fmax(LOOKS_LEAST, meter->steps ? LOOKS_SHARE * meter->stepping / (double)meter->steps : 0);
}

/* The time that such an order has taken, however long it was, is made up for by steps before the next boundary at which one is served. */
static void book_look(Run *run, double seconds)
{
    const bool moves = run->state == RUN_RUNNING;
    run->looks_from = moves ? fmax(run->looks_from, run->meter.stepping) + seconds / LOOKS_SHARE : 0;
}

/* May such an order be served? looked: the time that others have taken at this boundary. */
static bool may_look(const Run *run, double looked)
{
    return looked > 0 ? looked <= patience(run) : run->meter.stepping >= run->looks_from;
}

/* looked: the time that orders which only look have taken at this boundary. They wait for a later one then, and who has a file written waits for the disk,
 * so that a run in motion need not; what is behind those that wait waits too, as orders keep their order. While the run comes back after a crash, those that have no time for that; the others wait until it is there. */
static Order *next_order(Run *run, double looked)
{
    if (run->state == RUN_RECOVERING) return mailbox_take_meanwhile(&run->mailbox);
    if (run->state == RUN_RUNNING)
        return mailbox_take_but(&run->mailbox, !may_look(run, looked), writer_is_full(run->outputs.writer));
    return mailbox_take(&run->mailbox, wake_time(run));
}

static void serve_some(Run *run)
{
    double looked = 0;
    keep_appointments(run);
    for (int k = 0; k < SERVED_AT_ONCE && !run->leaving; k++) {
        run_answer_filed(run);
        run_settle(run);
        Order *order = next_order(run, looked);
        if (!order && has_to_tell(run)) { /* nobody else to write down with it */
            run_commit(run);
            continue;
        }
        run_beat(run);
        if (!order) break;
        const bool looks = order->looks;
        const double began = clock_now();
        if (order->writes && has_to_tell(run)) run_commit(run); /* a file has only what is on the disk */
        serve(run, order);
        if (looks) {
            const double took = clock_now() - began;
            looked += took;
            book_look(run, took);
        }
        keep_appointments(run);
    }
    run_expire(run);
    run_commit(run);
}

/* Whoever still waits is told that it was in vain. */
static void answer_all(Run *run)
{
    MnsError error;
    mns_fail(&error, MNS_E_UNAVAILABLE, "the daemon is leaving");
    run_answer_filed(run);
    run_release_held(run);
    run_goal_end(run, MNS_E_UNAVAILABLE, &error);
    run_answer_all_waiters(run, &error);
    for (Order *order; (order = mailbox_take(&run->mailbox, 0));)
        run_answer_unserved(run, order, MNS_E_UNAVAILABLE, &error);
    run_commit(run);
}

void run_offer(Run *run, bool stepped)
{
    const Sample *sample = &run->outputs.sample;
    if (!run->sim) return;
    const bool known = sample->taken && sample->step == mns_sim_progress(run->sim).step;
    tap_look(run->tap, run->sim, stepped, known ? sample->values : NULL);
}

static void *run_thread(void *arg)
{
    Run *run = arg;
    environment_threads();
    /* Linux keeps a niceness for each thread, and the team of OpenMP, made by this one, inherits it. So the threads that
     * serve people are first in line when all processors compute. Without the permission nothing is lost but that. */
    if (run->options.nice) setpriority(PRIO_PROCESS, (id_t)gettid(), run->options.nice);
    while (!run->leaving) {
        serve_some(run);
        if (run->state == RUN_RUNNING) run_advance(run);
        else if (run->state == RUN_RECOVERING) run_recover_on(run);
        else run_offer(run, false);
    }
    answer_all(run);
    return NULL;
}

static void answer_output(void *run, Order *order, MnsStatus status, const MnsError *error)
{
    run_filed(run, order, status, error);
}

static void destroy(Run *run)
{
    writer_free(run->outputs.writer);
    journal_free(run->journal);
    breakpoints_free(run->breakpoints);
    document_leave(run->published);
    versions_done(&run->versions);
    mailbox_done(&run->mailbox);
    outbox_done(&run->outbox);
    pthread_mutex_destroy(&run->outputs.series_lock);
    tap_free(run->tap);
    pthread_mutex_destroy(&run->lock);
    free(run);
}

MnsStatus run_new(const RunOptions *options, Run **ret, MnsError *error)
{
    Run *run = calloc(1, sizeof *run);
    if (!run) return mns_fail(error, MNS_E_MEMORY, "no memory for a run");
    MnsStatus status = outbox_init(&run->outbox, error);
    if (status) {
        free(run);
        return status;
    }
    run->options = *options;
    run->directory_lock = -1;
    mailbox_init(&run->mailbox, MAILBOX_LIMIT);
    pthread_mutex_init(&run->lock, NULL);
    run->breakpoints = breakpoints_new();
    run->outputs =
        (Outputs){.lock = -1, .outbox = &run->outbox, .answer = answer_output, .note = run_tell_file, .arg = run};
    pthread_mutex_init(&run->outputs.series_lock, NULL);
    run->tap = tap_new(options->stream_memory);
    if (!run->breakpoints || !run->tap) status = mns_fail(error, MNS_E_MEMORY, "no memory for a run");
    else status = writer_new(run_beat, run, &run->outputs.writer, error);
    if (!status && pthread_create(&run->thread, NULL, run_thread, run))
        status = mns_fail(error, MNS_E_MEMORY, "the operating system refuses a thread for the solver");
    if (status) destroy(run);
    else *ret = run;
    return status;
}

void run_join(Run *run)
{
    pthread_join(run->thread, NULL);
    answer_all(run); /* what came after the last order */
}

void run_free(Run *run)
{
    if (run) destroy(run);
}

MnsStatus run_post(Run *run, Order *order, MnsError *error)
{
    return mailbox_post(&run->mailbox, order, error);
}

Tap *run_tap(Run *run)
{
    return run->tap;
}

MnsStatus run_rows(Run *run, const Document *document, uint64_t line, uint64_t first, size_t most, size_t n_columns,
                   const int *columns, SeriesRows *ret, MnsError *error)
{
    return outputs_rows(&run->outputs, document, line, first, most, n_columns, columns, ret, error);
}

void run_follow(Run *run, int by)
{
    run->outputs.followers += (unsigned)by;
}

void run_ask(Run *run, Feed *feed)
{
    tap_ask(run->tap, feed);
    mailbox_wake(&run->mailbox);
}

Outbox *run_outbox(Run *run)
{
    return &run->outbox;
}

RunState run_state(const Run *run)
{
    return run->state;
}

const MnsSim *run_sim(const Run *run)
{
    return run->sim;
}
