/* SPDX-License-Identifier: BSD-3-Clause */
/* Formulas of a case, as in "0.1*sin(2*pi*x)" or "y < 1 and x < 2": expressions of Lua with mathematics and nothing else. */
#ifndef SIM_FORMULA_H
#define SIM_FORMULA_H

#include <meniscus/case.h>
#include <stdbool.h>

typedef struct Formula Formula;

/* Is it a word of the language, such as "and"? */
bool formula_is_word(const char *name);

/* What a name means in formulas already, as in "a function of formulas", so that no constant can have it; NULL: nothing. */
const char *formula_reserved(const char *name);

/* Compile text.
 *  variables  NULL-terminated names that formula_eval() gives values to
 *  constants  [n] named formulas, each of the ones before it
 * MNS_OK; MNS_E_INVALID if it is no expression, uses an unknown name, or runs too long; MNS_E_MEMORY. */
MnsStatus formula_new(const char *text, const char *const *variables, const MnsConstant *constants, size_t n,
                      Formula **ret, MnsError *error);

/* Its value where the variables have these values; 1 and 0 for true and false, NAN if it fails there, as it does where it is
 * true or false and was a number when it was compiled, or the other way round. One caller at a time for each formula. */
double formula_eval(const Formula *formula, const double *values);

/* Why formula_eval() failed for the first time; NULL if it never did. Borrowed. */
const char *formula_failure(const Formula *formula);

/* Does it use no variable, so that its value is the same anywhere? */
bool formula_is_constant(const Formula *formula);

/* Let it be a number here, and true or false there. */
void formula_mix(Formula *formula);

/* Whether it gave true or false, not a number, when it was compiled. */
bool formula_is_condition(const Formula *formula);

void formula_free(Formula *formula);

/* One formula for up to `threads` callers at a time; as formula_new(). */
typedef struct FormulaTeam {
    int n;
    Formula **member; /* [n] */
    bool shared;      /* the only one is a constant, which anybody may read */
} FormulaTeam;

MnsStatus formula_team_init(FormulaTeam *team, int threads, const char *text, const char *const *variables,
                            const MnsConstant *constants, size_t n, MnsError *error);
void formula_team_done(FormulaTeam *team);

/* That of thread k, counted from 0. */
static inline const Formula *formula_of(const FormulaTeam *team, int k)
{
    return team->member[team->shared ? 0 : k];
}

/* As formula_failure(), of any of them. */
const char *formula_team_failure(const FormulaTeam *team);
void formula_team_forget(FormulaTeam *team); /* as if none had */

#endif
