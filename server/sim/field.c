/* SPDX-License-Identifier: BSD-3-Clause */
/* The table of fields: allocation, sorting, output, restart, probes and queries all walk it. A new field is one member of
 * Particles and one row here. */
#include "sim/particles.h"
#include <string.h>

#define SLOT(member) offsetof(Particles, member)

static const MnsFieldInfo FIELDS[] = {
    {"id", "1", "identity, the same for the whole run", 1, MNS_U32, true, SLOT(id)},
    {"phase", "1", "index of the fluid; number of fluids + index of the wall for wall particles", 1, MNS_U8, true,
     SLOT(phase)},
    {"position", "m", "position", 3, MNS_F64, true, SLOT(x)},
    {"velocity", "m/s", "velocity of the material", 3, MNS_F64, true, SLOT(v)},
    {"density", "kg/m^3", "density", 1, MNS_F64, true, SLOT(rho)},
    {"pressure", "Pa", "pressure", 1, MNS_F64, false, SLOT(p)},
    {"mass", "kg", "mass; per metre of depth in two dimensions", 1, MNS_F64, true, SLOT(m)},
    {"volume", "m^dim", "mass over density", 1, MNS_F64, false, SLOT(vol)},
    {"acceleration", "m/s^2", "acceleration at the end of the step", 3, MNS_F64, true, SLOT(a)},
    {"background_acceleration", "m/s^2",
     "acceleration of the advection velocity by the background pressure (P3 eq. 11)", 3, MNS_F64, true, SLOT(b)},
    {"advection_velocity_excess", "m/s", "advection velocity less velocity", 3, MNS_F64, false, SLOT(w)},
    {"list_position", "m", "position when the neighbour lists were built", 3, MNS_F64, true, SLOT(ref)},
    {"impedance", "kg/(m^2 s)", "density times speed of sound", 1, MNS_F64, false, SLOT(z)},
    {0},
};

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

void *particles_field(const Particles *s, int field, int d)
{
    void *pointer = NULL;
    const size_t slot = FIELDS[field].slot + (size_t)d * sizeof pointer;
    if (d < FIELDS[field].components) memcpy(&pointer, (const char *)s + slot, sizeof pointer);
    return pointer;
}
