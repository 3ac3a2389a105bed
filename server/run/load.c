/* SPDX-License-Identifier: BSD-3-Clause */
/* Where a simulation comes from and where it goes: load, reset, restore, stop, leave. A new one is complete, its files too, before
 * the old one is given up, so that a bad case, a damaged file or a full disk changes nothing. */
#include "run/inside.h"

#include "base/clock.h"
#include "base/log.h"
#include "common/case/file.h"
#include "common/case/name.h"
#include "common/host/places.h"
#include "io/atomic_file.h"
#include "io/directory.h"
#include "io/names.h"
#include "run/abandoned.h"
#include "run/environment.h"
#include "run/history.h"
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <math.h>
#include <string.h>
#include <unistd.h>

/* What is to take the place of the present run. */
typedef struct Candidate {
    const Order *order; /* who wants it */
    Document *document;
    MnsSim *sim;
    Document *stored;          /* as a checkpoint had it; NULL without one */
    Document *original;        /* what a reset leads back to, if it is another one than now */
    bool goes_on;              /* from a checkpoint                                         */
    bool asked_to;             /* go on, if there is one                                    */
    bool overwrites;           /* what was in the directory, unless it goes on              */
    bool other;                /* the arithmetic of what it goes on from is not to be had   */
    size_t made;               /* of the directory, by rundir_make()                      */
    int lock;                  /* of the directory; -1 if the present run has it            */
    Journal *journal;          /* the same; NULL                                            */
    bool journal_made;         /* it was not there before                                   */
    MnsError damage;           /* of the journal of the run that was there, to which nothing may be added; MNS_OK */
    char retired[RUNDIR_PATH]; /* where that is now; empty: where it was */
    History history;           /* what the journal tells of what it goes on from            */
    uint64_t from_sum;         /* of the checkpoint that it goes on from                    */
    char directory[RUNDIR_PATH];
} Candidate;

static void candidate_drop(Candidate *candidate)
{
    history_done(&candidate->history);
    mns_sim_free(candidate->sim);
    document_leave(candidate->document);
    document_leave(candidate->stored);
    document_leave(candidate->original);
    if (candidate->lock < 0) return; /* the directory is not ours to take away */
    journal_free(candidate->journal);
    if (candidate->journal_made) rundir_forget_journal(candidate->directory);
    if (candidate->retired[0]) rundir_return_journal(candidate->directory, candidate->retired);
    if (candidate->made) rundir_unmake(candidate->directory, candidate->made);
    close(candidate->lock);
}

/* Before anything is written there: what is added to a journal whose end was cut off would hide that. A run may begin from a checkpoint alone; and one that
 * begins anew has a journal of its own, or it could not go on later. */
static MnsStatus read_history(Candidate *candidate, MnsError *error)
{
    MnsError why;
    const MnsStatus status = history_check(candidate->directory, &candidate->history, &why);
    if (!candidate->asked_to) history_done(&candidate->history);
    if (!status || status == MNS_E_NOT_FOUND) return MNS_OK;
    *error = why;
    if (candidate->asked_to || (status != MNS_E_CORRUPT && status != MNS_E_VERSION)) return status;
    candidate->damage = why;
    return MNS_OK;
}

static bool has_journal(const char *directory)
{
    char path[4096];
    return !directory_path(path, directory, JOURNAL_NAME, NULL) && !access(path, F_OK);
}

static MnsStatus open_journal(Run *run, Candidate *candidate, MnsError *error)
{
    return run_journal_open(run, candidate->directory, &candidate->journal, &candidate->journal_made, error);
}

/* The last thing before the files themselves. */
static MnsStatus begin_journal(Run *run, Candidate *candidate, MnsError *error)
{
    MnsStatus status = MNS_OK;
    if (candidate->damage.status) status = rundir_retire_journal(candidate->directory, candidate->retired, error);
    return status ? status : open_journal(run, candidate, error);
}

/* Make its directory and have it to ourselves: before anything in it is looked at, as another run may be writing there. A journal is made only when the
 * simulation is: a program that is killed before leaves none that looks as if its records were lost. */
