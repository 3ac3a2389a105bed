/* SPDX-License-Identifier: BSD-3-Clause */
/* Run a pass. Each particle writes only its own sums, so no order of threads can change a bit. What a term asks its neighbours for
 * comes from bundles, which are copies, or from fields that its pass does not write: so local rules can follow the rows of a chunk
 * while these are in the cache, when other chunks have not begun. */
#include "sim/pass.h"

#include "sim/shares.h"
#include <omp.h>

enum { CHUNK_ROWS = 64, CHUNK_LOCAL = 4096 };

void local_run(const Local *local, Particles *s, const Model *model, int threads)
{
    if (!local_needed(local, model)) return;
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

/* What is done for the particles of one group, chunk by chunk. */
typedef struct Sweep {
    int n_before, n_terms, n_after;
    const Local *before[PASS_LOCALS_MAX], *after[PASS_LOCALS_MAX];
    const Term *terms[PASS_TERMS_MAX];
    const Fusion
        *fusion[LIST_KINDS + 1]; /* by kinds of neighbours, of just the terms that have to do; NULL if there is none */
    RowPlan plan;
} Sweep;

/* Local rules [first, last) that are for a group; returns how many. */
static int locals_for(const Local *const *locals, int first, int last, int group, const Local **ret)
{
    int n = 0;
    for (int k = first; k < last; k++)
        if (locals[k]->on & 1u << group) ret[n++] = locals[k];
    return n;
}

static int terms_for(const Pass *pass, int group, const Model *model, const Term **ret)
{
    int n = 0;
    for (int k = 0; k < PASS_TERMS_MAX && pass->terms[k]; k++) {
        const Term *term = pass->terms[k];
        if (term->on & 1u << group && term_needed(term, model)) ret[n++] = term;
    }
    return n;
}

/* Which terms of a pass are in a list of n, or up to NULL: a bit for each. */
static unsigned among(const Pass *pass, int n, const Term *const *list)
{
    unsigned found = 0;
    for (int k = 0; k < n && list[k]; k++)
        for (int q = 0; q < PASS_TERMS_MAX && pass->terms[q]; q++) found |= (unsigned)(pass->terms[q] == list[k]) << q;
    return found;
}

/* For particles that have neighbours of these kinds. */
static const Fusion *fusion_for(const Pass *pass, int n, const Term *const *terms, unsigned kinds, const Model *model)
{
    const Term *busy[PASS_TERMS_MAX];
    int n_busy = 0;
    for (int k = 0; k < n; k++)
        if (!terms[k]->beside || terms[k]->beside & kinds) busy[n_busy++] = terms[k];
    const unsigned wanted = among(pass, n_busy, busy);
    for (int k = 0; k < PASS_FUSIONS_MAX && pass->fusions[k]; k++) {
        const Fusion *fusion = pass->fusions[k];
        const unsigned must = among(pass, PASS_TERMS_MAX, fusion->terms),
                       may = among(pass, PASS_TERMS_MAX, fusion->also);
        if (!fusion->row[model->level][0] || !fusion_serves(fusion, kinds)) continue;
        if (fusion->needed && !fusion->needed(model)) continue;
        if ((wanted & must) == must && !(wanted & ~(must | may)) && wanted) return fusion;
    }
    return NULL;
}

const Fusion *pass_fusion(const Pass *pass, int group, unsigned kinds, const Model *model)
{
    const Term *terms[PASS_TERMS_MAX];
    const int n = terms_for(pass, group, model, terms);
    return fusion_for(pass, n, terms, kinds, model);
}

/* The local rules of a list that are needed. */
typedef struct Locals {
    int n;
    const Local *of[PASS_LOCALS_MAX];
} Locals;

static Locals needed(const Local *const *list, const Model *model)
{
    Locals locals = {0};
    for (int k = 0; k < PASS_LOCALS_MAX && list[k]; k++)
        if (local_needed(list[k], model)) locals.of[locals.n++] = list[k];
    return locals;
}

/* How many of the rules before the terms must be done before copies are made: up to the last one that copies show, or that needs all
 * particles at once. */
static int early(const Locals *before, Fields copied)
{
    int n = before->n;
    while (n > 0 && !before->of[n - 1]->whole && !(before->of[n - 1]->writes & copied)) n--;
    return n;
}

/* How many of the rules after the terms can be done chunk by chunk: up to the first one that needs all particles at once, or that writes
 * what rows read where it is. */
static int prompt(const Locals *after, Fields read)
{
    int n = 0;
    while (n < after->n && !after->of[n]->whole && !(after->of[n]->writes & read)) n++;
    return n;
}

static void rows(const Sweep *sweep, Row *row, Particles *s, const Model *model, size_t first, size_t last)
{
    for (size_t i = first; i < last; i++) {
        row_build(row, &sweep->plan, i);
        for (int k = 0; k < sweep->n_terms; k++) term_row(sweep->terms[k], row, s, model);
    }
}

/* What is not fused for some particles goes over rows, and so do nearly all terms of those that have images in a mirror. */
static void fused_rows(const Sweep *sweep, Row *row, Particles *s, const Model *model, size_t first, size_t last)
{
    const uint8_t *has = sweep->plan.nb->has;
    for (size_t i = first; i < last; i++) {
        const Fusion *fusion = sweep->fusion[has[i] & LIST_KINDS];
        if (fusion && (fusion->with_images || !(has[i] & LIST_MIRRORS)))
            fusion->row[model->level][s->dim - 2](&sweep->plan, s, i);
        else rows(sweep, row, s, model, i, i + 1);
    }
}

static void sweep_chunk(const Sweep *sweep, Row *row, Particles *s, const Model *model, size_t first, size_t last)
{
    for (int k = 0; k < sweep->n_before; k++) sweep->before[k]->apply(s, model, first, last);
    if (sweep->n_terms) fused_rows(sweep, row, s, model, first, last);
    for (int k = 0; k < sweep->n_after; k++) sweep->after[k]->apply(s, model, first, last);
}

static void sweep_all(const Sweep sweeps[GROUPS], Particles *s, const Model *model, int threads)
{
    Shares shares[GROUPS]; /* that lie together: a thread has most neighbours in its cache */
    for (int g = 0; g < GROUPS; g++) {
        const Sweep *sweep = &sweeps[g];
        const bool any = sweep->n_before + sweep->n_terms + sweep->n_after > 0;
        shares_init(&shares[g], any ? (s->begin[g + 1] - s->begin[g] + CHUNK_ROWS - 1) / CHUNK_ROWS : 0, threads);
    }
#pragma omp parallel num_threads(threads)
    {
        Row row;
        for (int g = 0; g < GROUPS; g++) {
            const size_t last = s->begin[g + 1];
            for (size_t k; shares_take(&shares[g], omp_get_thread_num(), &k);) {
                const size_t first = s->begin[g] + k * CHUNK_ROWS;
                sweep_chunk(&sweeps[g], &row, s, model, first, first + CHUNK_ROWS < last ? first + CHUNK_ROWS : last);
            }
        }
    }
}

/* Has all that served the particles of a group noted who is in reach, as rows do? What is fused need not. */
static bool noted(const Sweep *sweep)
{
    bool all = sweep->n_terms > 0;
    for (unsigned kinds = 0; kinds <= LIST_KINDS; kinds++)
        all = all && (!sweep->fusion[kinds] || sweep->fusion[kinds]->notes);
    return all;
}

/* Say what has been written, now that nobody reads the old copies any more. */
static void declare(const Sweep sweeps[GROUPS], Particles *s, Neighbours *nb)
{
    for (int g = 0; g < GROUPS; g++) {
        const Sweep *sweep = &sweeps[g];
        if (noted(sweep)) nb->marked |= 1u << g;
        for (int k = 0; k < sweep->n_before; k++) particles_changed(s, 1u << g, sweep->before[k]->writes);
        for (int k = 0; k < sweep->n_terms; k++) particles_changed(s, 1u << g, sweep->terms[k]->writes);
        for (int k = 0; k < sweep->n_after; k++) particles_changed(s, 1u << g, sweep->after[k]->writes);
    }
}

void pass_run(const Pass *pass, Particles *s, Neighbours *nb, const Model *model, int threads)
{
    Sweep sweeps[GROUPS];
    unsigned needs[GROUPS] = {0}, all = 0;
    for (int g = 0; g < GROUPS; g++) {
        sweeps[g].n_terms = terms_for(pass, g, model, sweeps[g].terms);
        for (unsigned kinds = 0; kinds <= LIST_KINDS; kinds++)
            sweeps[g].fusion[kinds] = fusion_for(pass, sweeps[g].n_terms, sweeps[g].terms, kinds, model);
        for (int k = 0; k < sweeps[g].n_terms; k++) needs[g] |= sweeps[g].terms[k]->needs;
        all |= needs[g];
    }
    const Locals before = needed(pass->before, model), after = needed(pass->after, model);
    const Fields copied = bundles_fields(&nb->bundles, all);
    const int first = early(&before, copied), last = prompt(&after, copied & s->housed);
    for (int k = 0; k < first; k++) local_run(before.of[k], s, model, threads);
    neighbours_refresh(nb, s, model, all);
    for (int g = 0; g < GROUPS; g++) {
        sweeps[g].n_before = locals_for(before.of, first, before.n, g, sweeps[g].before);
        sweeps[g].n_after = locals_for(after.of, 0, last, g, sweeps[g].after);
        sweeps[g].plan = row_plan(nb, s, model, needs[g], nb->marked >> g & 1 ? ROW_MARKED : ROW_LISTED);
    }
    sweep_all(sweeps, s, model, threads);
    declare(sweeps, s, nb);
    for (int k = last; k < after.n; k++) local_run(after.of[k], s, model, threads);
}
