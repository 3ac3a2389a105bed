/* SPDX-License-Identifier: BSD-3-Clause */
/* Commands that change what the daemon does: each prints the state after its effect and the step at which it took
 * effect. */
#include "client/cli/command.h"
#include "client/cli/output.h"
#include "common/case/find.h"
#include "common/host/text.h"
#include "common/wire/lease.h"
#include <inttypes.h>
#include <math.h>
#include <pwd.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Print a reply, and forget it. path: what it names, or NULL. */
static MnsStatus report_path(const Invocation *in, MnsReply *reply, const char *path, MnsError *error)
{
    MnsStatus status = MNS_OK;
    if (in->json) {
        json_t *object = output_reply(reply);
        if (path) json_object_set_new(object, "path", output_text(path));
        status = output_json(object, error);
    } else {
        const char *message = path && !strcmp(path, reply->message) ? "" : reply->message;
        const char *stopped = reply->state == MNS_STATE_EMPTY && path ? ", stopped" : "";
        printf("%s%s at step %" PRIu64 ", t = %.6g s", mns_state_name(reply->state), stopped, reply->step, reply->time);
        printf("%s%s%s%s\n", path ? ": " : "", text_shown(path), *message ? ": " : "", text_shown(message));
    }
    mns_reply_free(reply);
    return status;
}

static MnsStatus report(const Invocation *in, MnsStatus status, MnsReply *reply, MnsError *error)
{
    if (status != MNS_OK) return status;
    return report_path(in, reply, reply->output ? reply->output->path : NULL, error);
}

/* A run in motion has gone on by the time of the reply, and one that was stopped is nowhere: people are told the moment of the effect, which
 * is that of the file. Scripts have it in effect_step. */
static MnsStatus report_effect(const Invocation *in, MnsStatus status, MnsReply *reply, MnsError *error)
{
    if (status == MNS_OK && reply->output && !in->json) {
        reply->step = reply->output->step;
        reply->time = reply->output->time;
    }
    return report(in, status, reply, error);
}

MnsStatus command_simple(Invocation *in, MnsError *error)
{
    MnsReply *reply = NULL;
    MnsStatus status = command_connect(in, error);
    if (status == MNS_OK) status = in->command->call(in->client, &reply, error);
    return report(in, status, reply, error);
}

MnsStatus command_step(Invocation *in, MnsError *error)
{
    uint64_t count = 1;
    MnsReply *reply = NULL;
    MnsStatus status = MNS_OK;
    if (in->options.n_words) status = command_usage(in, parse_count("COUNT", in->options.words[0], &count, error));
    if (status == MNS_OK) status = command_connect(in, error);
    if (status == MNS_OK) status = mns_client_step(in->client, count, &reply, error);
    return report(in, status, reply, error);
}

MnsStatus command_run_until(Invocation *in, MnsError *error)
{
    double time;
    MnsReply *reply = NULL;
    const bool exact = !options_get(&in->options, OPT_WHOLE_STEPS);
    MnsStatus status = command_usage(in, parse_number("TIME", in->options.words[0], &time, error));
    if (status == MNS_OK) status = command_connect(in, error);
    if (status == MNS_OK) status = mns_client_run_until(in->client, time, exact, &reply, error);
    return report(in, status, reply, error);
}

MnsStatus command_stop(Invocation *in, MnsError *error)
{
    MnsReply *reply = NULL;
    const bool checkpoint = options_get(&in->options, OPT_CHECKPOINT);
    MnsStatus status = command_connect(in, error);
    if (status == MNS_OK) status = mns_client_stop(in->client, checkpoint, &reply, error);
    return report_effect(in, status, reply, error);
}

MnsStatus command_shutdown(Invocation *in, MnsError *error)
{
    MnsReply *reply = NULL;
    const bool checkpoint = options_get(&in->options, OPT_CHECKPOINT);
    MnsStatus status = command_connect(in, error);
    if (status == MNS_OK) status = mns_client_shutdown(in->client, checkpoint, &reply, error);
    return report(in, status, reply, error);
}

MnsStatus command_restore(Invocation *in, MnsError *error)
{
    MnsReply *reply = NULL;
    const char *file = in->options.n_words ? in->options.words[0] : NULL;
    MnsStatus status = command_connect(in, error);
    if (status == MNS_OK) status = mns_client_restore(in->client, file, &reply, error);
    return report(in, status, reply, error);
}

