/* SPDX-License-Identifier: BSD-3-Clause */
/* What a run leaves behind, and when: taken after a step, written elsewhere. */
#include "run/outputs.h"

#include "base/clock.h"
#include "io/atomic_file.h"
#include "io/directory.h"
#include "run/jobs.h"
#include "run/schedule.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* --- from one directory to the next ------------------------------------------------------------------------------------- */

/* A directory made ready for a run, while nothing of the present one has been given up. */
typedef struct Opening {
    const char *directory;
    bool goes_on, again, damaged;
    uint64_t step;
    size_t state_size;
    Series *series;
    Reserve reserve; /* that of the present run, if it is the same directory */
    char aside[RUNDIR_PATH];
    char path[IO_PATH_MAX]; /* of case.yaml               */
    AtomicFile text;        /* that file without its name */
} Opening;

/* After a crash, a run that is done again from its beginning is of the same time line, if its file can be read. One that goes on does so without its
 * samples rather than not at all: nobody may be there to move the file away. The sample of the beginning is taken anew. */
static MnsStatus open_series(Opening *opening, Writer *writer, const Document *document, MnsError *error)
{
    const char *directory = opening->directory;
    Series **ret = &opening->series;
    const bool goes_on = opening->goes_on && opening->step > 0;
    if (opening->again && !goes_on && !job_open_series(writer, directory, document, true, opening->step, ret, NULL))
        return MNS_OK;
    MnsStatus status = job_open_series(writer, directory, document, goes_on, opening->step, ret, error);
    opening->damaged = status == MNS_E_CORRUPT && opening->again;
    if (!opening->damaged) return status;
    status = series_set_aside(directory, error);
    return status ? status : job_open_series(writer, directory, document, true, opening->step, ret, error);
}

/* What takes room or reads files. */
static MnsStatus prepare(Opening *opening, Writer *writer, const Document *document, MnsError *error)
{
    const char *directory = opening->directory;
    MnsStatus status = directory_path(opening->path, directory, "case.yaml", error);
    if (!status) status = atomic_fill(&opening->text, opening->path, document->text, strlen(document->text), error);
    if (status) return status;
    status = job_hold(writer, &opening->reserve, directory, opening->state_size, error);
    if (!status && document->c->n_probes) status = open_series(opening, writer, document, error);
    if (!status && opening->series && !opening->again && series_was_cut(opening->series))
        status = series_begin_line(opening->series, error);
    if (status) atomic_cancel(&opening->text);
    return status;
}

/* What a failure leaves: the reserve of the present run goes on to be that. */
static void call_off(const Opening *opening, Outputs *outputs, bool same)
{
    Reserve reserve = opening->reserve;
    series_free(opening->series);
    if (same) outputs->reserve = reserve;
    else reserve_release(&reserve);
}

/* Tell the list of snapshots, move files aside, so that whoever reads it never looks for what has gone, and last make the first sign of
 * the run; or leave all files as they were. */
static MnsStatus move_in(Opening *opening, const Outputs *outputs, MnsError *error)
{
    const char *directory = opening->directory;
    MnsStatus status = MNS_OK;
    if (opening->goes_on)
        status = job_index(outputs->writer, directory, opening->step, outputs->note, outputs->arg, error);
    if (!status) status = rundir_abandon(directory, !opening->goes_on, opening->step, opening->aside, error);
    if (!status) status = atomic_commit(&opening->text, error);
    if (!status) return MNS_OK;
    atomic_cancel(&opening->text);
    rundir_return(directory, opening->aside);
    if (opening->goes_on) job_index(outputs->writer, directory, UINT64_MAX, NULL, NULL, NULL);
    return status;
}

static void put_series(Outputs *outputs, Series *series, Document *document)
{
    pthread_mutex_lock(&outputs->series_lock);
    outputs->series = series;
    outputs->document = document;
    pthread_mutex_unlock(&outputs->series_lock);
}

static void note_checkpoint(Outputs *outputs, uint64_t step, Document *document)
{
    document_leave(outputs->checkpoint_of);
    outputs->at_checkpoint = step;
    outputs->checkpoint_of = document_share(document);
}

/* One of this step, but from before the case was changed, would undo the change for who goes on from it. */
static bool is_checkpointed(const Outputs *outputs, uint64_t step, const Document *document)
{
    const Document *of = outputs->checkpoint_of;
    return outputs->at_checkpoint == step && of && of->size == document->size &&
           !memcmp(of->blob, document->blob, of->size);
}

