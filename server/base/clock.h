/* SPDX-License-Identifier: BSD-3-Clause */
/* Wall-clock time that never jumps. */
#ifndef BASE_CLOCK_H
#define BASE_CLOCK_H

/* Seconds since some moment in the past. */
double clock_now(void);

#endif
