/* SPDX-License-Identifier: BSD-3-Clause */
/* Words of case files: names of enum values, numbers as text in any locale, and guesses at what a wrong word meant. */
#include "common/case/words.h"
#include <ctype.h>
#include <locale.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LONGEST = 40 }; /* no name is longer; a longer wrong word is like none of them */

const char *words_from_enum(const char *name, char word[static 64])
{
    size_t n = 0;
    for (; name[n] && n < 63; n++) word[n] = name[n] == '_' ? '-' : (char)tolower((unsigned char)name[n]);
    word[n] = 0;
    return word;
}

/* Least number of letters to insert, drop, exchange or swap with their neighbour (optimal string alignment). */
static size_t distance(const char *a, const char *b)
{
    const size_t n = strlen(a), m = strlen(b);
    size_t d[LONGEST + 1][LONGEST + 1];
    if (n > LONGEST || m > LONGEST) return LONGEST;
    for (size_t i = 0; i <= n; i++) d[i][0] = i;
    for (size_t j = 0; j <= m; j++) d[0][j] = j;
    for (size_t i = 1; i <= n; i++)
        for (size_t j = 1; j <= m; j++) {
            size_t least = d[i - 1][j - 1] + (a[i - 1] != b[j - 1]);
            if (d[i - 1][j] + 1 < least) least = d[i - 1][j] + 1;
            if (d[i][j - 1] + 1 < least) least = d[i][j - 1] + 1;
            const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
            if (swapped && d[i - 2][j - 2] + 1 < least) least = d[i - 2][j - 2] + 1;
            d[i][j] = least;
        }
    return d[n][m];
}

/* How many letters are wrong in the likeliest of them; SIZE_MAX: none is like it. */
static size_t least_wrong(const char *const *names, size_t n, const char *wrong)
{
    const size_t bound = strlen(wrong) < 6 ? 2 : strlen(wrong) / 3 + 1; /* one letter, or every third */
    size_t least = SIZE_MAX;
    for (size_t k = 0; k < n; k++) {
        const size_t d = distance(wrong, names[k]);
        if (d < bound && d < least && d < strlen(names[k])) least = d;
    }
    return least;
}

/* "did you mean "a" or "b"? Allowed: ", with all that are as like it as the likeliest, up to LIKE; how long it is. */
static size_t suggest(const char *const *names, size_t n, const char *wrong, char *text, size_t size)
{
    enum { LIKE = 3 };
    const size_t least = least_wrong(names, n, wrong);
    size_t used = 0, found = 0;
    for (size_t k = 0; k < n && found < LIKE && least < SIZE_MAX && used < size; k++) {
        if (distance(wrong, names[k]) != least) continue;
        used += (size_t)snprintf(text + used, size - used, "%s \"%s\"", found++ ? " or" : "did you mean", names[k]);
    }
    if (used < size) used += (size_t)snprintf(text + used, size - used, found ? "? Allowed: " : "allowed: ");
    return used;
}

void words_suggest(const char *const *names, size_t n, const char *wrong, const char *all, char *text, size_t size)
{
    const char *open = all ? " (" : "", *close = all ? " lists all)" : "";
    const size_t more = sizeof ", and 999 more" + strlen(open) + strlen(all ? all : "") + strlen(close);
    size_t used = suggest(names, n, wrong, text, size);
    for (size_t k = 0; k < n && used < size; k++) {
        const size_t room = k + 1 < n ? more : 1;
        if (k && used + 2 + strlen(names[k]) + room > size) {
            snprintf(text + used, size - used, ", and %zu more%s%s%s", n - k, open, all ? all : "", close);
            return;
        }
        used += (size_t)snprintf(text + used, size - used, "%s%s", k ? ", " : "", names[k]);
    }
}

static const char *digits(const char *text)
{
    while (isdigit((unsigned char)*text)) text++;
    return text;
}

/* [+-] digits [. digits] [e [+-] digits], with at least one digit before the exponent and one in it. */
static bool is_decimal(const char *text)
{
    const char *p = text + (*text == '+' || *text == '-');
    const char *end = digits(p);
    size_t n = (size_t)(end - p);
    if (*end == '.') {
        p = end + 1;
        end = digits(p);
        n += (size_t)(end - p);
    }
    if (!n) return false;
    if (*end == 'e' || *end == 'E') {
        p = end + 1;
        p += *p == '+' || *p == '-';
        end = digits(p);
        if (end == p) return false;
    }
    return !*end;
}

bool words_to_number(const char *text, double *ret)
{
    const char *bare = text + (*text == '+' || *text == '-');
    if (!strcmp(bare, ".inf") || !strcmp(bare, "inf")) {
        *ret = *text == '-' ? -(double)INFINITY : (double)INFINITY;
        return true;
    }
    if (!is_decimal(text)) return false;
    const locale_t plain = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    if (!plain) return false;
    *ret = strtod_l(text, NULL, plain);
    freelocale(plain);
    return true;
}

/* A foreign locale's decimal comma is the only thing that could be wrong in what printf wrote. */
static void with_point(char *text)
{
    char *comma = strchr(text, ',');
    if (comma) *comma = '.';
}

const char *words_from_number(double value, char text[static 32])
{
    double back;
    if (isinf(value)) return strcpy(text, value < 0 ? "-.inf" : ".inf");
    if (isnan(value)) return strcpy(text, ".nan");
    for (int precision = 15; precision <= 17; precision++) {
        snprintf(text, 32, "%.*g", precision, value);
        with_point(text);
        if (words_to_number(text, &back) && back == value) break;
    }
    return text;
}