MnsStatus command_fields(const Invocation *in, const char **ret, size_t *ret_n, char **ret_text, MnsError *error)
{
    const char *given[MAX_WORDS];
    const size_t n_given = options_all(&in->options, OPT_FIELDS, given);
    size_t size = 1, n = 0;
    for (size_t k = 0; k < n_given; k++) size += strlen(given[k]) + 1;
    char *text = calloc(size, 1), *save = NULL;
    if (!text) return mns_fail(error, MNS_E_MEMORY, "no memory for the names of fields");
    for (size_t k = 0; k < n_given; k++) strcat(strcat(text, k ? "," : ""), given[k]);
    for (char *name = strtok_r(text, ",", &save); name && n < MAX_WORDS; name = strtok_r(NULL, ",", &save))
        ret[n++] = name;
    *ret_n = n;
    *ret_text = text;
    return MNS_OK;
}

MnsStatus command_snapshot(Invocation *in, MnsError *error)
{
    const char *fields[MAX_WORDS];
    char *text;
    size_t n;
    MnsReply *reply = NULL;
    MnsStatus status = command_fields(in, fields, &n, &text, error);
    if (status != MNS_OK) return status;
    status = command_connect(in, error);
    if (status == MNS_OK) status = mns_client_snapshot(in->client, n, fields, &reply, error);
    free(text);
    return report_effect(in, status, reply, error);
}

MnsStatus command_checkpoint(Invocation *in, MnsError *error)
{
    MnsReply *reply = NULL;
    MnsStatus status = command_connect(in, error);
    if (status == MNS_OK) status = mns_client_checkpoint(in->client, &reply, error);
    return report_effect(in, status, reply, error);
}

MnsStatus command_cancel(Invocation *in, MnsError *error)
{
    uint8_t id[MNS_REQUEST_ID_SIZE];
    MnsReply *reply = NULL;
    MnsStatus status = command_usage(in, parse_id("ID", in->options.words[0], id, error));
    if (status == MNS_OK) status = command_connect(in, error);
    if (status == MNS_OK) status = mns_client_cancel(in->client, id, &reply, error);
    return report(in, status, reply, error);
}

MnsStatus command_rollback(Invocation *in, MnsError *error)
{
    uint64_t version;
    MnsReply *reply = NULL;
    MnsStatus status = command_usage(in, parse_count("VERSION", in->options.words[0], &version, error));
    if (status == MNS_OK) status = command_connect(in, error);
    if (status == MNS_OK) status = mns_client_rollback(in->client, version, &reply, error);
    return report(in, status, reply, error);
}

/* Print a lease, or that it was given back; in a shell its number is all that is wanted. */
static MnsStatus report_lease(const Invocation *in, MnsReply *reply, MnsError *error)
{
    MnsStatus status = MNS_OK;
    if (in->json) {
        json_t *object = output_reply(reply);
        json_object_set_new(object, "lease_epoch",
                            reply->lease_epoch ? json_integer((json_int_t)reply->lease_epoch) : json_null());
        json_object_set_new(object, "lease_s", output_number(reply->lease_epoch ? reply->lease_s : NAN));
        status = output_json(object, error);
    } else if (reply->lease_epoch) {
        printf("%" PRIu64 "\n", reply->lease_epoch);
        if (isatty(STDOUT_FILENO))
            fprintf(stderr,
                    "It is yours for %.0f s. Commands are sent under it with: export MENISCUS_LEASE=%" PRIu64 "\n",
                    reply->lease_s, reply->lease_epoch);
    }
    mns_reply_free(reply);
    return status;
}

/* Bytes of a name of which at most 30 are shown: no character is cut in the middle. */
static int name_bytes(const char *name)
{
    size_t n = strnlen(name, 31);
    if (n == 31) do
            n--;
        while (n && ((unsigned char)name[n] & 0xc0) == 0x80);
    return (int)n;
}

/* $USER, which cron and services have not, or whose the process is; by number where no name is known for it. */
static const char *user_name(char ret[static 1024])
{
    const char *user = getenv("USER");
    struct passwd entry, *found = NULL;
    if (user && *user) return user;
    if (!getpwuid_r(geteuid(), &entry, ret, 1024, &found) && found) return entry.pw_name;
    snprintf(ret, 1024, "%u", (unsigned)geteuid());
    return ret;
}

/* ret: [256], user@host */
static void name_holder(char *ret)
{
    char host[128] = "somewhere", buffer[1024];
    const char *user = user_name(buffer);
    gethostname(host, sizeof host - 1);
    snprintf(ret, 256, "%.*s@%.*s", name_bytes(user), user, name_bytes(host), host);
}

