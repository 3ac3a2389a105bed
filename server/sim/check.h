/* SPDX-License-Identifier: BSD-3-Clause */
/* Complaints about a case that its schemes make as well (Scheme.check). */
#ifndef SIM_CHECK_H
#define SIM_CHECK_H

#include "meniscus/case.h"
#include "sim/bounds.h"

/* A number and what case.proto allows: a case made by a C program has not been through that. */
typedef struct Bounded {
    const char *entry; /* below `at` */
    double value;
    Bounds bounds;
} Bounded;

/* MNS_E_INVALID of the first that is out of its bounds. */
MnsStatus check_bounds(const char *at, const Bounded *list, size_t n, MnsError *error);

#define CHECK_BOUNDS(at, list, error) check_bounds((at), (list), sizeof(list) / sizeof *(list), (error))

/* MNS_E_INVALID of one that this program was built without. */
MnsStatus check_solver(MnsSolver solver, const char *at, MnsError *error);

#endif
