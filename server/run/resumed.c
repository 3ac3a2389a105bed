/* SPDX-License-Identifier: BSD-3-Clause */
/* With which case a run goes on: as its checkpoint has it, steered as it was then; what is set by hand on resuming wins over that. The
 * case file only says which case it is. */
#include "run/inside.h"

#include "base/log.h"
#include "common/case/file.h"
#include "run/history.h"
#include <string.h>

/* Its own copy of the message, with the settings made one after the other, which together must make a case. */
static MnsStatus assign(const Document *stored, const RunLoad *load, Meniscus__Case **ret, MnsError *error)
{
    Meniscus__Case *last = NULL;
    for (size_t k = 0; k < load->n_settings; k++) {
        Meniscus__Case *next;
        const RunSetting *setting = &load->settings[k];
        const MnsStatus status =
            case_message_put(last ? last : stored->message, setting->path, setting->value, &next, error);
        if (last) meniscus__case__free_unpacked(last, NULL);
        if (status) return status;
        last = next;
    }
    const MnsStatus status = last ? case_message_check(last, error) : MNS_OK;
    if (!status) *ret = last;
    else meniscus__case__free_unpacked(last, NULL);
    return status;
}

MnsStatus resumed_case(Document *stored, const char *checkpoint, const Document *given, const RunLoad *load,
                       Document **ret, MnsError *error)
{
    MnsError why;
    Meniscus__Case *message = NULL;
    MnsStatus status = case_message_steerable(stored->message, given->message, &why);
    if (status)
        return mns_fail_at(
            error, status, why.path,
            "the case is not that of %s, which can go on with no other (give again what it was begun with): %.300s",
            checkpoint, why.text);
    status = assign(stored, load, &message, error);
    if (status || !message) {
        *ret = status ? NULL : document_share(stored);
        return status;
    }
    status = document_new(message, stored->name, ret, error);
    meniscus__case__free_unpacked(message, NULL);
    return status;
}

MnsStatus resumed_owned(const History *history, const char *directory, const Checkpoint *checkpoint, MnsError *error)
{
    MnsError why;
    const MnsStatus status = history_owns(history, directory, checkpoint, &why);
    if (status != MNS_E_INVALID && status != MNS_E_VERSION)
        return status ? mns_fail(error, status, "%s", why.text) : MNS_OK;
    return mns_fail(error, status,
                    "%.350s; restore one that this run has written since, or copy it into a new directory and load its "
                    "case with --resume there",
                    why.text);
}

/* For the newest checkpoint of a run; on the writer's thread, while the runner waits. */
typedef struct Search {
    Run *run;
    const History *history;
    const char *directory;
    size_t n_silent; /* of those that were passed over, and do not tell whose they are */
    bool silent;     /* one of them is looked for                                      */
} Search;

static MnsStatus takes(void *arg, const Checkpoint *checkpoint, MnsError *error)
{
    Search *search = arg;
    MnsError why;
    const MnsStatus status = history_owns(search->history, search->directory, checkpoint, &why);
    if (!status || (search->silent && status == MNS_E_VERSION)) return MNS_OK;
    if (status == MNS_E_VERSION) search->n_silent++;
    return mns_fail(error, status,
                    "%.350s; it is passed over. To go on from it, copy it into a new directory and resume there",
                    why.text);
}

static void note(void *arg, const char *text)
{
    run_tell(((Search *)arg)->run, NOTE_LOG, LOG_WARNING, "checkpoint", text);
}

MnsStatus resumed_newest(Run *run, const History *history, const char *directory, bool silent_too, Checkpoint *ret,
                         MnsError *error)
{
    Search search = {.run = run, .history = history, .directory = directory};
    Writer *writer = run->outputs.writer;
    char text[512];
    MnsStatus status = outputs_read_newest(writer, directory, history->n ? takes : NULL, note, &search, ret, error);
    if (status != MNS_E_NOT_FOUND || !search.n_silent || !silent_too) return status;
    search.silent = true;
    status = outputs_read_newest(writer, directory, takes, NULL, &search, ret, error);
    if (status) return status;
    snprintf(text, sizeof text, "%.350s is taken all the same, as there is no other: see whether this run wrote it",
             ret->path);
    note(&search, text);
    return MNS_OK;
}

/* After a crash the run goes on from its newest checkpoint with the case that was loaded, and a replay follows that too. */
MnsStatus resumed_restore(const Document *stored, const char *checkpoint, const Document *now, MnsError *error)
{
    MnsError why;
    const MnsStatus status = case_message_steerable(stored->message, now->message, &why);
    if (!status) return MNS_OK;
    return mns_fail_at(error, status, why.path,
                       "%.200s is a checkpoint of another case; restore one that this run has written, or load its own "
                       "case to go on from it: %.200s",
                       checkpoint, why.text);
}

static void tell_set(void *run, const char *path, const char *before, const char *now)
{
    char text[512];
    snprintf(text, sizeof text, "%.100s = %.120s, as set on resuming; the checkpoint has %.120s", path, now, before);
    run_tell(run, NOTE_LOG, LOG_NOTICE, "resumed", text);
}

/* Whoever has changed the file since may have meant it. */
static void tell_kept(void *run, const char *path, const char *given, const char *now)
{
    char text[512];
    snprintf(text, sizeof text,
             "%.100s = %.120s, as the checkpoint has it, not %.120s as the case says; it can be set, as with --set",
             path, now, given);
    run_tell(run, NOTE_LOG, LOG_WARNING, "resumed", text);
}

void run_tell_resumed(Run *run, const Document *stored, const Document *given)
{
    case_message_differences(stored->message, run->document->message, tell_set, run);
    case_message_differences(given->message, run->document->message, tell_kept, run);
}
