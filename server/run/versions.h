/* SPDX-License-Identifier: BSD-3-Clause */
/* What the case of a run was before it was steered: every change of it makes a version, and each of the last ones can be gone back to. */
#ifndef RUN_VERSIONS_H
#define RUN_VERSIONS_H

#include "run/document.h"
#include <stdint.h>

enum { VERSIONS_KEPT = 256 };

typedef struct Versions {
    uint64_t number;               /* of the present one; 0 without a case */
    size_t n;                      /* that are kept                        */
    Document *kept[VERSIONS_KEPT]; /* [number % VERSIONS_KEPT]: shares of the versions (number - n, number] */
} Versions;

/* The first version of a case, or of one that was gone back to by other ways: nothing before it is kept. A share is taken. */
void versions_begin(Versions *versions, uint64_t number, Document *document);

/* One more. A share is taken. */
void versions_add(Versions *versions, Document *document);

/* Forget them all. */
void versions_done(Versions *versions);

/* ret: borrowed. MNS_OK; MNS_E_NOT_FOUND: there was never such a one, or it is kept no longer. */
MnsStatus versions_find(const Versions *versions, uint64_t number, Document **ret, MnsError *error);

#endif
