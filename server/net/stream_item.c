/* SPDX-License-Identifier: BSD-3-Clause */
/* An item of a stream. */
#include "net/stream_item.h"

#include <stdlib.h>
#include <string.h>

static size_t bytes_of(const PackingArray *array)
{
    size_t bytes = (size_t)(array->type[2] - '0');
    for (size_t k = 0; k < array->n_dims; k++) bytes *= array->shape[k];
    return bytes;
}

static void hold(StreamItem *item, size_t bytes)
{
    item->held += bytes;
    *item->memory += bytes;
}

static StreamItem *new_item(StreamMemory *memory)
{
    StreamItem *item = calloc(1, sizeof *item);
    if (!item) return NULL;
    item->users = 1;
    item->memory = memory;
    hold(item, sizeof *item);
    return item;
}

size_t stream_item_raw(const StreamItem *item)
{
    size_t bytes = 0;
    for (size_t k = 0; k < item->n; k++) bytes += bytes_of(&item->parts[k].array);
    return bytes;
}

StreamItem *stream_item_share(StreamItem *item)
{
    if (item) item->users++;
    return item;
}

void stream_item_leave(StreamItem *item)
{
    if (!item || --item->users) return;
    *item->memory -= item->held;
    for (size_t k = 0; k < item->n; k++) {
        packing_free(item->parts[k].packed);
        free(item->parts[k].raw);
    }
    if (item->event) meniscus__event__free_unpacked(item->event, NULL);
    free(item);
}

/* Another array with numbers that are taken over. */
static void add(StreamItem *item, PackingArray array, void *raw)
{
    StreamPart *part = &item->parts[item->n++];
    array.data = raw;
    *part = (StreamPart){.array = array, .raw = raw};
    hold(item, bytes_of(&array));
}

/* --- of a shot ---------------------------------------------------------------------------------------------------------- */

static size_t bytes_needed(const StreamSpec *spec, const MnsCapture *capture, size_t n)
{
    size_t width = 0;
    for (size_t k = 0; k < spec->n; k++) width += selection_width(capture, spec->columns[k]);
    return width * n;
}

static MnsStatus add_field(StreamItem *item, const MnsCapture *capture, int field, const uint32_t *chosen, size_t n,
                           MnsError *error)
{
    const MnsFieldInfo *info = &mns_fields()[field];
    const size_t width = selection_width(capture, field);
    void *raw = malloc(n * width + 1);
    if (!raw) return mns_fail(error, MNS_E_MEMORY, "no memory for %zu particles", n);
    selection_gather(capture, field, chosen, n, raw);
    const PackingArray array = {.name = info->name,
                                .unit = info->unit,
                                .type = selection_numpy(info->type),
                                .n_dims = info->components == 1 ? 1 : 2,
                                .shape = {n, (size_t)capture->dim}};
    add(item, array, raw);
    return MNS_OK;
}

static MnsStatus add_fields(StreamItem *item, const StreamSpec *spec, const MnsCapture *capture, size_t limit,
                            size_t *ret_needed, MnsError *error)
{
    const Selection *where = &spec->where;
    const bool all = !where->boxed && !where->ball && !where->mixed && where->every == 1;
    uint32_t *chosen = all ? NULL : malloc((capture->n + 1) * sizeof *chosen);
    if (!all && !chosen) return mns_fail(error, MNS_E_MEMORY, "no memory for a choice of particles");
    const size_t everybody = where->walls ? capture->n : capture->n_fluid;
    const size_t n = all ? everybody : selection_choose(where, capture, chosen);
    MnsStatus status = MNS_OK;
    const size_t needed = bytes_needed(spec, capture, n);
    if (needed > limit) {
        *ret_needed = needed;
        status = mns_fail(error, MNS_E_LIMIT, "%zu bytes are needed, and streams may hold %zu more", needed, limit);
    }
    for (size_t k = 0; !status && k < spec->n; k++)
        status = add_field(item, capture, spec->columns[k], chosen, n, error);
    free(chosen);
    return status;
}

static MnsStatus add_values(StreamItem *item, const StreamSpec *spec, const double *values, MnsError *error)
{
    double *raw = malloc(spec->n * sizeof *raw + 1);
    if (!raw) return mns_fail(error, MNS_E_MEMORY, "no memory for %zu values", spec->n);
    for (size_t k = 0; k < spec->n; k++) raw[k] = values[spec->columns[k]];
    add(item, (PackingArray){.name = "values", .type = "<f8", .n_dims = 1, .shape = {spec->n}}, raw);
    return MNS_OK;
}

