/* SPDX-License-Identifier: BSD-3-Clause */
/* Which fields live in bundles follows from the table of passes, as what a compiler may keep in one register follows from where it is
 * written and read. A pass may write into a bundle that it does not load: all others are copies that its sums rest on. */
#include "sim/home.h"
#include "base/array.h"
#include <stdlib.h>

static const Fields CANDIDATES = FIELD(NORMAL) | FIELD(GRADIENT);

static bool locals_write(const Local *const *locals, int field)
{
    for (int k = 0; k < PASS_LOCALS_MAX && locals[k]; k++)
        if (locals[k]->writes >> field & 1) return true;
    return false;
}

/* Bundles that a pass loads, as bits; whether it writes a field. */
static unsigned loads(const Pass *pass, const Model *model, int dim, int field, bool *ret_writes)
{
    unsigned needs = 0, loaded = 0;
    *ret_writes = locals_write(pass->before, field) || locals_write(pass->after, field);
    for (int k = 0; k < PASS_TERMS_MAX && pass->terms[k]; k++) {
        const Term *term = pass->terms[k];
        if (term->needed && !term->needed(model)) continue;
        needs |= term->needs;
        *ret_writes = *ret_writes || term->writes >> field & 1;
    }
    for (int k = 0; k < BUNDLES; k++)
        if (bundle_meets(dim, k) & needs) loaded |= 1u << k;
    return loaded;
}

static bool can_live(const Scheme *scheme, const Model *model, int dim, int field)
{
    const unsigned in = bundles_with(dim, field), needs = scheme_needs(scheme, model);
    for (int k = 0; k < BUNDLES; k++)
        if (in >> k & 1 && !(bundle_meets(dim, k) & needs)) return false; /* there is no such bundle */
    if (needs & NEED_FLUX) return false;
    for (int p = 0; p < SCHEME_PASSES_MAX && scheme->rates[p].name; p++) {
        bool writes = false;
        const unsigned loaded = loads(&scheme->rates[p], model, dim, field, &writes);
        if (writes && loaded & in) return false;
    }
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
        for (int d = 0; d < s->dim; d++) {
            double *array = particles_field(s, f, d), *place = bundles_place(b, f, d);
            copy(place, BUNDLE_STEP, array, 1, s->n, threads);
            free(array);
            particles_set_field(s, f, d, place);
        }
        particles_set_step(s, f, BUNDLE_STEP);
        s->housed |= UINT64_C(1) << f;
    }
}

/* Arrays for a field, all or none. */
static bool arrays_for(const Particles *s, double *arrays[3], int threads)
{
    bool well = true;
    for (int d = 0; d < s->dim; d++) well = (arrays[d] = array_new_team(s->n, sizeof **arrays, threads)) && well;
    for (int d = 0; d < s->dim && !well; d++) {
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
        if (s->housed >> f & 1) well = well && arrays_for(s, arrays[f], threads);
    for (int f = 0; f < FIELDS_END; f++) {
        if (!(s->housed >> f & 1)) continue;
        for (int d = 0; d < s->dim; d++) {
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
