/* SPDX-License-Identifier: BSD-3-Clause */
/* Powers for Tait's equation of state. The C library's have other last bits on other machines. */
#include "sim/state.h"

static const double INVERSE[] = {0,        1.0,      1.0 / 2,  1.0 / 3,  1.0 / 4,  1.0 / 5,  1.0 / 6,  1.0 / 7,
                                 1.0 / 8,  1.0 / 9,  1.0 / 10, 1.0 / 11, 1.0 / 12, 1.0 / 13, 1.0 / 14, 1.0 / 15,
                                 1.0 / 16, 1.0 / 17, 1.0 / 18, 1.0 / 19, 1.0 / 20, 1.0 / 21};

/* ln x, x > 0: of the mantissa by the series of 2 artanh u, u = (m - 1)/(m + 1), |u| < 0.172. */
static double logarithm(double x)
{
    static const double ROOT = 0.70710678118654752;
    int exponent = 0;
    double m = x;
    if (!(m >= ROOT && m < 2 * ROOT)) {
        m = frexp(x, &exponent);
        if (m < ROOT) {
            m *= 2;
            exponent--;
        }
    }
    const double u = (m - 1) / (m + 1), u2 = u * u;
    double sum = 0;
    for (int k = 21; k >= 1; k -= 2) sum = sum * u2 + INVERSE[k];
    return 2 * u * sum + exponent * 0.69314718055994531;
}

/* e^y: of what is left beside a power of two by its series. */
static double exponential(double y)
{
    const double n = rint(y * 1.4426950408889634), r = y - n * 0.69314718055994531;
    double sum = 1;
    for (int k = 14; k >= 1; k--) sum = 1 + sum * (r * INVERSE[k]);
    return n == 0 ? sum : ldexp(sum, (int)n);
}

double state_power(double x, double exponent)
{
    if (!(x > 0)) return x == 0 ? 0 : NAN;
    if (!(x < INFINITY)) return x;
    if (exponent == 7) { /* of most liquids */
        const double x2 = x * x, x4 = x2 * x2;
        return x4 * x2 * x;
    }
    return exponential(exponent * logarithm(x));
}
