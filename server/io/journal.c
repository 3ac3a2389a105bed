/* SPDX-License-Identifier: BSD-3-Clause */
/* Writing a journal. What is not on the disk yet stays in memory, so that a write that failed can be tried again. */
#include "io/journal.h"
#include "io/atomic_file.h"
#include "io/journal_frame.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <unistd.h>

/* Room is taken in blocks. Of what the system has got and the disk perhaps not, so much is kept: then the disk is waited for. */
enum { BLOCK = 1 << 16, KEPT = 1 << 20 };

struct Journal {
    int fd;
    char *path;
    uint64_t records;
    uint8_t chain[JOURNAL_CHAIN];
    uint64_t durable;  /* where the file ended when it was last on the disk, and `kept` begins */
    uint64_t reserved; /* up to here there is room                                             */
    uint8_t *kept;     /* [n] of [room] bytes behind that                                      */
    size_t n, room;
    size_t written; /* of them, handed to the operating system */
    uint64_t first; /* of a JournalPlace */
    JournalPlace place, durable_place;
};

/* @return 0 or an errno. */
static int begin_file(int fd)
{
    int failure = ftruncate(fd, 0) ? errno : 0;
    if (!failure) failure = file_write_at(fd, journal_magic, JOURNAL_HEAD, 0);
    return !failure && fsync(fd) ? errno : failure;
}

static MnsStatus cut_or_begin(int fd, const char *path, const JournalReport *report, MnsError *error)
{
    int failure = 0;
    const bool begun = report->size >= JOURNAL_HEAD;
    if (!begun) failure = begin_file(fd);
    else if (report->torn && (ftruncate(fd, (off_t)report->size) || fsync(fd))) failure = errno;
    if (!begun && !failure) failure = file_sync_directory(path);
    return failure ? file_fail(error, failure, begun ? "cut the torn end off" : "begin", path) : MNS_OK;
}

static JournalPlace place_now(const Journal *journal)
{
    return (JournalPlace){journal->records, journal->first, journal_sum(journal->chain)};
}

static MnsStatus open_file(Journal *journal, JournalReport *ret_report, MnsError *error)
{
    JournalReport report;
    journal->fd = open(journal->path, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY, 0666);
    if (journal->fd < 0) return file_fail(error, errno, "open", journal->path);
    MnsStatus status = journal_scan(journal->fd, journal->path, NULL, NULL, &report, journal->chain, error);
    if (!status) status = cut_or_begin(journal->fd, journal->path, &report, error);
    if (status) return status;
    journal->records = report.records;
    journal->durable = journal->reserved = report.size < JOURNAL_HEAD ? JOURNAL_HEAD : report.size;
    if (report.records) status = journal_sum_at(journal->path, JOURNAL_HEAD, &journal->first, error);
    if (status) return status;
    journal->place = journal->durable_place = place_now(journal);
    if (ret_report) *ret_report = report;
    return MNS_OK;
}

MnsStatus journal_open(const char *path, Journal **ret, JournalReport *ret_report, MnsError *error)
{
    Journal *journal = calloc(1, sizeof *journal);
    if (journal) journal->fd = -1;
    if (!journal || !(journal->path = strdup(path))) {
        journal_free(journal);
        return mns_fail(error, MNS_E_MEMORY, "no memory for the journal");
    }
    const MnsStatus status = open_file(journal, ret_report, error);
    if (status) journal_free(journal);
    else *ret = journal;
    return status;
}

void journal_free(Journal *journal)
{
    if (!journal) return;
    const uint64_t end = journal->durable + journal->written;
    if (journal->fd >= 0 && journal->reserved > end && ftruncate(journal->fd, (off_t)end)) errno = 0; /* only room */
    if (journal->fd >= 0) close(journal->fd);
    free(journal->kept);
    free(journal->path);
    free(journal);
}

