/* SPDX-License-Identifier: BSD-3-Clause */
/* Locks of whole files by flock(), which belongs to the open file: closing any other descriptor of it changes nothing, as it
 * would with POSIX locks. */
#include "run/lock.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

/* Who wrote last is who has it, but for the moment between their lock and their words. */
static void read_holder(int fd, char ret[static LOCK_HOLDER])
{
    const ssize_t got = pread(fd, ret, LOCK_HOLDER - 1, 0);
    ret[got > 0 ? got : 0] = 0;
    ret[strcspn(ret, "\n")] = 0;
    if (!ret[0]) snprintf(ret, LOCK_HOLDER, "another process");
}

static const char LEAVING[] = ", which is leaving";

/* People read it; the lock does not depend on it, so that a full disk is no reason to refuse. */
static void write_holder(int fd, const char *does)
{
    char host[65] = "", text[LOCK_HOLDER];
    gethostname(host, sizeof host - 1);
    const int n = snprintf(text, sizeof text, "process %ld on %s%s\n", (long)getpid(), host, does);
    if (ftruncate(fd, 0) || pwrite(fd, text, (size_t)n, 0) != n) return;
}

void lock_leave(int fd)
{
    write_holder(fd, LEAVING);
}

bool lock_is_leaving(const char *holder)
{
    return strstr(holder, LEAVING);
}

static MnsStatus fail(MnsError *error, int number, const char *verb, const char *path)
{
    return mns_fail(error, number == ENOSPC || number == EDQUOT ? MNS_E_NO_SPACE : MNS_E_IO, "cannot %s '%s': %s; %s",
                    verb, path, strerror(number), mns_refusal_hint(number));
}

/* Who can open a file can lock it, and so keep others from starting: it is for its owner alone, who is us or has the directory. Those of earlier versions
 * were for everybody to read. */
static MnsStatus make_private(int fd, const char *path, MnsError *error)
{
    char directory[4096];
    struct stat file, around;
    const char *slash = strrchr(path, '/');
    snprintf(directory, sizeof directory, "%.*s", slash && slash > path ? (int)(slash - path) : 1, slash ? path : ".");
    if (fstat(fd, &file) || stat(directory, &around)) return fail(error, errno, "look at", path);
    if (!S_ISREG(file.st_mode))
        return mns_fail(error, MNS_E_IO, "'%s' is no file, where a lock is to be; move it away", path);
    if (file.st_uid != geteuid() && file.st_uid != around.st_uid)
        return mns_fail(error, MNS_E_IO,
                        "'%s' belongs to user %ld, who could keep this from starting; remove it, or choose a directory "
                        "of your own",
                        path, (long)file.st_uid);
    if (file.st_mode & 077 && file.st_uid == geteuid() && fchmod(fd, 0600)) return fail(error, errno, "protect", path);
    return MNS_OK;
}

MnsStatus lock_take(const char *path, int *ret_fd, char ret_holder[static LOCK_HOLDER], MnsError *error)
{
    const int fd = open(path, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY, 0600);
    if (fd < 0) return fail(error, errno, "open", path);
    const MnsStatus status = make_private(fd, path, error);
    if (status) {
        close(fd);
        return status;
    }
    if (!flock(fd, LOCK_EX | LOCK_NB)) {
        write_holder(fd, "");
        *ret_fd = fd;
        return MNS_OK;
    }
    const int why = errno;
    if (why == EWOULDBLOCK) read_holder(fd, ret_holder);
    close(fd);
    if (why != EWOULDBLOCK) return fail(error, why, "lock", path);
    return mns_fail(error, MNS_E_STATE, "%s has locked '%s'", ret_holder, path);
}
