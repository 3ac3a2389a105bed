/* SPDX-License-Identifier: BSD-3-Clause */
/* What the tests of output files share: scratch directories, captures full of noise, disks that are full. */
#ifndef TESTS_IO_FIXTURE_H
#define TESTS_IO_FIXTURE_H

#include "io/file.h"
#include <time.h>

/* A new empty directory, removed with all it holds by scratch_free(). */
char *scratch_new(void);
void scratch_free(char *dir);

/* For cmocka: one as the state of each test; afterwards files may grow again. */
int scratch_begin(void **state);
int scratch_end(void **state);

/* "DIR/NAME"; [4096], to be freed. */
char *path_in(const char *dir, const char *name);

/* A capture of all fields with bits that no two values share, NaN and -0 among them. */
MnsCapture *noise_capture(int dim, size_t n, size_t n_fluid, uint64_t seed);

/* The same bits in every field of `fields`, the same size. */
bool same_values(const MnsCapture *a, const MnsCapture *b, uint64_t fields);
bool same_progress(const MnsProgress *a, const MnsProgress *b);

/* A made-up run of two fluids in one wall with two probes, P1 and front. */
FileMeta noise_meta(void);

/* The bytes of a file, to be freed; put them back or anywhere. */
unsigned char *bytes_of(const char *path, size_t *ret_size);
void put_bytes(const char *path, const void *bytes, size_t size);

/* Write a file of text below a directory, and the directories that it is in. */
void put_file(const char *root, const char *name, const char *text);

/* As if it had last been written then. */
void put_date(const char *path, time_t second);

bool exists(const char *path);

/* From now on no file grows beyond `bytes`, as on a full disk; SIZE_MAX: they may again. */
void limit_files(size_t bytes);

/* Whether dir holds a file whose name ends so. */
bool holds(const char *dir, const char *end);

#endif
