/* SPDX-License-Identifier: BSD-3-Clause */
/* An HDF5 file driver over an open file descriptor that remembers the first failure instead of reporting it. */
#include "io/h5_driver.h"
#include "io/atomic_file.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

typedef struct DiskFile {
    H5FD_t base; /* HDF5's part comes first */
    Disk *disk;
    haddr_t end_allocated, end_written;
} DiskFile;

typedef struct DiskAccess {
    Disk *disk;
} DiskAccess;

static H5FD_t *disk_open(const char *name, unsigned flags, hid_t access, haddr_t largest)
{
    (void)name, (void)flags, (void)largest;
    const DiskAccess *info = H5Pget_driver_info(access);
    struct stat about;
    if (!info || fstat(info->disk->fd, &about) != 0) return NULL;
    DiskFile *file = calloc(1, sizeof *file);
    if (!file) return NULL;
    file->disk = info->disk;
    file->end_written = (haddr_t)about.st_size;
    return &file->base;
}

static herr_t disk_close(H5FD_t *base)
{
    free(base);
    return 0;
}

static herr_t disk_query(const H5FD_t *base, unsigned long *flags)
{
    (void)base;
    *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
             H5FD_FEAT_AGGREGATE_SMALLDATA;
    return 0;
}

static haddr_t disk_end_allocated(const H5FD_t *base, H5FD_mem_t kind)
{
    (void)kind;
    return ((const DiskFile *)base)->end_allocated;
}

static herr_t disk_allocate(H5FD_t *base, H5FD_mem_t kind, haddr_t end)
{
    (void)kind;
    ((DiskFile *)base)->end_allocated = end;
    return 0;
}

static haddr_t disk_end_written(const H5FD_t *base, H5FD_mem_t kind)
{
    (void)kind;
    return ((const DiskFile *)base)->end_written;
}

/* What lies behind the end of the file reads as zeros, as in every other driver. */
static herr_t disk_read(H5FD_t *base, H5FD_mem_t kind, hid_t transfer, haddr_t at, size_t size, void *data)
{
    (void)kind, (void)transfer;
    Disk *disk = ((DiskFile *)base)->disk;
    size_t got = 0;
    const int failure = file_read_at(disk->fd, data, size, (size_t)at, &got);
    if (failure && !disk->failure) disk->failure = failure;
    memset((char *)data + got, 0, size - got);
    return failure ? -1 : 0;
}

static herr_t disk_write(H5FD_t *base, H5FD_mem_t kind, hid_t transfer, haddr_t at, size_t size, const void *data)
{
    (void)kind, (void)transfer;
    DiskFile *file = (DiskFile *)base;
    if (!file->disk->failure) file->disk->failure = file_write_at(file->disk->fd, data, size, (size_t)at);
    if (at + size > file->end_written) file->end_written = at + size;
    return 0;
}

static herr_t disk_truncate(H5FD_t *base, hid_t transfer, hbool_t closing)
{
    (void)transfer, (void)closing;
    DiskFile *file = (DiskFile *)base;
    Disk *disk = file->disk;
    if (file->end_allocated == file->end_written) return 0;
    if (!disk->failure && ftruncate(disk->fd, (off_t)file->end_allocated) != 0) disk->failure = errno;
    file->end_written = file->end_allocated;
    return 0;
}

static const H5FD_class_t disk_class = {
    .name = "meniscus",
    .maxaddr = INT64_MAX,
    .fc_degree = H5F_CLOSE_STRONG, /* whatever is open in a file is closed with it, also after a failure */
    .fapl_size = sizeof(DiskAccess),
    .open = disk_open,
    .close = disk_close,
    .query = disk_query,
    .get_eoa = disk_end_allocated,
    .set_eoa = disk_allocate,
    .get_eof = disk_end_written,
    .read = disk_read,
    .write = disk_write,
    .truncate = disk_truncate,
    .fl_map = H5FD_FLMAP_DICHOTOMY,
};

herr_t h5_driver_use(hid_t access, Disk *disk)
{
    const hid_t driver = H5FDregister(&disk_class);
    if (driver < 0) return -1;
    const DiskAccess info = {disk};
    disk->driver = driver;
    return H5Pset_driver(access, driver, &info);
}

/* A file gives its own hold of the driver up before it calls its close(), so that it must not be the last. */
void h5_driver_done(Disk *disk)
{
    if (disk->driver > 0) H5FDunregister(disk->driver);
    disk->driver = 0;
}