static MnsStatus read_ttl(const Invocation *in, double *ret, MnsError *error)
{
    const char *ttl = options_get(&in->options, OPT_TTL);
    *ret = 30;
    const MnsStatus status = ttl ? parse_number("--ttl", ttl, ret, error) : MNS_OK;
    if (status || lease_can_live(*ret)) return status;
    return mns_fail(error, MNS_E_INVALID, "--ttl %s: a lease lives from %g to %g s", ttl, 1e-3 * LEASE_MS_MIN,
                    1e-3 * LEASE_MS_MAX);
}

MnsStatus command_lease(Invocation *in, MnsError *error)
{
    const char *what = in->options.n_words ? in->options.words[0] : "take";
    const char *holder = options_get(&in->options, OPT_HOLDER);
    const bool take = !strcmp(what, "take"), release = !strcmp(what, "release");
    char name[256];
    double seconds;
    MnsReply *reply = NULL;
    MnsStatus status = command_usage(in, read_ttl(in, &seconds, error));
    if (!status && !take && !release && strcmp(what, "renew") != 0)
        status = command_usage(in, mns_fail(error, MNS_E_INVALID,
                                            "lease takes one of take, renew and release, but found \"%.60s\"", what));
    if (!status && !take && !in->lease)
        status = command_usage(
            in, mns_fail(error, MNS_E_INVALID, "which lease? Give its epoch with --lease or $MENISCUS_LEASE"));
    name_holder(name);
    if (!status) status = command_connect(in, error);
    if (!status && take) mns_client_set_lease(in->client, 0);
    if (!status)
        status = release ? mns_client_release(in->client, &reply, error)
                         : mns_client_lease(in->client, seconds, take ? holder ? holder : name : NULL, &reply, error);
    return status ? status : report_lease(in, reply, error);
}

/* The options of a breakpoint. Exactly one of time, step, condition and removal must be said. */
static MnsStatus read_breakpoint(const Invocation *in, MnsBreakpoint *ret, MnsError *error)
{
    const char *time = options_get(&in->options, OPT_AT_TIME), *step = options_get(&in->options, OPT_AT_STEP);
    const char *condition = options_get(&in->options, OPT_CONDITION);
    *ret = (MnsBreakpoint){.name = in->options.words[0], .condition = condition, .time = NAN};
    if (!time + !step + !condition + !options_get(&in->options, OPT_REMOVE) != 3)
        return mns_fail(error, MNS_E_INVALID, "breakpoint takes exactly one of --time, --step, --when and --remove");
    if (time) return parse_number("--time", time, &ret->time, error);
    if (!step) return MNS_OK;
    const MnsStatus status = parse_count("--step", step, &ret->step, error);
    if (status == MNS_OK && !ret->step)
        return mns_fail(error, MNS_E_INVALID, "--step 0: the first step to pause after is 1");
    return status;
}

MnsStatus command_breakpoint(Invocation *in, MnsError *error)
{
    MnsBreakpoint breakpoint;
    MnsReply *reply = NULL;
    MnsStatus status = command_usage(in, read_breakpoint(in, &breakpoint, error));
    if (status == MNS_OK) status = command_connect(in, error);
    if (status == MNS_OK) status = mns_client_breakpoint(in->client, &breakpoint, &reply, error);
    return report(in, status, reply, error);
}

/* The directory is in the reply to the load. */
static MnsStatus start_loaded(const Invocation *in, MnsReply *loaded, MnsError *error)
{
    MnsReply *reply = NULL;
    MnsStatus status = mns_client_start(in->client, &reply, error);
    if (status == MNS_OK) status = report_path(in, reply, loaded->output ? loaded->output->path : NULL, error);
    mns_reply_free(loaded);
    return status;
}

MnsStatus command_load(Invocation *in, MnsError *error)
{
    const char *sets[MAX_WORDS];
    char path[4096];
    const MnsLoad load = {.file = path,
                          .name = options_get(&in->options, OPT_NAME),
                          .n_sets = options_all(&in->options, OPT_SET, sets),
                          .sets = sets,
                          .resume = options_get(&in->options, OPT_RESUME)};
    MnsReply *reply = NULL;
    MnsStatus status = case_find(in->options.words[0], path, error);
    if (status == MNS_OK) status = command_connect(in, error);
    if (status == MNS_OK) status = mns_client_load(in->client, &load, &reply, error);
    if (status != MNS_OK && strcmp(error->path, "name") == 0) command_usage(in, status); /* --name, not the case */
    if (status != MNS_OK || !options_get(&in->options, OPT_START)) return report(in, status, reply, error);
    return start_loaded(in, reply, error);
}
