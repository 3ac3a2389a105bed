/* SPDX-License-Identifier: BSD-3-Clause */
/* Files that are whole under their name, or not there. */
#include "client/cli/whole_file.h"
#include <errno.h>
#include <string.h>
#include <unistd.h>

static MnsStatus refuse(const char *path, const char *what, int code, MnsError *error)
{
    const MnsStatus status = code == ENOSPC || code == EDQUOT ? MNS_E_NO_SPACE : MNS_E_IO;
    return mns_fail_at(error, status, path, "cannot write %s %s: %s; %s", what, path, strerror(code),
                       mns_refusal_hint(code));
}

MnsStatus whole_file_write(const char *path, const char *what, bool (*write)(FILE *file, const void *arg),
                           const void *arg, MnsError *error)
{
    char part[4096];
    if ((size_t)snprintf(part, sizeof part, "%s.part", path) >= sizeof part)
        return refuse(path, what, ENAMETOOLONG, error);
    FILE *file = fopen(part, "wbe");
    if (!file) return refuse(path, what, errno, error);
    errno = 0;
    const bool written = write(file, arg) && !fflush(file) && !ferror(file);
    int code = written ? 0 : errno ? errno : EIO;
    if (fclose(file) && !code) code = errno;
    if (!code && rename(part, path)) code = errno;
    if (!code) return MNS_OK;
    unlink(part);
    return refuse(path, what, code, error);
}
