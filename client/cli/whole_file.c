/* SPDX-License-Identifier: BSD-3-Clause */
/* Files that are whole under their name, or not there. */
#include "client/cli/whole_file.h"
#include "common/host/disk.h"
#include <errno.h>
#include <string.h>
#include <unistd.h>

static MnsStatus refuse(const char *path, const char *what, int code, MnsError *error)
{
    return mns_fail_at(error, disk_status(code), path, "cannot write %s %s: %s; %s", what, path, strerror(code),
                       mns_refusal_hint(code));
}

static bool name_part(const char *path, char ret[WHOLE_FILE_PATH])
{
    return snprintf(ret, WHOLE_FILE_PATH, "%s.part", path) < WHOLE_FILE_PATH;
}

/* Close it. What was written so far must be on the disk before it has a name that says that it is whole. @return 0 or an errno */
static int finish(FILE *file, bool written, const char *part, const char *path)
{
    int code = written && !ferror(file) ? 0 : errno ? errno : EIO;
    if (!code && path && (fflush(file) || fsync(fileno(file)))) code = errno;
    if (fclose(file) && !code) code = errno;
    if (!code && path && rename(part, path)) code = errno;
    return code || !path ? code : disk_sync_above(path);
}

MnsStatus whole_file_write(const char *path, const char *what, bool (*write)(FILE *file, const void *arg),
                           const void *arg, MnsError *error)
{
    char part[WHOLE_FILE_PATH];
    if (!name_part(path, part)) return refuse(path, what, ENAMETOOLONG, error);
    FILE *file = disk_open(part, "w");
    if (!file) return refuse(path, what, errno, error);
    errno = 0;
    const bool written = write(file, arg);
    const int code = finish(file, written, part, path);
    if (!code) return MNS_OK;
    unlink(part);
    return refuse(path, what, code, error);
}

MnsStatus whole_file_piece(const char *path, const char *what, const FilePiece *piece, MnsError *error)
{
    char part[WHOLE_FILE_PATH];
    if (!name_part(path, part)) return refuse(path, what, ENAMETOOLONG, error);
    FILE *file = disk_open(part, piece->offset ? "r+" : "w");
    if (!file) return refuse(path, what, errno, error);
    errno = 0;
    const bool written = !fseeko(file, (off_t)piece->offset, SEEK_SET) &&
                         (!piece->size || fwrite(piece->data, 1, piece->size, file) == piece->size);
    const int code = finish(file, written, part, piece->is_last ? path : NULL);
    return code ? refuse(path, what, code, error) : MNS_OK;
}
