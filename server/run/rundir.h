/* SPDX-License-Identifier: BSD-3-Clause */
/* The directory that holds everything of one run: case.yaml, log, journal, checkpoint-STEP.hdf, snapshot-STEP.hdf,
 * snapshots.hdf.series, probes.hdf. Files of a time line that was left go to a subdirectory, abandoned/, abandoned.2/ and so on;
 * lock says who is running there. */
#ifndef RUN_RUNDIR_H
#define RUN_RUNDIR_H

#include <meniscus/status.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { RUNDIR_PATH = 4096 - 64 }; /* leaves room for the names of its files in a path */

/* Which directory below parent a run of this name takes: NAME, or the first of NAME.2, NAME.3 ... that does not exist; with
 * `latest`, the last that does (NAME if there is none). MNS_E_LIMIT if the path is too long. */
MnsStatus rundir_choose(const char *parent, const char *name, bool latest, char ret[static RUNDIR_PATH],
                        MnsError *error);

/* Make the directory and those above it, and see whether it can be written to. MNS_E_IO, MNS_E_NO_SPACE: none is left that was not
 * there before.
 *  ret_made  length of the path of the first one that was made; 0: all were there before */
MnsStatus rundir_make(const char *dir, size_t *ret_made, MnsError *error);

/* Have the directory for oneself until the descriptor is closed. MNS_E_STATE: another run has it, and the sentence says whose;
 * MNS_E_IO, MNS_E_NO_SPACE. */
MnsStatus rundir_lock(const char *dir, int *ret_fd, MnsError *error);

/* Is that still the directory whose lock this is? Another run may have one of the same name by now. MNS_E_IO: it is not, and the sentence says what to do.
 *  lock  of rundir_lock(); -1: no lock was taken, and any directory will do */
MnsStatus rundir_check(const char *dir, int lock, MnsError *error);

/* Have the directory that runs get theirs in, so that no other daemon goes on with them meanwhile; the same otherwise. */
MnsStatus rundir_hold(const char *parent, int *ret_fd, MnsError *error);

/* Remove what a writer that was killed left half written; only whoever has the lock may. */
void rundir_clear(const char *dir);

/* Note in the file `current` of parent that the run of this directory was loaded last there, and read it. MNS_E_NOT_FOUND if there is
 * none; MNS_E_IO, MNS_E_NO_SPACE.
 *  asked     text of lines that is noted and compared: what the command line of the program asks for; NULL: for nothing
 *  ret_same  it was the same when the run was loaded */
MnsStatus rundir_note_current(const char *parent, const char *dir, const char *asked, MnsError *error);
MnsStatus rundir_current(const char *parent, const char *asked, char ret[static RUNDIR_PATH], bool *ret_same,
                         MnsError *error);
void rundir_forget_current(const char *parent);

/* Could it be noted? Of a full disk that is known before the run that is there is given up. */
MnsStatus rundir_try_current(const char *parent, MnsError *error);

/* Does it say so of this one? *ret_same: and with the same text. */
bool rundir_is_current(const char *parent, const char *dir, const char *asked, bool *ret_same);

/* The directories below parent, other than `but`, that have a journal: the one that was written last is the last, and before it as many as have at most so many
 * bytes of journals together. What cannot be looked at is left out. ret and its *ret_n strings are the caller's. MNS_E_MEMORY. */
MnsStatus rundir_former(const char *parent, const char *but, uint64_t most_bytes, char ***ret, size_t *ret_n,
                        MnsError *error);

/* Take away a journal in which nothing stands yet, as after a run that could not begin. */
void rundir_forget_journal(const char *dir);

/* Take away what was made, as far as nothing is in it but our lock, as after a run that could not begin. */
void rundir_unmake(const char *dir, size_t made);

/* Move aside the checkpoints and snapshots of steps later than `after`, or with all, every one, their index first and the probes; where some are
 * left, a link to the probes goes with the others, or a copy. On failure all is where it was.
 *  ret_aside  where they are to go, as after rundir_retire_journal(); or empty, and then the directory they are in now, one that did not exist, or
 *             empty if there were none */
MnsStatus rundir_abandon(const char *dir, bool all, uint64_t after, char ret_aside[static RUNDIR_PATH],
                         MnsError *error);

/* Undo that, as far as the disk lets us. Nothing to do if aside is empty. */
void rundir_return(const char *dir, const char *aside);

/* Move the journal aside, as nothing may be added to it, before the files that it tells of; and undo that, as far as the disk lets us.
 *  ret_aside  the directory that it is in now, one that did not exist */
MnsStatus rundir_retire_journal(const char *dir, char ret_aside[static RUNDIR_PATH], MnsError *error);
void rundir_return_journal(const char *dir, const char *aside);

/* Names of the files people look for (log and journal are none), sorted; ret and its *ret_n strings are the caller's. */
MnsStatus rundir_list(const char *dir, char ***ret, size_t *ret_n, MnsError *error);

#endif
