/* SPDX-License-Identifier: BSD-3-Clause */
/* A picture's worth of particles. */
#include "client/dashboard/frame.h"
#include "client/cli/output.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

bool wish_equal(const Wish *a, const Wish *b)
{
    return a->limit == b->limit && a->walls == b->walls && !strcmp(a->field, b->field);
}

bool key_equal(FrameKey a, FrameKey b)
{
    return a.generation == b.generation && a.step == b.step;
}

uint64_t frame_every(uint64_t n, uint64_t limit)
{
    return limit && n > limit ? (n + limit / 2) / limit : 1;
}

static size_t columns(const MnsArray *array)
{
    return array->n_dims > 1 ? array->shape[1] : 1;
}

/* Element k of an array: one of the types that fields have. Chosen once for an array, as there are millions of elements a second. */
typedef double Reader(const void *data, size_t k);

static double read_double(const void *data, size_t k)
{
    return ((const double *)data)[k];
}

static double read_u32(const void *data, size_t k)
{
    return ((const uint32_t *)data)[k];
}

static double read_u8(const void *data, size_t k)
{
    return ((const uint8_t *)data)[k];
}

/* NULL: no field has this type. */
static Reader *reader_of(const MnsArray *array)
{
    static const struct {
        const char *type;
        Reader *read;
    } readers[] = {{"<f8", read_double}, {"<u4", read_u32}, {"|u1", read_u8}};
    for (size_t k = 0; k < sizeof readers / sizeof *readers; k++)
        if (!strcmp(array->type, readers[k].type)) return readers[k].read;
    return NULL;
}

static MnsStatus find(const MnsReply *reply, const char *name, size_t rows, const MnsArray **ret, MnsError *error)
{
    *ret = mns_reply_array(reply, name);
    const bool fits = *ret && (*ret)->n_dims && (*ret)->n_dims <= 2 && (*ret)->shape[0] == rows && columns(*ret) <= 3;
    if (fits && reader_of(*ret)) return MNS_OK;
    return mns_fail_at(error, MNS_E_CORRUPT, name, "the daemon's answer lacks a usable array \"%s\"", name);
}

/* Little-endian, as every browser has it. */
static unsigned char *put_u32(unsigned char *to, uint32_t value)
{
    for (int k = 0; k < 4; k++) *to++ = (unsigned char)(value >> 8 * k);
    return to;
}

static unsigned char *put_float(unsigned char *to, double value)
{
    const float narrow = (float)value;
    uint32_t bits;
    memcpy(&bits, &narrow, sizeof bits);
    return put_u32(to, bits);
}

static unsigned char *put_places(unsigned char *to, const MnsArray *places)
{
    const size_t n = places->shape[0] * columns(places);
    Reader *read = reader_of(places);
    for (size_t k = 0; k < n; k++) to = put_float(to, read(places->data, k));
    return to;
}

/* Of a vector its length. */
static unsigned char *put_values(unsigned char *to, const MnsArray *values)
{
    const size_t width = columns(values);
    Reader *read = reader_of(values);
    for (size_t k = 0; k < values->shape[0]; k++) {
        double sum = 0;
        for (size_t d = 0; d < width; d++) sum += read(values->data, k * width + d) * read(values->data, k * width + d);
        to = put_float(to, width > 1 ? sqrt(sum) : read(values->data, k));
    }
    return to;
}

static unsigned char *put_phases(unsigned char *to, const MnsArray *phases)
{
    Reader *read = reader_of(phases);
    for (size_t k = 0; k < phases->shape[0]; k++) *to++ = (unsigned char)read(phases->data, k);
    return to;
}

static char *header_of(const Wish *wish, const MnsArray *places, const MnsArray *values, uint64_t every, uint64_t all,
                       const MnsReply *reply)
{
    json_t *header =
        json_pack("{ss sI so sI sI sI sI ss ss sb sb}", "topic", "frame", "step", (json_int_t)reply->step, "time",
                  output_number(reply->time), "particles", (json_int_t)places->shape[0], "all", (json_int_t)all,
                  "every", (json_int_t)every, "dimensions", (json_int_t)columns(places), "field", wish->field, "unit",
                  values ? values->unit : "", "magnitude", values ? columns(values) > 1 : 0, "walls", (int)wish->walls);
    char *text = header ? json_dumps(header, JSON_COMPACT | JSON_REAL_PRECISION(17)) : NULL;
    json_decref(header);
    return text;
}

MnsStatus frame_new(const Wish *wish, FrameKey key, uint64_t every, uint64_t all, const MnsReply *reply, Frame **ret,
                    MnsError *error)
{
    const MnsArray *places = mns_reply_array(reply, "position"), *phases, *values = NULL;
    const size_t n = places && places->n_dims ? places->shape[0] : 0;
    MnsStatus status = find(reply, "position", n, &places, error);
    if (!status) status = find(reply, "phase", n, &phases, error);
    if (!status && strcmp(wish->field, "phase") != 0) status = find(reply, wish->field, n, &values, error);
    if (status) return status;
    char *header = header_of(wish, places, values, every, all, reply);
    const size_t length = header ? strlen(header) : 0, padded = (length + 3) / 4 * 4;
    const size_t size = FRAME_PREFIX + padded + n * (4 * columns(places) + (values ? 4 : 0) + 1);
    Frame *frame = header ? malloc(sizeof *frame + FRAME_HEADROOM + size) : NULL;
    if (!frame) {
        free(header);
        return mns_fail(error, MNS_E_MEMORY, "no memory for a picture of %zu particles", n);
    }
    *frame = (Frame){.wish = *wish, .key = key, .size = size};
    unsigned char *to = put_u32(frame->bytes + FRAME_HEADROOM, (uint32_t)padded);
    to = put_u32(to, 0);
    memset(to, ' ', padded);
    memcpy(to, header, length);
    free(header);
    to = put_places(to + padded, places);
    if (values) to = put_values(to, values);
    put_phases(to, phases);
    *ret = frame;
    return MNS_OK;
}

void frame_set_skipped(Frame *frame, uint64_t skipped)
{
    put_u32(frame->bytes + FRAME_HEADROOM + 4, skipped < UINT32_MAX ? (uint32_t)skipped : UINT32_MAX);
}

void frame_free(Frame *frame)
{
    free(frame);
}
