/* SPDX-License-Identifier: BSD-3-Clause */
#include "run/environment.h"

#include "common/host/processors.h"
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <meniscus/sim.h>
#include <omp.h>
#include <pthread.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <stdnoreturn.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

/* Where threads are bound to processors (OMP_PROC_BIND, OMP_PLACES), the runtime has bound this one before main(), and a program that is
 * started by it would take its one processor for all there are. */
static void unbind(void)
{
    cpu_set_t all;
    CPU_ZERO(&all);
    for (int place = 0; place < omp_get_num_places(); place++) {
        int ids[CPU_SETSIZE];
        const int n = omp_get_place_num_procs(place);
        if (n > CPU_SETSIZE) return;
        omp_get_place_proc_ids(place, ids);
        for (int k = 0; k < n; k++) CPU_SET((size_t)ids[k], &all);
    }
    if (CPU_COUNT(&all)) (void)sched_setaffinity(0, sizeof all, &all);
}

/* The OpenMP team must not spin for long: on a machine with other work to do, a thread that spins keeps from the
 * processor the very one it waits for, and a step takes longer. Nor may it sleep at once: to be woken at each barrier takes a
 * fifteenth of a step of 100,000 particles in the plane. GNU's runtime reads its settings before main(), so the program starts
 * itself again with them; whoever sets one has their way. For 0.5 s of dambreak2d at resolution 20, two threads on two
 * processors with a busy loop beside: 1.0 s at 1000, 1.1 at 2000, 1.3 to 1.6 at 5000. */
void environment_waiting(char **argv)
{
    if (getenv("GOMP_SPINCOUNT") || getenv("OMP_WAIT_POLICY")) return;
    setenv("GOMP_SPINCOUNT", "1000", 1);
    setenv("KMP_BLOCKTIME", "0", 0);
    unbind();
    char path[4096] = ""; /* the true one, or the process would be listed as "exe" */
    if (readlink("/proc/self/exe", path, sizeof path - 1) > 0) execv(path, argv);
}

void environment_threads(void)
{
    const double threads = ceil(processors_look("").quota);
    if (!getenv("OMP_NUM_THREADS") && threads < omp_get_max_threads()) omp_set_num_threads((int)threads);
}

/* --- stacks --------------------------------------------------------------------------------------------------------------- */

enum { STACK_NEEDED = 512, STACK_LOST = 16 }; /* [KiB] the latter to guards and what the runtime keeps there */

/* Of the second thread of a team. */
static size_t measure_stack(void)
{
    size_t size = 0;
#pragma omp parallel num_threads(2)
    if (omp_get_thread_num() == 1) {
        pthread_attr_t attributes;
        if (!pthread_getattr_np(pthread_self(), &attributes)) {
            pthread_attr_getstacksize(&attributes, &size);
            pthread_attr_destroy(&attributes);
        }
    }
    return size;
}

/* Where a thread cannot be started, the runtime says so in words of its own and calls exit(): neither may come of it here. */
static noreturn void measure_and_end(int fd)
{
    const int nothing = open("/dev/null", O_WRONLY | O_CLOEXEC);
    dup2(nothing, STDOUT_FILENO);
    dup2(nothing, STDERR_FILENO);
    const size_t size = measure_stack();
    _exit(write(fd, &size, sizeof size) == sizeof size ? 0 : 1);
}

/* Asked of a child, whose end process_main() may be the one to note. False: there is no such thread. */
static bool find_stack(size_t *ret)
{
    int ends[2];
    if (pipe2(ends, O_CLOEXEC)) return false;
    fflush(NULL);
    const pid_t child = fork();
    if (child == 0) measure_and_end(ends[1]);
    close(ends[1]);
    const bool found = child > 0 && read(ends[0], ret, sizeof *ret) == sizeof *ret;
    close(ends[0]);
    while (child > 0 && waitpid(child, NULL, 0) < 0 && errno == EINTR) continue;
    return found;
}

/* The variable that the runtime takes the size from; NULL: it takes the system's. */
static const char *stack_variable(void)
{
    static const char *const names[] = {"OMP_STACKSIZE", "GOMP_STACKSIZE"};
    for (size_t k = 0; k < sizeof names / sizeof *names; k++)
        if (getenv(names[k])) return names[k];
    return NULL;
}

MnsStatus environment_stacks(MnsError *error)
{
    size_t size;
    const char *name = stack_variable();
    const bool found = find_stack(&size);
    if (found && (!size || size >= (size_t)(STACK_NEEDED - STACK_LOST) << 10)) return MNS_OK;
    if (!found && !name)
        return mns_fail(error, MNS_E_LIMIT,
                        "cannot start the threads of OpenMP; raise the limits on processes (`ulimit -u`) and memory "
                        "(`ulimit -v`)");
    if (!name) name = "OMP_STACKSIZE";
    if (!found)
        return mns_fail(
            error, MNS_E_LIMIT,
            "threads of OpenMP cannot be started with %s=%.40s; set %s=%dk, which the solver needs, or leave it out",
            name, getenv(name), name, STACK_NEEDED);
    return mns_fail(error, MNS_E_LIMIT,
                    "threads of OpenMP have stacks of %zu KiB, and the solver needs %d; set %s=%dk or more, or leave "
                    "it out",
                    size >> 10, STACK_NEEDED, name, STACK_NEEDED);
}

/* --- instructions --------------------------------------------------------------------------------------------------------- */

static const char *level_asked_for(void)
{
    const char *name = getenv("MENISCUS_LEVEL");
    return name && *name ? name : NULL;
}

/* What the program began with. */
typedef struct Own {
    const char *level, *arithmetic;
} Own;

static const Own *own(void)
{
    static Own began;
    if (!began.level) began = (Own){mns_level(), mns_arithmetic()};
    return &began;
}

const char *environment_own_level(void)
{
    return own()->level;
}

MnsStatus environment_level(MnsError *error)
{
    const char *name = level_asked_for();
    MnsError why;
    if (name && mns_level_force(name, &why)) return mns_fail(error, why.status, "MENISCUS_LEVEL: %s", why.text);
    (void)own();
    return MNS_OK;
}

void environment_compute_anew(void)
{
    (void)mns_level_force(own()->level, NULL);
}

bool environment_compute_as(const char *arithmetic)
{
    const bool mine = arithmetic && !strcmp(arithmetic, own()->arithmetic);
    if (!mine && arithmetic && !level_asked_for() && !mns_level_force("x86-64", NULL)) {
        if (!strcmp(arithmetic, mns_arithmetic())) return true;
    }
    environment_compute_anew();
    return mine;
}
