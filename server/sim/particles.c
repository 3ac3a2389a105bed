/* SPDX-License-Identifier: BSD-3-Clause */
/* Allocate and permute the particles, field by field. */
#include "sim/particles.h"
#include "base/array.h"
#include "sim/making.h"
#include <stdlib.h>
#include <string.h>

int particles_components(const Particles *s, int field)
{
    if (!(s->fields >> field & 1)) return 0;
    return mns_fields()[field].components == 1 ? 1 : s->dim;
}

static size_t owners_of(const Particles *s, int field)
{
    const Owners owners = particles_owners(s, field);
    return owners.last - owners.first;
}

static MnsStatus allocate_fields(Particles *s, int threads, const MnsMaking *making, MnsError *error)
{
    const MnsFieldInfo *fields = mns_fields();
    for (int f = 0; fields[f].name; f++)
        for (int d = 0; d < particles_components(s, f); d++) {
            if (particles_field(s, f, d)) continue;
            const MnsStatus status = making ? making_goes_on(making, error) : MNS_OK;
            if (status) return status;
            void *array = array_new_team(owners_of(s, f), field_size(&fields[f]), threads);
            if (!array) return mns_fail(error, MNS_E_MEMORY, "no memory for %zu particles", s->n);
            particles_set_field(s, f, d, array);
        }
    return MNS_OK;
}

static MnsStatus allocate(Particles *s, bool mirrored, int threads, const MnsMaking *making, MnsError *error)
{
    const size_t n_wall = s->n - particles_fluid(s);
    const MnsStatus status = allocate_fields(s, threads, making, error);
    if (status) return status;
    bool well = (s->rate = array_new_team(s->n, sizeof(double), threads));
    for (size_t k = 0; well && k < s->n_phases; k++)
        well = (s->p_wall[k] = array_new_team(n_wall, sizeof(double), threads));
    for (int d = 0; well && mirrored && d < s->dim; d++)
        well = (s->v_wall[d] = array_new_team(n_wall, sizeof(double), threads));
    return well ? MNS_OK : mns_fail(error, MNS_E_MEMORY, "no memory for %zu particles", s->n);
}

MnsStatus particles_init(Particles *s, int dim, size_t n_phases, const size_t sizes[GROUPS], Fields fields,
                         Fields of_fluid, bool mirrored, int threads, const MnsMaking *making, MnsError *error)
{
    *s = (Particles){.dim = dim, .n_phases = n_phases, .fields = fields, .of_fluid = of_fluid};
    s->x_step = s->v_step = s->p_step = s->normal_step = s->gradient_step = s->offset_step = 1;
    for (int g = 0; g < GROUPS; g++) s->begin[g + 1] = s->begin[g] + sizes[g];
    s->n = s->begin[GROUPS];
    const MnsStatus status = allocate(s, mirrored, threads, making, error);
    if (status) particles_done(s);
    else particles_changed(s, ON_ALL, ALL_FIELDS);
    return status;
}

MnsStatus particles_add(Particles *s, Fields fields, int threads, MnsError *error)
{
    const Fields before = s->fields;
    s->fields |= fields;
    const MnsStatus status = allocate_fields(s, threads, NULL, error);
    if (status) particles_keep(s, before);
    return status;
}

void particles_keep(Particles *s, Fields fields)
{
    for (int f = 0; mns_fields()[f].name; f++)
        for (int d = 0; d < particles_components(s, f) && !(fields >> f & 1); d++) {
            free(particles_field(s, f, d));
            particles_set_field(s, f, d, NULL);
        }
    s->fields &= fields;
}

void particles_done(Particles *s)
{
    const MnsFieldInfo *fields = mns_fields();
    for (int f = 0; fields[f].name; f++)
        for (int d = 0; d < fields[f].components; d++) free(particles_field(s, f, d));
    for (size_t k = 0; k < MNS_MAX_FLUIDS; k++) free(s->p_wall[k]);
    for (int d = 0; d < 3; d++) free(s->v_wall[d]);
    free(s->rate);
    free(s->power);
    *s = (Particles){0};
}