static MnsStatus occupy(Run *run, Candidate *candidate, MnsError *error)
{
    const int lock = run->directory_lock;
    const bool ours = lock >= 0 && !strcmp(candidate->directory, run->outputs.directory) &&
                      !rundir_check(candidate->directory, lock, NULL);
    if (ours) return candidate->asked_to ? read_history(candidate, error) : MNS_OK;
    MnsStatus status = rundir_make(candidate->directory, &candidate->made, error);
    if (!status) status = rundir_lock(candidate->directory, &candidate->lock, error);
    if (!status) status = read_history(candidate, error);
    if (!status) rundir_clear(candidate->directory);
    if (!status && run->options.parent && !candidate->order->lineage)
        status = rundir_try_current(run->options.parent, error);
    if (!status && !candidate->damage.status && has_journal(candidate->directory))
        status = open_journal(run, candidate, error);
    return status;
}

void run_tell_file(void *run, const char *text)
{
    char told[512];
    snprintf(told, sizeof told, "%.400s; it is left out of " INDEX_NAME, text);
    run_tell(run, NOTE_LOG, LOG_WARNING, "snapshot", told);
}

/* --- building ---------------------------------------------------------------------------------------------------------- */

/* Compute as this was computed. A run that comes back after a crash is computed as its journal says: it need not be as its checkpoint was. */
static void take_arithmetic(Candidate *candidate, const char *arithmetic)
{
    const Lineage *lineage = candidate->order->lineage;
    candidate->other = !environment_compute_as(lineage && lineage->arithmetic ? lineage->arithmetic : arithmetic);
}

/* A beginning has no arithmetic but the program's own, unless a crash has led back to it. */
static void begin_arithmetic(Candidate *candidate)
{
    const Lineage *lineage = candidate->order->lineage;
    if (lineage && lineage->arithmetic) take_arithmetic(candidate, NULL);
    else environment_compute_anew();
}

static MnsStatus build(Run *run, Candidate *candidate, Document *document, const MnsCapture *state, MnsError *error)
{
    if (!state) begin_arithmetic(candidate);
    candidate->document = document;
    candidate->goes_on = state != NULL;
    return run_make(run, candidate->order, document->c, state, &candidate->sim, error);
}

/* Go over to the steerable entries of another document of the same case; it is taken over. */
static MnsStatus adopt(Candidate *candidate, Document *document, MnsError *error)
{
    const MnsStatus status = mns_sim_steer(candidate->sim, document->c, error);
    document_leave(status ? document : candidate->document);
    if (!status) candidate->document = document;
    return status;
}

/* From a checkpoint that has been read. load: what is wanted, with its document, or NULL to go on in the present run as it was then. */
static MnsStatus build_from(Run *run, Candidate *candidate, const Checkpoint *checkpoint, const char *name,
                            const RunLoad *load, Document *given, MnsError *error)
{
    Document *stored, *wanted = NULL;
    MnsStatus status = document_unpack(checkpoint->case_blob, checkpoint->case_size, name, &stored, error);
    if (status) return status;
    if (load) status = resumed_case(stored, checkpoint->path, given, load, &wanted, error);
    else status = resumed_restore(stored, checkpoint->path, run->document, error);
    if (!status && !load && run->journal)
        status = resumed_owned(&candidate->history, candidate->directory, checkpoint, error);
    candidate->from_sum = checkpoint->sum;
    if (!status) {
        take_arithmetic(candidate, checkpoint->arithmetic);
        candidate->stored = document_share(stored);
        status = build(run, candidate, document_share(stored), checkpoint->state, error);
    }
    document_leave(stored);
    if (status || !wanted || wanted == stored) {
        document_leave(wanted);
        return status;
    }
    return adopt(candidate, wanted, error);
}

/* --- replacing --------------------------------------------------------------------------------------------------------- */

static void close_log(Run *run)
{
    if (run->log) fclose(run->log);
    run->log = NULL;
}

/* Give up the present run, but for its files. */
static void give_up(Run *run)
{
    close_log(run);
    mns_sim_free(run->sim);
    document_leave(run->document);
    breakpoints_clear(run->breakpoints);
    run->sim = NULL;
    run->document = NULL;
    run->hashed = false;
}

/* And those too: they stay where they are. MNS_OK, or why some output could not be written. */
static MnsStatus close_run(Run *run, MnsError *error)
{
    const MnsStatus status = outputs_close(&run->outputs, error);
    tap_place(run->tap, NULL, NULL, false);
    give_up(run);
    return status;
}

