/* SPDX-License-Identifier: BSD-3-Clause */
/* All particles, as a structure of arrays: fluid first, then the dummy particles of the walls. Storage order changes when
 * they are sorted; ids never do. The table of what there is, with units, is in field.h. */
#ifndef SIM_PARTICLES_H
#define SIM_PARTICLES_H

#include "sim/field.h"
#include "sim/model.h"

/* Groups are contiguous. They differ in how the density is found, so that no loop over particles asks. */
typedef enum Group { GROUP_CONTINUITY, GROUP_SUMMATION, GROUP_WALL, GROUPS } Group;
enum { ON_CONTINUITY = 1, ON_SUMMATION = 2, ON_WALL = 4, ON_FLUID = 3, ON_ALL = 7 };

typedef struct Particles {
    int dim;
    size_t n, n_phases;
    Fields fields;            /* that there are: those that the scheme needs; the pointers of others are NULL */
    size_t begin[GROUPS + 1]; /* group g is [begin[g], begin[g + 1]) */
    uint32_t *id;
    uint8_t *phase;                                     /* fluid; n_phases + wall for a dummy particle */
    double *x[3], *v[3], *a[3];                         /* position, velocity, acceleration */
    double *b[3];                                       /* acceleration by the background pressure, a_b of P3 eq. 11 */
    double *ref[3];                                     /* position when the neighbour lists were built */
    double *m, *rho, *p;                                /* mass, density, pressure */
    double *shepard;                                    /* sum of W V */
    double *gradient[3], *normal[3], *concentration[3]; /* of the pressure; of the interface, 0 away from it */
    double *curvature;                                  /* of the interface in reach (terms/curvature.c) */
    double *strain[3], *strain_off[3];                  /* rates of strain: xx, yy, zz; xy, xz, yz */
    double *correction[3], *correction_off[3]; /* of the kernel's gradient or of differences: xx, yy, zz; xy, xz, yz */
    double *offset[3], *laplacian;             /* of differences (terms/differences.h) */
    double *colour, *colour_gradient[3];       /* of what is around: share of the first fluid */
    double *to_surface[3];                     /* [n_wall] */
    double *belt[3];                /* [n_wall] what friction adds to the velocity of a wall; NULL: nothing */
    double *x0[3], *v0[3], *rho0;   /* at the beginning of the step, for integrators of more than one evaluation */
    double *p_wall[MNS_MAX_FLUIDS]; /* [n_wall] pressure a wall shows to each fluid */
    double *v_wall[3]; /* [n_wall] velocity that a wall shows, as the scheme's term for it says; NULL where none asks */
    /* [n] within a step: of continuity d rho/dt, of summation the sum of W, while particles are shifted |v|^2 from before; between steps
     * work space to permute, and of fluid_sum() */
    double *rate;
    double *power; /* [n_fluid] of walls, within the account of energy; NULL where none asks [W] */
    struct System
        *system;   /* for the pressure, of schemes that project (solve/solve.h); NULL of others. Not theirs to free */
    Fields housed; /* that are in bundles and nowhere else (home.h) */
    size_t x_step, v_step, p_step, normal_step, gradient_step, offset_step; /* from a particle's to the next one's */
    Fields made;                                                            /* that are made where they are asked for */
    Fields of_fluid;        /* of which there is room for the fluid alone */
    Fields changed[GROUPS]; /* since the neighbours' copies were last made (bundle.h) */
} Particles;

static inline size_t particles_fluid(const Particles *s)
{
    return s->begin[GROUP_WALL];
}

/* What only fluid moves by or has differences with, and what only walls have: no others need room for it. What they are shown with is 0. */
static const Fields FLUID_FIELDS = FIELD(A) | FIELD(CURVATURE) | FIELD(CONCENTRATION) | FIELD(CORRECTION) |
                                   FIELD(CORRECTION_OFF) | FIELD(LAPLACIAN) | FIELD(COLOUR_GRADIENT) | FIELD(X0) |
                                   FIELD(V0) | FIELD(RHO0);
