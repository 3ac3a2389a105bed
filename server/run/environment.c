/* SPDX-License-Identifier: BSD-3-Clause */
#include "run/environment.h"

#include "proto/processors.h"
#include <math.h>
#include <meniscus/sim.h>
#include <omp.h>
#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
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

/* Of a second thread of a team; 0: there is none. The thread that asks has its own team, which ends with it. */
static void *measure_stack(void *ret)
{
    size_t *size = ret;
#pragma omp parallel num_threads(2)
    if (omp_get_thread_num() == 1) {
        pthread_attr_t attributes;
        if (!pthread_getattr_np(pthread_self(), &attributes)) {
            pthread_attr_getstacksize(&attributes, size);
            pthread_attr_destroy(&attributes);
        }
    }
    return NULL;
}

MnsStatus environment_stacks(MnsError *error)
{
    size_t size = 0;
    sigset_t all, before;
    pthread_t thread;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    const bool begun = !pthread_create(&thread, NULL, measure_stack, &size);
    if (begun) pthread_join(thread, NULL);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    if (!size || size >= (size_t)(STACK_NEEDED - STACK_LOST) << 10) return MNS_OK;
    return mns_fail(
        error, MNS_E_LIMIT,
        "threads of OpenMP have stacks of %zu KiB, and the solver needs %d; set OMP_STACKSIZE=%dk or more, or "
        "leave it out",
        size >> 10, STACK_NEEDED, STACK_NEEDED);
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
