/* SPDX-License-Identifier: BSD-3-Clause */
/* A file of records that only grows. Each has its length, its number and a checksum over all records up to it, so a changed
 * byte anywhere is found, and where; what a crash left half written at the end is told from that and cut off. The checksums,
 * XXH3 of 128 bits, find accidents and careless hands; they are no signature. */
#ifndef IO_JOURNAL_H
#define IO_JOURNAL_H

#include "io/file.h"
#include <meniscus/status.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { JOURNAL_RECORD_MAX = 16 << 20 }; /* [bytes] */
enum { JOURNAL_HEAD = 8 };              /* bytes of the file before the first record */

typedef struct Journal Journal;

/* What is in a file. */
typedef struct JournalReport {
    uint64_t records; /* whole ones, numbered from 1                                   */
    uint64_t size;    /* of the file up to the end of the last of them [bytes]         */
    uint64_t torn;    /* bytes behind that, of a record that was never whole           */
} JournalReport;

/* One record; anything but MNS_OK ends the reading. */
typedef MnsStatus JournalVisit(void *arg, uint64_t number, uint64_t offset, const void *data, size_t size,
                               MnsError *error);

/* Read a file from its beginning and check it all. visit may be NULL.
 *  MNS_OK, also with a torn end; MNS_E_NOT_FOUND: there is no such file; MNS_E_CORRUPT: a byte has been changed, and the sentence
 *  names the record and where in the file it begins; MNS_E_IO, MNS_E_MEMORY; what visit returns. */
MnsStatus journal_read(const char *path, JournalVisit *visit, void *arg, JournalReport *ret, MnsError *error);

/* Open a file to go on behind its last record, after a look at all of it; a torn end is cut off, and a file that is not there
 * is made. What journal_read() returns; MNS_E_NO_SPACE.
 *  ret_report  as the file was; may be NULL */
MnsStatus journal_open(const char *path, Journal **ret, JournalReport *ret_report, MnsError *error);

/* Close the file; what was not committed may be lost. NULL is fine. */
void journal_free(Journal *journal);

/* See to it that a full disk does not come in the way of `size` more bytes of records. MNS_E_NO_SPACE, MNS_E_IO. File systems that
 * cannot promise it are taken at their word later. */
MnsStatus journal_reserve(Journal *journal, size_t size, MnsError *error);

/* Add a record, in memory. MNS_E_MEMORY, MNS_E_LIMIT. */
MnsStatus journal_add(Journal *journal, const void *data, size_t size, MnsError *error);

/* Hand what was added to the operating system, without a wait for the disk: a crash of the program does not lose it. */
MnsStatus journal_write(Journal *journal, MnsError *error);

/* Have all that was added on the disk. MNS_E_NO_SPACE, MNS_E_IO: it is kept, and the next call tries again. */
MnsStatus journal_commit(Journal *journal, MnsError *error);

/* Is there something that is not on the disk? */
bool journal_behind(const Journal *journal);

uint64_t journal_records(const Journal *journal);

/* How far the file has come, as the operating system has it; of nothing that could not be written. */
JournalPlace journal_place(const Journal *journal);

/* The checksum of the record that begins at this byte of a file that was read, as a JournalPlace has it. MNS_E_IO. */
MnsStatus journal_sum_at(const char *path, uint64_t offset, uint64_t *ret, MnsError *error);

#endif
