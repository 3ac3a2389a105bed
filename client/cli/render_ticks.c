/* SPDX-License-Identifier: BSD-3-Clause */
/* Round numbers for axes and colour bars, and their spelling. */
#include "client/cli/render_ticks.h"
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

static const char *const raised[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};

/* The smallest of 1, 2, 5 times a power of ten that is at least `least`. */
static double round_step(double least)
{
    const double power = pow(10, floor(log10(least)));
    static const double nice[] = {1, 2, 5, 10};
    for (size_t k = 0; k < 3; k++)
        if (nice[k] * power >= least * (1 - 1e-9)) return nice[k] * power;
    return 10 * power;
}

/* Labels of five digits and more, or with four zeros behind the point, are read better with a power of ten in front. */
static int common_exponent(double largest, double step)
{
    if (largest >= 1e5 || step < 1e-4) return (int)floor(log10(largest) + 1e-9);
    return 0;
}

static void print_label(double value, int decimals, size_t size, char *label)
{
    char digits[20];
    snprintf(digits, sizeof digits, "%.*f", decimals, fabs(value));
    const bool zero = strspn(digits, "0.") == strlen(digits);
    snprintf(label, size, "%s%s", value < 0 && !zero ? "−" : "", digits);
}

static void print_labels(Ticks *t, double lo, double hi)
{
    t->exponent = common_exponent(fmax(fabs(lo), fabs(hi)), t->step);
    const double scale = pow(10, t->exponent), step = t->step / scale;
    const int decimals = step >= 1 - 1e-9 ? 0 : (int)ceil(-log10(step) - 1e-9);
    for (int k = 0; k < t->n; k++)
        print_label(t->value[k] / scale, decimals < 12 ? decimals : 12, sizeof t->label[k], t->label[k]);
}

/* How many multiples of step lie in the range. */
static double count(double lo, double hi, double step)
{
    return floor(hi / step) - ceil(lo / step) + 1;
}

Ticks ticks_make(double lo, double hi, int most)
{
    Ticks t = {0};
    if (most > TICKS_MOST - 1) most = TICKS_MOST - 1;
    if (most < 2) most = 2;
    const double slack = 1e-9 * (hi - lo), from = lo - slack, to = hi + slack;
    t.step = round_step((hi - lo) / most);
    while (count(from, to, t.step) > most) t.step = round_step(t.step * 1.5);
    /* A step of 5 may jump over a range of 4; then two multiples of 2 are within. */
    if (count(from, to, t.step) < 1) t.step = round_step(t.step / 3);
    for (double k = ceil(from / t.step); k <= floor(to / t.step) && t.n < TICKS_MOST; k++)
        t.value[t.n++] = k == 0 ? 0 : k * t.step;
    print_labels(&t, lo, hi);
    return t;
}

static void append(char *text, size_t size, const char *more)
{
    const size_t length = strlen(text);
    if (length + strlen(more) < size) strcpy(text + length, more);
}

void unit_print(const char *unit, size_t size, char text[])
{
    text[0] = '\0';
    for (const char *c = unit; *c; c++) {
        if (*c == '^') {
            if (c[1] == '-') append(text, size, "⁻"), c++;
            while (c[1] >= '0' && c[1] <= '9') append(text, size, raised[*++c - '0']);
        } else {
            append(text, size, *c == '*' ? "·" : (const char[]){*c, '\0'});
        }
    }
}

void power_print(int exponent, size_t size, char text[])
{
    char digits[16];
    text[0] = '\0';
    snprintf(digits, sizeof digits, "%d", exponent);
    append(text, size, "10");
    for (const char *c = digits; *c; c++) append(text, size, *c == '-' ? "⁻" : raised[*c - '0']);
}
