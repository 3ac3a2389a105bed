/* SPDX-License-Identifier: BSD-3-Clause */
/* What the run counts for whoever watches it from outside, and how the figures get there. */
#include "run/watch.h"

#include "run/inside.h"
#include <string.h>

void run_count_step(Run *run, double seconds)
{
    run->figures.steps++;
    run->figures.stepping += seconds;
}

void run_count_phases(Run *run)
{
    size_t *particles = run->figures.particles;
    const size_t n = mns_sim_particles(run->sim);
    const uint8_t *phase = mns_sim_field(run->sim, mns_field_find("phase"), 0);
    memset(particles, 0, sizeof run->figures.particles);
    if (!run->options.figures || !phase) return;
    for (size_t k = 0; k < n; k++)
        if (phase[k] < MNS_MAX_FLUIDS + MNS_MAX_WALLS) particles[phase[k]]++;
}

/* The status is this thread's to write, so it may read it without the lock. */
static void fill_run(const RunStatus *status, RunFigures *figures)
{
    figures->progress = status->progress;
    figures->end_time = status->end_time;
    figures->eta = status->eta;
    figures->threads = status->threads;
    figures->bytes = status->bytes;
    figures->uncorrected = status->uncorrected;
    figures->energy_excess = status->energy_excess;
    figures->n_timers = status->n_timers;
    memcpy(figures->timers, status->timers, figures->n_timers * sizeof *figures->timers);
}

static void fill_sample(const Sample *sample, size_t n, RunFigures *figures)
{
    figures->sampled = sample->taken;
    figures->sampled_at = sample->t;
    if (sample->taken) memcpy(figures->probes, sample->values, n * sizeof *sample->values);
}

void run_show(Run *run)
{
    RunFigures *figures = &run->figures;
    if (!run->options.figures) return;
    figures->state = run->status.state;
    figures->fault = run->status.fault;
    figures->lease = run->status.lease;
    figures->document = run->document;
    fill_run(&run->status, figures);
    if (run->document) fill_sample(&run->outputs.sample, run->document->c->n_probes, figures);
    figures_put(run->options.figures, figures);
}

/* --- for any thread ---------------------------------------------------------------------------------------------------- */

static RunFiles files_of(const OutputTally *tally)
{
    return (RunFiles){
        .written = tally->written, .failed = tally->failed, .seconds = tally->seconds, .latest = tally->latest};
}

void run_counts(Run *run, RunCounts *ret)
{
    const Outputs *outputs = &run->outputs;
    *ret = (RunCounts){.beats = run->beat,
                       .orders = run->mailbox.n,
                       .notes = run->outbox.live,
                       .progress_dropped = run->outbox.dropped[NOTE_PROGRESS],
                       .samples_dropped = run->outbox.dropped[NOTE_PROBES],
                       .snapshots = files_of(&outputs->snapshots),
                       .checkpoints = files_of(&outputs->checkpoints),
                       .journal = {.records = run->journal_tally.records,
                                   .failures = run->journal_tally.failures,
                                   .seconds = run->journal_tally.seconds}};
    writer_queue(outputs->writer, &ret->files, &ret->rows);
}
