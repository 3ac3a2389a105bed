/* SPDX-License-Identifier: BSD-3-Clause */
/* Wall-clock time that never jumps, whatever happens to the time of day. */
#include "base/clock.h"

#include <time.h>

double clock_now(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}
