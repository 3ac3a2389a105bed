/* SPDX-License-Identifier: BSD-3-Clause */
/* What the probes have measured before the watcher listened, from the run's series: on a thread of its own, as there may be hours of it. */
#include "client/dashboard/watcher.h"
#include <meniscus/stream.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

/* For rows to come: while a stream follows a series, it gets to the disk about each second. */
static const double patience_s = 3;

typedef struct Backlog {
    Hub *hub;
    uint64_t version; /* of the history that this belongs before */
    double until, reached;
    History past;
} Backlog;

static const double *numbers(const MnsStreamItem *item, const char *name, size_t rows, size_t columns)
{
    for (size_t k = 0; k < item->n_arrays; k++) {
        const MnsArray *array = &item->arrays[k];
        if (strcmp(array->name, name) != 0) continue;
        const size_t width = array->n_dims > 1 ? array->shape[1] : 1;
        return array->n_dims && array->shape[0] == rows && width == columns && !strcmp(array->type, "<f8") ? array->data
                                                                                                           : NULL;
    }
    return NULL;
}

/* Rows of a time line that was left need no care: those that take their place are earlier. */
static MnsStatus take_rows(Backlog *backlog, const MnsStream *stream, const MnsStreamItem *item, MnsError *error)
{
    size_t n, rows = 0;
    const MnsStreamColumn *columns = mns_stream_columns(stream, &n);
    for (size_t k = 0; k < item->n_arrays; k++)
        if (!strcmp(item->arrays[k].name, "time") && item->arrays[k].n_dims) rows = item->arrays[k].shape[0];
    const double *times = numbers(item, "time", rows, 1), *values = numbers(item, "values", rows, n);
    if (!rows || !n) return MNS_OK;
    MnsValue *row = times && values ? calloc(n, sizeof *row) : NULL;
    if (!row) return mns_fail(error, MNS_E_CORRUPT, "the daemon's rows lack times or values");
    for (size_t k = 0; k < n; k++) row[k] = (MnsValue){.name = columns[k].name, .unit = columns[k].unit};
    for (size_t i = 0; i < rows; i++) {
        for (size_t k = 0; k < n; k++) row[k].number = values[i * n + k];
        history_add(&backlog->past, times[i], n, row);
    }
    backlog->reached = times[rows - 1];
    free(row);
    return MNS_OK;
}

/* Until the series has come to where the watcher began, or ends before. */
static MnsStatus gather(Backlog *backlog, MnsError *error)
{
    const MnsStreamOptions options = {.kind = MNS_STREAM_SERIES};
    MnsClient *client = NULL;
    MnsStream *stream = NULL;
    const MnsStreamItem *item;
    MnsStatus status = mns_client_open(hub_daemon(backlog->hub), &client, error);
    if (!status) mns_client_set_timeout(client, patience_s);
    if (!status) status = mns_stream_open(client, &options, &stream, error);
    while (!status && backlog->reached < backlog->until && hub_history_version(backlog->hub) == backlog->version) {
        status = mns_stream_next(stream, patience_s, &item, error);
        if (!status && !item->abandoned) status = take_rows(backlog, stream, item, error);
    }
    mns_stream_close(stream);
    mns_client_close(client);
    return status;
}

/* Whatever ends it: what came is shown. */
static void *live(void *arg)
{
    Backlog *backlog = arg;
    gather(backlog, NULL);
    if (backlog->past.n) hub_precede(backlog->hub, backlog->version, &backlog->past);
    history_clear(&backlog->past);
    free(backlog);
    return NULL;
}

void backlog_start(Hub *hub, double until)
{
    pthread_t thread;
    Backlog *backlog = calloc(1, sizeof *backlog);
    if (!backlog) return;
    *backlog = (Backlog){.hub = hub, .version = hub_history_version(hub), .until = until, .reached = -1};
    if (pthread_create(&thread, NULL, live, backlog)) free(backlog);
    else pthread_detach(thread);
}
