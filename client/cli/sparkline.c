/* SPDX-License-Identifier: BSD-3-Clause */
/* Values as blocks of eight heights; where the locale has no such characters, as ASCII that gets darker. */
#include "client/cli/sparkline.h"
#include <langinfo.h>
#include <locale.h>
#include <math.h>
#include <string.h>

enum { HEIGHTS = 8 };

static const char *const blocks[HEIGHTS] = {"▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
static const char *const shades[HEIGHTS] = {".", ":", "-", "=", "+", "*", "#", "%"};

void sparkline_add(History *history, double value)
{
    history->values[history->n++ % HISTORY_SIZE] = value;
}

/* A series that does not change is half high. */
static int height(double value, double least, double greatest)
{
    if (!(greatest > least)) return HEIGHTS / 2 - 1;
    const double part =
        (value / 2 - least / 2) / (greatest / 2 - least / 2); /* the difference itself may be too great */
    return (int)fmin(HEIGHTS - 1, part * HEIGHTS);
}

size_t sparkline(const History *history, size_t width, bool has_blocks, char ret[SPARKLINE_TEXT_SIZE],
                 double *ret_least, double *ret_greatest)
{
    const size_t kept = history->n < HISTORY_SIZE ? history->n : HISTORY_SIZE, n = kept < width ? kept : width;
    double least = INFINITY, greatest = -INFINITY;
    for (size_t k = history->n - n; k < history->n; k++) {
        const double value = history->values[k % HISTORY_SIZE];
        if (!isfinite(value)) continue;
        least = fmin(least, value);
        greatest = fmax(greatest, value);
    }
    *ret = '\0';
    for (size_t k = history->n - n; k < history->n; k++) {
        const double value = history->values[k % HISTORY_SIZE];
        strcat(ret, !isfinite(value) ? " " : (has_blocks ? blocks : shades)[height(value, least, greatest)]);
    }
    if (least <= greatest) {
        *ret_least = least;
        *ret_greatest = greatest;
    }
    return n;
}

bool terminal_has_blocks(void)
{
    const locale_t locale = newlocale(LC_CTYPE_MASK, "", (locale_t)0);
    if (!locale) return false;
    const bool is_utf8 = strcmp(nl_langinfo_l(CODESET, locale), "UTF-8") == 0;
    freelocale(locale);
    return is_utf8;
}
