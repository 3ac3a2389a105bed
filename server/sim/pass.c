/* SPDX-License-Identifier: BSD-3-Clause */
/* Run a pass. Each particle writes only its own sums, so no order of threads can change a bit. */
#include "sim/pass.h"

enum { CHUNK_ROWS = 256, CHUNK_LOCAL = 4096 };

void local_run(const Local *local, Particles *s, const Model *model, int threads)
{
    if (local->whole) local->whole(s, model, threads);
    for (int g = 0; g < GROUPS && local->apply; g++) {
        if (!(local->on & 1u << g)) continue;
        const size_t first = s->begin[g], last = s->begin[g + 1];
#pragma omp parallel for schedule(static) num_threads(threads)
        for (size_t k = first; k < last; k += CHUNK_LOCAL)
            local->apply(s, model, k, k + CHUNK_LOCAL < last ? k + CHUNK_LOCAL : last);
    }
    particles_changed(s, local->on, local->writes);
}

/* The terms of a pass that have something to do for a group; returns how many. */
static int terms_for(const Pass *pass, int group, const Model *model, const Term *terms[static PASS_TERMS_MAX])
{
    int n = 0;
    for (int k = 0; k < PASS_TERMS_MAX && pass->terms[k]; k++) {
        const Term *term = pass->terms[k];
        if (term->on & 1u << group && (!term->needed || term->needed(model))) terms[n++] = term;
    }
    return n;
}

static void rows_each(const Term *const *terms, int n_terms, int group, Particles *s, Neighbours *nb,
                      const Model *model, int threads)
{
    const size_t first = s->begin[group], last = s->begin[group + 1];
    unsigned needs = 0;
    for (int k = 0; k < n_terms; k++) needs |= terms[k]->needs;
    neighbours_refresh(nb, s, model, needs);
    const RowPlan plan = row_plan(nb, s, model, needs, nb->marked >> group & 1 ? ROW_MARKED : ROW_LISTED);
#pragma omp parallel num_threads(threads)
    {
        Row row;
#pragma omp for schedule(dynamic, CHUNK_ROWS)
        for (size_t i = first; i < last; i++) {
            row_build(&row, &plan, i);
            for (int k = 0; k < n_terms; k++) term_row(terms[k], &row, s, model);
        }
    }
    nb->marked |= 1u << group;
    for (int k = 0; k < n_terms; k++) particles_changed(s, 1u << group, terms[k]->writes);
}

void pass_run(const Pass *pass, Particles *s, Neighbours *nb, const Model *model, int threads)
{
    for (int k = 0; k < PASS_LOCALS_MAX && pass->before[k]; k++) local_run(pass->before[k], s, model, threads);
    for (int g = 0; g < GROUPS; g++) {
        const Term *terms[PASS_TERMS_MAX];
        const int n = terms_for(pass, g, model, terms);
        if (n > 0) rows_each(terms, n, g, s, nb, model, threads);
    }
    for (int k = 0; k < PASS_LOCALS_MAX && pass->after[k]; k++) local_run(pass->after[k], s, model, threads);
}
