/* SPDX-License-Identifier: BSD-3-Clause */
/* The constants that the formulas of a case may use. */
#include "sim/constants.h"
#include <stdio.h>
#include <stdlib.h>

MnsStatus constants_init(Constants *constants, const MnsCase *c, MnsError *error)
{
    *constants = (Constants){.n = c->n_constants + 1, .list = calloc(c->n_constants + 1, sizeof *constants->list)};
    if (!constants->list) return mns_fail(error, MNS_E_MEMORY, "no memory for constants");
    snprintf(constants->dx, sizeof constants->dx, "%.17g", c->reference_length / c->resolution);
    static char dx[] = "dx";
    constants->list[0] = (MnsConstant){dx, constants->dx};
    for (size_t k = 0; k < c->n_constants; k++) constants->list[k + 1] = c->constants[k];
    return MNS_OK;
}

void constants_done(Constants *constants)
{
    free(constants->list);
    constants->list = NULL;
}

MnsStatus constants_formula(const MnsCase *c, const char *text, const char *const *variables, Formula **ret,
                            MnsError *error)
{
    Constants constants;
    MnsStatus status = constants_init(&constants, c, error);
    if (!status) status = formula_new(text, variables, constants.list, constants.n, ret, error);
    if (!status) formula_mix(*ret);
    constants_done(&constants);
    return status;
}
