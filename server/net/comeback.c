/* SPDX-License-Identifier: BSD-3-Clause */
/* A daemon that is started again. */
#include "net/comeback.h"

#include "base/log.h"
#include "common/host/places.h"
#include "net/ledger.h"
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* How much is read of the journals of runs before the one that was loaded last: a tenth of a second. */
enum { FORMER_BYTES = 64 << 20 };

/* A lease that nobody was told of is none: whoever asks for it again gets another. */
static bool has_reply(const History *history, size_t k, const char *boot)
{
    const Meniscus__JournalRecord *record = history->records[k].message;
    const Meniscus__Request *request = record->request;
    const bool replied = request && record->reply && request->has_id && request->id.len == ORDER_ID;
    return replied && !history_untold(history, k, boot);
}

static void recall(Answers *answers, const Meniscus__JournalRecord *record)
{
    const Meniscus__Request *request = record->request;
    const size_t size = meniscus__reply__get_packed_size(record->reply);
    uint8_t *packed = malloc(size + 1);
    if (!packed) return;
    meniscus__reply__pack(record->reply, packed);
    answers_recall(answers, request, packed, size);
    free(packed);
}

/* Those that are remembered, the last ones. */
static void recall_last(Answers *answers, const History *history, const char *boot)
{
    size_t k = history->n;
    for (size_t n = 0; k > 0 && n < LEDGER_DEEDS; k--) n += has_reply(history, k - 1, boot);
    for (; k < history->n; k++)
        if (has_reply(history, k, boot)) recall(answers, history->records[k].message);
}

/* Of runs that were loaded before: one whose journal is damaged tells what stands before that. */
static void recall_former(Answers *answers, const char *parent, const char *current, const char *boot)
{
    char **former;
    size_t n;
    if (rundir_former(parent, current, FORMER_BYTES, &former, &n, NULL)) return;
    for (size_t k = 0; k < n; k++) {
        History history;
        (void)history_read(former[k], &history, NULL);
        recall_last(answers, &history, boot);
        history_done(&history);
        free(former[k]);
    }
    free(former);
}

static bool is_directory(const char *path)
{
    struct stat info;
    return path[0] && !stat(path, &info) && S_ISDIR(info.st_mode);
}

/* As the place of a file system that is not mounted. */
static bool is_empty(const char *path)
{
    DIR *stream = opendir(path);
    bool empty = stream != NULL;
    for (const struct dirent *entry; empty && (entry = readdir(stream));)
        empty = !strcmp(entry->d_name, ".") || !strcmp(entry->d_name, "..");
    if (stream) closedir(stream);
    return empty;
}

/* That the run was loaded stood there before it became the current one. */
static MnsStatus fail_gone(const Comeback *comeback, MnsError *error)
{
    return mns_fail(error, MNS_E_CORRUPT, "the journal of '%.300s' is gone", comeback->directory);
}

static MnsStatus fail_missing(const char *directory, MnsError *error)
{
    char found[PLACES_FOUND] = "";
    struct stat info;
    if (is_directory(directory))
        return mns_fail(
            error, MNS_E_NOT_FOUND,
            "its directory is empty; put its files back, or load the run with --resume from where they are");
    if (!lstat(directory, &info)) places_found(directory, found);
    return mns_fail(error, MNS_E_NOT_FOUND,
                    "its directory is not there%s%s; put it back, or load the run with --resume from where it is",
                    *found ? ", in its place is " : "", found);
}

static MnsStatus fail_unread(const Comeback *comeback, const char *parent, const MnsError *why, MnsError *error)
{
    return mns_fail(
        error, why->status,
        "the %srun of %.200s, which was not ended, cannot be gone on with: %.300s. Nothing was done; mend that and "
        "start again, or remove '%.200s/current' to begin without that run",
        comeback->directory[0] ? "" : "last ", comeback->directory[0] ? comeback->directory : parent, why->text,
        parent);
}

