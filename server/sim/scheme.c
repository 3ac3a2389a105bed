/* SPDX-License-Identifier: BSD-3-Clause */
/* The table of schemes, and what it says of itself. */
#include "sim/scheme.h"
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static const Scheme *const SCHEMES[] = {&scheme_riemann, &scheme_dissipation, &scheme_interfacial,
                                        &scheme_incompressible, &scheme_differences};
enum { N_SCHEMES = sizeof SCHEMES / sizeof *SCHEMES };

const Scheme *scheme_find(const char *name)
{
    for (size_t k = 0; k < N_SCHEMES; k++)
        if (strcmp(SCHEMES[k]->name, name) == 0) return SCHEMES[k];
    return NULL;
}

static Fields written(const Local *const *locals, const Model *model)
{
    Fields fields = 0;
    for (int k = 0; k < PASS_LOCALS_MAX && locals[k]; k++)
        if (local_needed(locals[k], model)) fields |= locals[k]->writes;
    return fields;
}

static Fields all_fields(const Scheme *scheme, const Model *model)
{
    Fields fields = scheme->state | scheme->integrator->works;
    for (size_t k = 0; k < model->n_walls; k++)
        if (model->wall[k].has_belt) fields |= FIELD(BELT);
    if (scheme->derive) fields |= scheme->derive->writes;
    for (int p = 0; p < SCHEME_PASSES_MAX && scheme->rates[p].name; p++) {
        const Pass *pass = &scheme->rates[p];
        fields |= written(pass->before, model) | written(pass->after, model);
        for (int k = 0; k < PASS_TERMS_MAX && pass->terms[k]; k++)
            if (term_needed(pass->terms[k], model)) fields |= pass->terms[k]->writes;
    }
    return fields;
}

Fields scheme_fields(const Scheme *scheme, const Model *model)
{
    return all_fields(scheme, model) & ~MADE_FIELDS;
}

Fields scheme_made(const Scheme *scheme, const Model *model)
{
    return all_fields(scheme, model) & MADE_FIELDS;
}

unsigned scheme_needs(const Scheme *scheme, const Model *model)
{
    unsigned needs = 0;
    for (int p = 0; p < SCHEME_PASSES_MAX && scheme->rates[p].name; p++)
        for (int k = 0; k < PASS_TERMS_MAX && scheme->rates[p].terms[k]; k++) {
            const Term *term = scheme->rates[p].terms[k];
            if (term_needed(term, model)) needs |= term->needs;
        }
    return needs;
}

typedef struct Text {
    char *text;
    size_t used, size;
} Text;

static void add(Text *t, const char *format, ...) __attribute__((format(printf, 2, 3)));
static void add(Text *t, const char *format, ...)
{
    if (t->used + 1 >= t->size) return;
    va_list list;
    va_start(list, format);
    const int n = vsnprintf(t->text + t->used, t->size - t->used, format, list);
    va_end(list);
    if (n > 0) t->used = t->used + (size_t)n < t->size ? t->used + (size_t)n : t->size - 1;
}

static void add_rule(Text *t, const char *name, const char *source, const char *equation)
{
    add(t, "    %-22s %-25s %s\n", name, source, equation);
}

static void add_locals(Text *t, const Local *const *locals)
{
    for (int k = 0; k < PASS_LOCALS_MAX && locals[k]; k++)
        add_rule(t, locals[k]->name, locals[k]->source, locals[k]->equation);
}

const char *mns_scheme_describe(size_t k, char *text, size_t size)
{
    if (k >= N_SCHEMES) return NULL;
    const Scheme *s = SCHEMES[k];
    Text t = {text, 0, size};
    add(&t, "%s: %s\n  %s\n  step\n", s->name, s->title, s->source);
    add_rule(&t, s->integrator->name, s->integrator->source, s->integrator->equation);
    for (int q = 0; q < SCHEME_LIMITS_MAX && s->limits[q]; q++)
        add_rule(&t, s->limits[q]->name, s->limits[q]->source, s->limits[q]->equation);
    for (int p = 0; p < SCHEME_PASSES_MAX && s->rates[p].name; p++) {
        const Pass *pass = &s->rates[p];
        add(&t, "  %s\n", pass->name);
        add_locals(&t, pass->before);
        for (int q = 0; q < PASS_TERMS_MAX && pass->terms[q]; q++)
            add_rule(&t, pass->terms[q]->name, pass->terms[q]->source, pass->terms[q]->equation);
        add_locals(&t, pass->after);
    }
    return s->name;
}
