/* SPDX-License-Identifier: BSD-3-Clause */
/* meniscus wait: come back when a state, a time or a step is reached, or when it never will be. */
#include "client/cli/command.h"
#include "client/cli/output.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

typedef struct Goal {
    unsigned states;
    double time;   /* NAN: none */
    uint64_t step; /* MNS_NO_STEP: none */
} Goal;

static MnsStatus read_state(const char *name, Goal *goal, MnsError *error)
{
    MnsState state;
    if (!mns_state_parse(name, &state))
        return mns_fail(error, MNS_E_INVALID,
                        "--for state=%.40s: the states are EMPTY, LOADING, READY, RUNNING, PAUSED, "
                        "DONE, FAULT, STOPPING and RECOVERING",
                        name);
    goal->states |= 1u << state;
    return MNS_OK;
}

static MnsStatus read_time(const char *text, Goal *goal, MnsError *error)
{
    const MnsStatus status = parse_number("--for time", text, &goal->time, error);
    if (status || goal->time >= 0) return status;
    return mns_fail(error, MNS_E_INVALID, "--for time=%s: a time to wait for is 0 s or more", text);
}

static MnsStatus read_goal(const char *text, Goal *goal, MnsError *error)
{
    if (strncmp(text, "state=", 6) == 0) return read_state(text + 6, goal, error);
    if (strncmp(text, "time=", 5) == 0) return read_time(text + 5, goal, error);
    if (strncmp(text, "step=", 5) == 0) return parse_count("--for step", text + 5, &goal->step, error);
    return mns_fail(error, MNS_E_INVALID, "--for \"%.100s\": write state=DONE, time=1.5 or step=1000", text);
}

static MnsStatus read_goals(const Invocation *in, Goal *goal, MnsError *error)
{
    const char *given[MAX_WORDS];
    const size_t n = options_all(&in->options, OPT_FOR, given);
    *goal = (Goal){.time = NAN, .step = MNS_NO_STEP};
    if (n == 0) goal->states = 1u << MNS_STATE_DONE;
    for (size_t k = 0; k < n; k++) {
        const MnsStatus status = read_goal(given[k], goal, error);
        if (status != MNS_OK) return status;
    }
    return MNS_OK;
}

/* States after which a time or a step is never reached, or in which nothing good comes any more. */
static unsigned dead_ends(const Goal *goal)
{
    const bool of_run = !isnan(goal->time) || goal->step != MNS_NO_STEP;
    return 1u << MNS_STATE_FAULT | (of_run ? 1u << MNS_STATE_DONE : 0);
}

/* The wait ended in a state that nobody asked for. */
static MnsStatus in_vain(Invocation *in, const MnsReply *reply, MnsError *error)
{
    if (reply->state == MNS_STATE_DONE)
        return mns_fail(error, MNS_E_STATE,
                        "the run was done at step %" PRIu64 ", t = %.6g s, before what was waited for", reply->step,
                        reply->time);
    return command_fault(in, error);
}

static MnsStatus report(const Invocation *in, const MnsReply *reply, MnsError *error)
{
    if (in->json) {
        json_t *object = output_reply(reply);
        json_object_set_new(object, "state_reached", json_boolean(reply->state_reached));
        return output_json(object, error);
    }
    printf("%s at step %" PRIu64 ", t = %.6g s\n", mns_state_name(reply->state), reply->step, reply->time);
    return MNS_OK;
}

/* Somebody who looks at a terminal is told for how long. What cannot be told does not matter. */
static void tell_how_long(Invocation *in)
{
    MnsReply *reply = NULL;
    if (in->json || !isatty(STDERR_FILENO) || mns_client_status(in->client, &reply, NULL)) return;
    const MnsRunInfo *info = reply->info;
    if (info && isfinite(info->eta_s))
        fprintf(stderr, "%s, t = %.4g s of %.4g s, some %.0f s to its end; `meniscus watch` shows it\n",
                mns_state_name(info->state), info->time, info->end_time, info->eta_s);
    mns_reply_free(reply);
}

MnsStatus command_wait(Invocation *in, MnsError *error)
{
    Goal goal;
    MnsReply *reply = NULL;
    MnsStatus status = command_usage(in, read_goals(in, &goal, error));
    if (status == MNS_OK) status = command_connect(in, error);
    if (status == MNS_OK) tell_how_long(in);
    if (status == MNS_OK)
        status = mns_client_wait(in->client, goal.states | dead_ends(&goal), goal.time, goal.step, &reply, error);
    if (status != MNS_OK) return status;
    const bool in_time = !isnan(goal.time) && reply->time >= goal.time;
    const bool asked = in_time || reply->step >= goal.step || goal.states & 1u << reply->state || !reply->state_reached;
    status = asked ? report(in, reply, error) : in_vain(in, reply, error);
    mns_reply_free(reply);
    return status;
}
