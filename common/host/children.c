/* SPDX-License-Identifier: BSD-3-Clause */
/* Children that this process started, and those that it did not. */
#include "common/host/children.h"
#include <errno.h>
#include <pthread.h>
#include <stdbool.h>
#include <sys/wait.h>
#include <unistd.h>

static pthread_mutex_t lock =
    PTHREAD_MUTEX_INITIALIZER; /* of the list, which a child is in before its end can be seen */
static Child *started;

int children_start(Child *ret, const char *program, const posix_spawn_file_actions_t *actions, char *const *words)
{
    pthread_mutex_lock(&lock);
    *ret = (Child){.next = started};
    const int failed = posix_spawnp(&ret->pid, program, actions, NULL, words, environ);
    if (failed) ret->pid = 0;
    else started = ret;
    pthread_mutex_unlock(&lock);
    return failed;
}

/* Until it is waited for it may hide others from children_reap(), so they get their turn. */
int children_wait(Child *child)
{
    int how = 0;
    while (waitpid(child->pid, &how, 0) < 0 && errno == EINTR) continue;
    pthread_mutex_lock(&lock);
    for (Child **at = &started; *at; at = &(*at)->next) {
        if (*at != child) continue;
        *at = child->next;
        break;
    }
    child->pid = 0;
    pthread_mutex_unlock(&lock);
    children_reap();
    return how;
}

static bool is_started_here(pid_t pid)
{
    for (const Child *child = started; child; child = child->next)
        if (child->pid == pid) return true;
    return false;
}

void children_reap(void)
{
    pthread_mutex_lock(&lock);
    for (;;) {
        siginfo_t info = {.si_pid = 0};
        if (waitid(P_ALL, 0, &info, WEXITED | WNOHANG | WNOWAIT) || !info.si_pid || is_started_here(info.si_pid)) break;
        waitpid(info.si_pid, NULL, WNOHANG);
    }
    pthread_mutex_unlock(&lock);
}
