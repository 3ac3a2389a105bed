/* SPDX-License-Identifier: BSD-3-Clause */
/* Where a run shall pause. A condition measures only the probes it names. */
#include "run/breakpoint.h"

#include "sim/constants.h"
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* So many words fit into a condition, and Lua has room for as many variables. */
enum { WORDS = BREAKPOINT_TEXT / 2 };

typedef struct Watch {
    Breakpoint is;
    Formula *formula; /* NULL without a condition */
    bool was_true;
    size_t n, probe[WORDS]; /* the probes the condition names, in the order of its variables */
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
    if (points) breakpoints_clear(points);
    free(points);
}

void breakpoints_clear(Breakpoints *points)
{
    for (size_t k = 0; k < points->n; k++) formula_free(points->watch[k].formula);
    points->n = 0;
}

/* Words that cannot be the name of a variable, or are that of another one. */
static bool is_taken(const char *word)
{
    return !strcmp(word, "t") || !strcmp(word, "step") || formula_is_word(word);
}

/* What a condition calls a probe. Names too long for any condition are cut, and so match no word of it. */
static void variable_name(const char *probe, char ret[static BREAKPOINT_TEXT + 1])
{
    const bool prefix = isdigit((unsigned char)*probe) || is_taken(probe);
    snprintf(ret, BREAKPOINT_TEXT + 1, "%s%s", prefix ? "_" : "", probe);
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

/* Variables of a condition: t, step, and one for each probe it names. */
typedef struct Variables {
    const char *list[WORDS + 3]; /* NULL-terminated */
    char words[WORDS][BREAKPOINT_TEXT + 1];
} Variables;

/* Note the probe as one the condition names, unless another one goes by the same word. */
static MnsStatus add_probe(Watch *watch, const MnsCase *c, size_t probe, const char *word, Variables *variables,
                           MnsError *error)
{
    for (size_t k = 0; k < watch->n; k++)
        if (!strcmp(variables->words[k], word))
            return mns_fail_at(error, MNS_E_INVALID, "condition",
                               "the probes \"%.60s\" and \"%.60s\" are both called %.60s in a condition; rename one",
                               c->probes[watch->probe[k]].name, c->probes[probe].name, word);
    snprintf(variables->words[watch->n], sizeof variables->words[0], "%s", word);
    variables->list[watch->n + 2] = variables->words[watch->n];
    watch->probe[watch->n++] = probe;
    return MNS_OK;
}

/* Only the probes it names become variables: Lua has room for few, and a measurement may be as dear as a step. */
static MnsStatus compile(Watch *watch, const MnsCase *c, MnsError *error)
{
    char word[BREAKPOINT_TEXT + 1];
    MnsStatus status = MNS_OK;
    Variables *variables = calloc(1, sizeof *variables);
    if (!variables) return mns_fail(error, MNS_E_MEMORY, "no memory for a breakpoint");
    variables->list[0] = "t";
    variables->list[1] = "step";
    for (size_t k = 0; !status && k < c->n_probes; k++) {
        variable_name(c->probes[k].name, word);
        if (!names(watch->is.condition, word)) continue;
        status = add_probe(watch, c, k, word, variables, error);
    }
    if (!status) status = constants_formula(c, watch->is.condition, variables->list, &watch->formula, error);
    free(variables);
    if (status || formula_is_condition(watch->formula)) return status;
    formula_free(watch->formula);
    return mns_fail_at(error, MNS_E_INVALID, "condition",
                       "the condition must be true or false, as in \"P1 > 2e3\"; \"%.80s\" is a number",
                       watch->is.condition);
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
    double values[WORDS + 2] = {now.t, (double)now.step};
    for (size_t k = 0; k < watch->n; k++) values[k + 2] = mns_sim_probe(sim, watch->probe[k]);
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

void breakpoints_note(Breakpoints *points, const char *name, const MnsSim *sim)
{
    Watch *watch = find(points, name);
    if (watch && watch->formula) watch->was_true = condition_holds(watch, sim);
}
