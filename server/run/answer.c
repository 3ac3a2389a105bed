/* SPDX-License-Identifier: BSD-3-Clause */
/* Answers to orders, and those who wait for something to come about. */
#include "run/inside.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void run_hand_back(Run *run, Order *order)
{
    order->note = (Note){.kind = NOTE_ANSWER, .order = order};
    outbox_put(&run->outbox, &order->note);
}

static void fill(Order *order, MnsStatus status, const MnsError *error)
{
    order->status = status;
    if (status) order->error = *error;
}

/* On any thread, which knows of the run what is published. */
void run_answer_now(Run *run, Order *order, MnsStatus status, const MnsError *error)
{
    fill(order, status, error);
    pthread_mutex_lock(&run->lock);
    order->state = run->status.state;
    order->step = run->status.progress.step;
    order->version = run->status.version;
    order->t = run->status.progress.t;
    pthread_mutex_unlock(&run->lock);
    run_hand_back(run, order);
}

void run_answer(Run *run, Order *order, MnsStatus status, const MnsError *error)
{
    /* Where there is no simulation any more, as it was when it went: this thread alone writes that. */
    const MnsProgress now = run->sim ? mns_sim_progress(run->sim) : run->status.progress;
    fill(order, status, error);
    order->state = run->state;
    order->step = now.step;
    order->version = run->sim ? run_version(run) : run->status.version;
    order->t = now.t;
    if (order->request) run_note_done(run, order);
    if (order->appointed && status) run_tell_undone(run, order, error);
    if (!run_keep(run, order)) run_hand_back(run, order);
}

/* What the journal tells of is answered by the runner, which waits for the files of scheduled ones. */
void run_filed(Run *run, Order *order, MnsStatus status, const MnsError *error)
{
    if (!order->request) {
        run_answer_now(run, order, status, error);
        return;
    }
    order->status = status;
    if (status) order->error = *error;
    order->filed = true;
    if (order->appointed) return;
    pthread_mutex_lock(&run->lock);
    order->next = run->filed;
    run->filed = order;
    pthread_mutex_unlock(&run->lock);
    mailbox_wake(&run->mailbox);
}

static Order *take_filed(Run *run)
{
    Order *first = NULL;
    pthread_mutex_lock(&run->lock);
    for (Order *order = run->filed, *next; order; order = next) { /* in the order in which they were written */
        next = order->next;
        order->next = first;
        first = order;
    }
    run->filed = NULL;
    pthread_mutex_unlock(&run->lock);
    return first;
}

void run_answer_filed(Run *run)
{
    for (Order *order = take_filed(run), *next; order; order = next) {
        next = order->next;
        run_answer(run, order, order->status, &order->error);
    }
}

/* Of a command that had set out before a crash the journal tells where it ended. */
void run_answer_unserved(Run *run, Order *order, MnsStatus status, const MnsError *error)
{
    const Lineage *ahead = run_is_held_up(run) ? NULL : run->recovery.lineage;
    if (ahead) order->effect_step = ahead->step;
    else if (run->sim) order->effect_step = mns_sim_progress(run->sim).step;
    run_answer(run, order, status, error);
}

static bool wait_over(const Run *run, const RunWait *wait)
{
    if (wait->states & (1u << run->state)) return true;
    if (!run->sim) return false;
    const MnsProgress now = mns_sim_progress(run->sim);
    return now.t >= wait->t || now.step >= wait->step;
}

/* Answer and forget the waiters for whom over() is true. Returns whether there were any. */
static bool answer_some(Run *run, bool (*over)(const Run *, const Waiter *, const void *), const void *arg,
                        MnsStatus status, const MnsError *error)
{
    bool any = false;
    for (Waiter **list = &run->waiters; *list;) {
        Waiter *waiter = *list;
        if (!over(run, waiter, arg)) {
            list = &waiter->next;
            continue;
        }
        *list = waiter->next;
        if (run->sim) { /* the boundary at which it came about, not that at which the waiting began */
            waiter->order->effect_step = mns_sim_progress(run->sim).step;
            waiter->order->effect_t = mns_sim_progress(run->sim).t;
        }
        run_answer(run, waiter->order, status, error);
        free(waiter);
        any = true;
    }
    return any;
}

