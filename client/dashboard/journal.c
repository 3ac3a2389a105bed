/* SPDX-License-Identifier: BSD-3-Clause */
/* The journal of a run. Only the daemon's program knows how it lies in its file, so that is asked. */
#include "client/dashboard/journal.h"
#include "client/cli/beside.h"
#include "common/host/children.h"
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum { MOST_BYTES = 64 << 20, PIECE = 1 << 16, PATIENCE_MS = 20000 };

static MnsStatus begin(const char *directory, Child *ret_child, int *ret_fd, MnsError *error)
{
    char path[PATH_MAX];
    int ends[2];
    if (!beside_find("meniscusd", path)) memcpy(path, "meniscusd", sizeof "meniscusd");
    if (pipe2(ends, O_CLOEXEC)) return mns_fail(error, MNS_E_LIMIT, "cannot read the journal: %s", strerror(errno));
    char *arguments[] = {(char *)"meniscusd", (char *)"--log", (char *)directory, (char *)"--output=json", NULL};
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    const int failed = children_start(ret_child, path, &actions, arguments);
    posix_spawn_file_actions_destroy(&actions);
    close(ends[1]);
    *ret_fd = ends[0];
    if (!failed) return MNS_OK;
    close(ends[0]);
    return mns_fail(error, MNS_E_NOT_FOUND,
                    "cannot run meniscusd, which reads journals: %s; it belongs beside this program", strerror(failed));
}

static long left_ms(const struct timespec *began)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return PATIENCE_MS - (now.tv_sec - began->tv_sec) * 1000 - (now.tv_nsec - began->tv_nsec) / 1000000;
}

/* All that it says, yours. */
static MnsStatus listen_to(int fd, char **ret, size_t *ret_size, MnsError *error)
{
    struct timespec began;
    clock_gettime(CLOCK_MONOTONIC, &began);
    char *text = NULL;
    size_t size = 0;
    for (;;) {
        struct pollfd item = {.fd = fd, .events = POLLIN};
        const long left = left_ms(&began);
        char *more = realloc(text, size + PIECE);
        if (more) text = more;
        MnsStatus status = more ? MNS_OK : mns_fail(error, MNS_E_MEMORY, "no memory for the journal");
        if (!status && (left <= 0 || poll(&item, 1, (int)left) == 0))
            status = mns_fail(error, MNS_E_TIMEOUT, "the journal was not read in %d s", PATIENCE_MS / 1000);
        const ssize_t n = status ? 0 : read(fd, text + size, PIECE);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) status = mns_fail(error, MNS_E_IO, "cannot read the journal: %s", strerror(errno));
        if (n > 0) size += (size_t)n;
        if (size > MOST_BYTES)
            status = mns_fail(error, MNS_E_LIMIT, "the journal is too long to show; see `meniscus log`");
        if (status) free(text);
        if (status) return status;
        if (n > 0) continue;
        *ret = text;
        *ret_size = size;
        return MNS_OK;
    }
}

/* What nobody asked for: a hash, or a note that somebody was told of a lease. */
static bool is_silent(const json_t *record)
{
    const char *kind = json_string_value(json_object_get(record, "kind"));
    return kind && (!strcmp(kind, "hash") || !strcmp(kind, "lease"));
}

static void drop_silent(json_t *log)
{
    json_t *records = json_object_get(log, "records"), *kept = json_array();
    const size_t n = json_array_size(records);
    size_t from = n, wanted = JOURNAL_RECORDS;
    while (from && wanted) wanted -= !is_silent(json_array_get(records, --from));
    for (size_t k = from; k < n; k++)
        if (!is_silent(json_array_get(records, k))) json_array_append(kept, json_array_get(records, k));
    json_object_set_new(log, "records", kept);
}

MnsStatus journal_shown(const char *directory, json_t **ret, MnsError *error)
{
    Child child;
    int fd;
    char *text = NULL;
    size_t size = 0;
    MnsStatus status = begin(directory, &child, &fd, error);
    if (status) return status;
    status = listen_to(fd, &text, &size, error);
    close(fd);
    if (status) kill(child.pid, SIGKILL);
    children_wait(&child);
    if (status) return status;
    json_t *log = json_loadb(text, size, 0, NULL);
    free(text);
    if (!log) return mns_fail(error, MNS_E_IO, "meniscusd does not say what is in the journal of %.300s", directory);
    drop_silent(log);
    *ret = log;
    return MNS_OK;
}
