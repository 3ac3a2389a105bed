/* SPDX-License-Identifier: BSD-3-Clause */
/* The state for a bitwise restart: rotated files, whole or absent, verified by checksum when read. */
#ifndef IO_CHECKPOINT_H
#define IO_CHECKPOINT_H

#include "io/file.h"

/* Write DIR/checkpoint-STEP.hdf (step with ten digits) and drop the oldest beyond `keep`, never this one. Age is when a
 * file was written, not its step: after a restore the run goes on from there. A number in the seal tells it, and the date of
 * files that have none.
 * case_blob: the packed Case message, kept as it is. ret_path: [4096] where it went; may be NULL.
 * MNS_OK; MNS_E_NO_SPACE, MNS_E_IO, MNS_E_MEMORY: none was written, none dropped. */
MnsStatus checkpoint_write(const char *dir, const MnsCapture *state, const FileMeta *meta, const void *case_blob,
                           size_t case_size, unsigned keep, char *ret_path, MnsError *error);

typedef struct Checkpoint {
    MnsCapture *state;
    void *case_blob; /* the packed Case message of the run, as it was when this was written */
    size_t case_size;
    char path[4096];
    const char *arithmetic; /* it was computed in, as mns_arithmetic() names it; NULL: by a version that did not say */
    JournalPlace journal;   /* how far the journal of its run had come */
    uint64_t sum;           /* of the file, as its seal has it: no other checkpoint has the same */
} Checkpoint;

/* Read one file. MNS_E_NOT_FOUND, MNS_E_IO; MNS_E_CORRUPT if a checksum does not match; MNS_E_VERSION; MNS_E_MEMORY:
 * *ret is untouched. */
MnsStatus checkpoint_read(const char *path, Checkpoint *ret, MnsError *error);

/* Is it one to go on from? Else why not. */
typedef MnsStatus CheckpointTakes(void *arg, const Checkpoint *checkpoint, MnsError *error);

/* Read the last written whole one in dir, of those that takes() returns MNS_OK for, if it is given. The others are passed over; note() is given
 * why, and a sentence on those that look newer by their date, if it is given.
 * MNS_E_NOT_FOUND if there is none. */
MnsStatus checkpoint_newest(const char *dir, Checkpoint *ret, CheckpointTakes *takes,
                            void (*note)(void *arg, const char *text), void *arg, MnsError *error);

/* Name of the last written one in dir, by its seal: the rest is not looked at. False if there is none.
 * ret: [256] */
bool checkpoint_last(const char *dir, char *ret);

/* Names of those in dir that are not damaged, the last written first; of many only how many older ones there are. @return how many there are in all */
size_t checkpoint_tell(const char *dir, size_t size, char *ret);

/* How far the journal of its run had come when each in dir was written, as far as its seal is whole and tells it. What follows the seal is not looked at. */
typedef void CheckpointPlace(void *arg, const char *name, const JournalPlace *place);
void checkpoint_places(const char *dir, CheckpointPlace *visit, void *arg);

void checkpoint_done(Checkpoint *checkpoint);

#endif