/* Nothing here can fail. */
static void take_over(Outputs *outputs, const Opening *opening, Document *document, MnsProgress progress)
{
    const bool goes_on = opening->goes_on;
    snprintf(outputs->directory, sizeof outputs->directory, "%s", opening->directory);
    memcpy(outputs->aside, opening->aside, sizeof outputs->aside);
    put_series(outputs, opening->series, document_share(document));
    outputs->reserve = opening->reserve;
    outputs->rescued = false;
    outputs->listing = (Listing){.listed = 0};
    outputs->state_size = opening->state_size;
    outputs->sample.taken = false;
    outputs->timers[OUTPUTS_PROBES] = (MnsTimer){.name = "probes"};
    outputs->timers[OUTPUTS_CAPTURES] = (MnsTimer){.name = "captures"};
    const bool sampled = outputs->series && document->c->output.probe_interval > 0 && progress.step > 0;
    outputs->series_lost = goes_on && sampled && !series_rows(outputs->series);
    outputs->series_damaged = opening->damaged;
    const double before = goes_on && progress.step > 0 ? progress.t : -INFINITY;
    outputs->before = (OutputTimes){before, before, before};
    note_checkpoint(outputs, goes_on ? progress.step : UINT64_MAX, document);
    outputs->at_snapshot = UINT64_MAX;
    outputs->wall_checkpoint = outputs->wall_flush = clock_now();
    outputs->capture_seconds = 0;
    outputs->checkpoint_seconds = 0;
    outputs->rows_wait = true;
}

MnsStatus outputs_open(Outputs *outputs, const OutputsPlace *place, Document *document, const MnsSim *sim,
                       MnsError *ret_lost, MnsError *error)
{
    const MnsProgress progress = mns_sim_progress(sim);
    const size_t state_size = mns_sim_capture_size(sim, mns_sim_state_fields(sim));
    const bool same = !strcmp(place->directory, outputs->directory);
    Opening opening = {.directory = place->directory,
                       .goes_on = place->goes_on,
                       .again = place->again,
                       .step = progress.step,
                       .state_size = state_size};
    if (place->aside) snprintf(opening.aside, sizeof opening.aside, "%s", place->aside);
    /* The files may be read here, or moved aside: the list with all snapshots, and all samples. */
    writer_hurry(outputs->writer);
    MnsStatus status = outputs_fit(sim, error);
    if (!status) status = outputs_flush(outputs, error);
    if (status) return status;
    if (same) opening.reserve = outputs->reserve;
    status = prepare(&opening, outputs->writer, document, error);
    if (!status) status = move_in(&opening, outputs, error);
    if (status) {
        call_off(&opening, outputs, same);
        return status;
    }
    *ret_lost = (MnsError){.status = MNS_OK};
    if (same) outputs->reserve = (Reserve){.held = false};
    outputs_close(outputs, ret_lost);
    outputs->lock = place->lock;
    take_over(outputs, &opening, document, progress);
    /* That a line was left is on the disk before anything of the new one, or whoever has rows of it would take these for more of them. */
    if (!place->again && opening.series && series_was_cut(opening.series) && !outputs_flush(outputs, NULL))
        writer_drain(outputs->writer, NULL);
    return MNS_OK;
}

MnsStatus outputs_close(Outputs *outputs, MnsError *error)
{
    if (!outputs->directory[0]) return MNS_OK;
    outputs_flush(outputs, NULL);
    writer_hurry(outputs->writer);
    const MnsStatus status = writer_drain(outputs->writer, error);
    writer_discard(outputs->writer);
    mns_capture_free(atomic_exchange(&outputs->spare, NULL));
    Series *series = outputs->series;
    Document *document = outputs->document;
    put_series(outputs, NULL, NULL);
    series_free(series);
    document_leave(document);
    document_leave(outputs->checkpoint_of);
    outputs->checkpoint_of = NULL;
    reserve_release(&outputs->reserve);
    outputs->directory[0] = 0;
    return status;
}

/* --- what is there ----------------------------------------------------------------------------------------------------- */

static MnsStatus copy_rows(const Series *series, size_t n_columns, const int *columns, SeriesRows *ret, MnsError *error)
{
    const size_t n = ret->n;
    ret->step = malloc(n * sizeof *ret->step);
    ret->time = malloc(n * sizeof *ret->time);
    ret->values = malloc(n * n_columns * sizeof *ret->values);
    if (ret->step && ret->time && ret->values) {
        series_copy(series, ret->first, n, n_columns, columns, ret->step, ret->time, ret->values);
        return MNS_OK;
    }
    free(ret->step);
    free(ret->time);
    free(ret->values);
    return mns_fail(error, MNS_E_MEMORY, "no memory for %zu rows", n);
}

