/* SPDX-License-Identifier: BSD-3-Clause */
/* What libFuzzer calls, and what a target says when a promise is broken. */
#ifndef TESTS_FUZZ_H
#define TESTS_FUZZ_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* A find, as a crash is. */
#define PROMISE(kept)                                                                                                  \
    do {                                                                                                               \
        if (kept) break;                                                                                               \
        fprintf(stderr, "%s:%d: broken: %s\n", __FILE__, __LINE__, #kept);                                             \
        abort();                                                                                                       \
    } while (0)

#endif
