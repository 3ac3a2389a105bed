/* SPDX-License-Identifier: BSD-3-Clause */
/* Reading a journal: what is whole, what was torn by a crash, what has been changed. */
#include "io/atomic_file.h"
#include "io/journal_frame.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

typedef struct Reader {
    int fd;
    const char *path;
    uint64_t size; /* of the file */
    uint8_t chain[JOURNAL_CHAIN];
    JournalReport report;
    uint8_t *data; /* [room] */
    size_t room;
} Reader;

static MnsStatus damaged(const Reader *reader, const char *what, MnsError *error)
{
    return mns_fail(error, MNS_E_CORRUPT,
                    "'%.300s' is damaged: record %" PRIu64 ", which begins at byte %" PRIu64
                    ", %s; what comes before it is whole",
                    reader->path, reader->report.records + 1, reader->report.size, what);
}

/* All of it, or MNS_E_IO. */
static MnsStatus take(const Reader *reader, void *data, size_t size, uint64_t offset, MnsError *error)
{
    size_t got = 0;
    int failure = file_read_at(reader->fd, data, size, (size_t)offset, &got);
    if (!failure && got < size) failure = EIO; /* it became shorter meanwhile */
    return failure ? file_fail(error, failure, "read", reader->path) : MNS_OK;
}

enum { PAGE = 4096, SECTOR = 512 };

/* A file system may have made room and never filled it, all of it or from the beginning of a sector on: then there are only zeros from there
 * to the end. */
static MnsStatus only_zeros(const Reader *reader, uint64_t from, bool *ret, MnsError *error)
{
    uint8_t block[PAGE];
    *ret = from < reader->size;
    for (uint64_t at = from; *ret && at < reader->size; at += sizeof block) {
        const uint64_t left = reader->size - at;
        const size_t n = left < sizeof block ? (size_t)left : sizeof block;
        const MnsStatus status = take(reader, block, n, at, error);
        if (status) return status;
        for (size_t k = 0; k < n; k++) *ret = *ret && !block[k];
    }
    return MNS_OK;
}

static MnsStatus make_room(Reader *reader, size_t size, MnsError *error)
{
    if (size <= reader->room) return MNS_OK;
    uint8_t *data = realloc(reader->data, size);
    if (!data) return mns_fail(error, MNS_E_MEMORY, "no memory for a record of the journal");
    reader->data = data;
    reader->room = size;
    return MNS_OK;
}

/* Was a record of so many bytes at the place reached, which is not as it must be, written up to the end of some sector only? */
static MnsStatus is_torn(const Reader *reader, uint64_t size, bool *ret, MnsError *error)
{
    const uint64_t begin = reader->report.size,
                   sector = (begin + size - 1) / SECTOR * SECTOR; /* the last that it reaches into */
    return only_zeros(reader, sector > begin ? sector : begin, ret, error);
}

/* The frame at the place reached. *ret_torn: the file ends before the record does. */
static MnsStatus read_frame(Reader *reader, JournalFrame *ret, bool *ret_torn, MnsError *error)
{
    const uint64_t left = reader->size - reader->report.size;
    *ret_torn = left < sizeof *ret;
    MnsStatus status = *ret_torn ? MNS_OK : take(reader, ret, sizeof *ret, reader->report.size, error);
    if (status || *ret_torn) return status;
    if (ret->check != journal_frame_check(ret) || le32toh(ret->mark) != journal_mark) {
        status = is_torn(reader, sizeof *ret, ret_torn, error);
        return status || *ret_torn ? status : damaged(reader, "has a changed head", error);
    }
    if (le64toh(ret->number) != reader->report.records + 1 || le32toh(ret->size) > JOURNAL_RECORD_MAX)
        return damaged(reader, "is another one: records were taken out or put in", error);
    *ret_torn = le32toh(ret->size) > left - sizeof *ret;
    return MNS_OK;
}