/* The directory, too, is anybody's again. */
static void forget_run(Run *run)
{
    document_leave(run->original);
    run->original = NULL;
    versions_done(&run->versions);
    journal_free(run->journal);
    run->outputs.journal = run->journal = NULL;
    if (run->directory_lock >= 0) close(run->directory_lock);
    run->directory_lock = -1;
}

/* Does this end the run that the next start would look for? Then it is not looked for, and its directory may be taken away. */
static bool ends_current(const Run *run, const Order *order)
{
    bool same;
    return run->options.parent && order->request && !run_leaves_unended(run, order) &&
           rundir_is_current(run->options.parent, order->path, run->options.asked, &same);
}

/* The last answer of a run: it is written down in its directory, and leaves when that is free. The order is no longer ours when it is answered. */
static void answer_last(Run *run, Order *order, MnsStatus status, const MnsError *error)
{
    const bool ends = ends_current(run, order);
    run_answer(run, order, status, error);
    run_sync(run);
    if (ends) rundir_forget_current(run->options.parent);
    forget_run(run);
    run_reveal(run);
    run_release(run);
}

/* A run goes on without its log, which people read and programs do not. */
static void tell_without_log(Run *run, const char *path, int number)
{
    char found[PLACES_FOUND], text[768];
    MnsError error;
    places_found(path, found);
    file_fail(&error, number, "write", path);
    if (number == ENXIO || number == EISDIR)
        snprintf(text, sizeof text, "there is no log of this run: '%.200s' is %.400s; move it away for the next", path,
                 found);
    else snprintf(text, sizeof text, "there is no log of this run: %.600s", error.text);
    run_tell(run, NOTE_LOG, LOG_WARNING, "log", text);
}

static void open_log(Run *run)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/log", run->outputs.directory);
    const int fd = file_open(path, O_WRONLY | O_APPEND | O_CREAT, 0666);
    run->log = fd < 0 ? NULL : fdopen(fd, "a");
    run->log_lacks = false;
    if (run->log) return;
    tell_without_log(run, path, errno);
    if (fd >= 0) close(fd);
}

/* Put the candidate in place. On failure the present run stays there, and nothing that could fail comes after the files. */
static MnsStatus install(Run *run, Candidate *candidate, MnsError *error)
{
    MnsError lost;
    const OutputsPlace place = {.directory = candidate->directory,
                                .aside = candidate->retired,
                                .lock = candidate->lock >= 0 ? candidate->lock : run->directory_lock,
                                .goes_on = candidate->goes_on,
                                .again = candidate->order->lineage != NULL};
    const MnsStatus status = outputs_open(&run->outputs, &place, candidate->document, candidate->sim, &lost, error);
    if (status) return status;
    if (lost.status) run_tell(run, NOTE_LOG, LOG_WARNING, "lost", lost.text);
    run_answer_filed(run);
    run_drop_appointments(run, "called off by a load, reset or restore");
    if (!candidate->order->lineage) run_drop_held(run, "called off by a load, reset or restore");
    run_commit(run); /* they belong to the journal of the run that goes */
    give_up(run);
    run->astray = false;
    if (!candidate->order->lineage) run->recovery.lineage = NULL;
    run->noted = run->noted_here = 0;
    run->sim = candidate->sim;
    run->level = mns_level();
    run->document = candidate->document;
    tap_place(run->tap, run->sim, run->document, !candidate->original);
    if (candidate->original) {
        document_leave(run->original);
        run->original = candidate->original;
    }
    if (candidate->lock >= 0) {
        if (run->directory_lock >= 0) close(run->directory_lock);
        run->directory_lock = candidate->lock;
        journal_free(run->journal);
        run->journal = candidate->journal;
        run->current_due = run->options.parent != NULL;
    }
    run->outputs.journal = run->journal;
    versions_begin(&run->versions, candidate->original ? 1 : run->versions.number + 1, run->document);
    run->meter = (Meter){.stepping = 0};
    run->looks_from = 0;
    run->warned = 0;
    run->loaded = clock_now();
    run_count_phases(run);
    open_log(run);
    return MNS_OK;
}