MnsStatus journal_reserve(Journal *journal, size_t size, MnsError *error)
{
    const uint64_t end = journal->durable + journal->n + size;
    if (end <= journal->reserved) return MNS_OK;
    const uint64_t wanted = (end + BLOCK - 1) / BLOCK * BLOCK, from = journal->reserved;
    int failure;
    do failure = fallocate(journal->fd, FALLOC_FL_KEEP_SIZE, (off_t)from, (off_t)(wanted - from)) ? errno : 0;
    while (failure == EINTR);
    if (failure && failure != EOPNOTSUPP && failure != ENOSYS)
        return file_fail(error, failure, "make room in", journal->path);
    journal->reserved = wanted;
    return MNS_OK;
}

static MnsStatus make_room(Journal *journal, size_t more, MnsError *error)
{
    if (journal->n + more <= journal->room) return MNS_OK;
    const size_t room = 2 * (journal->n + more);
    uint8_t *kept = realloc(journal->kept, room);
    if (!kept) return mns_fail(error, MNS_E_MEMORY, "no memory for a record of the journal");
    journal->kept = kept;
    journal->room = room;
    return MNS_OK;
}

MnsStatus journal_add(Journal *journal, const void *data, size_t size, MnsError *error)
{
    JournalFrame frame = {.mark = htole32(journal_mark), .number = htole64(journal->records + 1)};
    if (size > JOURNAL_RECORD_MAX)
        return mns_fail(error, MNS_E_LIMIT, "a record of the journal has at most %d bytes; found %zu",
                        JOURNAL_RECORD_MAX, size);
    const MnsStatus status = make_room(journal, sizeof frame + size, error);
    if (status) return status;
    frame.size = htole32((uint32_t)size);
    frame.check = journal_frame_check(&frame);
    if (!journal_frame_chain(journal->chain, &frame, data, size, frame.chain))
        return mns_fail(error, MNS_E_MEMORY, "no memory for a record of the journal");
    memcpy(journal->kept + journal->n, &frame, sizeof frame);
    memcpy(journal->kept + journal->n + sizeof frame, data, size);
    memcpy(journal->chain, frame.chain, sizeof frame.chain);
    journal->n += sizeof frame + size;
    if (!journal->records++) journal->first = journal_sum(frame.chain);
    return MNS_OK;
}

static void forget_written(Journal *journal)
{
    journal->durable += journal->written;
    journal->durable_place = journal->place;
    journal->n -= journal->written;
    memmove(journal->kept, journal->kept + journal->written, journal->n);
    journal->written = 0;
}

static MnsStatus sync_written(Journal *journal, MnsError *error)
{
    int failure;
    do failure = fdatasync(journal->fd) ? errno : 0;
    while (failure == EINTR);
    if (failure) { /* the system may have dropped what it could not write: all of it once more */
        journal->written = 0;
        journal->place = journal->durable_place;
        return file_fail(error, failure, "write", journal->path);
    }
    forget_written(journal);
    return MNS_OK;
}

MnsStatus journal_write(Journal *journal, MnsError *error)
{
    const size_t from = journal->written;
    if (from == journal->n) return MNS_OK;
    if (!file_is_at(journal->fd, journal->path)) /* it would be written, and not found again */
        return mns_fail(error, MNS_E_IO,
                        "'%.300s' is not the journal of this run any more: it, or its directory, was moved, removed or "
                        "replaced; put it back",
                        journal->path);
    const int failure =
        file_write_at(journal->fd, journal->kept + from, journal->n - from, (size_t)journal->durable + from);
    if (failure) return file_fail(error, failure, "write", journal->path);
    journal->written = journal->n;
    journal->place = place_now(journal);
    return journal->n > KEPT ? sync_written(journal, error) : MNS_OK;
}

MnsStatus journal_commit(Journal *journal, MnsError *error)
{
    const MnsStatus status = journal_write(journal, error);
    return status ? status : sync_written(journal, error);
}

bool journal_behind(const Journal *journal)
{
    return journal->n > 0;
}

JournalPlace journal_place(const Journal *journal)
{
    return journal->place;
}

uint64_t journal_records(const Journal *journal)
{
    return journal->records;
}
