/* SPDX-License-Identifier: BSD-3-Clause */
/* Questions about the simulation between two steps. */
#include "net/look.h"

#include "net/selection.h"
#include "run/tap.h"
#include "run/unknown.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static MnsStatus find_field(const MnsSim *sim, const char *name, int *ret, MnsError *error)
{
    *ret = mns_field_find(name ? name : "");
    if (*ret >= 0 && mns_sim_fields(sim) >> *ret & 1) return MNS_OK;
    return unknown_field("field", name, tap_fields_of(sim), error);
}

/* --- probes ------------------------------------------------------------------------------------------------------------ */

static MnsStatus find_probe(const MnsCase *c, const char *name, size_t *ret, MnsError *error)
{
    for (*ret = 0; *ret < c->n_probes; ++*ret)
        if (!strcmp(c->probes[*ret].name, name)) return MNS_OK;
    return unknown_probe("probes", name, c, error);
}

MnsStatus look_probes(const MnsSim *sim, const Meniscus__ProbeQuery *query, Exchange *exchange, MnsError *error)
{
    const MnsCase *c = mns_sim_case(sim);
    const size_t n = query->n_names ? query->n_names : c->n_probes;
    size_t probes[MNS_MAX_PROBES];
    double found[MNS_MAX_PROBES]; /* by number of the probe: one that is named again costs nothing again */
    bool known[MNS_MAX_PROBES] = {false};
    if (n > MNS_MAX_PROBES)
        return mns_fail_at(error, MNS_E_LIMIT, "probes", "at most %d probes at a time, found %zu", MNS_MAX_PROBES, n);
    for (size_t k = 0; k < n; k++) {
        probes[k] = k;
        if (query->n_names && find_probe(c, query->names[k], &probes[k], error)) return MNS_E_NOT_FOUND;
    }
    Meniscus__Value **values = calloc(n + 1, sizeof(Meniscus__Value *));
    if (!values) return mns_fail(error, MNS_E_MEMORY, "no memory for %zu values", n);
    for (size_t k = 0; k < n; k++) {
        const size_t probe = probes[k];
        const MnsProbe *is = &c->probes[probe];
        if (!known[probe]) found[probe] = mns_sim_probe(sim, probe);
        known[probe] = true;
        values[k] = exchange_value(is->name, found[probe], NULL, mns_probe_unit(is));
    }
    return exchange_values(exchange, values, n, error);
}

/* --- points ------------------------------------------------------------------------------------------------------------ */

/* [n][dim] of a message to [n][3]; NULL if there is no memory. */
static double (*widen(const double *points, size_t n, size_t dim))[3]
{
    double(*wide)[3] = calloc(n + 1, sizeof *wide);
    for (size_t k = 0; wide && k < n; k++)
        for (size_t d = 0; d < dim; d++) wide[k][d] = points[k * dim + d];
    return wide;
}

static MnsStatus sample(const MnsSim *sim, int field, size_t n, const double (*points)[3], Exchange *exchange,
                        MnsError *error)
{
    const MnsFieldInfo *info = &mns_fields()[field];
    const size_t parts = info->components == 1 ? 1 : (size_t)mns_sim_case(sim)->dim;
    double *values = calloc(n * parts + 1, sizeof *values), *column = calloc(n + 1, sizeof *column);
    if (!values || !column) {
        free(values);
        free(column);
        return mns_fail(error, MNS_E_MEMORY, "no memory for %zu points", n);
    }
    for (size_t d = 0; d < parts; d++) {
        mns_sim_sample(sim, field, (int)d, n, points, column);
        for (size_t k = 0; k < n; k++) values[k * parts + d] = column[k];
    }
    free(column);
    const uint64_t shape[2] = {n, parts};
    return exchange_add(exchange, info->name, "<f8", info->unit, shape, parts == 1 ? 1 : 2, values,
                        n * parts * sizeof *values, error);
}

MnsStatus look_points(const MnsSim *sim, const Meniscus__PointQuery *query, Exchange *exchange, MnsError *error)
{
    const size_t dim = (size_t)mns_sim_case(sim)->dim, n = query->n_points / dim;
    int field;
    const MnsStatus found = find_field(sim, query->field, &field, error);
    if (found) return found;
    if (mns_fields()[field].type != MNS_F64)
        return mns_fail_at(error, MNS_E_INVALID, "field", "%s has no average; ask for particles of a box instead",
                           mns_fields()[field].name);
    if (!n || query->n_points % dim)
        return mns_fail_at(error, MNS_E_INVALID, "points", "points take %zu numbers each; found %zu numbers", dim,
                           query->n_points);
    if (query->n_points > LOOK_COORDINATES)
        return mns_fail_at(error, MNS_E_LIMIT, "points",
                           "at most %zu points at a time in %zu dimensions, found %zu; ask in several requests",
                           LOOK_COORDINATES / dim, dim, n);
    for (size_t k = 0; k < query->n_points; k++)
        if (!isfinite(query->points[k]))
            return mns_fail_at(error, MNS_E_INVALID, "points", "coordinate number %zu is not finite", k);
    double(*points)[3] = widen(query->points, n, dim);
    if (!points) return mns_fail(error, MNS_E_MEMORY, "no memory for %zu points", n);
    const MnsStatus status = sample(sim, field, n, (const double(*)[3])points, exchange, error);
    free(points);
    return status;
}

/* --- particles --------------------------------------------------------------------------------------------------------- */

