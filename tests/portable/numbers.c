/* SPDX-License-Identifier: BSD-3-Clause */
/* Formulas that are plain numbers, where there is no Lua: in place of server/sim/formula.c. */
#include "sim/formula.h"
#include <stdlib.h>

struct Formula {
    double value;
};

MnsStatus formula_new(const char *text, const char *const *variables, const MnsConstant *constants, size_t n,
                      Formula **ret, MnsError *error)
{
    (void)variables, (void)constants, (void)n;
    char *end;
    Formula *f = malloc(sizeof *f);
    if (!f) return mns_fail(error, MNS_E_MEMORY, "no memory for a formula");
    f->value = strtod(text, &end);
    if (!*end) {
        *ret = f;
        return MNS_OK;
    }
    free(f);
    return mns_fail(error, MNS_E_INVALID, "\"%s\" is not a number", text);
}

double formula_eval(const Formula *formula, const double *values)
{
    (void)values;
    return formula->value;
}

const char *formula_failure(const Formula *formula)
{
    (void)formula;
    return NULL;
}

void formula_mix(Formula *formula)
{
    (void)formula;
}

bool formula_is_condition(const Formula *formula)
{
    (void)formula;
    return false;
}

void formula_free(Formula *formula)
{
    free(formula);
}

MnsStatus formula_team_init(FormulaTeam *team, int threads, const char *text, const char *const *variables,
                            const MnsConstant *constants, size_t n, MnsError *error)
{
    (void)threads;
    *team = (FormulaTeam){.n = 1, .member = malloc(sizeof *team->member)};
    if (!team->member) return mns_fail(error, MNS_E_MEMORY, "no memory for a formula");
    const MnsStatus status = formula_new(text, variables, constants, n, team->member, error);
    if (status) {
        free(team->member);
        *team = (FormulaTeam){0};
    }
    return status;
}

void formula_team_done(FormulaTeam *team)
{
    for (int k = 0; k < team->n; k++) formula_free(team->member[k]);
    free(team->member);
    *team = (FormulaTeam){0};
}

const char *formula_team_failure(const FormulaTeam *team)
{
    (void)team;
    return NULL;
}

void formula_team_forget(FormulaTeam *team)
{
    (void)team;
}
