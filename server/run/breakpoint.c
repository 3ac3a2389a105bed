/* SPDX-License-Identifier: BSD-3-Clause */
/* Where a run shall pause. A condition measures only the probes it names. */
#include "run/breakpoint.h"

#include "sim/formula.h"
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { VARIABLES = MNS_MAX_PROBES + 2, VARIABLE_NAME = 128 };

typedef struct Watch {
    Breakpoint is;
    Formula *formula; /* NULL without a condition         */
    bool was_true;
    bool used[MNS_MAX_PROBES]; /* the probes the condition names */
} Watch;

struct Breakpoints {
    size_t n;
    Watch watch[BREAKPOINTS];
};

Breakpoints *breakpoints_new(void)
{
    return calloc(1, sizeof(Breakpoints));
}

void breakpoints_free(Breakpoints *points)
{
    for (size_t k = 0; points && k < points->n; k++) formula_free(points->watch[k].formula);
    free(points);
}

static void variable_name(const char *probe, char ret[static VARIABLE_NAME])
{
    snprintf(ret, VARIABLE_NAME, "%s", probe);
    for (char *c = ret; *c; c++)
        if (*c == '.' || *c == '-') *c = '_';
}

static bool is_word(char c)
{
    return isalnum((unsigned char)c) || c == '_';
}

/* Is the word in the text, whole? */
static bool names(const char *text, const char *word)
{
    const size_t n = strlen(word);
    for (const char *at = text; n && (at = strstr(at, word)); at++)
        if ((at == text || !is_word(at[-1])) && !is_word(at[n])) return true;
    return false;
}

/* Compile the condition of a watch; its variables are t, step and one for each probe. */
static MnsStatus compile(Watch *watch, const MnsCase *c, MnsError *error)
{
    char(*words)[VARIABLE_NAME] = calloc(VARIABLES, sizeof *words);
    if (!words) return mns_fail(error, MNS_E_MEMORY, "no memory for a breakpoint");
    const char *variables[VARIABLES + 1] = {"t", "step"};
    for (size_t k = 0; k < c->n_probes; k++) {
        variable_name(c->probes[k].name, words[k]);
        variables[k + 2] = words[k];
        watch->used[k] = names(watch->is.condition, words[k]);
    }
    const MnsStatus status =
        formula_new(watch->is.condition, variables, c->constants, c->n_constants, &watch->formula, error);
    free(words);
    return status;
}

static Watch *find(Breakpoints *points, const char *name)
{
    for (size_t k = 0; k < points->n; k++)
        if (!strcmp(points->watch[k].is.name, name)) return &points->watch[k];
    return NULL;
}

MnsStatus breakpoints_set(Breakpoints *points, const MnsCase *c, const Breakpoint *point, MnsError *error)
{
    if (!point->name[0]) return mns_fail_at(error, MNS_E_INVALID, "name", "a breakpoint needs a name");
    if (isnan(point->t) && !point->step && !point->condition[0])
        return mns_fail(error, MNS_E_INVALID, "a breakpoint needs a time, a step or a condition; \"%s\" has none",
                        point->name);
    Watch *old = find(points, point->name);
    if (!old && points->n == BREAKPOINTS)
        return mns_fail(error, MNS_E_LIMIT, "there are %d breakpoints already; remove one first", BREAKPOINTS);
    Watch watch = {.is = *point};
    const MnsStatus status = point->condition[0] ? compile(&watch, c, error) : MNS_OK;
    if (status) return status;
    if (old) formula_free(old->formula);
    else old = &points->watch[points->n++];
    *old = watch;
    return MNS_OK;
}

MnsStatus breakpoints_remove(Breakpoints *points, const char *name, MnsError *error)
{
    Watch *watch = find(points, name);
    if (!watch) return mns_fail(error, MNS_E_NOT_FOUND, "there is no breakpoint \"%.60s\"", name);
    formula_free(watch->formula);
    *watch = points->watch[--points->n];
    return MNS_OK;
}

void breakpoints_list(const Breakpoints *points, Breakpoint ret[static BREAKPOINTS], size_t *ret_n)
{
    for (size_t k = 0; k < points->n; k++) ret[k] = points->watch[k].is;
    *ret_n = points->n;
}

static bool condition_holds(const Watch *watch, const MnsSim *sim)
{
    const MnsProgress now = mns_sim_progress(sim);
    double values[VARIABLES] = {now.t, (double)now.step};
    const size_t n = mns_sim_case(sim)->n_probes;
    for (size_t k = 0; k < n; k++)
        if (watch->used[k]) values[k + 2] = mns_sim_probe(sim, k);
    return formula_eval(watch->formula, values) > 0;
}

static bool reached(Watch *watch, const MnsSim *sim, MnsProgress before)
{
    const MnsProgress now = mns_sim_progress(sim);
    if (watch->is.step && before.step < watch->is.step && now.step >= watch->is.step) return true;
    if (before.t < watch->is.t && now.t >= watch->is.t) return true;
    if (!watch->formula) return false;
    const bool was_true = watch->was_true;
    watch->was_true = condition_holds(watch, sim);
    return watch->was_true && !was_true;
}

const Breakpoint *breakpoints_reached(Breakpoints *points, const MnsSim *sim, MnsProgress before)
{
    const Breakpoint *first = NULL;
    for (size_t k = 0; k < points->n; k++)
        if (reached(&points->watch[k], sim, before) && !first) first = &points->watch[k].is;
    return first;
}
