/* SPDX-License-Identifier: BSD-3-Clause */
/* Tables for other programs: one line of headings with units, then a line for each row. The same numbers are the same table, whichever command
 * writes it. */
#ifndef CLI_CSV_H
#define CLI_CSV_H

#include <stddef.h>
#include <stdio.h>

/* Component k of n, as in "velocity_y [m/s]". */
void csv_heading(FILE *out, const char *name, size_t k, size_t n, const char *unit);

/* All digits that it takes to lose nothing; nothing where there is no number. */
void csv_number(FILE *out, double value);

#endif