MnsStatus outputs_rows(Outputs *outputs, const Document *document, uint64_t line, uint64_t first, size_t most,
                       size_t n_columns, const int *columns, SeriesRows *ret, MnsError *error)
{
    MnsStatus status = MNS_OK;
    pthread_mutex_lock(&outputs->series_lock);
    const Series *series = outputs->series;
    if (!series) status = mns_fail(error, MNS_E_STATE, "there is no series of probes");
    else if (outputs->document != document) status = mns_fail(error, MNS_E_STATE, "the series is of another case");
    else {
        const size_t end = line ? series_line_end(series, line) : SIZE_MAX, saved = series_saved(series);
        *ret = (SeriesRows){.line = series_line(series), .first = first};
        ret->left = first > end;
        if (ret->left) ret->first = end;
        else if (first < saved) ret->n = saved - first < most ? saved - first : most;
        if (ret->n) status = copy_rows(series, n_columns, columns, ret, error);
    }
    pthread_mutex_unlock(&outputs->series_lock);
    return status;
}

MnsStatus outputs_begin_line(Outputs *outputs, MnsError *error)
{
    if (!outputs->series) return MNS_OK;
    writer_drain(outputs->writer, NULL); /* all rows until now are of the line before */
    pthread_mutex_lock(&outputs->series_lock);
    const MnsStatus status = series_begin_line(outputs->series, error);
    pthread_mutex_unlock(&outputs->series_lock);
    outputs->rows_wait = true;
    return status;
}

/* --- what is due ------------------------------------------------------------------------------------------------------- */

static void book(MnsTimer *timer, double began)
{
    timer->seconds += clock_now() - began;
    timer->calls++;
}

/* As mns_sim_capture(), with its time booked; into the room of one that was written, as fresh pages take the system several times as long
 * to hand out as they take to fill. */
static MnsStatus capture_fields(Outputs *outputs, const MnsSim *sim, uint64_t fields, MnsCapture **ret, MnsError *error)
{
    const double began = clock_now();
    MnsCapture *spare = atomic_exchange(&outputs->spare, NULL);
    MnsStatus status = spare ? mns_sim_recapture(sim, fields, spare, NULL) : MNS_E_STATE;
    if (!status) *ret = spare;
    else {
        mns_capture_free(spare);
        status = mns_sim_capture(sim, fields, ret, error);
    }
    book(&outputs->timers[OUTPUTS_CAPTURES], began);
    return status;
}

/* Measure all probes; the samples go to the file and to whoever watches. */
static MnsStatus take_probes(Outputs *outputs, const MnsSim *sim, Document *document, MnsError *error)
{
    const double began = clock_now();
    const size_t n = document->c->n_probes;
    const MnsProgress now = mns_sim_progress(sim);
    double values[MNS_MAX_PROBES];
    for (size_t k = 0; k < n; k++) values[k] = mns_sim_probe(sim, k);
    book(&outputs->timers[OUTPUTS_PROBES], began);
    outputs->sample.taken = true;
    outputs->sample.step = now.step;
    outputs->sample.t = now.t;
    memcpy(outputs->sample.values, values, n * sizeof *values);
    Note *note = note_new(NOTE_PROBES, n);
    if (!note) return mns_fail(error, MNS_E_MEMORY, "no memory for a sample of the probes");
    note->state = RUN_RUNNING;
    note->step = now.step;
    note->t = now.t;
    note->document = document_share(document);
    for (size_t k = 0; k < n; k++) note->values[k] = values[k];
    const MnsStatus status = job_post_row(outputs, now, n, values, error);
    if (status) {
        note_free(note);
        return status;
    }
    outputs->rows_wait = true;
    outbox_put(outputs->outbox, note);
    return MNS_OK;
}

MnsStatus outputs_flush(Outputs *outputs, MnsError *error)
{
    const MnsStatus status = outputs->series ? job_post_flush(outputs, error) : MNS_OK;
    if (status) return status;
    outputs->wall_flush = clock_now();
    outputs->rows_wait = false;
    return MNS_OK;
}

MnsStatus outputs_settle(Outputs *outputs, MnsError *error)
{
    const MnsStatus status = outputs->rows_wait ? outputs_flush(outputs, error) : MNS_OK;
    return status ? status : writer_drain(outputs->writer, error);
}

MnsStatus outputs_checkpoint(Outputs *outputs, const MnsSim *sim, Document *document, Order *order, MnsError *error)
{
    MnsCapture *capture;
    const double began = clock_now();
    MnsStatus status = capture_fields(outputs, sim, mns_sim_state_fields(sim), &capture, error);
    if (status) return status;
    outputs->capture_seconds = clock_now() - began;
    const uint64_t step = capture->progress.step;
    if (outputs->rows_wait) /* a restart needs the samples up to the checkpoint */
        status = outputs_flush(outputs, error);
    if (!status) status = job_post_checkpoint(outputs, capture, document, order, error);
    else mns_capture_free(capture);
    if (status) return status;
    outputs->wall_checkpoint = clock_now();
    note_checkpoint(outputs, step, document);
    return MNS_OK;
}

static uint64_t field_bit(const char *name)
{
    const int k = mns_field_find(name);
    return k < 0 ? 0 : (uint64_t)1 << k;
}

