/* SPDX-License-Identifier: BSD-3-Clause */
/* A run once more, from its journal. Between two records the solver steps as it did then; at each record what was commanded is
 * done again, or the hash compared. The states that a later restore goes back to are kept in memory as they are passed. */
#include "batch/replay.h"

#include "base/log.h"
#include "batch/outcome.h"
#include "common/case/file.h"
#include "run/document.h"
#include "run/environment.h"
#include "run/history.h"
#include "run/lineage.h"
#include <inttypes.h>
#include <jansson.h>
#include <math.h>
#include <meniscus/exit.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef Meniscus__JournalRecord Record;

/* A state that is gone back to. */
typedef struct Kept {
    uint64_t step;
    MnsCapture *state;  /* NULL: not come by yet */
    Document *document; /* of the case that it is a state of; NULL as well */
    bool changed;       /* something was set there that changed it */
} Kept;

/* A scheduled command, which shortens the steps before its time. */
typedef struct Pending {
    const Meniscus__Request *request;
    uint64_t until; /* the step at which it was done or dropped; UINT64_MAX: a later record tells */
} Pending;

typedef struct Replay {
    const char *directory;
    int threads;
    MnsSim *sim;
    Document *document;
    double limit; /* of a run_until under way, which shortens the last step [s] */
    size_t n_kept;
    Kept *kept; /* [n_kept] */
    size_t n_pending;
    Pending *pending;     /* [n_pending] */
    const Record *origin; /* the record it began with last                                                */
    size_t again;         /* of the commands there that are to be done again, the next one                */
    bool fallen;          /* it has diverged, as the run had                                              */
    uint64_t steps, compared, agreed_step;
} Replay;

static MnsStatus differs(const HistoryRecord *at, MnsError *error, const char *what)
{
    return mns_fail(error, MNS_E_STATE, "record %" PRIu64 ", step %" PRIu64 ": %s", at->number, at->message->step,
                    what);
}

/* --- documents --------------------------------------------------------------------------------------------------------- */

/* Of a message, with the threads that the replay is to use. */
static MnsStatus document_of(const Replay *replay, const Meniscus__Case *message, Document **ret, MnsError *error)
{
    Meniscus__Case *changed;
    char threads[16];
    if (replay->threads < 0) return document_new(message, "replay", ret, error);
    snprintf(threads, sizeof threads, "%d", replay->threads);
    MnsStatus status = case_message_set(message, "threads", threads, &changed, error);
    if (status) return status;
    status = document_new(changed, "replay", ret, error);
    meniscus__case__free_unpacked(changed, NULL);
    return status;
}

static Kept *find_kept(const Replay *replay, uint64_t step)
{
    for (size_t k = 0; k < replay->n_kept; k++)
        if (replay->kept[k].step == step) return &replay->kept[k];
    return NULL;
}

static MnsStatus adopt(Replay *replay, const Meniscus__Case *message, MnsError *error)
{
    Document *document;
    MnsStatus status = document_of(replay, message, &document, error);
    if (status) return status;
    Kept *kept = find_kept(replay, mns_sim_progress(replay->sim).step);
    const uint64_t before = kept ? mns_sim_hash(replay->sim) : 0;
    status = mns_sim_steer(replay->sim, document->c, error);
    document_leave(status ? document : replay->document);
    if (status) return status;
    replay->document = document;
    if (kept) kept->changed = kept->changed || mns_sim_hash(replay->sim) != before;
    return MNS_OK;
}

static MnsStatus set_again(Replay *replay, const Meniscus__Set *set, MnsError *error)
{
    Document *changed;
    MnsStatus status = document_set(replay->document, set, &changed, error);
    if (status) return status;
    status = adopt(replay, changed->message, error);
    document_leave(changed);
    return status;
}

/* --- states that are gone back to -------------------------------------------------------------------------------------- */

static MnsStatus list_kept(Replay *replay, const HistoryRecord *records, size_t n, MnsError *error)
{
    replay->kept = calloc(n + 1, sizeof *replay->kept);
    if (!replay->kept) return mns_fail(error, MNS_E_MEMORY, "no memory for the replay");
    for (size_t k = 0; k < n; k++)
        if (history_goes_back(records[k].message) && !find_kept(replay, records[k].message->step))
            replay->kept[replay->n_kept++].step = records[k].message->step;
    return MNS_OK;
}

static void keep_this(Kept *kept, Document *document, MnsCapture *state)
{
    document_leave(kept->document);
    mns_capture_free(kept->state);
    kept->document = document;
    kept->state = state;
}

/* The latest state of that step is the one that the checkpoint of its name had. */
static MnsStatus keep(const Replay *replay, MnsError *error)
{
    Kept *kept = find_kept(replay, mns_sim_progress(replay->sim).step);
    MnsCapture *state;
    if (!kept) return MNS_OK;
    const MnsStatus status = mns_sim_capture(replay->sim, mns_sim_state_fields(replay->sim), &state, error);
    if (status) return status;
    keep_this(kept, document_share(replay->document), state);
    return MNS_OK;
}

