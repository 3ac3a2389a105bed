/* SPDX-License-Identifier: BSD-3-Clause */
/* What there is: the status of a daemon, what it can do, schemes, and the daemons of this host. */
#include "client/cli/command.h"
#include "client/cli/glance.h"
#include "client/cli/output.h"
#include "client/cli/program.h"
#include "common/host/text.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>

static void print_breakpoints(const MnsRunInfo *info)
{
    for (size_t k = 0; k < info->n_breakpoints; k++) {
        const MnsBreakpoint *at = &info->breakpoints[k];
        printf("breakpoint  %s:", text_shown(at->name));
        if (at->condition) printf(" %s", text_shown(at->condition));
        if (isfinite(at->time)) printf(" t = %g s", at->time);
        if (at->step) printf(" step %" PRIu64, at->step);
        putchar('\n');
    }
}

static void print_scheduled(const MnsRunInfo *info)
{
    for (size_t k = 0; k < info->n_scheduled; k++) {
        char id[2 * MNS_REQUEST_ID_SIZE + 1];
        output_id(info->scheduled[k].id, id);
        printf("scheduled   %s (%s, id %s)\n", text_shown(info->scheduled[k].what), text_shown(info->scheduled[k].who),
               id);
    }
}

static void print_timers(const MnsRunInfo *info)
{
    double all = 0;
    for (size_t k = 0; k < info->n_timers; k++) all += info->timers[k].seconds;
    for (size_t k = 0; k < info->n_timers && all > 0; k++)
        printf("%-11s %-22s %5.1f %%  %.3g s\n", k ? "" : "time in", info->timers[k].name,
               100 * info->timers[k].seconds / all, info->timers[k].seconds);
}

/* What is not known, as before the first step, is not there. */
static void print_speed(const MnsRunInfo *info)
{
    printf("speed       ");
    if (isfinite(info->steps_per_second)) printf("%.4g steps/s, ", info->steps_per_second);
    if (isfinite(info->ns_per_particle_step)) printf("%.4g ns per particle and step, ", info->ns_per_particle_step);
    printf("%u threads\n", info->threads);
}

/* As long as there are any. */
static void print_streams(const MnsStreamsNow *streams)
{
    if (!streams || !(streams->latest + streams->lossless)) return;
    printf("streams     %" PRIu64 " of the newest, %" PRIu64 " of everything; %.1f MiB held, %" PRIu64
           " items skipped since the daemon began\n",
           streams->latest, streams->lossless, (double)streams->memory_bytes / (1 << 20), streams->skipped);
}

static void print_info(const MnsRunInfo *info)
{
    printf("state       %s\n", mns_state_name(info->state));
    if (*info->fault) printf("fault       %s\n", text_shown(info->fault));
    if (info->state != MNS_STATE_EMPTY) {
        printf("case        %s%s%s\n", info->case_name, *info->title ? ": " : "", text_shown(info->title));
        printf("directory   %s\n", text_shown(info->run_directory));
        if (*info->lease_holder) printf("lease       %s, for %.1f s\n", text_shown(info->lease_holder), info->lease_s);
        if (info->case_version > 1) printf("version     %" PRIu64 " of the case\n", info->case_version);
        printf("time        %.6g of %.6g s, step %" PRIu64 ", last dt %.3g s\n", info->time, info->end_time, info->step,
               info->time_step);
        if (info->recovery_step != MNS_NO_STEP)
            printf("coming back to step %" PRIu64 ", where the run was before the crash\n", info->recovery_step);
        printf("particles   %" PRIu64 ", %" PRIu64 " of fluid; kept from walls %" PRIu64 " times\n", info->particles,
               info->fluid_particles, info->guarded);
        if (info->uncorrected)
            printf("densities   off by more than the case allows after %" PRIu64 " steps\n", info->uncorrected);
        if (info->energy_excess > 0)
            printf("energy      made of nothing: %.2g %% of what moves\n", 100 * info->energy_excess);
        print_speed(info);
        if (isfinite(info->eta_s)) printf("to go       %.0f s\n", info->eta_s);
        if (info->state_hash) printf("state hash  %016" PRIx64 "\n", info->state_hash);
    }
    print_breakpoints(info);
    print_scheduled(info);
    print_timers(info);
    print_streams(info->streams);
    printf("memory      %.1f MiB\n", (double)info->memory_bytes / (1 << 20));
    printf("meniscusd   %s\n", info->version);
}

MnsStatus command_status(Invocation *in, MnsError *error)
{
    MnsReply *reply = NULL;
    MnsStatus status = command_connect(in, error);
    if (status == MNS_OK) status = mns_client_status(in->client, &reply, error);
    if (status == MNS_OK && !reply->info) status = mns_fail(error, MNS_E_VERSION, "the daemon's status is empty");
    if (status == MNS_OK && in->json) status = output_json(output_info(reply->info), error);
    if (status == MNS_OK && !in->json) print_info(reply->info);
    mns_reply_free(reply);
    return status;
}

/* --- what a daemon can do ----------------------------------------------------------------------------------------- */

static void print_topics(const char *title, size_t n, const MnsTopicInfo *list)
{
    if (n) printf("\n%s\n", title);
    for (size_t k = 0; k < n; k++) {
        const MnsTopicInfo *t = &list[k];
        const char *unit = output_unit(t->unit);
        printf("  %-32s %s%s%s%s%s%s\n", t->name, text_shown(t->value), *t->value && *unit ? " " : "", unit,
               *t->range ? " in " : "", t->range, *unit || *t->range || *t->value ? ";" : "");
        if (*t->meaning) printf("  %-32s %s\n", "", t->meaning);
    }
}

