/* SPDX-License-Identifier: BSD-3-Clause */
/* What the formulas of a case may use besides their variables: dx, and the constants the case defines. */
#ifndef SIM_CONSTANTS_H
#define SIM_CONSTANTS_H

#include "sim/formula.h"

typedef struct Constants {
    size_t n;
    MnsConstant *list; /* [n]; names and values borrowed from the case */
    char dx[32];
} Constants;

MnsStatus constants_init(Constants *constants, const MnsCase *c, MnsError *error);
void constants_done(Constants *constants);

/* Compile a formula of a case, which need not be an entry of it; otherwise as formula_new(). It may be
 * a number here, and true or false there. */
MnsStatus constants_formula(const MnsCase *c, const char *text, const char *const *variables, Formula **ret,
                            MnsError *error);

#endif
