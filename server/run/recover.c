/* SPDX-License-Identifier: BSD-3-Clause */
/* Back to where a run was before a crash: from its newest whole checkpoint, with all that was commanded since, at the steps at
 * which it was. Orders that come meanwhile wait; whoever asks for the status is told how far it is. */
#include "run/inside.h"

#include "base/log.h"
#include <inttypes.h>
#include <math.h>

static MnsStatus advance(Run *run, uint64_t step, double limit, bool *ret_output, MnsError *error)
{
    MnsStatus status = MNS_OK;
    while (!status && mns_sim_progress(run->sim).step < step) {
        const double end = run->document->c->end_time;
        if (mns_sim_progress(run->sim).t >= end)
            return mns_fail(error, MNS_E_INTERNAL, "the end time was reached before step %" PRIu64 " of the journal",
                            step);
        status = run_step_once(run, fmin(limit, end), ret_output, error);
    }
    return status;
}

/* A breakpoint that has been passed, or was gone when it was removed, changes nothing now. */
static MnsStatus do_again(Run *run, const LineageEntry *entry, double *limit, MnsError *error)
{
    const Meniscus__Request *request = entry->request;
    if (entry->adopted) return run_adopt_again(run, entry->adopted, error);
    if (request && request->command_case == MENISCUS__REQUEST__COMMAND_SET)
        return run_set_again(run, request->set, error);
    if (request && request->command_case == MENISCUS__REQUEST__COMMAND_BREAKPOINT) {
        run_breakpoint_again(run, request->breakpoint, NULL);
        return MNS_OK;
    }
    const bool exact =
        request && request->command_case == MENISCUS__REQUEST__COMMAND_RUN_UNTIL && request->run_until->exact;
    *limit = exact ? request->run_until->time : INFINITY;
    return MNS_OK;
}

static MnsStatus catch_up(Run *run, const Lineage *lineage, bool *ret_output, MnsError *error)
{
    const uint64_t checkpoint = mns_sim_progress(run->sim).step;
    double limit = INFINITY;
    MnsStatus status = MNS_OK;
    *ret_output = outputs_behind(&run->outputs, mns_sim_progress(run->sim).t);
    if (*ret_output && (lineage->n || lineage->step))
        status = outputs_take(&run->outputs, run->sim, run->document, error);
    for (size_t k = 0; !status && k < lineage->n; k++) {
        const LineageEntry *entry = &lineage->entries[k];
        if (!lineage_needs(lineage, k, checkpoint)) continue;
        status = advance(run, entry->step, limit, ret_output, error);
        if (!status) status = do_again(run, entry, &limit, error);
    }
    return status ? status : advance(run, lineage->step, limit, ret_output, error);
}

void run_recover(Run *run, Order *order)
{
    MnsError error;
    bool output = false;
    const Lineage *lineage = order->lineage;
    const RunLoad load = {
        .message = lineage->original, .name = lineage->name, .directory = lineage->directory, .resume = true};
    run_load(run, order, &load);
    const bool loaded = run->state == RUN_READY;
    run_commit(run); /* and from here on the order is whoever's gave it */
    if (!loaded || run->state != RUN_READY) return;
    run_enter(run, RUN_LOADING, "doing again what came after the checkpoint");
    const MnsStatus status = catch_up(run, lineage, &output, &error);
    run_hash(run);
    if (status) run_fault(run, &error, output);
    else run_enter(run, lineage->state == RUN_READY ? RUN_READY : RUN_PAUSED, "back where it was");
}
