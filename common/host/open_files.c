/* SPDX-License-Identifier: BSD-3-Clause */
/* The limit on open files, and what is left of it. */
#include "common/host/open_files.h"

#include <fcntl.h>
#include <limits.h>
#include <sys/resource.h>
#include <unistd.h>

enum { USUAL = 1024 }; /* where the system does not say */

static int limit_of(const struct rlimit *limit, int most)
{
    return limit->rlim_cur < (rlim_t)most ? (int)limit->rlim_cur : most;
}

int open_files_raise(int most)
{
    struct rlimit limit;
    if (getrlimit(RLIMIT_NOFILE, &limit)) return USUAL;
    struct rlimit wanted = {limit.rlim_max, limit.rlim_max};
    if (wanted.rlim_cur > (rlim_t)most) wanted.rlim_cur = (rlim_t)most;
    if (!setrlimit(RLIMIT_NOFILE, &wanted)) limit = wanted;
    return limit_of(&limit, most);
}

MnsStatus open_files_check(int least, MnsError *error)
{
    struct rlimit limit;
    const int most = getrlimit(RLIMIT_NOFILE, &limit) ? USUAL : limit_of(&limit, INT_MAX);
    int fd = 0, taken = 0;
    for (; fd < most && fd - taken < least; fd++) taken += fd > STDERR_FILENO && fcntl(fd, F_GETFD) >= 0;
    if (fd - taken >= least) return MNS_OK;
    return mns_fail(error, MNS_E_LIMIT,
                    "this takes at least %d open files, and the process may have %d, of which %d %s in use already; "
                    "raise the limit (`ulimit -n`, LimitNOFILE=) to %d or more",
                    least, most, taken, taken == 1 ? "is" : "are", least + taken);
}

MnsStatus open_files_need(int least, MnsError *error)
{
    if (open_files_check(least, NULL) == MNS_OK) return MNS_OK;
    (void)open_files_raise(INT_MAX);
    return open_files_check(least, error);
}
