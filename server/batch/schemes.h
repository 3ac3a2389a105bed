/* SPDX-License-Identifier: BSD-3-Clause */
/* The schemes this program has, for who asks without a daemon. */
#ifndef BATCH_SCHEMES_H
#define BATCH_SCHEMES_H

#include <stdbool.h>

/* Print names and descriptions on standard output, as `meniscus schemes` does. Returns an exit code. */
int schemes_print(bool json);

#endif
