/* SPDX-License-Identifier: BSD-3-Clause */
/* Linear systems of particles: the one small interface between who has a system and who solves it. Every sum is of chunks of
 * rows, in order, so that the number of threads does not change a bit. */
#ifndef SIM_SOLVE_SOLVE_H
#define SIM_SOLVE_SOLVE_H

#include "sim/level.h"
#include <meniscus/case.h>
#include <stddef.h>
#include <stdint.h>

enum { ENTRIES = 8 }; /* of a row come in blocks of so many, the last filled up with zeros */

/* And so do numbers of all rows in vectors: sums of them are of eight lanes, without a remainder. */
static inline size_t whole_blocks(size_t n)
{
    return (n + ENTRIES - 1) / ENTRIES * ENTRIES;
}

/* (L x)_i = sum_k c_k (x_i - x_k): rows of differences, to which a constant is nothing, to the last bit. Symmetric where c_ij = c_ji. */
typedef struct Matrix {
    size_t n, room;   /* rows; blocks there is room for */
    size_t *start;    /* [n + 1] first block of each row */
    uint32_t *blocks; /* [n] of a row in use; 0: a row that says nothing, and that nobody refers to */
    uint32_t *column; /* [ENTRIES * room] */
    float *c;         /* [ENTRIES * room]; what they stand for is known to no more digits */
    double *diagonal; /* [n] sum of c */
} Matrix;

/* Room for n rows. false: no memory, nothing is left behind. */
bool matrix_init(Matrix *m, size_t n, int threads);
void matrix_done(Matrix *m);

/* Lay out the rows: blocks[i] says how many row i may take. false: no memory, and its rows are of no use. */
bool matrix_lay(Matrix *m, int threads);

/* y = L x; of the rows [first, last) alone */
void matrix_rows(const Matrix *m, const double *x, double *y, size_t first, size_t last);
void matrix_multiply(const Matrix *m, const double *x, double *y, int threads);

enum { HISTORY_MAX = 24 };

/* How a solve went. Residuals are over that of x = 0. */
typedef struct SolveReport {
    bool converged;
    MnsStatus status; /* of what the method makes of the matrix first: MNS_E_MEMORY or MNS_E_INTERNAL if it could not */
    unsigned iterations;
    double residual;
    int n;                    /* of the history */
    unsigned at[HISTORY_MAX]; /* iterations 0, 1, 2, 4 ... */
    double of[HISTORY_MAX];   /* and the residuals there */
} SolveReport;

/* Room for the vectors of the methods. */
enum { WORK_VECTORS = 7 };

#define NO_ROW SIZE_MAX

enum { MATRICES = 2 };   /* that take turns in a system */
enum { PARTS_MAX = 64 }; /* that are told apart */

struct Amg;

/* Who is told that something has been got done, see mns_sim_watch(). */
typedef struct Watcher {
    void (*going_on)(void *arg); /* NULL: nobody */
    void *arg;
} Watcher;

static inline void watcher_tell(const Watcher *watcher)
{
    if (watcher->going_on) watcher->going_on(watcher->arg);
}

/* L x = b. Of b the mean over the first `bulk` rows is taken away, as nothing else can be solved: constants are L's null space.
 * Spaces that a wall keeps apart are parts of a matrix, none of which refers to another: all this is so in each of them. */
typedef struct System {
    Matrix matrix;
    double *b, *x; /* [matrix.n] x: a guess, then the solution up to a constant */
    size_t bulk;
    size_t zero;     /* row at which x is 0 in the end; NO_ROW: its mean is */
    size_t speaking; /* rows that say something, and */
    size_t parts;    /* found by the last solve */
    uint32_t *part;  /* [matrix.n] of each row, [0, parts) where there are several; 0 of one that says nothing */
    double least;    /* that the residual of x = 0 counts as, where there is only rounding */
    int threads;
    double *work[WORK_VECTORS]; /* [matrix.n] */
    double *partial;            /* sums of chunks */
    struct Amg *
        amg[MATRICES]; /* what the multigrid method keeps of each from one solve to the next; NULL before it was used */
    int kept;          /* of which of them the matrix is now */
    double setup_seconds; /* spent on making it, so far */
    Watcher watcher;      /* of iterations */
} System;

typedef struct SolveGoal {
    double tolerance; /* of the residual, over that of x = 0 */
    unsigned iterations;
} SolveGoal;

typedef struct SolveMethod {
    const char *name, *equation;
    void (*solve)(System *system, const SolveGoal *goal, SolveReport *ret_report);
    /* Make what is kept, unless it is there; NULL: nothing is. Without it, or where it fails, solve() does, and tells. */
    MnsStatus (*prepare)(System *system);
} SolveMethod;

extern const SolveMethod solve_cg;           /* symmetric matrices */
extern const SolveMethod solve_bicgstab;     /* all */
extern const SolveMethod solve_amg;          /* symmetric ones; as solve_cg where there is no hypre */
extern const SolveMethod solve_amg_bicgstab; /* all; as solve_bicgstab where there is no hypre */

/* Room for n rows. false: no memory, nothing is left behind. */
bool system_init(System *system, size_t n, size_t bulk, int threads);
void system_done(System *system);
size_t system_bytes(const System *system);

/* Solve the rows from `first` on, none of which refers to another of them, by x of the rows before. */
void system_relax(System *system, size_t first);

/* Take away the mean of x over the bulk, everywhere; of each part its own, and of that with the row `zero` what x is there. */
void system_centre(System *system);

/* Begin the next solve from x = 0. */
void system_clear(System *system);

/* The matrix will be this one of those that take turns, [0, MATRICES). */
void system_keep(System *system, int matrix);

/* Is there what a method has kept of the matrix? */
bool system_is_ready(const System *system);

/* The rows have changed places, or the entries more than a little: what a method has kept is of no use any more. */
void system_forget(System *system);

/* Was this built with algebraic multigrid? */
bool amg_exists(void);

/* And can it take a matrix of so many rows and entries in each? hypre numbers them by int: some 19 million rows in space. */
bool amg_holds(double rows, double entries);

/* What it keeps of such a matrix, about. */
double amg_bytes(double rows, double entries);

/* Rows of so many blocks are of three dimensions, not of two. */
static inline bool rows_in_space(double blocks)
{
    return blocks > 8;
}

/* Would a system of so many rows, of so many blocks each, be solved with it? */
bool solve_takes_amg(MnsSolver solver, double rows, double blocks, bool symmetric);

/* The method that was asked for, or the fastest for a system of this size; one for all matrices unless they are symmetric. */
const SolveMethod *solve_method(MnsSolver solver, const System *system, bool symmetric);

/* The residuals of a solve in words, as in "1 after 0, 0.1 after 4, 0.02 after 8". */
void solve_history(const SolveReport *report, char *text, size_t size);

#endif
