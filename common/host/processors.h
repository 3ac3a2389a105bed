/* SPDX-License-Identifier: BSD-3-Clause */
/* How many processors this process may use: of this, threads of the solver by default. */
#ifndef COMMON_HOST_PROCESSORS_H
#define COMMON_HOST_PROCESSORS_H

typedef struct Processors {
    int there;    /* of the machine */
    int bound;    /* that this process is bound to (sched_setaffinity, cpuset) */
    double quota; /* that its control groups let it use at a time; INFINITY without a bound */
    int threads;  /* that can compute at once: the least of these, rounded up */
} Processors;

/* root: "" for the machine; for tests a directory that has its proc and sys/fs/cgroup. */
Processors processors_look(const char *root);

#endif
