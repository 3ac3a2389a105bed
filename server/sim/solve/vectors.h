/* SPDX-License-Identifier: BSD-3-Clause */
/* Sums over the rows of a system, chunk by chunk and in order; and what all methods begin with. */
#ifndef SIM_SOLVE_VECTORS_H
#define SIM_SOLVE_VECTORS_H

#include "sim/solve/solve.h"

enum { ROWS = 512 }; /* of a chunk, which is one thread's whatever the number of threads */

/* Numbers for each chunk in the partial sums: of all rows, then of parts. */
enum { SUMS = 3, SHARES = 2 * PARTS_MAX };

static inline size_t chunks_of(const System *y)
{
    return (y->matrix.n + ROWS - 1) / ROWS;
}

static inline size_t chunk_end(const System *y, size_t chunk)
{
    const size_t end = (chunk + 1) * ROWS;
    return end < y->matrix.n ? end : y->matrix.n;
}

/* With what fills up the last block. */
static inline size_t chunk_whole_end(const System *y, size_t chunk)
{
    return whole_blocks(chunk_end(y, chunk));
}

/* Sums of eight lanes, each of every eighth row: one sum would wait for itself at each row. */
typedef struct Eight {
    double of[ENTRIES];
} Eight;

INLINE double eight_sum(const Eight *sum)
{
    const double *of = sum->of;
    return ((of[0] + of[4]) + (of[2] + of[6])) + ((of[1] + of[5]) + (of[3] + of[7]));
}

/* Sum k of the chunks' partial sums. */
double vectors_partial_sum(const System *y, int k);

static inline double *partial_of(const System *y, int k)
{
    return y->partial + (size_t)k * chunks_of(y);
}

double vectors_dot(const System *y, const double *a, const double *b);

/* Take away from a the mean over the rows that say something; from these rows. In each part its own. */
void vectors_remove_mean(const System *y, double *a);

/* ret = L x. Returns the mean that is to be taken away from it; 0 where of each part its own has been. */
double vectors_multiply(const System *y, const double *x, double *ret);

/* Take away this from the rows of a that say something. Returns a . a and a . b of what is left. */
typedef struct Products {
    double aa, ab;
} Products;
Products vectors_level(const System *y, double *a, double mean, const double *b);

/* a = 0;  a = b */
void vectors_clear(const System *y, double *a);
void vectors_copy(const System *y, double *a, const double *b);

/* a += f b;  a = b + f a */
void vectors_add(const System *y, double *a, double f, const double *b);
void vectors_add_to(const System *y, double *a, double f, const double *b);

/* parts.c: find the parts of the matrix of now */
void parts_find(System *y);

/* parts.c: in each part, of the rows that say something, take away from a the mean; from the bulk what makes the sum of all
 * of them 0; from all rows, whether they say something or not, the mean over the bulk. */
typedef enum PartsHow { PARTS_MEAN, PARTS_BALANCE, PARTS_CENTRE } PartsHow;
void parts_level(const System *y, double *a, PartsHow how);

/* amg.c: what the multigrid method keeps */
void amg_free(struct Amg *amg);
void amg_forget(struct Amg *amg);
bool amg_is_ready(const struct Amg *amg);

/* z = M^-1 r: L is near M, and M easily solved. */
typedef void Precondition(System *y, const double *r, double *z);

/* z = r / diagonal, 0 in rows that say nothing. */
Precondition vectors_jacobi;

/* bicgstab.c: from the residual work[0] of x on; size: what residuals are over. */
void bicgstab_go_on(System *y, const SolveGoal *goal, SolveReport *report, double size, Precondition *precondition);

/* Make b solvable and r = b - L x, without what no x changes: the rounding of a guess that is far off has a part along the constants.
 * Returns |b|, or the least that counts. Rows that say nothing ask for nothing. */
double system_begin(System *y, double *r);

/* r = b - L x of a solve that has come to its end, if its tolerance is so small that the rounding of many iterations matters; true: more is
 * left of it than is allowed, and the method has to go on from there. */
bool system_is_left(System *y, const SolveGoal *goal, SolveReport *report, double *r, double size);

/* Note the residual of an iteration; true: it is small enough, and that is in the report. */
bool system_note(const System *y, SolveReport *report, const SolveGoal *goal, unsigned iteration, double residual);

#endif
