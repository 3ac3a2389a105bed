/* SPDX-License-Identifier: BSD-3-Clause */
/* Requests that the thread of the sockets answers at once, from what the run last published. */
#include "net/here.h"

#include "common/case/file.h"
#include "net/describe.h"
#include "net/handlers.h"
#include <assert.h>
#include <math.h>
#include <stdlib.h>

static void answer_now(Run *run, Exchange *x, MnsStatus status, const MnsError *error)
{
    run_answer_now(run, &x->order, status, error);
}

/* status: NULL if there was no memory for it. */
static void answer_status(Run *run, Exchange *x, const RunStatus *status)
{
    MnsError error;
    x->reply->status = status ? describe_status(status, x->streams) : NULL;
    if (x->reply->status) x->reply->result_case = MENISCUS__REPLY__RESULT_STATUS;
    answer_now(run, x, x->reply->status ? MNS_OK : mns_fail(&error, MNS_E_MEMORY, "no memory for the status"), &error);
}

static void serve_status_at_rest(Run *run, Order *order)
{
    RunStatus *status = malloc(sizeof *status);
    if (status) run_status(run, status);
    answer_status(run, (Exchange *)order, status);
    free(status);
}

/* Here, but for the moment in which the runner hashes the state it was stopped at: then by the runner, right after that. */
void here_status(Run *run, Exchange *x)
{
    RunStatus *status = malloc(sizeof *status);
    if (status) run_status(run, status);
    x->order.serve = serve_status_at_rest;
    x->order.urgent = true;
    const bool posted = status && status->hash_due && !run_post(run, &x->order, NULL);
    if (!posted) answer_status(run, x, status);
    free(status);
}

void here_capabilities(Run *run, Exchange *x)
{
    MnsError error;
    const char *names[HANDLER_NAMES];
    Document *document = run_document(run);
    RunStatus *status = malloc(sizeof *status);
    if (status) run_status(run, status);
    handler_names(names);
    x->reply->capabilities = status ? describe_capabilities(names, document, status->fields) : NULL;
    free(status);
    document_leave(document);
    if (x->reply->capabilities) x->reply->result_case = MENISCUS__REPLY__RESULT_CAPABILITIES;
    answer_now(run, x, x->reply->capabilities ? MNS_OK : mns_fail(&error, MNS_E_MEMORY, "no memory"), &error);
}

/* One entry of the case as text, and as a number where it is one. */
static MnsStatus get_entry(const Document *document, const char *path, Meniscus__Value **ret, MnsError *error)
{
    char *text, *end;
    const char *unit;
    const MnsStatus status = case_message_get(document->message, path, &text, &unit, error);
    if (status) return status;
    const double number = strtod(text, &end);
    *ret = exchange_value(path, end != text && !*end ? number : NAN, text, unit);
    free(text);
    return MNS_OK;
}

/* Entries of a case into the reply. */
MnsStatus here_entries(const Document *document, Exchange *x, size_t n, const char *const *paths, MnsError *error)
{
    if (!document) return mns_fail(error, MNS_E_STATE, "there is no case; load one first");
    Meniscus__Value **values = calloc(n + 1, sizeof(Meniscus__Value *));
    MnsStatus status = values ? MNS_OK : mns_fail(error, MNS_E_MEMORY, "no memory for %zu values", n);
    for (size_t k = 0; !status && k < n; k++) status = get_entry(document, paths[k], &values[k], error);
    if (!status) return exchange_values(x, values, n, error);
    exchange_values(x, values, n, NULL); /* frees them, as the one that failed is missing */
    return status;
}

/* Everything that this case could have. */
static size_t all_paths(const Document *document, const char *ret_paths[ENTRIES_MAX])
{
    size_t n, found = 0;
    const CaseParameter *table = case_parameters(&n);
    assert(n <= ENTRIES_MAX);
    for (size_t k = 0; k < n; k++)
        if (!document || !case_message_steers(document->message, table[k].path, NULL))
            ret_paths[found++] = table[k].path;
    return found;
}

static void answer_get(Run *run, Exchange *x, size_t n, const char *const *paths)
{
    const char *all[ENTRIES_MAX];
    MnsError error;
    Document *document = run_document(run);
    if (!n) {
        n = all_paths(document, all);
        paths = all;
    }
    answer_now(run, x, here_entries(document, x, n, paths, &error), &error);
    document_leave(document);
}

/* Of an empty list: everything that can be set. */
void here_get(Run *run, Exchange *x)
{
    const Meniscus__Get *get = x->request->get;
    MnsError error;
    const size_t n = get->n_paths;
    if (n > ENTRIES_MAX) {
        answer_now(run, x,
                   mns_fail_at(&error, MNS_E_LIMIT, "paths",
                               "at most %d entries can be asked for at a time, found %zu; without any, all that can be "
                               "set are answered",
                               ENTRIES_MAX, n),
                   &error);
        return;
    }
    answer_get(run, x, n, (const char *const *)get->paths);
}