static MnsStatus state_of(const Replay *replay, uint64_t step, const Kept **ret, MnsError *error)
{
    Kept *kept = find_kept(replay, step);
    MnsStatus status = MNS_OK;
    Document *document;
    MnsCapture *written;
    /* What is set changes the state there, and what was set before the checkpoint only its file knows. */
    if (step == 0 || kept->changed || !kept->state) {
        status = history_checkpoint(replay->directory, step, &document, &written, kept->state ? NULL : error);
        if (!status) keep_this(kept, document, written);
    }
    if (kept->state) *ret = kept;
    return kept->state ? MNS_OK : status;
}

/* --- what was commanded ------------------------------------------------------------------------------------------------ */

/* A simulation of the record's case: from a state, by way of the case that it is of, as what is set then changes it; or from the beginning
 * with NULL. */
static MnsStatus begin(Replay *replay, const Meniscus__Case *message, const Kept *kept, MnsError *error)
{
    Document *document;
    MnsSim *sim;
    MnsStatus status = document_of(replay, kept ? kept->document->message : message, &document, error);
    if (status) return status;
    status = kept ? mns_sim_resume(document->c, kept->state, &sim, error) : mns_sim_new(document->c, &sim, error);
    if (status) {
        document_leave(document);
        return status;
    }
    mns_sim_free(replay->sim);
    document_leave(replay->document);
    replay->sim = sim;
    replay->document = document;
    replay->limit = INFINITY;
    replay->fallen = false;
    if (kept) status = adopt(replay, message, error);
    return status ? status : keep(replay, error);
}

static void set_limit(Replay *replay, const Meniscus__Request *request)
{
    const bool exact =
        request && request->command_case == MENISCUS__REQUEST__COMMAND_RUN_UNTIL && request->run_until->exact;
    replay->limit = exact ? request->run_until->time : INFINITY;
}

/* --- what is scheduled -------------------------------------------------------------------------------------------------- */

static MnsStatus add_pending(Replay *replay, const Meniscus__Request *request, uint64_t until, MnsError *error)
{
    Pending *pending = reallocarray(replay->pending, replay->n_pending + 1, sizeof *pending);
    if (!pending) return mns_fail(error, MNS_E_MEMORY, "no memory for the replay");
    replay->pending = pending;
    pending[replay->n_pending++] = (Pending){request, until};
    return MNS_OK;
}

/* One was done or dropped, if the request is that of one. */
static void end_pending(Replay *replay, const Meniscus__Request *request)
{
    for (size_t k = 0; k < replay->n_pending; k++) {
        const ProtobufCBinaryData *id = &replay->pending[k].request->id;
        if (replay->pending[k].until != UINT64_MAX || !id->len || id->len != request->id.len ||
            memcmp(id->data, request->id.data, id->len) != 0)
            continue;
        replay->pending[k] = replay->pending[--replay->n_pending];
        return;
    }
}

/* The time to which the next step is shortened. */
static double pending_limit(const Replay *replay)
{
    double limit = INFINITY;
    const MnsProgress now = mns_sim_progress(replay->sim);
    const uint64_t step = now.step;
    for (size_t k = 0; k < replay->n_pending; k++) {
        const Pending *pending = &replay->pending[k];
        if (pending->request->has_at_time && step < pending->until && pending->request->at_time > now.t)
            limit = fmin(limit, pending->request->at_time);
    }
    return limit;
}

/* --- step by step ------------------------------------------------------------------------------------------------------- */

/* What a crash undid here, and was done again. */
static MnsStatus catch_up(Replay *replay, MnsError *error)
{
    MnsStatus status = MNS_OK;
    for (; !status && replay->again < replay->origin->n_again; replay->again++) {
        const Meniscus__Again *again = replay->origin->again[replay->again];
        const Meniscus__Request *request = again->request;
        if (again->step > mns_sim_progress(replay->sim).step) break;
        if (again->scheduled && request)
            status = add_pending(replay, request, again->has_until_step ? again->until_step : UINT64_MAX, error);
        else if (again->adopted) status = adopt(replay, again->adopted, error);
        else if (request && request->command_case == MENISCUS__REQUEST__COMMAND_SET)
            status = set_again(replay, request->set, error);
        else if (lineage_is_limit(request)) set_limit(replay, request);
    }
    return status;
}

/* What was commanded then found the run in FAULT or ended it, or tells nothing of that. */
static bool may_have_fallen(const Record *record)
{
    if (!record->reply || !record->reply->has_state) return true;
    switch (record->reply->state) {
    case MENISCUS__STATE__READY:
    case MENISCUS__STATE__RUNNING:
    case MENISCUS__STATE__PAUSED:
    case MENISCUS__STATE__DONE: return false;
    default: return true;
    }
}

