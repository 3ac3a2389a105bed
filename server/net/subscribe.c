/* SPDX-License-Identifier: BSD-3-Clause */
/* What a client asks for in a `subscribe`. */
#include "net/subscribe.h"

#include "run/unknown.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

bool stream_is_latest(StreamKind kind)
{
    return kind == STREAM_PROBES || kind == STREAM_FIELDS || kind == STREAM_EVENTS;
}

/* --- what --------------------------------------------------------------------------------------------------------------- */

static MnsStatus read_kind(const Meniscus__Subscribe *asked, StreamKind *ret, MnsError *error)
{
    const bool given = asked->has_delivery, lossless = asked->delivery == MENISCUS__DELIVERY__LOSSLESS;
    switch (asked->what_case) {
    case MENISCUS__SUBSCRIBE__WHAT_PROBES: *ret = given && lossless ? STREAM_SERIES : STREAM_PROBES; return MNS_OK;
    case MENISCUS__SUBSCRIBE__WHAT_FIELDS: *ret = STREAM_FIELDS; break;
    case MENISCUS__SUBSCRIBE__WHAT_EVENTS: *ret = STREAM_EVENTS; break;
    case MENISCUS__SUBSCRIBE__WHAT_SNAPSHOTS: *ret = STREAM_SNAPSHOTS; break;
    default:
        return mns_fail_at(error, MNS_E_INVALID, "what",
                           "a subscribe needs one of probes, fields, events and snapshots; it has none");
    }
    if (!given || lossless == (*ret == STREAM_SNAPSHOTS)) return MNS_OK;
    if (lossless)
        return mns_fail_at(error, MNS_E_INVALID, "delivery",
                           "%s are LATEST only; LOSSLESS are probes and snapshots, which are in files",
                           *ret == STREAM_FIELDS ? "fields" : "events");
    return mns_fail_at(error, MNS_E_INVALID, "delivery", "snapshots are LOSSLESS only; fields are LATEST");
}

/* path: of the exactness, without its last word. */
static MnsStatus read_exactness(const Meniscus__Exactness *asked, const char *path, PackingHow *ret, MnsError *error)
{
    char whole[64];
    if (!asked || asked->how_case == MENISCUS__EXACTNESS__HOW__NOT_SET) return MNS_OK;
    if (asked->how_case == MENISCUS__EXACTNESS__HOW_F32) ret->exactness = PACKING_F32;
    if (asked->how_case != MENISCUS__EXACTNESS__HOW_BOUND) return MNS_OK;
    snprintf(whole, sizeof whole, "%s.bound", path);
    if (!(asked->bound > 0) || isinf(asked->bound))
        return mns_fail_at(error, MNS_E_INVALID, whole,
                           "a bound of the error must be above 0 and finite; found %g. Leave it out for exact values",
                           asked->bound);
    ret->exactness = PACKING_BOUNDED;
    ret->bound = asked->bound;
    return MNS_OK;
}

static MnsStatus read_field(const Meniscus__FieldWish *asked, size_t k, const TapCase *now, StreamSpec *spec,
                            MnsError *error)
{
    char path[40];
    const int field = mns_field_find(asked->name ? asked->name : "");
    snprintf(path, sizeof path, "fields[%zu].name", k);
    if (field < 0 || !(now->fields >> field & 1)) return unknown_field(path, asked->name, now->fields, error);
    for (size_t j = 0; j < k; j++)
        if (spec->columns[j] == field)
            return mns_fail_at(error, MNS_E_INVALID, path, "the field %s is asked for twice", asked->name);
    spec->columns[k] = field;
    spec->wish.fields |= UINT64_C(1) << field;
    snprintf(path, sizeof path, "fields[%zu].exactness", k);
    const MnsStatus status = read_exactness(asked->exactness, path, &spec->how[k], error);
    if (status || mns_fields()[field].type == MNS_F64 || spec->how[k].exactness == PACKING_F64) return status;
    return mns_fail_at(error, MNS_E_INVALID, path, "%s are whole numbers, which come as they are; leave this out",
                       mns_fields()[field].name);
}

