/* SPDX-License-Identifier: BSD-3-Clause */
/* What a stream is asked for, as the message. What the daemon checks by name is left to it. */
#include "client/lib/stream_inside.h"
#include <math.h>
#include <stdlib.h>

enum { NAMES_MAX = 4096, FIELDS_MAX = 16 };

/* All the messages of one wish, which point into this. */
typedef struct Wish {
    Meniscus__Subscribe subscribe;
    Meniscus__ProbeStream probes;
    Meniscus__FieldStream fields;
    Meniscus__EventStream events;
    Meniscus__SnapshotStream snapshots;
    Meniscus__FieldWish field[FIELDS_MAX], *field_list[FIELDS_MAX];
    Meniscus__Exactness exactness[FIELDS_MAX];
    Meniscus__When when;
    Meniscus__Where where;
} Wish;

static Meniscus__Exactness *exactness(Meniscus__Exactness *to, bool f32, double bound)
{
    meniscus__exactness__init(to);
    if (bound != 0) {
        to->how_case = MENISCUS__EXACTNESS__HOW_BOUND;
        to->bound = bound;
    } else if (f32) {
        to->how_case = MENISCUS__EXACTNESS__HOW_F32;
        to->f32 = true;
    } else return NULL;
    return to;
}

static void want_probes(Wish *wish, const MnsStreamOptions *o)
{
    meniscus__probe_stream__init(&wish->probes);
    wish->probes.n_names = o->n_names;
    wish->probes.names = (char **)o->names;
    wish->probes.exactness = exactness(&wish->exactness[0], o->f32, o->bound);
    wish->subscribe.what_case = MENISCUS__SUBSCRIBE__WHAT_PROBES;
    wish->subscribe.probes = &wish->probes;
}

static void want_fields(Wish *wish, const MnsStreamOptions *o)
{
    meniscus__field_stream__init(&wish->fields);
    for (size_t k = 0; k < o->n_names; k++) {
        meniscus__field_wish__init(&wish->field[k]);
        wish->field[k].name = (char *)o->names[k];
        wish->field[k].exactness =
            exactness(&wish->exactness[k], !o->bounds && o->f32, o->bounds ? o->bounds[k] : o->bound);
        wish->field_list[k] = &wish->field[k];
    }
    wish->fields.n_fields = o->n_names;
    wish->fields.fields = wish->field_list;
    wish->subscribe.what_case = MENISCUS__SUBSCRIBE__WHAT_FIELDS;
    wish->subscribe.fields = &wish->fields;
}

static void want_when(Wish *wish, const MnsStreamOptions *o)
{
    Meniscus__When *when = &wish->when;
    meniscus__when__init(when);
    when->has_every_steps = o->every_steps > 0;
    when->every_steps = o->every_steps;
    when->has_interval = o->interval != 0;
    when->interval = o->interval;
    when->has_max_hz = o->max_hz != 0;
    when->max_hz = o->max_hz;
    when->has_first = o->first || o->kind == MNS_STREAM_PROBES; /* which would have one where nothing is said */
    when->first = o->first;
    if (when->has_every_steps || when->has_interval || when->has_max_hz || when->has_first) wish->subscribe.when = when;
}

static void want_where(Wish *wish, const MnsStreamOptions *o)
{
    Meniscus__Where *where = &wish->where;
    meniscus__where__init(where);
    if (o->in_box) {
        where->n_min = where->n_max = (size_t)o->dim;
        where->min = (double *)o->min;
        where->max = (double *)o->max;
    }
    if (o->radius != 0) {
        where->n_centre = (size_t)o->dim;
        where->centre = (double *)o->centre;
        where->has_radius = true;
        where->radius = o->radius;
    }
    where->n_phases = o->n_phases;
    where->phases = (uint32_t *)o->phases;
    where->has_walls = where->walls = o->walls;
    where->has_every = o->every > 0;
    where->every = o->every;
    if (o->in_box || o->radius != 0 || o->n_phases || o->walls || o->every) wish->subscribe.where = where;
}

static MnsStatus check(const MnsStreamOptions *o, MnsError *error)
{
    if ((unsigned)o->kind >= MNS_STREAM_KINDS)
        return mns_fail_at(error, MNS_E_INVALID, "kind", "there is no stream of kind %d; there are MNS_STREAM_*",
                           (int)o->kind);
    const size_t most = o->kind == MNS_STREAM_FIELDS ? FIELDS_MAX : NAMES_MAX;
    if (o->n_names > most)
        return mns_fail_at(error, MNS_E_INVALID, "names", "a stream of this kind has at most %zu names, not %zu", most,
                           o->n_names);
    if (o->dim < 0 || o->dim > 3 || ((o->in_box || o->radius != 0) && !o->dim))
        return mns_fail_at(error, MNS_E_INVALID, "dim", "a box or sphere has 1 to 3 dimensions, not %d", o->dim);
    return MNS_OK;
}

/* A copy that owns all it points to. */
static Meniscus__Subscribe *copy(const Meniscus__Subscribe *subscribe)
{
    const size_t size = meniscus__subscribe__get_packed_size(subscribe);
    uint8_t *packed = malloc(size + 1);
    if (packed) meniscus__subscribe__pack(subscribe, packed);
    Meniscus__Subscribe *copied = packed ? meniscus__subscribe__unpack(NULL, size, packed) : NULL;
    free(packed);
    return copied;
}

MnsStatus stream_wish(const MnsStreamOptions *options, Meniscus__Subscribe **ret, MnsError *error)
{
    const MnsStatus status = check(options, error);
    if (status) return status;
    Wish wish;
    Meniscus__Subscribe *subscribe = &wish.subscribe;
    meniscus__subscribe__init(subscribe);
    meniscus__event_stream__init(&wish.events);
    meniscus__snapshot_stream__init(&wish.snapshots);
    const bool latest = options->kind != MNS_STREAM_SERIES && options->kind != MNS_STREAM_SNAPSHOTS;
    subscribe->has_delivery = true;
    subscribe->delivery = latest ? MENISCUS__DELIVERY__LATEST : MENISCUS__DELIVERY__LOSSLESS;
    subscribe->has_codec = options->codec != MNS_CODEC_NONE;
    subscribe->codec = (Meniscus__Codec)options->codec;
    switch (options->kind) {
    case MNS_STREAM_FIELDS: want_fields(&wish, options); break;
    case MNS_STREAM_EVENTS:
        subscribe->what_case = MENISCUS__SUBSCRIBE__WHAT_EVENTS;
        subscribe->events = &wish.events;
        break;
    case MNS_STREAM_SNAPSHOTS:
        subscribe->what_case = MENISCUS__SUBSCRIBE__WHAT_SNAPSHOTS;
        subscribe->snapshots = &wish.snapshots;
        break;
    default: want_probes(&wish, options);
    }
    if (latest) want_when(&wish, options);
    want_where(&wish, options);
    *ret = copy(subscribe);
    return *ret ? MNS_OK : mns_fail(error, MNS_E_MEMORY, "no memory for a stream");
}