static MnsStatus check_payload(Reader *reader, const JournalFrame *frame, bool *ret_torn, MnsError *error)
{
    uint8_t chain[JOURNAL_CHAIN];
    const size_t size = le32toh(frame->size);
    MnsStatus status = make_room(reader, size + 1, error);
    if (!status) status = take(reader, reader->data, size, reader->report.size + sizeof *frame, error);
    if (status) return status;
    if (!journal_frame_chain(reader->chain, frame, reader->data, size, chain))
        return mns_fail(error, MNS_E_MEMORY, "no memory to check a record of the journal");
    if (memcmp(chain, frame->chain, sizeof chain) != 0) {
        status = is_torn(reader, sizeof *frame + size, ret_torn, error);
        if (status || *ret_torn) return status;
        return damaged(reader, "does not have its checksum: it was changed, or one before it exchanged", error);
    }
    memcpy(reader->chain, chain, sizeof chain);
    return MNS_OK;
}

static MnsStatus read_records(Reader *reader, JournalVisit *visit, void *arg, MnsError *error)
{
    MnsStatus status = MNS_OK;
    while (!status && reader->report.size < reader->size) {
        JournalFrame frame;
        bool torn;
        status = read_frame(reader, &frame, &torn, error);
        if (!status && !torn) status = check_payload(reader, &frame, &torn, error);
        if (!status && torn) break;
        const uint64_t offset = reader->report.size, number = reader->report.records + 1;
        if (!status && visit) status = visit(arg, number, offset, reader->data, le32toh(frame.size), error);
        if (status) return status;
        reader->report.records = number;
        reader->report.size = offset + sizeof frame + le32toh(frame.size);
    }
    return status;
}

/* A file that is shorter than its head was never begun. */
static MnsStatus read_head(Reader *reader, bool *ret_begun, MnsError *error)
{
    char head[JOURNAL_HEAD] = {0};
    const size_t n = reader->size < JOURNAL_HEAD ? (size_t)reader->size : JOURNAL_HEAD;
    const MnsStatus status = take(reader, head, n, 0, error);
    if (status) return status;
    if (memcmp(head, journal_magic, n) != 0)
        return mns_fail(error, MNS_E_CORRUPT, "'%.300s' is damaged, or no journal: its first %d bytes are others",
                        reader->path, JOURNAL_HEAD);
    *ret_begun = n == JOURNAL_HEAD;
    return MNS_OK;
}

MnsStatus journal_scan(int fd, const char *path, JournalVisit *visit, void *arg, JournalReport *ret,
                       uint8_t ret_chain[static JOURNAL_CHAIN], MnsError *error)
{
    struct stat about;
    Reader reader = {.fd = fd, .path = path};
    bool begun = false;
    if (fstat(fd, &about)) return file_fail(error, errno, "look at", path);
    if (!S_ISREG(about.st_mode)) return mns_fail(error, MNS_E_CORRUPT, "'%.300s' is no file, so no journal", path);
    reader.size = (uint64_t)about.st_size;
    MnsStatus status = read_head(&reader, &begun, error);
    if (!status && begun) {
        reader.report.size = JOURNAL_HEAD;
        status = read_records(&reader, visit, arg, error);
    }
    free(reader.data);
    reader.report.torn = reader.size - reader.report.size;
    memcpy(ret_chain, reader.chain, sizeof reader.chain);
    *ret = reader.report;
    return status;
}

MnsStatus journal_sum_at(const char *path, uint64_t offset, uint64_t *ret, MnsError *error)
{
    JournalFrame frame;
    Reader reader = {.path = path, .fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK)};
    if (reader.fd < 0) return file_fail(error, errno, "read", path);
    const MnsStatus status = take(&reader, &frame, sizeof frame, offset, error);
    if (!status) *ret = journal_sum(frame.chain);
    close(reader.fd);
    return status;
}

MnsStatus journal_read(const char *path, JournalVisit *visit, void *arg, JournalReport *ret, MnsError *error)
{
    uint8_t chain[JOURNAL_CHAIN];
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK); /* a pipe in its place holds up nobody */
    if (fd < 0 && (errno == ENOENT || errno == ENOTDIR))
        return mns_fail(error, MNS_E_NOT_FOUND, "there is no journal '%.300s'; is it the directory of a run?", path);
    if (fd < 0) return file_fail(error, errno, "read", path);
    const MnsStatus status = journal_scan(fd, path, visit, arg, ret, chain, error);
    close(fd);
    return status;
}
