/* SPDX-License-Identifier: BSD-3-Clause */
/* The table of fields: allocation, sorting, output, restart, probes and queries all walk it. A new field is one member of
 * Particles and one row here. */
#ifndef SIM_FIELD_H
#define SIM_FIELD_H

#include <meniscus/sim.h>

/* ROW(what code calls it, name, unit, meaning, components, type, member of Particles). MADE(what code calls it, name, unit, meaning): a number
 * that follows from others and is stored nowhere (shown.c). Which of them there are, and which a run goes on from, is the scheme's to say
 * (scheme.h). */
#define FIELD_ROWS(ROW, MADE)                                                                                          \
    ROW(ID, "id", "1", "identity, the same for the whole run", 1, MNS_U32, id)                                         \
    ROW(PHASE, "phase", "1", "index of the fluid; number of fluids + index of the wall for wall particles", 1, MNS_U8, \
        phase)                                                                                                         \
    ROW(X, "position", "m", "position", 3, MNS_F64, x)                                                                 \
    ROW(V, "velocity", "m/s", "velocity of the material", 3, MNS_F64, v)                                               \
    ROW(RHO, "density", "kg/m^3", "density", 1, MNS_F64, rho)                                                          \
    ROW(P, "pressure", "Pa", "pressure", 1, MNS_F64, p)                                                                \
    ROW(M, "mass", "kg", "mass; per metre of depth in two dimensions", 1, MNS_F64, m)                                  \
    MADE(VOL, "volume", "m^dim", "mass over density")                                                                  \
    ROW(A, "acceleration", "m/s^2", "acceleration at the end of the step", 3, MNS_F64, a)                              \
    ROW(B, "background_acceleration", "m/s^2",                                                                         \
        "acceleration of the advection velocity by the background pressure (P3 eq. 11)", 3, MNS_F64, b)                \
    ROW(REF, "list_position", "m", "position when the neighbour lists were built", 3, MNS_F64, ref)                    \
    MADE(Z, "impedance", "kg/(m^2 s)", "density times speed of sound")                                                 \
    ROW(SHEPARD, "shepard_sum", "1", "sum of W V over the particle and its neighbours", 1, MNS_F64, shepard)           \
    ROW(GRADIENT, "pressure_gradient", "Pa/m", "gradient of the pressure, exact for linear fields", 3, MNS_F64,        \
        gradient)                                                                                                      \
    ROW(NORMAL, "interface_normal", "1", "towards other fluids, of unit length; 0 away from interfaces", 3, MNS_F64,   \
        normal)                                                                                                        \
    ROW(CURVATURE, "interface_curvature", "1/m",                                                                       \
        "of the interface in reach, positive where its own fluid is inside; 0 away from it", 1, MNS_F64, curvature)    \
    ROW(CONCENTRATION, "concentration_gradient", "1/m",                                                                \
        "sum of V times the kernel's gradient, which points away from room", 3, MNS_F64, concentration)                \
    ROW(CORRECTION, "correction", "1", "of the kernel's gradient or of differences, diagonal of the matrix", 3,        \
        MNS_F64, correction)                                                                                           \
    ROW(CORRECTION_OFF, "correction_off", "1", "the rest of it: xy, xz, yz", 3, MNS_F64, correction_off)               \
    ROW(STRAIN, "strain_rate", "1/s", "rate of strain of its own fluid, diagonal of the matrix; 0 in gases", 3,        \
        MNS_F64, strain)                                                                                               \
    ROW(STRAIN_OFF, "strain_rate_off", "1/s", "the rest of it: xy, xz, yz", 3, MNS_F64, strain_off)                    \
    ROW(OFFSET, "offset", "1/m", "offset vector: where a particle's neighbours lie on average, corrected (P5 eq. 11)", \
        3, MNS_F64, offset)                                                                                            \
    ROW(LAPLACIAN, "laplacian_scale", "m^(dim-2)", "2 dim over the sum of r^2 of the neighbours, weighted (P5 eq. 9)", \
        1, MNS_F64, laplacian)                                                                                         \
    ROW(COLOUR, "colour", "1", "share of the first fluid among neighbours", 1, MNS_F64, colour)                        \
    ROW(COLOUR_GRADIENT, "colour_gradient", "m^2/kg", "gradient of the colour, over density", 3, MNS_F64,              \
        colour_gradient)                                                                                               \
    MADE(RHO_MIXED, "mixed_density", "kg/m^3", "density of the neighbours' mixture")                                   \
    MADE(MU_MIXED, "mixed_viscosity", "Pa s", "viscosity of the neighbours' mixture")                                  \
    ROW(TO_SURFACE, "to_surface", "m", "from a wall particle to the nearest point of its surface", 3, MNS_F64,         \
        to_surface)                                                                                                    \
    ROW(BELT, "surface_velocity", "m/s", "of a wall's surface, besides that of the wall", 3, MNS_F64, belt)            \
    ROW(X0, "position_before", "m", "position at the beginning of the step", 3, MNS_F64, x0)                           \
    ROW(V0, "velocity_before", "m/s", "velocity at the beginning of the step", 3, MNS_F64, v0)                         \
    ROW(RHO0, "density_before", "kg/m^3", "density at the beginning of the step", 1, MNS_F64, rho0)

#define FIELD_ID(id, ...) F_##id,
typedef enum FieldId { FIELD_ROWS(FIELD_ID, FIELD_ID) FIELDS_END } FieldId;

/* A set of fields: FIELD(X) | FIELD(V). */
typedef uint64_t Fields;
#define FIELD(id) (UINT64_C(1) << F_##id)
static const Fields ALL_FIELDS = ~UINT64_C(0);

/* Those that are stored nowhere. */
#define FIELD_STORED(id, ...)
#define FIELD_MADE(id, ...) | FIELD(id)
static const Fields MADE_FIELDS = 0 FIELD_ROWS(FIELD_STORED, FIELD_MADE);

_Static_assert((int)FIELDS_END <= (int)MNS_MAX_FIELDS, "captures and sets of fields have room for all");

#endif