static void print_names(const char *title, size_t n, const char *const *list)
{
    printf("\n%s\n ", title);
    for (size_t k = 0; k < n; k++) printf(" %s", list[k]);
    putchar('\n');
}

static void print_capabilities(const MnsCapabilities *c)
{
    char title[96];
    const char *when = c->n_parameters ? c->parameters[0].takes_effect : "";
    snprintf(title, sizeof title, "parameters%s%.60s", *when ? ": a set holds " : "", when);
    printf("meniscusd %s, %s\n", c->version, c->build);
    print_names("commands", c->n_commands, c->commands);
    print_names("telemetry to subscribe to, as `watch` does", c->n_topics, c->topics);
    print_names("probes", c->n_probes, c->probes);
    print_topics(title, c->n_parameters, c->parameters);
    print_topics("fields", c->n_fields, c->fields);
    print_topics("schemes", c->n_schemes, c->schemes);
}

static MnsStatus ask_capabilities(Invocation *in, MnsReply **ret, MnsError *error)
{
    MnsStatus status = mns_client_capabilities(in->client, ret, error);
    if (status == MNS_OK && !(*ret)->capabilities)
        status = mns_fail(error, MNS_E_VERSION, "the daemon's capabilities are empty");
    return status;
}

MnsStatus command_capabilities(Invocation *in, MnsError *error)
{
    MnsReply *reply = NULL;
    MnsStatus status = command_connect(in, error);
    if (status == MNS_OK) status = ask_capabilities(in, &reply, error);
    if (status == MNS_OK && in->json) status = output_json(output_capabilities(reply->capabilities), error);
    if (status == MNS_OK && !in->json) print_capabilities(reply->capabilities);
    mns_reply_free(reply);
    return status;
}

static json_t *schemes_json(const MnsCapabilities *c)
{
    json_t *list = json_array();
    for (size_t k = 0; k < c->n_schemes; k++)
        json_array_append_new(list, json_pack("{so so}", "name", output_text(c->schemes[k].name), "meaning",
                                              output_text(c->schemes[k].meaning)));
    return json_pack("{so}", "schemes", list);
}

/* A daemon knows its schemes; if there is none, its program can be asked. */
MnsStatus command_schemes(Invocation *in, MnsError *error)
{
    MnsReply *reply = NULL;
    MnsStatus status = command_connect(in, error);
    if (status == MNS_E_UNAVAILABLE && !options_get(&in->options, OPT_DAEMON)) {
        const char *const arguments[] = {"--schemes", in->json ? "-o" : NULL, "json", NULL};
        return program_become("meniscusd", arguments, error);
    }
    if (status == MNS_OK) status = ask_capabilities(in, &reply, error);
    if (status == MNS_OK && in->json) status = output_json(schemes_json(reply->capabilities), error);
    for (size_t k = 0; status == MNS_OK && !in->json && k < reply->capabilities->n_schemes; k++)
        printf("%s%s\n", k ? "\n" : "", reply->capabilities->schemes[k].meaning);
    mns_reply_free(reply);
    return status;
}

/* --- the daemons of this host ------------------------------------------------------------------------------------- */

typedef struct Listing {
    json_t *json; /* NULL: print text */
    size_t n;
} Listing;

static void list_one(Listing *listing, const char *name, const char *endpoint, const Glance *glance)
{
    const MnsRunInfo *info = glance->info;
    const char *state = info ? mns_state_name(info->state) : NULL, *fault = info && *info->fault ? info->fault : NULL;
    const bool has_case = info && info->state != MNS_STATE_EMPTY;
    if (listing->json) {
        json_t *daemon = json_pack("{ss so sb sb ss? so}", "name", name, "endpoint", output_text(endpoint), "alive",
                                   info != NULL, "silent", glance->is_silent, "state", state, "case",
                                   output_text(has_case ? info->case_name : NULL));
        json_object_set_new(daemon, "fault", output_text(fault));
        json_object_set_new(daemon, "time", output_number(has_case ? info->time : (double)NAN));
        json_object_set_new(daemon, "end_time", output_number(has_case ? info->end_time : (double)NAN));
        json_array_append_new(listing->json, daemon);
        return;
    }
    if (listing->n == 0) printf("%-16s %-10s %-18s %s\n", "NAME", "STATE", "CASE", "TIME");
    printf("%-16s %-10s %-18s ", name, glance_state(glance), has_case ? info->case_name : "-");
    if (has_case) printf("%.4g of %.4g s\n", info->time, info->end_time);
    else printf("-\n");
    if (fault) printf("  fault: %s\n", text_shown(fault));
}

static bool visit_daemon(void *arg, const char *name, const char *endpoint)
{
    Listing *listing = arg;
    Glance glance = glance_at(endpoint);
    list_one(listing, name, endpoint, &glance);
    listing->n++;
    glance_done(&glance);
    return true;
}

MnsStatus command_ls(Invocation *in, MnsError *error)
{
    Listing listing = {.json = in->json ? json_array() : NULL};
    mns_daemon_list(visit_daemon, &listing);
    if (in->json) return output_json(json_pack("{so}", "daemons", listing.json), error);
    if (listing.n == 0) printf("no daemon on this host; start one with `meniscusd`\n");
    return MNS_OK;
}