/* Whoever gives a command again may have meant to go on. */
static void tell_begun_anew(Run *run, const Candidate *candidate)
{
    char text[640];
    snprintf(text, sizeof text, "the run in %.200s is begun anew, and its files are in %.200s: %s",
             candidate->directory, run->outputs.aside,
             candidate->retired[0] ? "its journal could not be gone on with"
             : candidate->asked_to ? "there was no checkpoint to go on from"
                                   : "with --resume auto a run goes on from its newest checkpoint");
    run_tell(run, NOTE_LOG, LOG_WARNING, "files", text);
}

/* One directory for each run or time line that was left adds up, and nothing else tells of it. */
static void tell_kept(Run *run, const char *directory)
{
    enum { MANY = 10 };
    const Abandoned kept = abandoned_count(directory);
    char text[640];
    if (kept.n <= MANY) return;
    snprintf(
        text, sizeof text,
        "%zu directories %.200s/abandoned* hold %.3g MB of earlier runs: delete those that you do not need, as with "
        "`rm -r`; `meniscus run --overwrite` adds none",
        kept.n, directory, 1e-6 * (double)kept.bytes);
    run_tell(run, NOTE_LOG, LOG_WARNING, "files", text);
}

/* The run that was there, of which the journal alone still tells. */
static void overwrite(Run *run)
{
    MnsError error;
    if (abandoned_delete(run->outputs.aside, &error)) run_tell(run, NOTE_LOG, LOG_WARNING, "files", error.text);
}

/* How it is damaged, but not how to go on there. */
static void tell_retired(Run *run, const Candidate *candidate)
{
    char text[sizeof candidate->damage.text + 640];
    const char *why = candidate->damage.text, *way_on = strstr(why, HISTORY_WAY_ON);
    snprintf(text, sizeof text,
             "this run has a journal of its own, as that of the run before it could not be gone on "
             "with, and is %.400s/" JOURNAL_NAME ": %.*s",
             candidate->retired, way_on ? (int)(way_on - why) : -1, why);
    run_tell(run, NOTE_LOG, LOG_WARNING, "journal", text);
}

/* What people would not expect of the files. */
static void tell_files(Run *run, const Candidate *candidate)
{
    const Outputs *outputs = &run->outputs;
    const bool anew = candidate->original && !candidate->goes_on && !candidate->order->lineage;
    char text[512];
    const bool overwrites = anew && candidate->overwrites;
    if (outputs->aside[0] && overwrites) overwrite(run);
    else if (outputs->aside[0] && anew) tell_begun_anew(run, candidate);
    else if (outputs->aside[0]) {
        snprintf(text, sizeof text, "files of the time line that was left are in %.400s", outputs->aside);
        run_tell(run, NOTE_LOG, LOG_NOTICE, "files", text);
    }
    if (candidate->retired[0]) tell_retired(run, candidate);
    if (outputs->aside[0] && !overwrites) tell_kept(run, candidate->directory);
    if (!outputs->series_lost && !outputs->series_damaged) return;
    snprintf(text, sizeof text,
             "there are no samples of the probes from before step %" PRIu64 ": probes.hdf %s; the series begins here",
             mns_sim_progress(run->sim).step,
             outputs->series_damaged ? "was damaged, and is probes.hdf.damaged now"
                                     : "was taken away or is of other probes");
    run_tell(run, NOTE_LOG, LOG_WARNING, "probes", text);
}

/* What people would not expect of the last bits, or of the pace. before: the level of the run until now; NULL: there was none. */
static void tell_arithmetic(Run *run, const Candidate *candidate, const char *before)
{
    char text[768];
    if (candidate->other)
        snprintf(
            text, sizeof text,
            "the run in %.400s was computed in another arithmetic, or by an older version: what follows differs in "
            "the last bits from a run without interruption",
            candidate->directory);
    else if (strcmp(run->level, environment_own_level()) != 0 && (!before || strcmp(run->level, before) != 0))
        snprintf(text, sizeof text,
                 "the run in %.400s was computed in another arithmetic than this machine's: so is what follows, with "
                 "the instructions of %s, which takes longer; MENISCUS_LEVEL=%s goes on faster, with other last bits",
                 candidate->directory, run->level, environment_own_level());
    else return;
    run_tell(run, NOTE_LOG, LOG_WARNING, "checkpoint", text);
}

