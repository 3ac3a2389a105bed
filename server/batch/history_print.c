/* SPDX-License-Identifier: BSD-3-Clause */
/* The journal of a run directory: a line, or an object, for each record. */
#include "batch/history_print.h"

#include "base/log.h"
#include "batch/outcome.h"
#include "common/host/text.h"
#include "run/history.h"
#include "run/state.h"
#include <inttypes.h>
#include <jansson.h>
#include <meniscus/exit.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

typedef Meniscus__JournalRecord Record;

static const char *kind_name(const Record *record)
{
    switch (record->kind) {
    case MENISCUS__JOURNAL_RECORD__KIND__COMMAND: return "command";
    case MENISCUS__JOURNAL_RECORD__KIND__BEGUN: return "begun";
    case MENISCUS__JOURNAL_RECORD__KIND__HASH: return "hash";
    case MENISCUS__JOURNAL_RECORD__KIND__SCHEDULED: return "scheduled";
    case MENISCUS__JOURNAL_RECORD__KIND__LEASE: return "lease";
    case MENISCUS__JOURNAL_RECORD__KIND__HALTED: return "halted";
    default: return "unknown";
    }
}

static void when(const Record *record, char ret[static 40])
{
    struct tm parts;
    char seconds[24];
    const time_t whole = (time_t)(record->wall_us / 1000000u);
    strftime(seconds, sizeof seconds, "%Y-%m-%dT%H:%M:%S", gmtime_r(&whole, &parts));
    snprintf(ret, 40, "%s.%03uZ", seconds, (unsigned)(record->wall_us / 1000u % 1000u));
}

static const char *text(const char *string)
{
    return string ? string : "";
}

/* --- for people -------------------------------------------------------------------------------------------------------- */

/* Of what came to nothing, or has yet to come, no change tells what it was. */
static void print_assignments(FILE *out, const Meniscus__Set *set)
{
    for (size_t k = 0; k < set->n_assignments; k++)
        fprintf(out, "%s%s = %s", k ? ", " : "", text(set->assignments[k]->path), text(set->assignments[k]->value));
}

/* What was asked for, in words as short as those of the command line. */
static void print_arguments(FILE *out, const Record *record)
{
    const Meniscus__Request *request = record->request;
    switch (request->command_case) {
    case MENISCUS__REQUEST__COMMAND_LOAD: fputs(text(request->load->name), out); break;
    case MENISCUS__REQUEST__COMMAND_STEP: fprintf(out, "%" PRIu64, request->step->count); break;
    case MENISCUS__REQUEST__COMMAND_RUN_UNTIL: fprintf(out, "%.9g", request->run_until->time); break;
    case MENISCUS__REQUEST__COMMAND_RESTORE:
        fputs(request->restore->checkpoint ? request->restore->checkpoint : "the newest checkpoint", out);
        break;
    case MENISCUS__REQUEST__COMMAND_BREAKPOINT:
        fprintf(out, "%s%s", request->breakpoint->remove ? "remove " : "", text(request->breakpoint->name));
        break;
    case MENISCUS__REQUEST__COMMAND_SET:
        if (!record->n_changes) print_assignments(out, request->set);
        break;
    default: break;
    }
}

/* NULL if there are none; to be freed. */
static char *arguments_of(const Record *record)
{
    char *words = NULL;
    size_t size;
    FILE *out = record->request ? open_memstream(&words, &size) : NULL;
    if (!out) return NULL;
    print_arguments(out, record);
    if (!fclose(out) && *words) return words;
    free(words);
    return NULL;
}

static void print_moment(const Meniscus__Request *request)
{
    if (request->has_at_step) printf(": scheduled for step %" PRIu64, request->at_step);
    else printf(": scheduled for t = %.9g s", request->at_time);
}

static void print_outcome(const Record *record)
{
    const Meniscus__Reply *reply = record->reply;
    if (record->kind == MENISCUS__JOURNAL_RECORD__KIND__BEGUN) printf(": begun");
    else if (record->kind == MENISCUS__JOURNAL_RECORD__KIND__SCHEDULED && record->request)
        print_moment(record->request);
    else if (record->kind == MENISCUS__JOURNAL_RECORD__KIND__HALTED)
        printf(": %s", run_state_name((RunState)record->state));
    else if (record->undone) printf(": not done, as the journal could not be written");
    else if (reply && reply->code != MENISCUS__CODE__OK) printf(": %s", text_shown(reply->message));
    else if (reply) printf(": %s", run_state_name((RunState)reply->state));
}

static void print_line(const HistoryRecord *at)
{
    const Record *record = at->message;
    char moment[40], t[32] = "-"; /* a record that ends a run has no simulated time */
    when(record, moment);
    if (record->has_time) snprintf(t, sizeof t, "%.6g", record->time);
    printf("%6" PRIu64 "  %s  %8" PRIu64 "  %12s  %-22s  ", at->number, moment, record->step, t,
           record->who ? text_shown(record->who->name) : "");
    printf("%s", record->request ? history_command(record) : kind_name(record));
    char *arguments = arguments_of(record);
    if (arguments) printf(" %s", text_shown(arguments));
    free(arguments);
    for (size_t k = 0; k < record->n_changes; k++)
        printf("%s %s = %s (was %s)", k ? "," : "", text_shown(record->changes[k]->path),
               text_shown(record->changes[k]->after), text_shown(record->changes[k]->before));
    print_outcome(record);
    putchar('\n');
}