MnsStatus comeback_begin(Comeback *comeback, const char *parent, const char *asked, Answers *answers, MnsError *error)
{
    MnsError why;
    char boot[HISTORY_BOOT];
    history_boot(boot);
    MnsStatus status = rundir_current(parent, asked, comeback->directory, &comeback->same, &why);
    const bool other = !status && asked && !comeback->same;
    recall_former(answers, parent, comeback->directory, boot);
    const bool missing = !status && (!is_directory(comeback->directory) || is_empty(comeback->directory));
    if (missing) {
        status = fail_missing(comeback->directory, &why);
        if (!other) return fail_unread(comeback, parent, &why, error);
        log_line(LOG_WARNING, "'%s' was not ended, and %s", comeback->directory, why.text);
    }
    if (!status) status = history_verify(comeback->directory, &comeback->history, &why);
    if (status == MNS_E_NOT_FOUND && !missing && is_directory(comeback->directory)) status = fail_gone(comeback, &why);
    if (!status) recall_last(answers, &comeback->history, boot);
    if (!status) status = lineage_of(&comeback->history, boot, &comeback->lineage, &why);
    comeback->due = !status;
    comeback->lineage.directory = comeback->directory;
    if (!status || status == MNS_E_NOT_FOUND || status == MNS_E_STATE)
        return MNS_OK; /* there is none, or it was ended */
    if (!other) return fail_unread(comeback, parent, &why, error);
    log_line(LOG_ERROR, "%s", why.text);
    return MNS_OK;
}

void comeback_request(const Comeback *comeback, Meniscus__Request *ret, Meniscus__Load *load)
{
    meniscus__load__init(load);
    meniscus__request__init(ret);
    load->case_ = (Meniscus__Case *)comeback->lineage.original;
    load->name = (char *)comeback->lineage.name;
    load->has_resume = load->resume = true;
    ret->command_case = MENISCUS__REQUEST__COMMAND_LOAD;
    ret->load = load;
}

/* The step that a run does not survive, as it was to be taken: to the time that shortens it, if there was one. */
static void do_broken(const Meniscus__Request *broken, Meniscus__Request *ret, Meniscus__Step *step)
{
    ret->command_case = broken->command_case;
    if (broken->command_case == MENISCUS__REQUEST__COMMAND_RUN_UNTIL) ret->run_until = broken->run_until;
    else ret->step = step;
}

static Meniscus__Request *copy_of(const Meniscus__Request *request)
{
    const size_t size = meniscus__request__get_packed_size(request);
    uint8_t *packed = malloc(size + 1);
    if (!packed) return NULL;
    meniscus__request__pack(request, packed);
    Meniscus__Request *copy = meniscus__request__unpack(NULL, size, packed);
    free(packed);
    return copy;
}

Meniscus__Request *comeback_resume(const Comeback *comeback)
{
    const Lineage *lineage = &comeback->lineage;
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    Meniscus__Resume resume = MENISCUS__RESUME__INIT;
    Meniscus__Step step = MENISCUS__STEP__INIT; /* one */
    const bool stands = lineage->state == RUN_READY || lineage->state == RUN_PAUSED || lineage->state == RUN_DONE;
    if (lineage->begun || (stands && !lineage->broken)) return NULL;
    request.command_case = MENISCUS__REQUEST__COMMAND_RESUME;
    if (stands) do_broken(lineage->broken, &request, &step);
    else request.resume = &resume;
    return copy_of(&request);
}

Meniscus__Request *comeback_rest(const Comeback *comeback)
{
    return comeback->lineage.begun ? copy_of(comeback->lineage.begun) : NULL;
}

void comeback_scheduled(const Comeback *comeback, Answers *answers)
{
    const Lineage *lineage = &comeback->lineage;
    for (size_t k = 0; k < lineage->n; k++) {
        const LineageEntry *entry = &lineage->entries[k];
        if (!entry->scheduled || entry->until != UINT64_MAX) continue;
        Who who = {.role = entry->who && entry->who->role ? role_find(entry->who->role) : ROLE_ADMIN};
        snprintf(who.name, sizeof who.name, "%s", entry->who && entry->who->name ? entry->who->name : WHO_DAEMON);
        Meniscus__Request *request = copy_of(entry->request);
        if (request) answers_take_alone(answers, &who, request, lineage);
    }
}

void comeback_done(Comeback *comeback)
{
    lineage_done(&comeback->lineage);
    history_done(&comeback->history);
}