/* Install it and answer; status: whether it could be built. previous: the state to fall back to. */
static void replace(Run *run, Order *order, Candidate *candidate, MnsStatus status, RunState previous, const char *text,
                    MnsError *error)
{
    const char *before = run->sim ? run->level : NULL;
    if (!status && candidate->lock >= 0 && !candidate->journal) status = begin_journal(run, candidate, error);
    if (!status) status = install(run, candidate, error);
    if (status) {
        candidate_drop(candidate);
        if (run->sim) (void)mns_level_force(run->level, NULL); /* as before */
        else environment_compute_anew();
        run_enter(run, previous, error->text);
    } else {
        snprintf(order->path, sizeof order->path, "%s", run->outputs.directory);
        order->effect_step = mns_sim_progress(run->sim).step;
        order->from_checkpoint = candidate->goes_on;
        order->from_sum = candidate->from_sum;
        run->hash = mns_sim_hash(run->sim); /* the journal has it below, after the order */
        run->hashed = true;
        run_enter(run, order->lineage ? RUN_RECOVERING : RUN_READY, text);
        tell_files(run, candidate);
        tell_arithmetic(run, candidate, before);
        run_tell_warnings(run);
        if (candidate->stored && candidate->original) run_tell_resumed(run, candidate->stored, candidate->original);
        document_leave(candidate->stored);
        history_done(&candidate->history);
    }
    run_answer(run, order, status, error);
    if (!status) run_note_hash(run);
}

/* --- the orders -------------------------------------------------------------------------------------------------------- */

static MnsStatus choose_directory(const Run *run, const RunLoad *load, char ret[static RUNDIR_PATH], MnsError *error)
{
    if (load->directory) {
        snprintf(ret, RUNDIR_PATH, "%s", load->directory);
        return MNS_OK;
    }
    if (!run->options.directory) return rundir_choose(run->options.parent, load->name, load->resume, ret, error);
    if (strlen(run->options.directory) >= RUNDIR_PATH)
        return mns_fail(error, MNS_E_LIMIT, "the path of the run directory is too long: %.200s...",
                        run->options.directory);
    snprintf(ret, RUNDIR_PATH, "%s", run->options.directory);
    return MNS_OK;
}

/* From the start the case leads to another state. */
static MnsStatus fail_brought(const char *directory, MnsError *error)
{
    return mns_fail(
        error, MNS_E_CORRUPT,
        "the run in '%.300s' began from a checkpoint that was brought there, and neither that nor one of its "
        "own is there; put it back",
        directory);
}

/* document is taken over. */
static MnsStatus build_load(Run *run, const RunLoad *load, Document *document, Candidate *candidate, MnsError *error)
{
    Checkpoint checkpoint = {.state = NULL};
    MnsStatus status = MNS_E_NOT_FOUND;
    if (load->resume) status = resumed_newest(run, &candidate->history, candidate->directory, true, &checkpoint, error);
    const Lineage *lineage = candidate->order->lineage;
    if (status == MNS_E_NOT_FOUND && lineage && lineage->brought) status = fail_brought(candidate->directory, error);
    if (status == MNS_E_NOT_FOUND) return build(run, candidate, document, NULL, error);
    if (!status) {
        status = build_from(run, candidate, &checkpoint, load->name, load, document, error);
        checkpoint_done(&checkpoint);
    }
    document_leave(document);
    return status;
}

/* The document of a load, with what the case leaves to whoever started the program. */
static MnsStatus document_of(const Run *run, const RunLoad *load, Document **ret, MnsError *error)
{
    Meniscus__Case *message;
    char threads[16];
    if (run->options.threads < 0 || load->message->has_threads)
        return document_new(load->message, load->name, ret, error);
    snprintf(threads, sizeof threads, "%d", run->options.threads);
    MnsStatus status = case_message_set(load->message, "threads", threads, &message, error);
    if (status) return status;
    status = document_new(message, load->name, ret, error);
    meniscus__case__free_unpacked(message, NULL);
    return status;
}

