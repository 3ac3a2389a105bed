/* SPDX-License-Identifier: BSD-3-Clause */
/* Checkpoints: sealed HDF5 files with the state, the case and who wrote them.
 *
 *  /state  see state.h        /meniscus  see meta.h        /case  [bytes] the packed Case message; attribute xxh64 */
#include "io/checkpoint.h"
#include "io/atomic_file.h"
#include "io/directory.h"
#include "io/meta.h"
#include "io/names.h"
#include "io/seal.h"
#include "io/state.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <xxhash.h>

typedef struct Source {
    const MnsCapture *state;
    const FileMeta *meta;
    const void *blob;
    size_t size;
    uint64_t number;
} Source;

static void fill(H5 *h, const void *what)
{
    const Source *s = what;
    const uint64_t hash = XXH64(s->blob, s->size, 0);
    h->seal = (SealNote){.number = s->number, .journal = s->meta->journal};
    meta_put_run(h, s->meta);
    meta_put_moment(h, s->state, s->state->n);
    state_put(h, s->state);
    h5_put(h, "/case", H5T_NATIVE_UINT8, s->size, s->blob);
    h5_mark(h, "/case", "xxh64", H5T_NATIVE_UINT64, 0, &hash);
}

/* A checkpoint in its directory. Copying a directory changes when its files were written, so that the number in the seal
 * says which is the newest; older programs wrote none. */
typedef struct Kept {
    DirectoryEntry is;
    SealNote seal;
    bool damaged; /* has no whole seal, thus no number */
} Kept;

static int by_number(const void *left, const void *right)
{
    const Kept *a = left, *b = right;
    if (a->damaged != b->damaged) return a->damaged ? -1 : 1;
    if (a->seal.number != b->seal.number) return a->seal.number > b->seal.number ? -1 : 1;
    return directory_order(&a->is, &b->is);
}

/* List the checkpoints: the damaged ones, and behind them the others, the newest first. */
static MnsStatus list(const char *dir, Kept **ret, size_t *ret_n, MnsError *error)
{
    DirectoryEntry *entries = NULL;
    size_t n = 0;
    char path[IO_PATH_MAX];
    const MnsStatus status = directory_list(dir, CHECKPOINT_BEGIN, NUMBERED_END, &entries, &n, error);
    if (status) return status;
    Kept *kept = calloc(n + 1, sizeof *kept);
    for (size_t k = 0; kept && k < n; k++) {
        kept[k].is = entries[k];
        kept[k].damaged = directory_path(path, dir, entries[k].name, NULL) || !seal_read(path, &kept[k].seal);
    }
    free(entries);
    if (!kept) return mns_fail(error, MNS_E_MEMORY, "no memory for the list of checkpoints in '%s'", dir);
    qsort(kept, n, sizeof *kept, by_number);
    *ret = kept;
    *ret_n = n;
    return MNS_OK;
}

static size_t count_damaged(const Kept *kept, size_t n)
{
    size_t damaged = 0;
    while (damaged < n && kept[damaged].damaged) damaged++;
    return damaged;
}

/* Old checkpoints are in nobody's way, so what cannot be removed stays. */
static void drop_oldest(const char *dir, const char *written, unsigned keep)
{
    Kept *list_of = NULL;
    size_t n = 0;
    unsigned kept = 1; /* the one just written */
    char path[IO_PATH_MAX];
    if (list(dir, &list_of, &n, NULL)) return;
    const size_t damaged = count_damaged(list_of, n);
    for (size_t k = 0; k < n; k++) { /* the damaged ones last */
        const char *name = list_of[(damaged + k) % n].is.name;
        if (strcmp(name, written) != 0 && ++kept > keep && !directory_path(path, dir, name, NULL)) unlink(path);
    }
    free(list_of);
}

/* One more than any there is. */
static uint64_t next_number(const char *dir)
{
    Kept *kept = NULL;
    size_t n = 0;
    if (list(dir, &kept, &n, NULL)) return 1;
    const size_t damaged = count_damaged(kept, n);
    const uint64_t number = damaged < n ? kept[damaged].seal.number + 1 : 1;
    free(kept);
    return number;
}

MnsStatus checkpoint_write(const char *dir, const MnsCapture *state, const FileMeta *meta, const void *case_blob,
                           size_t case_size, unsigned keep, char *ret_path, MnsError *error)
{
    const Source source = {state, meta, case_blob, case_size, next_number(dir)};
    char name[NUMBERED_NAME], path[IO_PATH_MAX];
    name_numbered(CHECKPOINT_BEGIN, state->progress.step, name);
    MnsStatus status = directory_path(path, dir, name, error);
    if (!status) status = h5_save(path, true, fill, &source, error);
    if (status) return status;
    drop_oldest(dir, name, keep);
    if (ret_path) memcpy(ret_path, path, sizeof path);
    return MNS_OK;
}

static void get_case(H5 *h, Checkpoint *c)
{
    uint64_t hash = 0;
    c->case_size = h5_rows(h, "/case");
    h5_expect_bytes(h, c->case_size);
    if (h->status) return;
    c->case_blob = malloc(c->case_size + 1);
    if (!c->case_blob) h5_raise(h, MNS_E_MEMORY, "no memory for the case in '%s'", h->path);
    h5_get(h, "/case", H5T_NATIVE_UINT8, c->case_size, c->case_blob);
    h5_get_mark(h, "/case", "xxh64", H5T_NATIVE_UINT64, &hash);
    if (!h->status && hash != XXH64(c->case_blob, c->case_size, 0))
        h5_raise(h, MNS_E_CORRUPT, "'%s' is damaged: the checksum of its case does not match", h->path);
}