static const Fields WALL_FIELDS = FIELD(TO_SURFACE) | FIELD(BELT);

/* Made of density and mass each time; neighbours' are in bundles. A wall particle takes up its cell of the lattice. */
INLINE double particles_volume(const Particles *s, const Model *model, size_t i)
{
    return i < particles_fluid(s) ? s->m[i] / s->rho[i] : model->cell_volume;
}

/* Of the surface of wall particle i, as what sticks to it feels it. What flows together and what pushes has v alone: a surface moves along itself. */
INLINE double particles_surface_velocity(const Particles *s, int d, size_t i)
{
    const double v = s->v[d][i * s->v_step];
    return s->belt[d] ? v + s->belt[d][i - particles_fluid(s)] : v;
}

/* Walls have none. */
INLINE double particles_impedance(const Particles *s, const Model *model, size_t i)
{
    return i < particles_fluid(s) ? s->rho[i] * model->phase[s->phase[i]].c : 0;
}

/* What is linear in the share of the first fluid among neighbours.                                                      P5 eq. 6, 7 */
typedef struct Mixture {
    double one, jump; /* of the last fluid; from that to the first */
} Mixture;

INLINE Mixture mixture_of_densities(const Model *model)
{
    const double one = model->phase[model->n_phases - 1].rho0;
    return (Mixture){one, model->phase[0].rho0 - one};
}

INLINE Mixture mixture_of_viscosities(const Model *model)
{
    const double one = model->phase[model->n_phases - 1].mu;
    return (Mixture){one, model->phase[0].mu - one};
}

INLINE double mixed(Mixture mixture, double colour)
{
    return mixture.one + mixture.jump * colour;
}

/* Whoever writes fields of these groups (ON_FLUID ...) says so. Passes do it for terms and local rules. */
static inline void particles_changed(Particles *s, unsigned on, Fields fields)
{
    for (int g = 0; g < GROUPS; g++)
        if (on >> g & 1) s->changed[g] |= fields;
}

/* Arrays of zeros for groups of these sizes, made by so many threads. MNS_E_MEMORY, MNS_E_INTERRUPTED: nothing is left behind.
 *  of_fluid  those of which there is room for the fluid alone; tests give walls room for all
 *  mirrored  walls show the fluid a velocity
 *  making  asked before each array, as to fill one may take a second; NULL: nobody gives up */
MnsStatus particles_init(Particles *s, int dim, size_t n_phases, const size_t sizes[GROUPS], Fields fields,
                         Fields of_fluid, bool mirrored, int threads, const MnsMaking *making, MnsError *error);
void particles_done(Particles *s);

/* Arrays of zeros for fields that there are not yet. MNS_E_MEMORY: those that were there are. */
MnsStatus particles_add(Particles *s, Fields fields, int threads, MnsError *error);

/* Give up the fields that are not among these. */
void particles_keep(Particles *s, Fields fields);

/* How many components of a field there are; 0 of one that is not stored. */
int particles_components(const Particles *s, int field);

/* Particles [first, last), who have a field. */
typedef struct Owners {
    size_t first, last;
} Owners;
Owners particles_owners(const Particles *s, int field);

/* Fields that some do not have. */
Fields particles_parted(const Particles *s);

/* Component d of a field of mns_fields(), one number after the other for its owners; NULL where there is none, or none that is stored so. */
void *particles_field(const Particles *s, int field, int d);

/* That of particle i, wherever it is stored; NULL where there is none, and of who does not have it. */
void *particles_element(const Particles *s, int field, int d, size_t i);
void particles_set_field(Particles *s, int field, int d, void *array); /* one that there is */
size_t particles_step(const Particles *s, int field);                  /* from one to the next */
void particles_set_step(Particles *s, int field, size_t step);         /* of one that is housed */
size_t field_size(const MnsFieldInfo *field);                          /* bytes of an element */

/* New storage order: what was at from[k] comes to k. Groups must stay where they are. */
void particles_permute(Particles *s, const uint32_t *from, int threads);

size_t particles_bytes(const Particles *s);

#endif
