/* SPDX-License-Identifier: BSD-3-Clause */
/* Fluid at rest that hangs under walls: its columns take their pressure from their own fluid beside them, wherever that is open
 * above or reaches higher, as under a plate, a low ceiling, or in the closed arm of a siphon. */
#include "sim/hydrostatic.h"
#include "sim/making.h"
#include <stdlib.h>
#include <string.h>

/* The first point of a column of fluid. */
typedef struct Top {
    size_t at[3], level;
    bool open;
} Top;

typedef struct Hanging {
    const Laying *laying;
    Top *tops; /* [n] */
    size_t n;
    size_t (*settled)[3]; /* [n] of those whose columns have their final pressure */
    size_t n_settled, spread;
    uint8_t *done; /* [fluid particles] whether their pressure is final */
} Hanging;

/* One point on along d. False beyond the end of the lattice. */
static bool step(const Laying *l, size_t at[3], int d, int by, bool around)
{
    const size_t n = l->lattice->n[d], end = by < 0 ? 0 : n - 1;
    if (at[d] != end) at[d] += (size_t)by;
    else if (around && l->sim->model.period[d] > 0) at[d] = n - 1 - end;
    else return false;
    return true;
}

/* One point up or down the column. */
static bool climb(const Laying *l, size_t at[3])
{
    return step(l, at, l->axis, l->down ? 1 : -1, false);
}

static bool descend(const Laying *l, size_t at[3])
{
    return step(l, at, l->axis, l->down ? -1 : 1, false);
}

static const LatticeRun *run_at(const Laying *l, const size_t at[3])
{
    return lattice_run(&l->lattice->row[at[2] * l->lattice->n[1] + at[1]], at[0]);
}

static size_t particle_at(const LatticeRun *run, const size_t at[3])
{
    return run->at + at[0] - run->first;
}

/* Add to the pressure of the column below its top, which is final then. */
static void settle(Hanging *h, const size_t top[3], double difference)
{
    const Laying *l = h->laying;
    size_t at[3];
    memcpy(at, top, sizeof at);
    memcpy(h->settled[h->n_settled++], top, sizeof at);
    for (const LatticeRun *run = run_at(l, at); is_fluid(l, run); run = run_at(l, at)) {
        const size_t i = particle_at(run, at);
        l->sim->s.p[i] += difference;
        h->done[i] = 1;
        if (!descend(l, at)) break;
    }
}

/* The column at a point is as high in pressure there as particle i beside it. */
static void settle_beside(Hanging *h, const size_t at[3], size_t i, size_t k)
{
    const double *p = h->laying->sim->s.p;
    size_t top[3], up[3];
    memcpy(top, at, sizeof top);
    memcpy(up, at, sizeof up);
    while (climb(h->laying, up) && is_fluid(h->laying, run_at(h->laying, up))) memcpy(top, up, sizeof top);
    settle(h, top, p[i] - p[k]);
}

/* Columns that have a point of the same fluid beside one of this column follow it. */
static void spread(Hanging *h, const size_t top[3])
{
    const Laying *l = h->laying;
    size_t at[3];
    memcpy(at, top, sizeof at);
    for (const LatticeRun *run = run_at(l, at); is_fluid(l, run); run = run_at(l, at)) {
        for (int side = 0; side < 2 * l->sim->model.dim; side++) {
            size_t beside[3];
            memcpy(beside, at, sizeof beside);
            if (side / 2 == l->axis || !step(l, beside, side / 2, side % 2 ? 1 : -1, true)) continue;
            const LatticeRun *other = run_at(l, beside);
            if (!other || other->weighs_as != run->weighs_as || h->done[particle_at(other, beside)]) continue;
            settle_beside(h, beside, particle_at(run, at), particle_at(other, beside));
        }
        if (!descend(l, at)) break;
    }
}

static MnsStatus spread_all(Hanging *h, MnsError *error)
{
    MnsStatus status = MNS_OK;
    while (h->spread < h->n_settled && !status) {
        spread(h, h->settled[h->spread++]);
        status = making_goes_on(&h->laying->sim->making, error);
    }
    return status;
}

static size_t level_of(const Laying *l, const size_t at[3])
{
    return l->down ? l->lattice->n[l->axis] - 1 - at[l->axis] : at[l->axis];
}

static void find_tops_in(Hanging *h, size_t row, const LatticeRun *run)
{
    const Laying *l = h->laying;
    for (size_t q = run->first; q < (size_t)run->first + run->n; q++) {
        Top top = {.at = {q, row % l->lattice->n[1], row / l->lattice->n[1]}};
        size_t up[3];
        memcpy(up, top.at, sizeof up);
        const LatticeRun *over = climb(l, up) ? run_at(l, up) : NULL;
        if (is_fluid(l, over)) continue;
        top.open = !over;
        top.level = level_of(l, top.at);
        h->tops[h->n++] = top;
    }
}

static void find_tops(Hanging *h)
{
    const Lattice *lattice = h->laying->lattice;
    for (size_t r = 0; r < lattice->rows; r++)
        for (size_t k = 0; k < lattice->row[r].n; k++)
            if (is_fluid(h->laying, &lattice->row[r].runs[k])) find_tops_in(h, r, &lattice->row[r].runs[k]);
}

/* What is open first, then from the highest to the lowest; of two at one level the one that comes first in the lattice. */
static int compare_tops(const void *a, const void *b)
{
    const Top *one = a, *other = b;
    if (one->open != other->open) return one->open ? -1 : 1;
    if (!one->open && one->level != other->level) return one->level < other->level ? -1 : 1;
    for (int d = 2; d >= 0; d--)
        if (one->at[d] != other->at[d]) return one->at[d] < other->at[d] ? -1 : 1;
    return 0;
}

static bool same_rank(const Top *a, const Top *b)
{
    return a->open ? b->open : !b->open && a->level == b->level;
}

/* Columns that nothing has reached begin with zero, all of one level at once, and those beside them follow. */
static MnsStatus settle_all(Hanging *h, MnsError *error)
{
    MnsStatus status = MNS_OK;
    find_tops(h);
    qsort(h->tops, h->n, sizeof *h->tops, compare_tops);
    for (size_t k = 0; k < h->n && !status;) {
        const Top *first = &h->tops[k];
        for (; k < h->n && same_rank(first, &h->tops[k]); k++) {
            const size_t *at = h->tops[k].at;
            if (!h->done[particle_at(run_at(h->laying, at), at)]) settle(h, at, 0);
        }
        status = spread_all(h, error);
    }
    return status;
}

MnsStatus hydrostatic_hang(const Laying *l, size_t n_tops, MnsError *error)
{
    Hanging h = {.laying = l};
    MnsStatus status = MNS_OK;
    h.tops = malloc(n_tops * sizeof *h.tops);
    h.settled = malloc(n_tops * sizeof *h.settled);
    h.done = calloc(particles_fluid(&l->sim->s), 1);
    if (h.tops && h.settled && h.done) status = settle_all(&h, error);
    else status = mns_fail(error, MNS_E_MEMORY, "no memory for the pressure of %zu columns", n_tops);
    free(h.tops);
    free(h.settled);
    free(h.done);
    return status;
}
