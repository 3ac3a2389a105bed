/* SPDX-License-Identifier: BSD-3-Clause */
/* Formulas of a case, as in "0.1*sin(2*pi*x)" or "y < 1 and x < 2": expressions of Lua with mathematics and nothing else. */
#ifndef SIM_FORMULA_H
#define SIM_FORMULA_H

#include <meniscus/case.h>

typedef struct Formula Formula;

/* Compile text.
 *  variables  NULL-terminated names that formula_eval() gives values to
 *  constants  [n] named formulas, each of the ones before it
 * MNS_OK; MNS_E_INVALID if it is no expression, uses an unknown name, or runs too long; MNS_E_MEMORY. */
MnsStatus formula_new(const char *text, const char *const *variables, const MnsConstant *constants, size_t n,
                      Formula **ret, MnsError *error);

/* Its value where the variables have these values; 1 and 0 for true and false, NAN if it fails there.
 * One caller at a time for each formula. */
double formula_eval(const Formula *formula, const double *values);

/* Whether it gave true or false, not a number, when it was compiled. */
bool formula_is_condition(const Formula *formula);

void formula_free(Formula *formula);

#endif