static MnsStatus read_fields(const Meniscus__FieldStream *asked, const TapCase *now, StreamSpec *spec, MnsError *error)
{
    if (!asked->n_fields || asked->n_fields > STREAM_FIELDS_MAX)
        return mns_fail_at(error, MNS_E_INVALID, "fields", "a stream has 1 to %d fields; found %zu", STREAM_FIELDS_MAX,
                           asked->n_fields);
    spec->n = asked->n_fields;
    MnsStatus status = MNS_OK;
    for (size_t k = 0; !status && k < spec->n; k++) status = read_field(asked->fields[k], k, now, spec, error);
    return status;
}

static MnsStatus read_probe(const char *name, size_t k, const MnsCase *c, int *ret, MnsError *error)
{
    char path[40];
    for (*ret = 0; *ret < (int)c->n_probes; ++*ret)
        if (!strcmp(c->probes[*ret].name, name)) return MNS_OK;
    snprintf(path, sizeof path, "probes.names[%zu]", k);
    return unknown_probe(path, name, c, error);
}

static MnsStatus read_probes(const Meniscus__ProbeStream *asked, const MnsCase *c, StreamSpec *spec, MnsError *error)
{
    spec->n = asked->n_names ? asked->n_names : c->n_probes;
    if (!c->n_probes) return mns_fail_at(error, MNS_E_NOT_FOUND, "probes", "the case has no probes");
    if (spec->n > MNS_MAX_PROBES)
        return mns_fail_at(error, MNS_E_LIMIT, "probes.names", "a stream has at most %d probes; found %zu",
                           MNS_MAX_PROBES, spec->n);
    for (size_t k = 0; k < spec->n; k++) {
        spec->columns[k] = (int)k;
        const MnsStatus status = asked->n_names ? read_probe(asked->names[k], k, c, &spec->columns[k], error) : MNS_OK;
        if (status) return status;
        spec->wish.probes[spec->columns[k] / 64] |= UINT64_C(1) << spec->columns[k] % 64;
    }
    return read_exactness(asked->exactness, "probes.exactness", &spec->how[0], error);
}

/* --- when --------------------------------------------------------------------------------------------------------------- */

static MnsStatus check_positive(bool given, double value, const char *path, MnsError *error)
{
    if (!given || (value > 0 && isfinite(value))) return MNS_OK;
    return mns_fail_at(error, MNS_E_INVALID, path, "%s must be above 0 and finite; found %g", path, value);
}

/* Probes of every boundary begin with the one that the run is at. */
static bool is_first_due(const Meniscus__When *asked, StreamKind kind)
{
    if (asked && asked->has_first) return asked->first;
    return kind == STREAM_PROBES && !(asked && (asked->has_every_steps || asked->has_interval));
}

static MnsStatus read_when(const Meniscus__When *asked, StreamSpec *spec, MnsError *error)
{
    spec->first = is_first_due(asked, spec->kind);
    if (!asked) return MNS_OK;
    if (!stream_is_latest(spec->kind))
        return mns_fail_at(error, MNS_E_INVALID, "when",
                           "LOSSLESS streams have all that is written; `output` of the case says when. Leave this out");
    if (asked->has_every_steps && !asked->every_steps)
        return mns_fail_at(error, MNS_E_INVALID, "when.every_steps", "every_steps must be at least 1");
    MnsStatus status = check_positive(asked->has_interval, asked->interval, "when.interval", error);
    if (!status) status = check_positive(asked->has_max_hz, asked->max_hz, "when.max_hz", error);
    if (status) return status;
    spec->wish.when = (When){.every_steps = asked->every_steps,
                             .interval = asked->has_interval ? asked->interval : 0,
                             .gap = asked->has_max_hz ? 1 / asked->max_hz : 0};
    return MNS_OK;
}

/* --- where -------------------------------------------------------------------------------------------------------------- */

