/* SPDX-License-Identifier: BSD-3-Clause */
/* Children that this process did not start. */
#include "base/children.h"

#include <sys/wait.h>

static pid_t kept; /* 0: none */

/* The one that is kept may hide others for as long as it is not waited for; then they get their turn. */
void children_keep(pid_t pid)
{
    kept = pid;
    if (!pid) children_reap();
}

void children_reap(void)
{
    for (;;) {
        siginfo_t info = {.si_pid = 0};
        if (waitid(P_ALL, 0, &info, WEXITED | WNOHANG | WNOWAIT) || !info.si_pid || info.si_pid == kept) return;
        waitpid(info.si_pid, NULL, WNOHANG);
    }
}