MnsStatus stream_item_new(const StreamSpec *spec, const Shot *shot, StreamMemory *memory, size_t limit,
                          size_t *ret_needed, StreamItem **ret, MnsError *error)
{
    StreamItem *item = new_item(memory);
    if (!item) return mns_fail(error, MNS_E_MEMORY, "no memory for an item");
    item->step = shot->progress.step;
    item->time = shot->progress.t;
    const MnsStatus status = spec->kind == STREAM_FIELDS
                                 ? add_fields(item, spec, shot->capture, limit, ret_needed, error)
                                 : add_values(item, spec, shot->values, error);
    if (status) stream_item_leave(item);
    else *ret = item;
    return status;
}

/* --- others ------------------------------------------------------------------------------------------------------------- */

MnsStatus stream_item_rows(const StreamSpec *spec, size_t rows, uint64_t *step, double *time, double *values,
                           StreamMemory *memory, StreamItem **ret, MnsError *error)
{
    StreamItem *item = new_item(memory);
    if (!item) {
        free(step);
        free(time);
        free(values);
        return mns_fail(error, MNS_E_MEMORY, "no memory for an item");
    }
    item->step = rows ? step[rows - 1] : 0;
    item->time = rows ? time[rows - 1] : 0;
    add(item, (PackingArray){.name = "step", .unit = "1", .type = "<u8", .n_dims = 1, .shape = {rows}}, step);
    add(item, (PackingArray){.name = "time", .unit = "s", .type = "<f8", .n_dims = 1, .shape = {rows}}, time);
    add(item, (PackingArray){.name = "values", .type = "<f8", .n_dims = 2, .shape = {rows, spec->n}}, values);
    *ret = item;
    return MNS_OK;
}

StreamItem *stream_item_event(const Note *note, StreamMemory *memory)
{
    StreamItem *item = new_item(memory);
    Meniscus__Event event = MENISCUS__EVENT__INIT;
    uint8_t packed[1024];
    if (!item) return NULL;
    event.has_state = true;
    event.state = (Meniscus__State)note->state;
    event.what = (char *)note->word;
    event.text = (char *)note->text;
    const size_t size = meniscus__event__pack(&event, packed); /* at most 24 and 640 characters, and a few */
    item->event = meniscus__event__unpack(NULL, size, packed);
    item->step = note->step;
    item->time = note->t;
    item->packed = true;
    if (item->event) return item;
    stream_item_leave(item);
    return NULL;
}

/* --- packing ------------------------------------------------------------------------------------------------------------ */

/* The numbers are given up where they are not what is sent. */
static MnsStatus pack_part(StreamItem *item, StreamPart *part, const PackingHow *how, MnsError *error)
{
    const MnsStatus status = packing_pack(&part->array, how, &part->packed, error);
    if (status || part->packed->data == part->raw) return status;
    free(part->raw);
    part->raw = NULL;
    hold(item, part->packed->size);
    item->held -= bytes_of(&part->array);
    *item->memory -= bytes_of(&part->array);
    return MNS_OK;
}

MnsStatus stream_item_pack(StreamItem *item, const StreamSpec *spec, MnsError *error)
{
    MnsStatus status = MNS_OK;
    const PackingHow as_is = {.codec = spec->how[0].codec};
    if (item->packed) return MNS_OK;
    for (size_t k = 0; !status && k < item->n; k++) {
        StreamPart *part = &item->parts[k];
        if (part->packed) continue;
        const bool first = spec->kind != STREAM_FIELDS;
        const bool counts = spec->kind == STREAM_SERIES && k < 2; /* steps and times stay exact */
        status = pack_part(item, part, counts ? &as_is : &spec->how[first ? 0 : k], error);
        if (!status) item->size += part->packed->size;
    }
    item->packed = !status;
    return status;
}

const void *stream_item_bytes(const StreamItem *item, size_t offset, size_t n)
{
    for (size_t k = 0; k < item->n; k++) {
        const Packed *packed = item->parts[k].packed;
        if (offset + n <= packed->size) return (const char *)packed->data + offset;
        if (offset < packed->size) return NULL;
        offset -= packed->size;
    }
    return NULL;
}

void stream_item_copy(const StreamItem *item, size_t offset, size_t n, void *to)
{
    char *at = to;
    for (size_t k = 0; k < item->n && n; k++) {
        const Packed *packed = item->parts[k].packed;
        if (offset >= packed->size) {
            offset -= packed->size;
            continue;
        }
        const size_t part = packed->size - offset < n ? packed->size - offset : n;
        memcpy(at, (const char *)packed->data + offset, part);
        at += part;
        n -= part;
        offset = 0;
    }
}
