/* SPDX-License-Identifier: BSD-3-Clause */
/* The table of fields: allocation, sorting, output, restart, probes and queries all walk it. A new field is one member of
 * Particles and one row here. */
#include "sim/particles.h"
#include <string.h>

/* ROW(name, unit, meaning, components, type, in checkpoints, member of Particles) */
#define FIELD_ROWS(ROW)                                                                                                \
    ROW("id", "1", "identity, the same for the whole run", 1, MNS_U32, true, id)                                       \
    ROW("phase", "1", "index of the fluid; number of fluids + index of the wall for wall particles", 1, MNS_U8, true,  \
        phase)                                                                                                         \
    ROW("position", "m", "position", 3, MNS_F64, true, x)                                                              \
    ROW("velocity", "m/s", "velocity of the material", 3, MNS_F64, true, v)                                            \
    ROW("density", "kg/m^3", "density", 1, MNS_F64, true, rho)                                                         \
    ROW("pressure", "Pa", "pressure", 1, MNS_F64, false, p)                                                            \
    ROW("mass", "kg", "mass; per metre of depth in two dimensions", 1, MNS_F64, true, m)                               \
    ROW("volume", "m^dim", "mass over density", 1, MNS_F64, false, vol)                                                \
    ROW("acceleration", "m/s^2", "acceleration at the end of the step", 3, MNS_F64, true, a)                           \
    ROW("background_acceleration", "m/s^2",                                                                            \
        "acceleration of the advection velocity by the background pressure (P3 eq. 11)", 3, MNS_F64, true, b)          \
    ROW("list_position", "m", "position when the neighbour lists were built", 3, MNS_F64, true, ref)                   \
    ROW("impedance", "kg/(m^2 s)", "density times speed of sound", 1, MNS_F64, false, z)

#define PUBLIC(name, unit, meaning, components, type, state, member) {name, unit, meaning, components, type, state},
#define SLOT(name, unit, meaning, components, type, state, member)   offsetof(Particles, member),

static const MnsFieldInfo FIELDS[] = {FIELD_ROWS(PUBLIC){0}};
static const size_t SLOTS[] = {FIELD_ROWS(SLOT)}; /* where Particles has the pointer to the first component */

_Static_assert(sizeof FIELDS / sizeof *FIELDS - 1 <= MNS_MAX_FIELDS, "captures and sets of fields have room for all");

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

uint64_t mns_state_fields(void)
{
    uint64_t fields = 0;
    for (int k = 0; FIELDS[k].name; k++)
        if (FIELDS[k].is_state) fields |= UINT64_C(1) << k;
    return fields;
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

/* Where the pointer to component d of a field is. */
static size_t slot_of(int field, int d)
{
    return SLOTS[field] + (size_t)d * sizeof(void *);
}

void *particles_field(const Particles *s, int field, int d)
{
    void *pointer = NULL;
    if (d < FIELDS[field].components) memcpy(&pointer, (const char *)s + slot_of(field, d), sizeof pointer);
    return pointer;
}

void particles_set_field(Particles *s, int field, int d, void *array)
{
    memcpy((char *)s + slot_of(field, d), &array, sizeof array);
}
