/* SPDX-License-Identifier: BSD-3-Clause */
/* Which fields live in bundles follows from the table of passes, as what a compiler may keep in one register follows from where it is
 * written and read. Terms may write into a bundle that their pass does not load: all others are copies that its sums rest on. Integrators
 * write between passes, where they like. */
#include "sim/home.h"
#include "base/array.h"
#include <stdlib.h>

static const Fields CANDIDATES = FIELD(X) | FIELD(V) | FIELD(P) | FIELD(NORMAL) | FIELD(GRADIENT) | FIELD(OFFSET);

/* Bundles that the rows of a group load, as bits. */
static unsigned loaded(const Pass *pass, const Model *model, int dim, int group)
{
    unsigned needs = 0, bundles = 0;
    for (int k = 0; k < PASS_TERMS_MAX && pass->terms[k]; k++)
        if (pass->terms[k]->on >> group & 1 && term_needed(pass->terms[k], model)) needs |= pass->terms[k]->needs;
    for (int k = 0; k < BUNDLES; k++)
        if (bundle_meets(dim, k) & needs) bundles |= 1u << k;
    return bundles;
}

/* Does a pass load these bundles where its terms write the field? Walls have fluid alone for neighbours. Local rules wait until rows have been
 * read (pass.c). */
static bool collides(const Pass *pass, const Model *model, int dim, int field, unsigned bundles)
{
    unsigned written = 0; /* groups, as bits */
    for (int k = 0; k < PASS_TERMS_MAX && pass->terms[k]; k++)
        if (pass->terms[k]->writes >> field & 1 && term_needed(pass->terms[k], model)) written |= pass->terms[k]->on;
    for (int g = 0; g < GROUPS; g++) {
        const unsigned read = g == GROUP_WALL ? ON_FLUID : ON_ALL;
        if (written & read && loaded(pass, model, dim, g) & bundles) return true;
    }
    return false;
}

static bool can_live(const Scheme *scheme, const Model *model, int dim, int field)
{
    const unsigned in = bundles_with(dim, field, scheme_fields(scheme, model)), needs = scheme_needs(scheme, model);
    if (!in) return false;
    for (int k = 0; k < BUNDLES; k++)
        if (in >> k & 1 && !(bundle_meets(dim, k) & needs)) return false; /* there is no such bundle */
    for (int p = 0; p < SCHEME_PASSES_MAX && scheme->rates[p].name; p++)
        if (collides(&scheme->rates[p], model, dim, field, in)) return false;
    return true;
}

Fields home_fields(const Scheme *scheme, const Model *model, int dim)
{
    Fields fields = 0;
    for (int f = 0; f < FIELDS_END; f++)
        if (CANDIDATES >> f & 1 && can_live(scheme, model, dim, f)) fields |= UINT64_C(1) << f;
    return fields & scheme_fields(scheme, model);
}

static void copy(double *to, size_t to_step, const double *from, size_t from_step, size_t n, int threads)
{
#pragma omp parallel for schedule(static) num_threads(threads)
    for (size_t i = 0; i < n; i++) to[i * to_step] = from[i * from_step];
}

void home_enter(Particles *s, const Bundles *b, const Scheme *scheme, const Model *model, int threads)
{
    const Fields fields = home_fields(scheme, model, s->dim) & s->fields & ~s->housed;
    for (int f = 0; f < FIELDS_END; f++) {
        if (!(fields >> f & 1)) continue;
        for (int d = 0; d < particles_components(s, f); d++) {
            double *array = particles_field(s, f, d), *place = bundles_place(b, f, d);
            copy(place, BUNDLE_STEP, array, 1, s->n, threads);
            free(array);
            particles_set_field(s, f, d, place);
        }
        particles_set_step(s, f, BUNDLE_STEP);
        s->housed |= UINT64_C(1) << f;
    }
}

/* Arrays for n components, all or none. */
static bool arrays_for(const Particles *s, int n, double *arrays[3], int threads)
{
    bool well = true;
    for (int d = 0; d < n; d++) well = (arrays[d] = array_new_team(s->n, sizeof **arrays, threads)) && well;
    for (int d = 0; d < n && !well; d++) {
        free(arrays[d]);
        arrays[d] = NULL;
    }
    return well;
}

bool home_leave(Particles *s, int threads)
{
    double *arrays[FIELDS_END][3] = {{NULL}};
    bool well = true;
    for (int f = 0; f < FIELDS_END; f++)
        if (s->housed >> f & 1) well = well && arrays_for(s, particles_components(s, f), arrays[f], threads);
    for (int f = 0; f < FIELDS_END; f++) {
        if (!(s->housed >> f & 1)) continue;
        for (int d = 0; d < particles_components(s, f); d++) {
            if (!well) {
                free(arrays[f][d]);
                continue;
            }
            copy(arrays[f][d], 1, particles_element(s, f, d, 0), BUNDLE_STEP, s->n, threads);
            particles_set_field(s, f, d, arrays[f][d]);
        }
        if (well) particles_set_step(s, f, 1);
    }
    if (well) s->housed = 0;
    return well;
}