static void print_table(const History *history)
{
    printf("%6s  %-24s  %8s  %12s  %-22s  %s\n", "record", "when", "step", "t [s]", "who", "what");
    for (size_t k = 0; k < history->n; k++) {
        const Record *record = history->records[k].message;
        const bool told = record->kind == MENISCUS__JOURNAL_RECORD__KIND__LEASE && !record->undone; /* as always */
        if (record->kind != MENISCUS__JOURNAL_RECORD__KIND__HASH && !told) print_line(&history->records[k]);
    }
}

static void print_verdict(const History *history, MnsStatus status, const MnsError *error)
{
    size_t hashes = 0;
    for (size_t k = 0; k < history->n; k++)
        hashes += history->records[k].message->kind == MENISCUS__JOURNAL_RECORD__KIND__HASH;
    printf("%" PRIu64 " records, %zu of them hashes of the state, %" PRIu64 " bytes: ", history->report.records, hashes,
           history->report.size);
    if (status) printf("damaged. %s\n", error->text);
    else if (history->report.torn)
        printf("whole, and %" PRIu64 " bytes of a record that a crash left half written\n", history->report.torn);
    else printf("whole\n");
}

/* --- for programs ------------------------------------------------------------------------------------------------------ */

static json_t *changes_json(const Record *record)
{
    json_t *list = json_array();
    for (size_t k = 0; k < record->n_changes; k++)
        json_array_append_new(list, json_pack("{so so so}", "path", outcome_text(text(record->changes[k]->path)),
                                              "before", outcome_text(text(record->changes[k]->before)), "after",
                                              outcome_text(text(record->changes[k]->after))));
    return list;
}

static json_t *id_json(const Record *record)
{
    char hex[2 * 16 + 1] = "";
    const ProtobufCBinaryData *id = record->request ? &record->request->id : NULL;
    for (size_t k = 0; id && id->len == 16 && k < id->len; k++) snprintf(hex + 2 * k, 3, "%02x", id->data[k]);
    return hex[0] ? json_string(hex) : json_null();
}

static json_t *reply_json(const Meniscus__Reply *reply)
{
    if (!reply) return json_null();
    const ProtobufCEnumValue *code = protobuf_c_enum_descriptor_get_value(&meniscus__code__descriptor, reply->code);
    return json_pack("{ss so ss sI}", "code", code ? code->name : "UNKNOWN", "message", outcome_text(reply->message),
                     "state", run_state_name((RunState)reply->state), "effect_step", (json_int_t)reply->effect_step);
}

/* Of a record that says whether somebody was told. */
static json_t *undone_json(const Record *record)
{
    return record->kind == MENISCUS__JOURNAL_RECORD__KIND__LEASE ? json_boolean(record->undone) : json_null();
}

static json_t *record_json(const HistoryRecord *at)
{
    const Record *record = at->message;
    const Meniscus__Request *request = record->request;
    char moment[40], hash[24], *arguments = arguments_of(record);
    when(record, moment);
    snprintf(hash, sizeof hash, "%016" PRIx64, record->state_hash);
    json_t *said = outcome_text(arguments);
    free(arguments);
    const bool halted = record->kind == MENISCUS__JOURNAL_RECORD__KIND__HALTED;
    return json_pack("{sI sI ss ss so sI so so so so so so so so ss? so so so ss?}", "number", (json_int_t)at->number,
                     "offset", (json_int_t)at->offset, "kind", kind_name(record), "when", moment, "who",
                     outcome_text(record->who ? record->who->name : NULL), "step", (json_int_t)record->step, "time",
                     record->has_time ? json_real(record->time) : json_null(), "command",
                     outcome_text(request ? history_command(record) : NULL), "arguments", said, "at_step",
                     request && request->has_at_step ? json_integer((json_int_t)request->at_step) : json_null(),
                     "at_time", request && request->has_at_time ? json_real(request->at_time) : json_null(), "id",
                     id_json(record), "changes", changes_json(record), "reply", reply_json(record->reply), "state_hash",
                     record->has_state_hash ? hash : NULL, "undone", undone_json(record), "level",
                     outcome_text(record->level), "arithmetic", outcome_text(record->arithmetic), "state",
                     halted ? run_state_name((RunState)record->state) : NULL);
}

static void print_json(const char *directory, const History *history, bool verify, const MnsError *error, int code)
{
    json_t *list = json_array();
    for (size_t k = 0; !verify && k < history->n; k++) json_array_append_new(list, record_json(&history->records[k]));
    json_t *all = json_pack("{so sI sI sI sb so so}", "directory", outcome_text(directory), "n_records",
                            (json_int_t)history->report.records, "bytes", (json_int_t)history->report.size,
                            "torn_bytes", (json_int_t)history->report.torn, "whole", !error->status, "error",
                            outcome_failure(error, code), "records", list);
    outcome_print_json(all, JSON_COMPACT);
}

int history_print(const char *directory, bool verify, bool json)
{
    MnsError error = {.status = MNS_OK};
    History history;
    const MnsStatus status =
        verify ? history_verify(directory, &history, &error) : history_read(directory, &history, &error);
    const int code = status ? MNS_EXIT_IO : MNS_EXIT_DONE;
    if (status) fprintf(stderr, "%s: %s\n", log_program(), error.text);
    if (json) print_json(directory, &history, verify, &error, code);
    else if (!status || status == MNS_E_CORRUPT) {
        if (!verify) print_table(&history);
        print_verdict(&history, status, &error);
    }
    history_done(&history);
    return code;
}
