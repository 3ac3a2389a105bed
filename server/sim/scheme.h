/* SPDX-License-Identifier: BSD-3-Clause */
/* A scheme is a list of passes; a pass is a list of terms and local rules. Adding a scheme is a file in schemes/, its terms,
 * and a row of the table in scheme.c. */
#ifndef SIM_SCHEME_H
#define SIM_SCHEME_H

#include "sim/row.h"

/* One sum over neighbours, one formula of a paper. */
typedef struct Term {
    const char *name, *source; /* "riemann momentum", "P3 eq. 9": what `meniscus schemes` prints */
    const char *equation;
    unsigned on;                   /* whose sums: ON_CONTINUITY | ON_SUMMATION | ON_WALL */
    bool (*needed)(const Model *); /* NULL: always */
    unsigned needs;                /* of each pair: NEED_F | NEED_V ... */
    Fields writes;
    unsigned beside;   /* nothing to do for particles whose lists have no such neighbours: LIST_...; 0: for all */
    bool takes_motion; /* a power, of walls that move: zero where only their surfaces do */
    RowFunction row[LEVELS][2]; /* ROW_TABLE() */
} Term;

static inline bool term_needed(const Term *term, const Model *model)
{
    return !term->needed || term->needed(model);
}

static inline void term_row(const Term *term, const Row *row, Particles *s, const Model *model)
{
    term->row[model->level][s->dim - 2](row, s, model);
}

/* One rule per particle of a range, no neighbours: state equation, clearing, gravity. */
typedef struct Local {
    const char *name, *source, *equation;
    unsigned on;
    bool (*needed)(const Model *); /* NULL: always */
    void (*apply)(Particles *, const Model *, size_t first, size_t last);
    void (*whole)(Particles *, const Model *, int threads); /* instead, of one that needs all at once */
    Fields writes;                                          /* and those made of these that it is to be shown with */
} Local;

static inline bool local_needed(const Local *local, const Model *model)
{
    return !local->needed || local->needed(model);
}

enum { PASS_TERMS_MAX = 8, PASS_LOCALS_MAX = 4, PASS_FUSIONS_MAX = 6 };

/* Several terms in one function (fused.h), used for particles that need just these. */
typedef struct Fusion {
    const Term *terms[PASS_TERMS_MAX]; /* end with NULL; in the order of the pass, as are those that follow */
    const Term *also[PASS_TERMS_MAX];  /* what it does where it is needed, and finds out itself; end with NULL */
    bool (*needed)(const Model *);     /* is it for fluids like these? NULL: for all */
    unsigned not_for;                  /* particles whose lists have such neighbours: LIST_... */
    unsigned not_together;             /* nor those that have all of these, unless it is 0 */
    bool with_images;                  /* is it for particles that have images in a mirror too? */
    bool notes;                        /* does it note which of all that are listed are in reach (note_reach())? */
    FusedFunction row[LEVELS][2];      /* FUSED_TABLE() or BESIDE_TABLE(); NULL: not at this level */
} Fusion;

/* Is it for particles that have neighbours of these kinds? */
static inline bool fusion_serves(const Fusion *fusion, unsigned kinds)
{
    const unsigned together = fusion->not_together;
    return !(fusion->not_for & kinds) && !(together && (kinds & together) == together);
}

/* One sweep: local rules before, terms sharing a Row, local rules after. All lists end with NULL. */
typedef struct Pass {
    const char *name;
    const Local *before[PASS_LOCALS_MAX];
    const Term *terms[PASS_TERMS_MAX];
    const Local *after[PASS_LOCALS_MAX];
    const Fusion *fusions[PASS_FUSIONS_MAX];
    bool assembles; /* the matrix of a pressure */
    /* Not at the end of a step, but in its middle and at a start: what it finds changes slowly, and is part of the state. */
    bool halfway;
} Pass;

/* How a step is made of evaluations of the rates. */
typedef struct Integrator {
    const char *name, *source, *equation;
    MnsStatus (*step)(MnsSim *, double t, double dt, MnsError *error); /* of length dt, to t */
    void (*renew)(MnsSim *); /* what else is new, after the rates, under another gravity or other options; or NULL */
    Fields works;            /* room it needs within a step */
    bool halfway;            /* it asks for walls half-way too */
    bool staggered;          /* its rates are of velocities of half a step before the positions */
} Integrator;