static MnsStatus read_corner(size_t n, const double *asked, size_t dim, double otherwise, const char *path,
                             double ret[3], MnsError *error)
{
    for (size_t d = 0; d < 3; d++) ret[d] = n && d < dim ? asked[d < n ? d : 0] : otherwise;
    if (n && n != dim)
        return mns_fail_at(error, MNS_E_INVALID, path, "%s takes %zu coordinates; found %zu", path, dim, n);
    for (size_t d = 0; d < n; d++)
        if (isnan(asked[d])) return mns_fail_at(error, MNS_E_INVALID, path, "%s is no number along %c", path, "xyz"[d]);
    return MNS_OK;
}

static MnsStatus read_box(const Meniscus__Where *asked, size_t dim, Selection *ret, MnsError *error)
{
    ret->boxed = asked->n_min || asked->n_max;
    MnsStatus status = read_corner(asked->n_min, asked->min, dim, -INFINITY, "where.min", ret->min, error);
    if (!status) status = read_corner(asked->n_max, asked->max, dim, INFINITY, "where.max", ret->max, error);
    for (size_t d = 0; !status && d < dim; d++)
        if (ret->min[d] > ret->max[d])
            status = mns_fail_at(error, MNS_E_INVALID, "where.min",
                                 "the lower corner of the box, %g, is above the upper one, %g, along %c", ret->min[d],
                                 ret->max[d], "xyz"[d]);
    return status;
}

static MnsStatus read_ball(const Meniscus__Where *asked, size_t dim, Selection *ret, MnsError *error)
{
    ret->ball = asked->n_centre || asked->has_radius;
    if (!ret->ball) return MNS_OK;
    const MnsStatus status = read_corner(asked->n_centre, asked->centre, dim, 0, "where.centre", ret->centre, error);
    if (status) return status;
    if (!asked->n_centre)
        return mns_fail_at(error, MNS_E_INVALID, "where.centre", "a radius needs a centre of %zu coordinates", dim);
    ret->radius = asked->radius;
    return asked->has_radius ? check_positive(true, asked->radius, "where.radius", error)
                             : mns_fail_at(error, MNS_E_INVALID, "where.radius", "a centre needs a radius");
}

static MnsStatus read_phases(const Meniscus__Where *asked, const MnsCase *c, Selection *ret, MnsError *error)
{
    const size_t n = c->n_fluids + c->n_walls;
    ret->mixed = asked->n_phases > 0;
    for (size_t k = 0; k < asked->n_phases; k++) {
        const uint32_t phase = asked->phases[k];
        if (phase >= n)
            return mns_fail_at(error, MNS_E_NOT_FOUND, "where.phases",
                               "there is no phase %u: this case has %zu fluids and %zu walls, numbered from 0", phase,
                               c->n_fluids, c->n_walls);
        ret->phases[phase / 64] |= UINT64_C(1) << phase % 64;
    }
    return MNS_OK;
}

static MnsStatus read_where(const Meniscus__Where *asked, const MnsCase *c, StreamSpec *spec, MnsError *error)
{
    Selection *where = &spec->where;
    where->every = 1;
    if (!asked) return MNS_OK;
    if (spec->kind != STREAM_FIELDS)
        return mns_fail_at(error, MNS_E_INVALID, "where", "only fields are somewhere; leave this out");
    where->walls = asked->has_walls && asked->walls;
    if (asked->has_every) where->every = asked->every;
    if (!where->every)
        return mns_fail_at(error, MNS_E_INVALID, "where.every", "every must be at least 1: each particle");
    MnsStatus status = read_box(asked, (size_t)c->dim, where, error);
    if (!status) status = read_ball(asked, (size_t)c->dim, where, error);
    if (!status) status = read_phases(asked, c, where, error);
    spec->wish.fields |= selection_fields(where);
    return status;
}

/* --- how ---------------------------------------------------------------------------------------------------------------- */

