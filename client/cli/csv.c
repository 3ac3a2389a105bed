/* SPDX-License-Identifier: BSD-3-Clause */
/* Tables for other programs. */
#include "client/cli/csv.h"
#include "client/cli/output.h"
#include <math.h>

void csv_heading(FILE *out, const char *name, size_t k, size_t n, const char *unit)
{
    fputs(name, out);
    if (n > 1 && n <= 3) fprintf(out, "_%c", "xyz"[k]);
    else if (n > 1) fprintf(out, "_%zu", k);
    if (*output_unit(unit)) fprintf(out, " [%s]", unit);
}

void csv_number(FILE *out, double value)
{
    if (!isnan(value)) fprintf(out, "%.17g", value);
}