void run_load(Run *run, Order *order, const RunLoad *load)
{
    const RunState previous = run->state;
    MnsError error;
    Candidate candidate = {.order = order, .asked_to = load->resume, .overwrites = load->overwrite, .lock = -1};
    Document *document;
    MnsStatus status = document_of(run, load, &document, &error);
    if (status) {
        run_answer(run, order, status, &error);
        return;
    }
    if (!order->lineage && !run->sim) run->recovery.lineage = NULL; /* of a way back that could not begin */
    run_enter(run, order->lineage ? RUN_RECOVERING : RUN_LOADING, load->name);
    candidate.original = document_share(document);
    status = choose_directory(run, load, candidate.directory, &error);
    if (!status) status = occupy(run, &candidate, &error);
    if (status) document_leave(document);
    else status = build_load(run, load, document, &candidate, &error);
    replace(run, order, &candidate, status, previous,
            candidate.goes_on ? "loaded, to go on from a checkpoint" : "loaded", &error);
}

void run_reset(Run *run, Order *order)
{
    const RunState previous = run->state;
    MnsError error;
    Candidate candidate = {.order = order, .lock = -1};
    snprintf(candidate.directory, sizeof candidate.directory, "%s", run->outputs.directory);
    MnsStatus status = rundir_check(candidate.directory, run->directory_lock, &error);
    if (status) {
        run_answer(run, order, status, &error);
        return;
    }
    run_enter(run, RUN_LOADING, "placing the particles again");
    status = build(run, &candidate, document_share(run->original), NULL, &error);
    replace(run, order, &candidate, status, previous, "back at the beginning", &error);
}

static MnsStatus read_newest(Run *run, const History *history, Checkpoint *ret, MnsError *error)
{
    MnsError why;
    const MnsStatus status = resumed_newest(run, history, run->outputs.directory, false, ret, &why);
    if (!status) return MNS_OK;
    const bool none = status == MNS_E_NOT_FOUND;
    return mns_fail(error, status, "%.400s%s", why.text,
                    none ? "; `meniscus checkpoint` writes one, `meniscus reset` begins anew" : "");
}

static MnsStatus fail_unknown(const char *directory, const char *name, MnsError *error)
{
    char there[256];
    if (checkpoint_tell(directory, sizeof there, there))
        return mns_fail_at(error, MNS_E_NOT_FOUND, "checkpoint",
                           "there is no checkpoint \"%.60s\" in '%.150s', which has %s; name one of them, or none for "
                           "the newest",
                           name, directory, there);
    return mns_fail_at(error, MNS_E_NOT_FOUND, "checkpoint",
                       "there is no checkpoint \"%.60s\" in '%.150s', and no other one; `meniscus checkpoint` writes "
                       "one, `meniscus reset` begins anew",
                       name, directory);
}

static MnsStatus read_named(Run *run, const char *name, Checkpoint *ret, MnsError *error)
{
    char path[4096];
    const char *directory = run->outputs.directory;
    if (!is_name(name) || strlen(name) > 60)
        return mns_fail_at(
            error, MNS_E_INVALID, "checkpoint",
            "a checkpoint is named by its file in the run directory, as in checkpoint-0000000100.hdf; found "
            "\"%.60s\"",
            name);
    snprintf(path, sizeof path, "%s/%s", directory, name);
    const MnsStatus status = outputs_read(run->outputs.writer, path, ret, error);
    return status == MNS_E_NOT_FOUND ? fail_unknown(directory, name, error) : status;
}

void run_restore(Run *run, Order *order, const char *name)
{
    const RunState previous = run->state;
    MnsError error;
    Checkpoint checkpoint = {.state = NULL};
    Candidate candidate = {.order = order, .lock = -1};
    snprintf(candidate.directory, sizeof candidate.directory, "%s", run->outputs.directory);
    MnsStatus status = rundir_check(candidate.directory, run->directory_lock, &error);
    if (!status && run->journal) status = history_read(candidate.directory, &candidate.history, &error);
    if (!status)
        status = name ? read_named(run, name, &checkpoint, &error)
                      : read_newest(run, &candidate.history, &checkpoint, &error);
    if (status) {
        history_done(&candidate.history);
        run_answer(run, order, status, &error);
        return;
    }
    char text[4200];
    snprintf(text, sizeof text, "restored from %s", checkpoint.path);
    run_enter(run, RUN_LOADING, "restoring");
    status = build_from(run, &candidate, &checkpoint, run->document->name, NULL, NULL, &error);
    checkpoint_done(&checkpoint);
    replace(run, order, &candidate, status, previous, text, &error);
}