/* A bound of the time step; INFINITY where it does not bind. */
typedef struct Limit {
    const char *name, *source, *equation;
    const char *entries;                         /* of the case, that would change it */
    double (*of)(const MnsSim *);                /* [s] */
    double (*within)(const MnsSim *, double dt); /* instead, of one that looks ahead as far as those before it allow */
} Limit;

/* A kernel that a scheme was measured with, and the smoothing lengths over the spacing that are advised and that hold. */
typedef struct Suited {
    MnsKernel kernel;
    double advised, least, most;
} Suited;

enum { SCHEME_KERNELS_MAX = 2 };

enum { SCHEME_PASSES_MAX = 12, SCHEME_LIMITS_MAX = 8, POWER_TERMS_MAX = 3 };

typedef struct Scheme {
    const char *name, *title, *source;
    const Integrator *integrator;
    const Limit *limits[SCHEME_LIMITS_MAX]; /* ends with NULL */
    /* In the order in which the integrator goes through them; a nameless one ends the list. */
    Pass rates[SCHEME_PASSES_MAX + 1];
    const Term *power[POWER_TERMS_MAX + 1]; /* of walls that move, on the fluid; ends with NULL */
    Fields state;                           /* what a run goes on from: in checkpoints and in the hash */
    int given;    /* passes [0, given) are left out at the start: the case gives their results */
    Pass instead; /* of these, where rates are found of what is given: what the others ask for and no state has */
    /* After a state was set or restored: what follows from it without neighbours, NULL if nothing does that is stored, and the passes
     * [first, end) for what follows with them. */
    const Local *derive;
    int derived_passes[2];
    bool projects;         /* solves for the pressure: particles have a system for it */
    bool symmetric;        /* its matrices are */
    bool corrects_density; /* by a second pressure */
    bool floors_mirror; /* images have the pressure of their depth: sides across gravity are mirrors too (mirrors.h) */
    double energy_excess;                      /* that is not warned of (energy.c); 0: 0.01 */
    double arithmetic_ratio;                   /* of densities, up to which arithmetic averages hold; 0: none */
    bool reads_density_method, reads_exponent; /* of a fluid */
    bool takes_background;                     /* a background_pressure is in all pressures */
    bool needs_background;                     /* and must be there where there is surface tension */
    double tense_ratio;                        /* of densities, up to which it holds surface tension; 0: any */
    Suited suited[SCHEME_KERNELS_MAX + 1];     /* the first is advised; ends with a most of 0 */
    double free_smoothing; /* the least of viscous fluids that leave a part of the domain empty; 0: as elsewhere */
    /* Of the sound of a light fluid over that of a heavy one, what it holds; NULL: any. */
    void (*bound_sound)(const MnsCase *, size_t light, size_t heavy, double *ret_low, double *ret_high);
    void (*look)(MnsSim *); /* what else it warns of, at a start and whenever it is steered; or NULL */
    MnsStatus (*check)(const MnsCase *, MnsError *); /* its options, and whether it is for such a case */
    /* Whether those options are alike that cannot change during a run; NULL: all can. */
    bool (*keeps_options)(const MnsSchemeOptions *, const MnsSchemeOptions *);
    void (*options)(Model *, const MnsCase *); /* from the case to the model */
} Scheme;

extern const Scheme scheme_riemann, scheme_dissipation, scheme_interfacial, scheme_incompressible, scheme_differences;

/* All fields that its particles have with these options: a term or a rule that is not needed writes nothing. Those that are stored, and those
 * that are made where they are asked for. */
Fields scheme_fields(const Scheme *scheme, const Model *model);
Fields scheme_made(const Scheme *scheme, const Model *model);

/* All that its terms need of pairs, with these options. */
unsigned scheme_needs(const Scheme *scheme, const Model *model);

/* By name; NULL if there is none. */
const Scheme *scheme_find(const char *name);

#endif
