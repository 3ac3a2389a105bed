/* SPDX-License-Identifier: BSD-3-Clause */
/* Which particles of a capture a stream has. */
#include "net/selection.h"

#include "run/tap.h"
#include <string.h>

/* The finalizer of MurmurHash3. */
uint32_t selection_scatter(uint32_t id)
{
    id = (id ^ id >> 16) * 0x85ebca6bu;
    id = (id ^ id >> 13) * 0xc2b2ae35u;
    return id ^ id >> 16;
}

static uint64_t bit(const char *name)
{
    return UINT64_C(1) << mns_field_find(name);
}

uint64_t selection_fields(const Selection *s)
{
    return (s->boxed || s->ball ? bit("position") : 0) | (s->mixed ? bit("phase") : 0) | (s->every > 1 ? bit("id") : 0);
}

/* Each condition goes over those that are left: what there is no condition for costs nothing. */
static size_t keep_within(const Selection *s, const MnsCapture *capture, uint32_t *chosen, size_t n)
{
    void *const *x = capture->data[mns_field_find("position")];
    size_t left = 0;
    for (size_t k = 0; k < n; k++) {
        const uint32_t i = chosen[k];
        double distance2 = 0;
        bool within = true;
        for (int d = 0; d < capture->dim; d++) {
            const double at = ((const double *)x[d])[i], off = at - s->centre[d];
            within = within && (!s->boxed || (at >= s->min[d] && at <= s->max[d]));
            distance2 += off * off;
        }
        chosen[left] = i;
        left += within && (!s->ball || distance2 <= s->radius * s->radius);
    }
    return left;
}

static size_t keep_phases(const Selection *s, const MnsCapture *capture, uint32_t *chosen, size_t n)
{
    const uint8_t *phase = capture->data[mns_field_find("phase")][0];
    size_t left = 0;
    for (size_t k = 0; k < n; k++) {
        const uint8_t p = phase[chosen[k]];
        chosen[left] = chosen[k];
        left += s->phases[p / 64] >> p % 64 & 1;
    }
    return left;
}

static size_t keep_few(const Selection *s, const MnsCapture *capture, uint32_t *chosen, size_t n)
{
    const uint32_t *id = capture->data[mns_field_find("id")][0];
    const uint64_t below = ((uint64_t)UINT32_MAX + 1) / s->every;
    size_t left = 0;
    for (size_t k = 0; k < n; k++) {
        chosen[left] = chosen[k];
        left += selection_scatter(id[chosen[k]]) < below;
    }
    return left;
}

size_t selection_choose(const Selection *selection, const MnsCapture *capture, uint32_t *chosen)
{
    size_t n = selection->walls ? capture->n : capture->n_fluid;
    for (size_t i = 0; i < n; i++) chosen[i] = (uint32_t)i;
    if (selection->every > 1) n = keep_few(selection, capture, chosen, n);
    if (selection->mixed) n = keep_phases(selection, capture, chosen, n);
    if (selection->boxed || selection->ball) n = keep_within(selection, capture, chosen, n);
    return n;
}

const char *selection_numpy(MnsType type)
{
    return type == MNS_F64 ? "<f8" : type == MNS_U32 ? "<u4" : "|u1";
}

static int components(const MnsCapture *capture, int field)
{
    return mns_fields()[field].components == 1 ? 1 : capture->dim;
}

size_t selection_width(const MnsCapture *capture, int field)
{
    return (size_t)components(capture, field) * tap_number_size(mns_fields()[field].type);
}

/* Most of what is asked for are numbers of eight bytes, and this is most of the time that a stream takes. */
static void gather_doubles(const double *from, const uint32_t *chosen, size_t n, size_t stride, double *to)
{
    if (!chosen && stride == 1) memcpy(to, from, n * sizeof *to);
    else if (!chosen)
        for (size_t k = 0; k < n; k++) to[k * stride] = from[k];
    else
        for (size_t k = 0; k < n; k++) to[k * stride] = from[chosen[k]];
}

static void gather_bytes(const char *from, const uint32_t *chosen, size_t n, size_t size, char *to)
{
    for (size_t k = 0; k < n; k++) memcpy(to + k * size, from + (chosen ? chosen[k] : k) * size, size);
}

void selection_gather(const MnsCapture *capture, int field, const uint32_t *chosen, size_t n, void *to)
{
    const int parts = components(capture, field);
    const MnsType type = mns_fields()[field].type;
    for (int d = 0; d < parts; d++)
        if (type == MNS_F64) gather_doubles(capture->data[field][d], chosen, n, (size_t)parts, (double *)to + d);
        else gather_bytes(capture->data[field][d], chosen, n, tap_number_size(type), to); /* these have one component */
}