static bool is_over(const Run *run, const Waiter *waiter, const void *arg)
{
    (void)arg;
    return wait_over(run, &waiter->wait);
}

static bool is_late(const Run *run, const Waiter *waiter, const void *arg)
{
    (void)run;
    return waiter->order->deadline < *(const double *)arg;
}

static bool is_any(const Run *run, const Waiter *waiter, const void *arg)
{
    (void)run, (void)waiter, (void)arg;
    return true;
}

static bool has_id(const Run *run, const Waiter *waiter, const void *arg)
{
    (void)run;
    return !memcmp(waiter->order->id, arg, ORDER_ID);
}

void run_answer_waiters(Run *run)
{
    if (run->waiters && !run_due(run)) answer_some(run, is_over, NULL, MNS_OK, NULL);
}

void run_answer_late(Run *run, double now)
{
    MnsError error;
    mns_fail(&error, MNS_E_TIMEOUT, "the deadline passed before what was waited for came about");
    answer_some(run, is_late, &now, MNS_E_TIMEOUT, &error);
}

bool run_answer_cancelled(Run *run, const uint8_t id[static ORDER_ID], const MnsError *error)
{
    return answer_some(run, has_id, id, error->status, error);
}

void run_answer_all_waiters(Run *run, const MnsError *error)
{
    answer_some(run, is_any, NULL, error->status, error);
}

double run_next_deadline(const Run *run)
{
    double next = fmin(run->goal.order ? run->goal.order->deadline : INFINITY, agenda_deadline(&run->agenda));
    for (const Waiter *waiter = run->waiters; waiter; waiter = waiter->next) next = fmin(next, waiter->order->deadline);
    return next;
}

static bool is_this(const Run *run, const Waiter *waiter, const void *arg)
{
    (void)run;
    return waiter == arg;
}

static QuotaUse waits_of(const Run *run, const Who *who)
{
    QuotaUse use = {0};
    for (const Waiter *waiter = run->waiters; waiter; waiter = waiter->next)
        quota_count(&use, who, &waiter->order->who);
    return use;
}

/* The oldest is last in the list. */
static const Waiter *oldest_of(const Run *run, const Who *who)
{
    const Waiter *chosen = NULL;
    for (const Waiter *waiter = run->waiters; waiter; waiter = waiter->next)
        if (quota_same(who, &waiter->order->who)) chosen = waiter;
    return chosen;
}

static const Waiter *greediest(const Run *run, QuotaPool pool)
{
    const Waiter *chosen = NULL;
    for (const Waiter *waiter = run->waiters; waiter; waiter = waiter->next)
        if (quota_pool(&waiter->order->who) == pool && (!chosen || waiter->nth > chosen->nth)) chosen = waiter;
    return chosen;
}

/* A client that waits may have gone unseen, and a wait need not have an end. So an identity that has as many as it may have loses its own oldest, and where all
 * of its pool have that many, the identity with most loses its oldest. Returns how many the one who asks has then. */
static size_t make_place(Run *run, const Who *who)
{
    MnsError error;
    const QuotaPool pool = quota_pool(who);
    QuotaUse use = waits_of(run, who);
    const Who *loser = NULL;
    if (use.own >= quota_each(QUOTA_WAITS, pool)) loser = who;
    else if (use.pool >= quota_all(QUOTA_WAITS, pool)) loser = &greediest(run, pool)->order->who;
    if (!loser) return use.own;
    const Waiter *last = oldest_of(run, loser);
    (void)quota_check(QUOTA_WAITS, loser, &use, &error);
    use.own -= quota_same(loser, who);
    answer_some(run, is_this, last, error.status, &error);
    return use.own;
}

void run_wait(Run *run, Order *order, const RunWait *wait)
{
    MnsError error;
    Waiter *waiter = wait_over(run, wait) ? NULL : malloc(sizeof *waiter);
    if (waiter) {
        const size_t before = make_place(run, &order->who);
        *waiter = (Waiter){.next = run->waiters, .wait = *wait, .order = order, .nth = before + 1};
        run->waiters = waiter;
    } else if (wait_over(run, wait)) run_answer(run, order, MNS_OK, NULL);
    else run_answer(run, order, mns_fail(&error, MNS_E_MEMORY, "no memory for one more who waits"), &error);
}