/* Leave a checkpoint of this very step and an up-to-date series behind, whatever becomes of an output that failed. A broken
 * state is not worth going on from. */
static MnsStatus secure(Run *run, bool checkpoint, MnsError *error)
{
    char path[4096];
    Outputs *outputs = &run->outputs;
    const bool broken = run_is_broken(run);
    if (!run->sim) return MNS_OK;
    outputs_flush(outputs, NULL);
    const MnsStatus status = writer_salvage(outputs->writer, error);
    if (!checkpoint || broken) return status;
    if (!status && !outputs_finish(outputs, run->sim, run->document, error)) return MNS_OK;
    return outputs_rescue(outputs, run->sim, run->document, path, error);
}

static void note_short(const Run *run, Order *order)
{
    if (!run->recovery.lineage || !run->sim) return;
    order->short_of = run->recovery.lineage->step;
    order->reached = mns_sim_progress(run->sim).step;
}

/* The journal tells that the run is ended, unless it was stopped before there was one: then it is not looked for any more. */
static void end_recovery(Run *run, Order *order)
{
    if (run->recovery.lineage && !run->sim) rundir_forget_current(run->options.parent);
    note_short(run, order);
    run->recovery.lineage = NULL;
}

void run_stop(Run *run, Order *order, bool checkpoint)
{
    MnsError error;
    MnsError ended;
    run_close_books(run); /* of what goes before nothing is left to be written when the simulation is gone */
    run_call_off(run, order);
    const MnsStatus status = secure(run, checkpoint, &error);
    mns_fail(&ended, MNS_E_INTERRUPTED, "stopped on request");
    snprintf(order->path, sizeof order->path, "%s", run->outputs.directory);
    if (status && checkpoint) { /* asked to keep it, so it is kept until there is room */
        run_fault(run, &error, true);
        run_answer(run, order, status, &error);
        return;
    }
    run_goal_end(run, MNS_E_INTERRUPTED, &ended);
    run_drop_appointments(run, ended.text);
    run_drop_held(run, ended.text);
    end_recovery(run, order);
    if (run->sim) run_tell(run, NOTE_LOG, LOG_INFORMATION, "stopped", "on request"); /* the last word of its log */
    if (close_run(run, &error)) run_tell(run, NOTE_LOG, LOG_WARNING, "lost", error.text);
    environment_compute_anew();
    run_enter(run, RUN_EMPTY, "stopped on request");
    answer_last(run, order, MNS_OK, NULL);
}

/* What is gone, and from where one can go on. */
static void tell_lost(Run *run, const MnsError *why)
{
    char name[256], text[2 * sizeof why->text];
    const uint64_t step = mns_sim_progress(run->sim).step;
    const bool any = checkpoint_last(run->outputs.directory, name);
    snprintf(text, sizeof text, "the state at step %" PRIu64 " is not kept, a resume goes on from %s: %s", step,
             any ? name : "the beginning, as there is no checkpoint", why->text);
    run_tell(run, NOTE_LOG, LOG_ERROR, "lost", text);
}

void run_leave(Run *run, Order *order, bool checkpoint)
{
    MnsError error, ended;
    run_close_books(run);                          /* as in run_stop() */
    if (run->recovery.lineage) checkpoint = false; /* whoever went on from it would miss what comes after it */
    note_short(run, order);
    mns_fail(&ended, MNS_E_INTERRUPTED, "the program is stopping");
    run_enter(run, RUN_STOPPING, checkpoint ? "stopping, with a checkpoint" : "stopping");
    run_goal_end(run, MNS_E_INTERRUPTED, &ended);
    run_drop_appointments(run, ended.text);
    snprintf(order->path, sizeof order->path, "%s", run->outputs.directory);
    const MnsStatus status = secure(run, checkpoint, &error);
    const bool broken = run_is_broken(run);
    if (status && checkpoint && !broken) tell_lost(run, &error);
    else if (status && strcmp(error.text, run->fault.text) != 0) /* else it has been told */
        run_tell(run, NOTE_LOG, LOG_ERROR, "lost", error.text);
    MnsError lost;
    if (close_run(run, &lost) && !status && strcmp(lost.text, run->fault.text) != 0)
        run_tell(run, NOTE_LOG, LOG_WARNING, "lost", lost.text);
    run->leaving = true;
    answer_last(run, order, status, &error);
}