/* Corners of the box; everywhere where the query has none. */
static MnsStatus box_of(const Meniscus__ParticleQuery *query, size_t dim, double min[3], double max[3], MnsError *error)
{
    if ((query->n_min && query->n_min != dim) || (query->n_max && query->n_max != dim))
        return mns_fail_at(error, MNS_E_INVALID, "box",
                           "the corners of the box have %zu coordinates each; found %zu and %zu", dim, query->n_min,
                           query->n_max);
    for (size_t d = 0; d < 3; d++) {
        min[d] = query->n_min && d < dim ? query->min[d] : -INFINITY;
        max[d] = query->n_max && d < dim ? query->max[d] : INFINITY;
        if (isnan(min[d]) || isnan(max[d]))
            return mns_fail_at(error, MNS_E_INVALID, "box", "a corner of the box is no number along %c", "xyz"[d]);
        if (min[d] > max[d])
            return mns_fail_at(error, MNS_E_INVALID, "box",
                               "the lower corner of the box, %g, is above the upper one, %g, along %c", min[d], max[d],
                               "xyz"[d]);
    }
    return MNS_OK;
}

/* Indices of one in `every` of the particles within; yours. NULL if there is no memory. */
static uint32_t *select_within(const MnsSim *sim, size_t n, const double min[3], const double max[3], uint64_t every,
                               size_t *ret_n)
{
    const int position = mns_field_find("position"), dim = mns_sim_case(sim)->dim;
    const uint32_t *id = mns_sim_field(sim, mns_field_find("id"), 0);
    const uint64_t numbers = (uint64_t)UINT32_MAX + 1, below = every > 1 ? numbers / every : numbers;
    const double *x[3];
    uint32_t *chosen = malloc((n + 1) * sizeof *chosen);
    for (int d = 0; d < dim; d++) x[d] = mns_sim_field(sim, position, d);
    *ret_n = 0;
    for (size_t k = 0; chosen && k < n; k++) {
        bool within = selection_scatter(id[k]) < below;
        for (int d = 0; d < dim; d++) within = within && x[d][k] >= min[d] && x[d][k] <= max[d];
        if (within) chosen[(*ret_n)++] = (uint32_t)k;
    }
    return chosen;
}

static MnsStatus add_field(const MnsSim *sim, int field, const uint32_t *chosen, size_t n, Exchange *exchange,
                           MnsError *error)
{
    const MnsFieldInfo *info = &mns_fields()[field];
    const size_t parts = info->components == 1 ? 1 : (size_t)mns_sim_case(sim)->dim,
                 width = tap_number_size(info->type);
    char *data = malloc(n * parts * width + 1);
    if (!data) return mns_fail(error, MNS_E_MEMORY, "no memory for %zu particles", n);
    for (size_t d = 0; d < parts; d++) {
        const char *from = mns_sim_field(sim, field, (int)d);
        if (!from) {
            free(data);
            return mns_fail(error, MNS_E_MEMORY, "no memory for %zu particles", n);
        }
        for (size_t k = 0; k < n; k++) memcpy(data + (k * parts + d) * width, from + chosen[k] * width, width);
    }
    const uint64_t shape[2] = {n, parts};
    return exchange_add(exchange, info->name, selection_numpy(info->type), info->unit, shape, parts == 1 ? 1 : 2, data,
                        n * parts * width, error);
}

/* Fields to send: those asked for, or where the particles are, who they are and of what. */
static MnsStatus fields_of(const MnsSim *sim, const Meniscus__ParticleQuery *query, int fields[EXCHANGE_ARRAYS],
                           size_t *ret_n, MnsError *error)
{
    static const char *const usual[] = {"position", "id", "phase"};
    const size_t n = query->n_fields ? query->n_fields : 3;
    if (n > EXCHANGE_ARRAYS)
        return mns_fail_at(error, MNS_E_LIMIT, "fields", "at most %d fields at a time, found %zu", EXCHANGE_ARRAYS, n);
    for (size_t k = 0; k < n; k++) {
        const MnsStatus status = find_field(sim, query->n_fields ? query->fields[k] : usual[k], &fields[k], error);
        if (status) return status;
    }
    *ret_n = n;
    return MNS_OK;
}

static MnsStatus check_size(const Meniscus__ParticleQuery *query, const int *fields, size_t n_fields, size_t n,
                            MnsError *error)
{
    size_t bytes = 0;
    for (size_t k = 0; k < n_fields; k++)
        bytes += n * (size_t)mns_fields()[fields[k]].components * tap_number_size(mns_fields()[fields[k]].type);
    if (n > query->limit)
        return mns_fail_at(error, MNS_E_LIMIT, "limit",
                           "%zu particles are within, and the limit is %llu; ask for a smaller box or raise it", n,
                           (unsigned long long)query->limit);
    if (bytes <= LOOK_BYTES) return MNS_OK;
    return mns_fail_at(
        error, MNS_E_LIMIT, "particles",
        "%zu particles take %zu bytes, and a reply may have %d; ask for a smaller box, fewer fields, or a "
        "snapshot",
        n, bytes, LOOK_BYTES);
}

MnsStatus look_particles(const MnsSim *sim, const Meniscus__ParticleQuery *query, Exchange *exchange, MnsError *error)
{
    double min[3], max[3];
    int fields[EXCHANGE_ARRAYS];
    size_t n_fields = 0, n;
    MnsStatus status = box_of(query, (size_t)mns_sim_case(sim)->dim, min, max, error);
    if (!status) status = fields_of(sim, query, fields, &n_fields, error);
    if (status) return status;
    const size_t all = query->has_walls && query->walls ? mns_sim_particles(sim) : mns_sim_fluid_particles(sim);
    uint32_t *chosen = select_within(sim, all, min, max, query->every, &n);
    if (!chosen) return mns_fail(error, MNS_E_MEMORY, "no memory for a choice of particles");
    status = check_size(query, fields, n_fields, n, error);
    for (size_t k = 0; !status && k < n_fields; k++) status = add_field(sim, fields[k], chosen, n, exchange, error);
    free(chosen);
    return status;
}
