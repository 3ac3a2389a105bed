/* SPDX-License-Identifier: BSD-3-Clause */
/* What cmocka lacks: comparison of numbers that says both. Includes what cmocka.h wants to have before it. */
#ifndef SUPPORT_CHECK_H
#define SUPPORT_CHECK_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* Whether there is time for more of the same, as in `make nightly` and for who runs a program by hand. */
static inline bool check_at_length(void)
{
    const char *level = getenv("MENISCUS_TESTS");
    return !level || !strcmp(level, "nightly");
}

static inline void check_close(double a, double b, double tolerance, const char *what, const char *file, int line)
{
    if (fabs(a - b) <= tolerance) return;
    print_error("%s: %.17g and %.17g differ by %.3g, allowed: %.3g\n", what, a, b, fabs(a - b), tolerance);
    _fail(file, line);
}

static inline void check_less(double a, double b, const char *what, const char *file, int line)
{
    if (a < b) return;
    print_error("%s: %.17g is not less than %.17g\n", what, a, b);
    _fail(file, line);
}

/* |a - b| <= tolerance; never true of NaN. */
#define assert_close(a, b, tolerance) check_close((a), (b), (tolerance), #a " ~ " #b, __FILE__, __LINE__)

/* a < b; never true of NaN. */
#define assert_less(a, b) check_less((a), (b), #a " < " #b, __FILE__, __LINE__)

#endif