static void read_all(H5 *h, void *into)
{
    Checkpoint *c = into;
    c->state = state_get(h);
    c->arithmetic = meta_arithmetic(h);
    get_case(h, c);
}

MnsStatus checkpoint_read(const char *path, Checkpoint *ret, MnsError *error)
{
    Checkpoint found = {0};
    if (strlen(path) >= sizeof found.path)
        return mns_fail(error, MNS_E_INVALID, "the path '%.60s...' is too long", path);
    SealNote seal;
    const MnsStatus status = h5_load(path, true, read_all, &found, error);
    if (status || !seal_read(path, &seal)) {
        checkpoint_done(&found);
        return status ? status : mns_fail(error, MNS_E_IO, "cannot read '%s' once more", path);
    }
    found.journal = seal.journal;
    found.sum = seal.sum;
    memcpy(found.path, path, strlen(path) + 1);
    *ret = found;
    return MNS_OK;
}

void checkpoint_done(Checkpoint *checkpoint)
{
    mns_capture_free(checkpoint->state);
    free(checkpoint->case_blob);
    *checkpoint = (Checkpoint){0};
}

/* Lack of memory says nothing about a file: going back to an older one would lose work. */
static bool passed_over(MnsStatus status)
{
    return status != MNS_OK && status != MNS_E_MEMORY;
}

/* Somebody who goes by the clock would expect another one. */
static void note_later(const char *dir, const Kept *kept, size_t n, size_t taken, void (*note)(void *, const char *),
                       void *arg)
{
    char text[512];
    const char *name = kept[taken].is.name;
    if (!note || !kept[taken].seal.number) return;
    for (size_t k = taken + 1; k < n; k++) {
        if (directory_order(&kept[k].is, &kept[taken].is) > 0) continue;
        snprintf(text, sizeof text,
                 "'%.200s/%.60s' looks newer by its date, but '%.60s' was written after it and is taken", dir,
                 kept[k].is.name, name);
        note(arg, text);
    }
}

/* Read one that takes(), if it is given, does not refuse. */
static MnsStatus read_taken(const char *dir, const char *name, Checkpoint *ret, CheckpointTakes *takes, void *arg,
                            MnsError *error)
{
    char path[IO_PATH_MAX];
    Checkpoint found;
    MnsStatus status = directory_path(path, dir, name, error);
    if (!status) status = checkpoint_read(path, &found, error);
    if (status) return status;
    if (takes) status = takes(arg, &found, error);
    if (status) checkpoint_done(&found);
    else *ret = found;
    return status;
}

MnsStatus checkpoint_newest(const char *dir, Checkpoint *ret, CheckpointTakes *takes,
                            void (*note)(void *arg, const char *text), void *arg, MnsError *error)
{
    Kept *kept = NULL;
    size_t n = 0, k = 0;
    MnsError why = {0};
    MnsStatus status = list(dir, &kept, &n, error);
    if (status) return status;
    if (note) directory_others(dir, CHECKPOINT_BEGIN, NUMBERED_END, note, arg);
    for (; k < n; k++) {
        status = read_taken(dir, kept[k].is.name, ret, takes, arg, &why);
        if (!passed_over(status)) break;
        if (note) note(arg, why.text);
    }
    if (k < n && !status) note_later(dir, kept, n, k, note, arg);
    free(kept);
    if (n == 0) return mns_fail(error, MNS_E_NOT_FOUND, "there is no checkpoint in '%s'", dir);
    if (k == n)
        return mns_fail(error, MNS_E_NOT_FOUND, "none of the %zu checkpoints in '%s' is whole%s", n, dir,
                        takes ? " and of this run" : "");
    return status ? mns_fail(error, status, "%s", why.text) : MNS_OK;
}

bool checkpoint_last(const char *dir, char *ret)
{
    Kept *kept = NULL;
    size_t n = 0;
    if (list(dir, &kept, &n, NULL)) return false;
    const size_t damaged = count_damaged(kept, n);
    if (damaged < n) memcpy(ret, kept[damaged].is.name, sizeof kept[damaged].is.name);
    free(kept);
    return damaged < n;
}

size_t checkpoint_tell(const char *dir, size_t size, char *ret)
{
    enum { MOST = 4 };
    Kept *kept = NULL;
    size_t n = 0, at = 0;
    *ret = 0;
    if (list(dir, &kept, &n, NULL)) return 0;
    const size_t first = count_damaged(kept, n), whole = n - first;
    for (size_t k = 0; k < whole && k < MOST && at < size; k++)
        at += (size_t)snprintf(ret + at, size - at, "%s%s", k ? ", " : "", kept[first + k].is.name);
    if (whole > MOST && at < size) snprintf(ret + at, size - at, " and %zu older ones", whole - MOST);
    free(kept);
    return whole;
}

void checkpoint_places(const char *dir, CheckpointPlace *visit, void *arg)
{
    Kept *kept = NULL;
    size_t n = 0;
    if (list(dir, &kept, &n, NULL)) return;
    for (size_t k = count_damaged(kept, n); k < n; k++)
        if (kept[k].seal.journal.records) visit(arg, kept[k].is.name, &kept[k].seal.journal);
    free(kept);
}
