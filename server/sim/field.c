/* SPDX-License-Identifier: BSD-3-Clause */
/* What the table of fields says, and where Particles has them. */
#include "sim/field.h"
#include "sim/particles.h"
#include <string.h>

#define PUBLIC(id, name, unit, meaning, components, type, member) {name, unit, meaning, components, type},
#define PUBLIC_MADE(id, name, unit, meaning)                      {name, unit, meaning, 1, MNS_F64},
#define SLOT(id, name, unit, meaning, components, type, member)   offsetof(Particles, member),
#define NO_SLOT(...)                                              SIZE_MAX,

static const MnsFieldInfo FIELDS[] = {FIELD_ROWS(PUBLIC, PUBLIC_MADE){0}};
static const size_t SLOTS[] = {FIELD_ROWS(SLOT, NO_SLOT)}; /* where Particles has the pointer to the first component */

const MnsFieldInfo *mns_fields(void)
{
    return FIELDS;
}

int mns_field_find(const char *name)
{
    for (int k = 0; FIELDS[k].name; k++)
        if (strcmp(FIELDS[k].name, name) == 0) return k;
    return -1;
}

size_t field_size(const MnsFieldInfo *field)
{
    switch (field->type) {
    case MNS_F64: return sizeof(double);
    case MNS_U32: return sizeof(uint32_t);
    case MNS_U8: return sizeof(uint8_t);
    }
    return 0;
}

Owners particles_owners(const Particles *s, int field)
{
    if (WALL_FIELDS >> field & 1) return (Owners){particles_fluid(s), s->n};
    return (Owners){0, s->of_fluid >> field & 1 ? particles_fluid(s) : s->n};
}

Fields particles_parted(const Particles *s)
{
    const size_t fluid = particles_fluid(s);
    return s->fields & ((fluid < s->n ? s->of_fluid : 0) | (fluid > 0 ? WALL_FIELDS : 0));
}

/* Where the pointer to component d of a field is. */
static size_t slot_of(int field, int d)
{
    return SLOTS[field] + (size_t)d * sizeof(void *);
}

static void *pointer_of(const Particles *s, int field, int d)
{
    void *pointer = NULL;
    if (d < FIELDS[field].components && SLOTS[field] != SIZE_MAX)
        memcpy(&pointer, (const char *)s + slot_of(field, d), sizeof pointer);
    return pointer;
}

void *particles_field(const Particles *s, int field, int d)
{
    return s->housed >> field & 1 ? NULL : pointer_of(s, field, d);
}

void *particles_element(const Particles *s, int field, int d, size_t i)
{
    const Owners owners = particles_owners(s, field);
    char *first = pointer_of(s, field, d);
    if (!first || i < owners.first || i >= owners.last) return NULL;
    return first + (i - owners.first) * particles_step(s, field) * field_size(&FIELDS[field]);
}

void particles_set_field(Particles *s, int field, int d, void *array)
{
    memcpy((char *)s + slot_of(field, d), &array, sizeof array);
}

/* Of the fields that may be in bundles; NULL of others. */
static size_t *step_of(Particles *s, int field)
{
    switch (field) {
    case F_X: return &s->x_step;
    case F_V: return &s->v_step;
    case F_P: return &s->p_step;
    case F_NORMAL: return &s->normal_step;
    case F_GRADIENT: return &s->gradient_step;
    case F_OFFSET: return &s->offset_step;
    default: return NULL;
    }
}

size_t particles_step(const Particles *s, int field)
{
    const size_t *step = step_of((Particles *)s, field);
    return step ? *step : 1;
}

void particles_set_step(Particles *s, int field, size_t step)
{
    *step_of(s, field) = step;
}