static bool tells_of_fall(const Record *record)
{
    return record->reply && record->reply->reason && !strcmp(record->reply->reason, mns_status_name(MNS_E_DIVERGED));
}

static MnsStatus step_once(Replay *replay, MnsError *error)
{
    const double end = replay->document->c->end_time;
    replay->steps++;
    return mns_sim_step(replay->sim, fmin(fmin(replay->limit, pending_limit(replay)), end), error);
}

/* It diverged, as the run had. */
static MnsStatus fall(Replay *replay, MnsError *error)
{
    replay->fallen = true;
    *error = (MnsError){.status = MNS_OK};
    return MNS_OK;
}

/* It diverged on the way to a record. Where the run had come no further, that is what was to be shown. */
static MnsStatus fall_before(Replay *replay, const HistoryRecord *at, MnsError *error)
{
    char text[480];
    if (mns_sim_progress(replay->sim).step == at->message->step && may_have_fallen(at->message))
        return fall(replay, error);
    snprintf(text, sizeof text, "the replay did not get there: %.400s", error->text);
    return differs(at, error, text);
}

/* Up to the step of a record, with what is to be done again there: but a hash may be of the state before that (compare()). */
static MnsStatus advance(Replay *replay, const HistoryRecord *at, MnsError *error)
{
    const uint64_t step = at->message->step, now = mns_sim_progress(replay->sim).step;
    const bool hash = at->message->has_state_hash;
    MnsStatus status = hash && now == step ? MNS_OK : catch_up(replay, error);
    while (!status && mns_sim_progress(replay->sim).step < step) {
        if (mns_sim_progress(replay->sim).t >= replay->document->c->end_time)
            return differs(at, error, "the replay reached the end time before this step");
        status = step_once(replay, error);
        if (status == MNS_E_DIVERGED) return fall_before(replay, at, error);
        if (!status) status = keep(replay, error);
        if (!status && !(hash && mns_sim_progress(replay->sim).step == step)) status = catch_up(replay, error);
    }
    if (!status && mns_sim_progress(replay->sim).step > step)
        return differs(at, error, "the journal goes back without a restore");
    return status;
}

static MnsStatus compare(Replay *replay, const HistoryRecord *at, MnsError *error)
{
    const Record *record = at->message;
    char text[400], why[160] = "";
    replay->compared++;
    uint64_t hash = mns_sim_hash(replay->sim);
    if (hash != record->state_hash) {
        const MnsStatus status = catch_up(replay, error);
        if (status) return status;
        hash = mns_sim_hash(replay->sim);
    }
    if (hash == record->state_hash) {
        replay->agreed_step = record->step;
        return MNS_OK;
    }
    const Record *origin = replay->origin;
    if (origin->arithmetic && strcmp(origin->arithmetic, mns_arithmetic()) != 0)
        snprintf(why, sizeof why,
                 "; it was computed with %.40s products and sums (%.40s), this replay with %s ones (%s)",
                 origin->arithmetic, origin->level ? origin->level : "?", mns_arithmetic(), mns_level());
    snprintf(text, sizeof text,
             "the state differs: its hash is %016" PRIx64 ", and was %016" PRIx64
             "; the last that agreed was that of step %" PRIu64 "%s",
             hash, record->state_hash, replay->agreed_step, why);
    return differs(at, error, text);
}

static MnsStatus command_again(Replay *replay, const HistoryRecord *at, MnsError *error)
{
    const Record *record = at->message;
    const Meniscus__Request *request = record->request;
    switch (request->command_case) {
    case MENISCUS__REQUEST__COMMAND_SET: return set_again(replay, request->set, error);
    case MENISCUS__REQUEST__COMMAND_ROLLBACK:
        return record->case_ ? adopt(replay, record->case_, error)
                             : differs(at, error, "a rollback without the case that it led to");
    case MENISCUS__REQUEST__COMMAND_STEP:
    case MENISCUS__REQUEST__COMMAND_RUN_UNTIL: replay->limit = INFINITY; return MNS_OK;
    default: return MNS_OK; /* what it did is where the next record begins */
    }
}

/* Begin where the record does. The run may have got beyond the last record before, and have written a checkpoint there. */
static MnsStatus begin_again(Replay *replay, const HistoryRecord *at, MnsError *error)
{
    const Record *record = at->message;
    const Kept *kept = NULL;
    const bool back = history_goes_back(record);
    MnsStatus status = MNS_OK;
    if (back && replay->sim && record->step > mns_sim_progress(replay->sim).step) status = advance(replay, at, error);
    if (back && !status) status = state_of(replay, record->step, &kept, error);
    (void)environment_compute_as(record->arithmetic); /* states tell if that is not to be had */
    if (!status) status = begin(replay, record->case_, kept, error);
    replay->origin = record;
    replay->again = replay->n_pending = 0;
    return status;
}