static void permute_f64(double *restrict to, const double *restrict from, const uint32_t *restrict order, size_t n,
                        int threads)
{
#pragma omp parallel for simd schedule(static) num_threads(threads)
    for (size_t k = 0; k < n; k++) to[k] = from[order[k]];
}

static void permute_u32(uint32_t *restrict to, const uint32_t *restrict from, const uint32_t *restrict order, size_t n,
                        int threads)
{
#pragma omp parallel for simd schedule(static) num_threads(threads)
    for (size_t k = 0; k < n; k++) to[k] = from[order[k]];
}

static void permute_u8(uint8_t *restrict to, const uint8_t *restrict from, const uint32_t *restrict order, size_t n,
                       int threads)
{
#pragma omp parallel for schedule(static) num_threads(threads)
    for (size_t k = 0; k < n; k++) to[k] = from[order[k]];
}

/* memcpy() by all threads. */
static void copy(void *restrict to, const void *restrict from, size_t bytes, int threads)
{
    enum { PIECE = 1 << 16 };
#pragma omp parallel for schedule(static) num_threads(threads)
    for (size_t k = 0; k < bytes; k += PIECE)
        memcpy((char *)to + k, (const char *)from + k, bytes - k < PIECE ? bytes - k : PIECE);
}

/* Fill the work space and let it change places with the field. */
static void permute_field(Particles *s, int f, int d, const uint32_t *order, int threads)
{
    void *from = particles_field(s, f, d), *to = s->rate;
    switch (mns_fields()[f].type) {
    case MNS_F64:
        permute_f64(to, from, order, s->n, threads);
        particles_set_field(s, f, d, to);
        s->rate = from;
        break;
    case MNS_U32:
        permute_u32(to, from, order, s->n, threads);
        copy(from, to, s->n * sizeof(uint32_t), threads);
        break;
    case MNS_U8:
        permute_u8(to, from, order, s->n, threads);
        copy(from, to, s->n, threads);
        break;
    }
}

static void permute_housed(Particles *s, int f, int d, const uint32_t *order, int threads)
{
    double *restrict room = s->rate, *restrict first = particles_element(s, f, d, 0);
    const size_t step = particles_step(s, f), n = s->n;
#pragma omp parallel for schedule(static) num_threads(threads)
    for (size_t k = 0; k < n; k++) room[k] = first[order[k] * step];
#pragma omp parallel for schedule(static) num_threads(threads)
    for (size_t k = 0; k < n; k++) first[k * step] = room[k];
}

/* Numbers of the particles [first, first + n) alone: the work space is for all, and does not change places with them. */
static void permute_part(Particles *s, double *restrict part, size_t first, size_t n, const uint32_t *order,
                         int threads)
{
    double *restrict room = s->rate;
#pragma omp parallel for schedule(static) num_threads(threads)
    for (size_t k = 0; k < n; k++) room[k] = part[order[first + k] - first];
    copy(part, room, n * sizeof *part, threads);
}

void particles_permute(Particles *s, const uint32_t *from, int threads)
{
    const Fields parted = particles_parted(s);
    for (int f = 0; mns_fields()[f].name; f++)
        for (int d = 0; d < particles_components(s, f); d++) {
            if (s->housed >> f & 1) permute_housed(s, f, d, from, threads);
            else if (parted >> f & 1)
                permute_part(s, particles_field(s, f, d), particles_owners(s, f).first, owners_of(s, f), from, threads);
            else permute_field(s, f, d, from, threads);
        }
    const size_t first = particles_fluid(s), n_wall = s->n - first;
    for (size_t a = 0; a < s->n_phases; a++) permute_part(s, s->p_wall[a], first, n_wall, from, threads);
    particles_changed(s, ON_ALL, ALL_FIELDS);
}

size_t particles_bytes(const Particles *s)
{
    size_t fields = 0;
    for (int f = 0; mns_fields()[f].name; f++)
        if (!(s->housed >> f & 1))
            fields += owners_of(s, f) * field_size(&mns_fields()[f]) * (size_t)particles_components(s, f);
    return fields + s->n * sizeof *s->rate + (s->power ? particles_fluid(s) * sizeof *s->power : 0) +
           (s->n - particles_fluid(s)) * sizeof(double) * (s->n_phases + (s->v_wall[0] ? (size_t)s->dim : 0));
}
