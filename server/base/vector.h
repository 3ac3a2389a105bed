/* SPDX-License-Identifier: BSD-3-Clause */
/* Vectors of a case: always of three components, of which in two dimensions the last is not looked at. */
#ifndef BASE_VECTOR_H
#define BASE_VECTOR_H

#include <stdbool.h>

static inline bool same_vector(const double a[3], const double b[3])
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

#endif
