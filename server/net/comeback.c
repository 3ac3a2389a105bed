/* SPDX-License-Identifier: BSD-3-Clause */
/* A daemon that is started again. */
#include "net/comeback.h"

#include "base/log.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void recall(Desk *desk, const Meniscus__JournalRecord *record)
{
    const Meniscus__Request *request = record->request;
    if (!request || !record->reply || !request->has_id || request->id.len != ORDER_ID) return;
    const size_t size = meniscus__reply__get_packed_size(record->reply);
    uint8_t *packed = malloc(size + 1);
    if (!packed) return;
    meniscus__reply__pack(record->reply, packed);
    desk_recall(desk, request->id.data, packed, size);
    free(packed);
}

void comeback_begin(Comeback *comeback, const char *parent, const char *asked, Desk *desk)
{
    MnsError error;
    MnsStatus status = rundir_current(parent, asked, comeback->directory, &comeback->same, &error);
    if (!status) status = history_read(comeback->directory, &comeback->history, &error);
    if (status) {
        if (status != MNS_E_NOT_FOUND) log_line(LOG_ERROR, "no run is gone on with: %s", error.text);
        return;
    }
    for (size_t k = 0; k < comeback->history.n; k++) recall(desk, comeback->history.records[k].message);
    comeback->due = !lineage_of(&comeback->history, &comeback->lineage, &error);
    comeback->lineage.directory = comeback->directory;
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
    if (lineage->begun || lineage->state == RUN_READY || lineage->state == RUN_PAUSED) return NULL;
    request.command_case = MENISCUS__REQUEST__COMMAND_RESUME;
    request.resume = &resume;
    return copy_of(&request);
}

Meniscus__Request *comeback_rest(const Comeback *comeback)
{
    if (!comeback->lineage.begun) return NULL;
    Meniscus__Request begun = *comeback->lineage.begun;
    begun.has_if_step = begun.has_if_version = begun.has_lease_epoch = false; /* they were met when it set out */
    return copy_of(&begun);
}

void comeback_scheduled(const Comeback *comeback, Desk *desk)
{
    const Lineage *lineage = &comeback->lineage;
    for (size_t k = 0; k < lineage->n; k++) {
        const LineageEntry *entry = &lineage->entries[k];
        if (!entry->scheduled || entry->until != UINT64_MAX) continue;
        Who who = {.role = entry->who && entry->who->role ? role_find(entry->who->role) : ROLE_ADMIN};
        snprintf(who.name, sizeof who.name, "%s", entry->who && entry->who->name ? entry->who->name : WHO_DAEMON);
        Meniscus__Request *request = copy_of(entry->request);
        if (request) desk_take(desk, &who, request, lineage);
    }
}

void comeback_done(Comeback *comeback)
{
    lineage_done(&comeback->lineage);
    history_done(&comeback->history);
}
