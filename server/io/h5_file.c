/* SPDX-License-Identifier: BSD-3-Clause */
/* HDF5 files from opening to closing: atomic when written, checked when read, closed whatever happens in between. */
#include "io/atomic_file.h"
#include "io/h5.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* HDF5 prints its errors to standard error unless told not to. The caller's choice comes back afterwards. */
typedef struct Printing {
    H5E_auto2_t print;
    void *arg;
} Printing;

static Printing printing_off(void)
{
    static bool begun; /* HDF5 belongs to one thread */
    Printing was = {0};
    /* What a damaged file leaves open, HDF5 cannot close at the end, and complains on standard error. There is nothing to be
     * closed then: every file was, by itself. */
    if (!begun) H5dont_atexit();
    begun = true;
    H5Eget_auto2(H5E_DEFAULT, &was.print, &was.arg);
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    return was;
}

static void printing_restore(Printing was)
{
    H5Eclear2(H5E_DEFAULT);
    H5Eset_auto2(H5E_DEFAULT, was.print, was.arg);
}

/* The newest formats are asked for because they carry checksums of all metadata: a damaged file is reported rather than
 * believed. */
static hid_t new_access(Disk *disk)
{
    const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    if (access < 0) return access;
    if (h5_driver_use(access, disk) >= 0 && H5Pset_libver_bounds(access, H5F_LIBVER_V110, H5F_LIBVER_V110) >= 0)
        return access;
    H5Pclose(access);
    return -1;
}

static void create(H5 *h, bool sealed)
{
    const hid_t access = new_access(&h->disk), creation = H5Pcreate(H5P_FILE_CREATE);
    h->file = -1;
    if (access >= 0 && creation >= 0 && H5Pset_userblock(creation, sealed ? SEAL_SIZE : 0) >= 0)
        h->file = H5Fcreate(h->path, H5F_ACC_TRUNC, creation, access);
    if (h->file < 0) h5_raise(h, MNS_E_IO, "cannot begin the HDF5 file '%s'", h->path);
    if (creation >= 0) H5Pclose(creation);
    if (access >= 0) H5Pclose(access);
}

static void open_existing(H5 *h)
{
    const hid_t access = new_access(&h->disk);
    h->file = access < 0 ? -1 : H5Fopen(h->path, H5F_ACC_RDONLY, access);
    if (h->file < 0) h5_raise(h, MNS_E_CORRUPT, "'%s' is damaged, or not an HDF5 file", h->path);
    if (access >= 0) H5Pclose(access);
}

/* Also reports what the disk refused, which HDF5 was not told. */
static void finish(H5 *h)
{
    if (h->file >= 0 && H5Fclose(h->file) < 0) h5_raise(h, MNS_E_IO, "cannot close the HDF5 file '%s'", h->path);
    h5_driver_done(&h->disk);
    if (h->disk.failure && !h->status)
        h->status = file_fail(h->error, h->disk.failure, h->writing ? "write" : "read", h->path);
}

MnsStatus h5_save(const char *path, bool sealed, H5Fill *fill, const void *what, MnsError *error)
{
    AtomicFile file;
    const MnsStatus begun = atomic_begin(&file, path, error);
    if (begun) return begun;
    H5 h = {.path = path, .disk = {.fd = file.fd}, .writing = true, .error = error};
    const Printing printing = printing_off();
    create(&h, sealed);
    if (!h.status) fill(&h, what);
    finish(&h);
    printing_restore(printing);
    if (!h.status && sealed) h.status = seal_write(file.fd, path, &h.seal, error);
    if (!h.status) return atomic_commit(&file, error);
    atomic_cancel(&file);
    return h.status;
}

/* A file to be read may be anybody's word: it may be missing, where one to be written may not, and a pipe in its place holds up nobody. */
static MnsStatus open_file(const char *path, int *ret_fd, MnsError *error)
{
    struct stat about;
    const int fd = *ret_fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0 && errno == ENOENT)
        return mns_fail(error, MNS_E_NOT_FOUND, "cannot open '%s': %s; %s", path, strerror(errno),
                        mns_refusal_hint(errno));
    if (fd < 0) return file_fail(error, errno, "open", path);
    if (!fstat(fd, &about) && S_ISREG(about.st_mode)) return MNS_OK;
    close(fd);
    return mns_fail(error, MNS_E_CORRUPT, "'%s' is no file, so no HDF5 file", path);
}

MnsStatus h5_load(const char *path, bool sealed, H5Read *read, void *into, MnsError *error)
{
    int fd;
    const MnsStatus opened = open_file(path, &fd, error);
    if (opened) return opened;
    H5 h = {.path = path, .disk = {.fd = fd}, .file = -1, .error = error};
    const Printing printing = printing_off();
    if (sealed) h.status = seal_check(fd, path, error);
    if (!h.status) open_existing(&h);
    if (!h.status) read(&h, into);
    finish(&h);
    printing_restore(printing);
    close(fd);
    return h.status;
}
