/* SPDX-License-Identifier: BSD-3-Clause */
/* Checkpoints: sealed HDF5 files with the state, the case and who wrote them.
 *
 *  /state  see state.h        /meniscus  see meta.h        /case  [bytes] the packed Case message; attribute xxh64 */
#include "io/checkpoint.h"
#include "io/atomic_file.h"
#include "io/directory.h"
#include "io/meta.h"
#include "io/names.h"
#include "io/state.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <xxhash.h>

typedef struct Source {
    const MnsCapture *state;
    const FileMeta *meta;
    const void *blob;
    size_t size;
} Source;

static void fill(H5 *h, const void *what)
{
    const Source *s = what;
    const uint64_t hash = XXH64(s->blob, s->size, 0);
    meta_put_run(h, s->meta);
    meta_put_moment(h, s->state, s->state->n);
    state_put(h, s->state);
    h5_put(h, "/case", H5T_NATIVE_UINT8, s->size, s->blob);
    h5_mark(h, "/case", "xxh64", H5T_NATIVE_UINT64, 0, &hash);
}

/* Old checkpoints are in nobody's way, so what cannot be removed stays. */
static void drop_oldest(const char *dir, const char *written, unsigned keep)
{
    DirectoryEntry *entries = NULL;
    size_t n = 0;
    unsigned kept = 1; /* the one just written */
    char path[IO_PATH_MAX];
    if (directory_list(dir, CHECKPOINT_BEGIN, NUMBERED_END, &entries, &n, NULL)) return;
    for (size_t k = 0; k < n; k++)
        if (strcmp(entries[k].name, written) != 0 && ++kept > keep && !directory_path(path, dir, entries[k].name, NULL))
            unlink(path);
    free(entries);
}

MnsStatus checkpoint_write(const char *dir, const MnsCapture *state, const FileMeta *meta, const void *case_blob,
                           size_t case_size, unsigned keep, char *ret_path, MnsError *error)
{
    const Source source = {state, meta, case_blob, case_size};
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
    c->case_blob = malloc(c->case_size + 1);
    if (!c->case_blob) h5_raise(h, MNS_E_MEMORY, "no memory for the case in '%s'", h->path);
    h5_get_rows(h, "/case", H5T_NATIVE_UINT8, 0, c->case_size, c->case_blob);
    h5_get_mark(h, "/case", "xxh64", H5T_NATIVE_UINT64, &hash);
    if (!h->status && hash != XXH64(c->case_blob, c->case_size, 0))
        h5_raise(h, MNS_E_CORRUPT, "'%s' is damaged: the checksum of its case does not match", h->path);
}

static void read_all(H5 *h, void *into)
{
    Checkpoint *c = into;
    c->state = state_get(h);
    get_case(h, c);
}

MnsStatus checkpoint_read(const char *path, Checkpoint *ret, MnsError *error)
{
    Checkpoint found = {0};
    if (strlen(path) >= sizeof found.path)
        return mns_fail(error, MNS_E_INVALID, "the path '%.60s...' is too long", path);
    const MnsStatus status = h5_load(path, true, read_all, &found, error);
    if (status) {
        checkpoint_done(&found);
        return status;
    }
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

MnsStatus checkpoint_newest(const char *dir, Checkpoint *ret, void (*note)(void *arg, const char *text), void *arg,
                            MnsError *error)
{
    DirectoryEntry *entries = NULL;
    size_t n = 0, k = 0;
    char path[IO_PATH_MAX];
    MnsError why = {0};
    MnsStatus status = directory_list(dir, CHECKPOINT_BEGIN, NUMBERED_END, &entries, &n, error);
    if (status) return status;
    for (; k < n; k++) {
        status = directory_path(path, dir, entries[k].name, &why);
        if (!status) status = checkpoint_read(path, ret, &why);
        if (!passed_over(status)) break;
        if (note) note(arg, why.text);
    }
    free(entries);
    if (n == 0) return mns_fail(error, MNS_E_NOT_FOUND, "there is no checkpoint in '%s'", dir);
    if (k == n) return mns_fail(error, MNS_E_NOT_FOUND, "none of the %zu checkpoints in '%s' is whole", n, dir);
    return status ? mns_fail(error, status, "%s", why.text) : MNS_OK;
}
