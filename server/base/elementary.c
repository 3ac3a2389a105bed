/* SPDX-License-Identifier: BSD-3-Clause */
/* The elementary functions of <math.h>, rounded correctly. The C library takes other instructions on other processors, which now and
 * then round another way, and so a wall that moves by a sine, or a formula of a case, would end in other bits elsewhere. They stand
 * before the C library's in the whole program, as Lua's a^b is a call of pow().
 *
 * The extended functions err by a few units of 2^-63; where that does not settle which double is nearest, MPFR does. */
#include <math.h>
#include <mpfr.h>

static const long double MARGIN = 0x1p-60L;

/* What both ends of the interval about `near` are rounded to; NAN if they are not rounded alike, or if it is one. */
static double settled(long double near)
{
    const double low = (double)(near * (1 - MARGIN)), high = (double)(near * (1 + MARGIN));
    return low == high ? low : (double)NAN;
}

/* MPFR keeps pi and scratch memory for the thread, and they would be lost with it. */
static double taken_from(mpfr_t value)
{
    mpfr_free_cache2(MPFR_FREE_LOCAL_CACHE);
    return mpfr_get_d(value, MPFR_RNDN);
}

#define OF_ONE(name)                                                                                                   \
    static double nearest_##name(double x)                                                                             \
    {                                                                                                                  \
        const double quick = settled(name##l(x));                                                                      \
        if (!isnan(quick)) return quick;                                                                               \
        MPFR_DECL_INIT(value, 53);                                                                                     \
        mpfr_set_d(value, x, MPFR_RNDN);                                                                               \
        mpfr_##name(value, value, MPFR_RNDN);                                                                          \
        return taken_from(value);                                                                                      \
    }                                                                                                                  \
    double name(double x)                                                                                              \
    {                                                                                                                  \
        return nearest_##name(x);                                                                                      \
    }

#define OF_TWO(name)                                                                                                   \
    double name(double x, double y)                                                                                    \
    {                                                                                                                  \
        const double quick = settled(name##l(x, y));                                                                   \
        if (!isnan(quick)) return quick;                                                                               \
        MPFR_DECL_INIT(value, 53);                                                                                     \
        MPFR_DECL_INIT(other, 53);                                                                                     \
        mpfr_set_d(value, x, MPFR_RNDN);                                                                               \
        mpfr_set_d(other, y, MPFR_RNDN);                                                                               \
        mpfr_##name(value, value, other, MPFR_RNDN);                                                                   \
        return taken_from(value);                                                                                      \
    }

OF_ONE(sin)
OF_ONE(cos)
OF_ONE(tan)
OF_ONE(asin)
OF_ONE(acos)
OF_ONE(atan)
OF_ONE(exp)
OF_ONE(log)
OF_ONE(log2)
OF_ONE(log10)
OF_ONE(cbrt)
OF_TWO(atan2)
OF_TWO(pow)

/* What compilers make of a sine and a cosine of the same angle. */
void sincos(double x, double *ret_sine, double *ret_cosine)
{
    *ret_sine = nearest_sin(x);
    *ret_cosine = nearest_cos(x);
}
