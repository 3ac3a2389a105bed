/* SPDX-License-Identifier: BSD-3-Clause */
/* What there is where there are no libraries. In place of server/sim/formula.c, formulas that are plain numbers, without Lua. MPFR, which is asked
 * where a function cannot be rounded by less, is not there either: who asks it ends the program. */
#include "sim/formula.h"
#include <stdio.h>
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

const char *formula_reserved(const char *name)
{
    (void)name;
    return NULL;
}

bool formula_is_constant(const Formula *formula)
{
    (void)formula;
    return true;
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
    *team = (FormulaTeam){.n = 1, .shared = true, .member = malloc(sizeof *team->member)};
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

#define NO_MPFR(name)                                                                                                  \
    void mpfr_##name(void);                                                                                            \
    void mpfr_##name(void)                                                                                             \
    {                                                                                                                  \
        fputs("there is no mpfr_" #name "() here\n", stderr);                                                          \
        abort();                                                                                                       \
    }
NO_MPFR(free_cache2)
NO_MPFR(set_d)
NO_MPFR(get_d)
NO_MPFR(sin)
NO_MPFR(cos)
NO_MPFR(tan)
NO_MPFR(asin)
NO_MPFR(acos)
NO_MPFR(atan)
NO_MPFR(atan2)
NO_MPFR(exp)
NO_MPFR(log)
NO_MPFR(log2)
NO_MPFR(log10)
NO_MPFR(cbrt)
NO_MPFR(pow)