/* The run diverged there. A step that was too short to be taken leaves the state as it was, and is tried here. */
static MnsStatus fall_here(Replay *replay, const HistoryRecord *at, MnsError *error)
{
    if (replay->fallen) return MNS_OK;
    const MnsStatus status = step_once(replay, error);
    if (status == MNS_E_DIVERGED) return fall(replay, error);
    return status ? status : differs(at, error, "the run diverged here, and the replay goes on");
}

/* A step or run_until that ended before it was done; what was scheduled and refused changes no limit but its own. */
static bool is_broken_off(const Record *record)
{
    const bool motion = record->request && (record->request->command_case == MENISCUS__REQUEST__COMMAND_STEP ||
                                            record->request->command_case == MENISCUS__REQUEST__COMMAND_RUN_UNTIL);
    return motion && record->kind == MENISCUS__JOURNAL_RECORD__KIND__COMMAND;
}

static MnsStatus do_again(Replay *replay, const HistoryRecord *at, MnsError *error)
{
    const Record *record = at->message;
    if (record->kind == MENISCUS__JOURNAL_RECORD__KIND__LEASE) return MNS_OK; /* of who was told, not of the run */
    if (history_begins(record)) return begin_again(replay, at, error);
    if (!replay->sim)
        return differs(at, error, "the journal does not begin with a load, so there is nothing to replay");
    const MnsStatus status = advance(replay, at, error);
    if (status) return status;
    if (record->has_state_hash) return compare(replay, at, error);
    if (record->kind == MENISCUS__JOURNAL_RECORD__KIND__SCHEDULED && record->request)
        return add_pending(replay, record->request, UINT64_MAX, error);
    if (record->kind == MENISCUS__JOURNAL_RECORD__KIND__COMMAND && record->request)
        end_pending(replay, record->request);
    if (record->kind == MENISCUS__JOURNAL_RECORD__KIND__BEGUN && record->request) set_limit(replay, record->request);
    if (history_done_well(record)) return command_again(replay, at, error);
    if (is_broken_off(record)) replay->limit = INFINITY;
    return tells_of_fall(record) ? fall_here(replay, at, error) : MNS_OK;
}

/* The last load that neither went on from a checkpoint nor came after a crash. */
static size_t first_of(const History *history)
{
    for (size_t k = history->n; k-- > 0;) {
        const Record *record = history->records[k].message;
        if (history_begins(record) && !history_goes_back(record) && !record->comeback &&
            record->request->command_case == MENISCUS__REQUEST__COMMAND_LOAD)
            return k;
    }
    return 0;
}

static MnsStatus replay_all(Replay *replay, const History *history, MnsError *error)
{
    if (!history->n) return mns_fail(error, MNS_E_STATE, "the journal has no record, so there is nothing to replay");
    const size_t first = first_of(history);
    MnsStatus status = list_kept(replay, history->records + first, history->n - first, error);
    for (size_t k = first; !status && k < history->n; k++) status = do_again(replay, &history->records[k], error);
    return status;
}

static void print(const Replay *replay, const MnsError *error, int code, bool json)
{
    if (json) {
        json_t *all = json_pack("{so sI sI sb so}", "directory", outcome_text(replay->directory), "steps",
                                (json_int_t)replay->steps, "compared", (json_int_t)replay->compared, "agrees",
                                !error->status, "error", outcome_failure(error, code));
        outcome_print_json(all, JSON_COMPACT);
    } else if (!error->status)
        printf("%" PRIu64 " steps done again, %" PRIu64 " states compared: all agree\n", replay->steps,
               replay->compared);
}

int replay_run(const char *directory, int threads, bool json)
{
    MnsError error = {.status = MNS_OK};
    History history;
    Replay replay = {.directory = directory, .threads = threads, .limit = INFINITY};
    environment_threads();
    MnsStatus status = history_verify(directory, &history, &error);
    const bool unread = status != MNS_OK;
    if (!status) status = replay_all(&replay, &history, &error);
    const bool files = unread || status == MNS_E_CORRUPT || status == MNS_E_IO;
    const int code = files ? MNS_EXIT_IO : status ? MNS_EXIT_FAILED : MNS_EXIT_DONE;
    if (status) fprintf(stderr, "%s: %s\n", log_program(), error.text);
    print(&replay, &error, code, json);
    for (size_t k = 0; k < replay.n_kept; k++) keep_this(&replay.kept[k], NULL, NULL);
    free(replay.kept);
    free(replay.pending);
    mns_sim_free(replay.sim);
    document_leave(replay.document);
    history_done(&history);
    return code;
}
