/* SPDX-License-Identifier: BSD-3-Clause */
/* Round numbers for axes and colour bars, and their spelling. */
#ifndef CLI_RENDER_TICKS_H
#define CLI_RENDER_TICKS_H

#include <stddef.h>

enum { TICKS_MOST = 32 };

typedef struct Ticks {
    int n; /* at least 1 */
    double value[TICKS_MOST];
    double step;  /* 1, 2 or 5 times a power of ten                         */
    int exponent; /* labels show value / 10^exponent; 0 for common sizes    */
    char label[TICKS_MOST][24];
} Ticks;

/* At most `most` (2 to TICKS_MOST - 1) multiples of a round step within [lo, hi], lo < hi, both finite. */
Ticks ticks_make(double lo, double hi, int most);

/* A physical unit as print has it: "kg/m^3" becomes "kg/m³". */
void unit_print(const char *unit, size_t size, char text[]);

/* Ten to the power of exponent, as print has it. */
void power_print(int exponent, size_t size, char text[]);

#endif