void outputs_know_snapshot(Outputs *outputs, uint64_t step, uint64_t fields)
{
    outputs->snapshot_fields = fields | (outputs->at_snapshot == step ? outputs->snapshot_fields : 0);
    outputs->at_snapshot = step;
}

MnsStatus outputs_snapshot(Outputs *outputs, const MnsSim *sim, Document *document, uint64_t fields, Order *order,
                           MnsError *error)
{
    const MnsOutput *output = &document->c->output;
    MnsCapture *capture;
    fields |= field_bit("position") | field_bit("id") | field_bit("phase");
    for (size_t k = 0; k < output->n_fields; k++) fields |= field_bit(output->fields[k]);
    /* It takes the place of one of this step, and what somebody wanted of that is there still. */
    if (outputs->at_snapshot == mns_sim_progress(sim).step) fields |= outputs->snapshot_fields;
    MnsStatus status = capture_fields(outputs, sim, fields, &capture, error);
    if (status) return status;
    const uint64_t step = capture->progress.step;
    status = job_post_snapshot(outputs, capture, document, order, error);
    if (!status) outputs_know_snapshot(outputs, step, fields);
    return status;
}

static bool checkpoint_due(const Outputs *outputs, const MnsOutput *output, double t)
{
    const double wall =
        schedule_checkpoint(output->checkpoint_wall_interval, outputs->capture_seconds + outputs->checkpoint_seconds);
    if (wall > 0 && clock_now() - outputs->wall_checkpoint >= wall) return true;
    return schedule_due(output->checkpoint_interval, outputs->before.checkpoint, t);
}

MnsStatus outputs_take(Outputs *outputs, const MnsSim *sim, Document *document, MnsError *error)
{
    const MnsOutput *output = &document->c->output;
    OutputTimes *before = &outputs->before;
    const double t = mns_sim_progress(sim).t;
    MnsStatus status = MNS_OK;
    outputs->rescued = false;
    if (outputs->series && schedule_due(output->probe_interval, before->probes, t))
        status = take_probes(outputs, sim, document, error);
    if (status) return status;
    before->probes = t;
    if (schedule_due(output->snapshot_interval, before->snapshot, t))
        status = outputs_snapshot(outputs, sim, document, 0, NULL, error);
    if (status) return status;
    before->snapshot = t;
    if (checkpoint_due(outputs, output, t)) status = outputs_checkpoint(outputs, sim, document, NULL, error);
    if (status) return status;
    before->checkpoint = t;
    if (clock_now() - outputs->wall_flush >= schedule_flush(outputs->flush_seconds, outputs->followers > 0))
        status = outputs_flush(outputs, error);
    return status ? status : writer_failure(outputs->writer, error);
}

bool outputs_behind(const Outputs *outputs, double t)
{
    const OutputTimes *before = &outputs->before;
    return before->probes < t || before->snapshot < t || before->checkpoint < t;
}

/* For what is due at this boundary there may have been no memory, and a restart from a checkpoint of it does not look at it again, but for that of
 * the start. */
static MnsStatus catch_up(Outputs *outputs, const MnsSim *sim, Document *document, MnsError *error)
{
    const MnsProgress now = mns_sim_progress(sim);
    if (!now.step || !outputs_behind(outputs, now.t)) return MNS_OK;
    const MnsStatus status = outputs_take(outputs, sim, document, error);
    return outputs_behind(outputs, now.t) ? status : MNS_OK;
}

MnsStatus outputs_finish(Outputs *outputs, const MnsSim *sim, Document *document, MnsError *error)
{
    MnsStatus status = catch_up(outputs, sim, document, error);
    if (!status && !is_checkpointed(outputs, mns_sim_progress(sim).step, document))
        status = outputs_checkpoint(outputs, sim, document, NULL, error);
    writer_hurry(outputs->writer); /* the list of snapshots is whole when a run is done */
    return status ? status : outputs_settle(outputs, error);
}

MnsStatus outputs_rescue(Outputs *outputs, const MnsSim *sim, Document *document, char *ret_path, MnsError *error)
{
    MnsError why;
    MnsCapture *capture;
    MnsStatus status = catch_up(outputs, sim, document, error);
    if (status) return status;
    job_give_room(outputs);
    status = outputs_flush(outputs, error);
    if (status) return status;
    status = writer_salvage(outputs->writer, &why);
    if (status) return mns_fail(error, status, "%.400s; a checkpoint is written only behind that", why.text);
    status = mns_sim_capture(sim, mns_sim_state_fields(sim), &capture, error);
    if (status) return status;
    status = job_rescue_checkpoint(outputs, capture, document, ret_path, error);
    if (!status) note_checkpoint(outputs, capture->progress.step, document);
    mns_capture_free(capture);
    return status;
}