static MnsStatus read_how(const Meniscus__Subscribe *asked, StreamSpec *spec, MnsError *error)
{
    const Meniscus__Codec codec = asked->has_codec ? asked->codec : MENISCUS__CODEC__CODEC_NONE;
    spec->chunk = asked->has_chunk_bytes ? asked->chunk_bytes : STREAM_CHUNK;
    spec->credit = asked->credit;
    if (!packing_codec_name(codec))
        return mns_fail_at(error, MNS_E_INVALID, "codec", "there is no codec %d; there are none, lz4 and zstd",
                           (int)codec);
    if (codec != MENISCUS__CODEC__CODEC_NONE && spec->kind == STREAM_SNAPSHOTS)
        return mns_fail_at(error, MNS_E_INVALID, "codec", "snapshots come byte for byte; leave this out");
    if (spec->chunk < STREAM_CHUNK_LEAST || spec->chunk > STREAM_CHUNK_MOST)
        return mns_fail_at(error, MNS_E_INVALID, "chunk_bytes", "a chunk has %d to %d bytes; found %zu",
                           STREAM_CHUNK_LEAST, STREAM_CHUNK_MOST, spec->chunk);
    for (size_t k = 0; k < STREAM_FIELDS_MAX; k++) spec->how[k].codec = codec;
    return MNS_OK;
}

static MnsStatus read_from(const Meniscus__Cursor *asked, StreamSpec *spec, MnsError *error)
{
    if (!asked) return MNS_OK;
    if (stream_is_latest(spec->kind))
        return mns_fail_at(error, MNS_E_INVALID, "from", "a LATEST stream has no past to begin in; leave this out");
    StreamCursor *from = &spec->from;
    *from = (StreamCursor){.line = asked->line, .row = asked->row, .offset = asked->offset, .given = true};
    const char *file = asked->file ? asked->file : "";
    if (strlen(file) >= sizeof from->file || strchr(file, '/'))
        return mns_fail_at(error, MNS_E_INVALID, "from.file", "\"%.60s\" is no name of a snapshot", file);
    memcpy(from->file, file, strlen(file) + 1);
    return MNS_OK;
}

/* Copies of fields are made of all particles, whatever is selected of them later. */
static MnsStatus check_size(const StreamSpec *spec, const TapCase *now, size_t limit, MnsError *error)
{
    size_t width = 0;
    for (int f = 0; mns_fields()[f].name; f++)
        if (spec->wish.fields >> f & 1)
            width += (mns_fields()[f].components == 1 ? 1 : (size_t)now->document->c->dim) *
                     tap_number_size(mns_fields()[f].type);
    if (width * now->particles <= limit) return MNS_OK;
    return mns_fail_at(error, MNS_E_LIMIT, "fields",
                       "a copy of these fields takes %zu bytes, and all streams together may hold %zu: ask for fewer "
                       "fields, for snapshots, or start the daemon with a larger --stream-memory",
                       width * now->particles, limit);
}

MnsStatus subscribe_read(const Meniscus__Subscribe *asked, const TapCase *now, size_t limit, StreamSpec *ret,
                         MnsError *error)
{
    *ret = (StreamSpec){.n = 0};
    MnsStatus status = read_kind(asked, &ret->kind, error);
    if (status) return status;
    if (!now->document && ret->kind != STREAM_EVENTS)
        return mns_fail(error, MNS_E_STATE, "there is no case, so nothing to stream; load one first");
    if (ret->kind == STREAM_FIELDS) status = read_fields(asked->fields, now, ret, error);
    if (ret->kind == STREAM_PROBES || ret->kind == STREAM_SERIES)
        status = read_probes(asked->probes, now->document->c, ret, error);
    if (!status) status = read_when(asked->when, ret, error);
    if (!status) status = read_where(asked->where, now->document ? now->document->c : NULL, ret, error);
    if (!status) status = read_how(asked, ret, error);
    if (!status) status = read_from(asked->from, ret, error);
    return status || !ret->wish.fields ? status : check_size(ret, now, limit, error);
}
