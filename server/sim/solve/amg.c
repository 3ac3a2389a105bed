/* SPDX-License-Identifier: BSD-3-Clause */
/* Conjugate or, for matrices that are not symmetric, stabilised biconjugate gradients preconditioned by one cycle of hypre's algebraic
 * multigrid (BoomerAMG): iterations that hardly grow with the system. The preconditioner is asked for nothing along the constants, where the matrix is singular: hypre's own conjugate gradients
 * break down there. hypre as Debian builds it has one thread, so its bits do not depend on ours.
 * What is built without hypre has the same functions, and solves without the preconditioner. */
#include "base/array.h"
#include "sim/neighbours.h"
#include "sim/solve/vectors.h"
#include <limits.h>
#include <math.h>
#include <stdlib.h>

#if HAVE_HYPRE
#include <HYPRE.h>
#include <HYPRE_IJ_mv.h>
#include <HYPRE_parcsr_ls.h>
#include <mpi.h>
#include <omp.h>

#ifdef HYPRE_USING_OPENMP
#error                                                                                                                 \
    "this hypre has threads of its own, so its bits depend on their number: build with one without OpenMP, or with HYPRE= for none"
#endif

static const char symmetric_name[] = "amg", skew_name[] = "amg with bicgstab";

struct Amg {
    bool ready;       /* made, and the matrix has not changed much since */
    MnsStatus failed; /* in a cycle */
    int n;
    HYPRE_Solver solver;
    HYPRE_IJMatrix matrix;
    HYPRE_IJVector b, x;
    HYPRE_ParCSRMatrix A;
    HYPRE_ParVector pb, px;
    HYPRE_BigInt *rows; /* [n] 0, 1, 2 ... */
};

/* One process, which talks to nobody: as it comes, Open MPI would start a helper and listen on the network. */
void mns_multigrid_environment(void)
{
    setenv("OMPI_MCA_ess_singleton_isolated", "1", 0);
    setenv("OMPI_MCA_btl", "self", 0);
    setenv("OMPI_MCA_pml", "ob1", 0);
    setenv("OMPI_MCA_opal_signal", "", 0); /* signals are ours */
}

static void start_mpi(void)
{
    int started = 0;
    MPI_Initialized(&started);
    if (started) return;
    mns_multigrid_environment();
    int provided = 0;
    MPI_Init_thread(NULL, NULL, MPI_THREAD_SERIALIZED, &provided);
    /* By default errors end the process; hypre's codes tell of them. */
    MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_RETURN);
    MPI_Comm_set_errhandler(MPI_COMM_SELF, MPI_ERRORS_RETURN);
    HYPRE_Init();
}

static void drop(struct Amg *amg)
{
    if (amg->solver) HYPRE_BoomerAMGDestroy(amg->solver);
    if (amg->matrix) HYPRE_IJMatrixDestroy(amg->matrix);
    if (amg->b) HYPRE_IJVectorDestroy(amg->b);
    if (amg->x) HYPRE_IJVectorDestroy(amg->x);
    free(amg->rows);
    *amg = (struct Amg){0};
}

void amg_free(struct Amg *amg)
{
    if (amg) drop(amg);
    free(amg);
}

void amg_forget(struct Amg *amg)
{
    if (amg) amg->ready = false;
}

bool amg_is_ready(const struct Amg *amg)
{
    return amg && amg->ready;
}

/* By so much diagonals of matrices that are not symmetric are larger for the cycle: what the matrix makes of a constant is 0, what its transpose
 * does is not, and in a tube of 60,000 particles cycles without this blew up what is left of constants. */
static const double SKEW_SHIFT = 1e-5;

enum { MOST = ROW_MAX + 1 }; /* entries of a row: its particle's neighbours and itself */

/* A row that says nothing is one of the unit matrix. false: it has more entries than a row can have. */
static bool set_row(HYPRE_IJMatrix matrix, const Matrix *m, size_t i, double shift)
{
    HYPRE_BigInt row = (HYPRE_BigInt)i, column[MOST];
    HYPRE_Complex value[MOST];
    HYPRE_Int n = 1;
    column[0] = row;
    value[0] = m->blocks[i] ? (1 + shift) * m->diagonal[i] : 1;
    const size_t first = m->start[i] * ENTRIES, last = first + m->blocks[i] * (size_t)ENTRIES;
    for (size_t k = first; k < last; k++) {
        if (m->c[k] == 0) continue;
        if (n == MOST) return false;
        column[n] = (HYPRE_BigInt)m->column[k];
        value[n++] = -(double)m->c[k];
    }
    HYPRE_IJMatrixSetValues(matrix, 1, &n, &row, column, value);
    return true;
}

static MnsStatus fill_matrix(struct Amg *amg, const System *y, double shift)
{
    enum { PIECE = 1 << 16 }; /* rows, after which who watches is told */
    const Matrix *m = &y->matrix;
    HYPRE_Int *sizes = calloc(m->n, sizeof *sizes);
    if (!sizes) return MNS_E_MEMORY;
    for (size_t i = 0; i < m->n; i++) sizes[i] = (HYPRE_Int)(m->blocks[i] * ENTRIES + 1);
    HYPRE_IJMatrixCreate(MPI_COMM_SELF, 0, amg->n - 1, 0, amg->n - 1, &amg->matrix);
    HYPRE_IJMatrixSetObjectType(amg->matrix, HYPRE_PARCSR);
    HYPRE_IJMatrixSetRowSizes(amg->matrix, sizes);
    HYPRE_IJMatrixInitialize(amg->matrix);
    bool well = true;
    for (size_t i = 0; i < m->n && well; i++) {
        well = set_row(amg->matrix, m, i, shift);
        if (i % PIECE == 0) watcher_tell(&y->watcher);
    }
    HYPRE_IJMatrixAssemble(amg->matrix);
    HYPRE_IJMatrixGetObject(amg->matrix, (void **)&amg->A);
    free(sizes);
    return well && amg->A ? MNS_OK : MNS_E_INTERNAL;
}

static void make_vector(const struct Amg *amg, HYPRE_IJVector *ret, HYPRE_ParVector *ret_parallel)
{
    HYPRE_IJVectorCreate(MPI_COMM_SELF, 0, amg->n - 1, ret);
    HYPRE_IJVectorSetObjectType(*ret, HYPRE_PARCSR);
    HYPRE_IJVectorInitialize(*ret);
    HYPRE_IJVectorAssemble(*ret);
    HYPRE_IJVectorGetObject(*ret, (void **)ret_parallel);
}

/* One cycle, with the same relaxation before and after, so that it is symmetric; relaxed on the coarsest level too, where elimination
 * would meet the singular matrix. In the plane the first level is coarsened twice, which takes twice the iterations and half of the making; in
 * space that takes longer where a liquid rests under a gas (DECISIONS.md). */
static void make_solver(struct Amg *amg, bool in_space)
{
    enum { HMIS = 10, EXTENDED = 6, SYMMETRIC = 6, COARSEST = 3, NEIGHBOURS = 4 };
    HYPRE_BoomerAMGCreate(&amg->solver);
    HYPRE_BoomerAMGSetPrintLevel(amg->solver, 0);
    HYPRE_BoomerAMGSetCoarsenType(amg->solver, HMIS);
    HYPRE_BoomerAMGSetAggNumLevels(amg->solver, in_space ? 0 : 1);
    HYPRE_BoomerAMGSetInterpType(amg->solver, EXTENDED);
    HYPRE_BoomerAMGSetPMaxElmts(amg->solver, NEIGHBOURS);
    HYPRE_BoomerAMGSetStrongThreshold(amg->solver, 0.25);
    HYPRE_BoomerAMGSetRelaxType(amg->solver, SYMMETRIC);
    HYPRE_BoomerAMGSetCycleRelaxType(amg->solver, SYMMETRIC, COARSEST);
    HYPRE_BoomerAMGSetMaxIter(amg->solver, 1);
    HYPRE_BoomerAMGSetTol(amg->solver, 0);
    HYPRE_BoomerAMGSetup(amg->solver, amg->A, amg->pb, amg->px);
}

/* What hypre has noted since it was last asked, but for what is expected. */
static MnsStatus noted(HYPRE_Int expected)
{
    const HYPRE_Int code = HYPRE_GetError() & ~expected;
    HYPRE_ClearAllErrors();
    return code == 0 ? MNS_OK : code & HYPRE_ERROR_MEMORY ? MNS_E_MEMORY : MNS_E_INTERNAL;
}

static MnsStatus make(struct Amg *amg, const System *y, double shift)
{
    const Matrix *m = &y->matrix;
    amg->n = (int)m->n;
    const double blocks = (double)m->start[m->n] / (double)m->n;
    if (!amg_holds((double)m->n, ENTRIES * blocks)) return MNS_E_MEMORY;
    if (!(amg->rows = array_new(m->n, sizeof *amg->rows))) return MNS_E_MEMORY;
    for (int i = 0; i < amg->n; i++) amg->rows[i] = i;
    HYPRE_ClearAllErrors();
    MnsStatus status = fill_matrix(amg, y, shift);
    if (status) return status;
    make_vector(amg, &amg->b, &amg->pb);
    make_vector(amg, &amg->x, &amg->px);
    status = noted(0);
    if (status) return status;
    watcher_tell(&y->watcher); /* what follows is one piece */
    make_solver(amg, rows_in_space(blocks));
    return noted(0);
}

/* What was not made is not ready, and not kept. */
static MnsStatus prepare(System *y, double shift)
{
    struct Amg **kept = &y->amg[y->kept], *amg = *kept;
    if (amg_is_ready(amg)) return MNS_OK;
    if (!amg && !(amg = *kept = calloc(1, sizeof *amg))) return MNS_E_MEMORY;
    const double start = omp_get_wtime();
    start_mpi();
    drop(amg);
    const MnsStatus status = make(amg, y, shift);
    if (status) drop(amg);
    else amg->ready = true;
    y->setup_seconds += omp_get_wtime() - start;
    return status;
}

static MnsStatus prepare_symmetric(System *y)
{
    return prepare(y, 0);
}

static MnsStatus prepare_skew(System *y)
{
    return prepare(y, SKEW_SHIFT);
}

/* z: what a cycle makes of r. */
static void cycle(System *y, const double *r, double *z)
{
    struct Amg *amg = y->amg[y->kept];
    vectors_clear(y, z);
    HYPRE_IJVectorSetValues(amg->b, amg->n, amg->rows, r);
    HYPRE_IJVectorSetValues(amg->x, amg->n, amg->rows, z);
    HYPRE_BoomerAMGSolve(amg->solver, amg->A, amg->pb, amg->px);
    HYPRE_IJVectorGetValues(amg->x, amg->n, amg->rows, z);
    const MnsStatus status = noted(HYPRE_ERROR_CONV); /* a single cycle does not */
    if (status) amg->failed = status;
    vectors_remove_mean(y, z);
}

static void conjugate_gradients(System *y, const SolveGoal *goal, SolveReport *report, double size)
{
    double *r = y->work[0], *z = y->work[1], *p = y->work[2], *q = y->work[3];
    unsigned k = 0;
    do {
        double rz = 1;
        vectors_clear(y, p);
        for (; !system_note(y, report, goal, k, sqrt(vectors_dot(y, r, r)) / size); k++) {
            const double before = rz;
            cycle(y, r, z);
            rz = vectors_dot(y, r, z);
            vectors_add_to(y, p, rz / before, z);
            matrix_multiply(&y->matrix, p, q, y->threads);
            const double alpha = rz / vectors_dot(y, p, q);
            vectors_add(y, y->x, alpha, p);
            vectors_add(y, r, -alpha, q);
            vectors_remove_mean(y, r);
        }
    } while (system_is_left(y, goal, report, r, size));
}

static void solve_with(System *y, const SolveGoal *goal, SolveReport *report, bool symmetric)
{
    const double size = system_begin(y, y->work[0]);
    *report = (SolveReport){.converged = size == 0};
    if (size == 0) vectors_clear(y, y->x);
    else report->status = symmetric ? prepare_symmetric(y) : prepare_skew(y);
    if (size == 0 || report->status) return;
    struct Amg *amg = y->amg[y->kept];
    amg->failed = MNS_OK;
    if (symmetric) conjugate_gradients(y, goal, report, size);
    else bicgstab_go_on(y, goal, report, size, cycle);
    if (amg->failed) report->status = amg->failed;
}

static void solve_symmetric(System *y, const SolveGoal *goal, SolveReport *report)
{
    solve_with(y, goal, report, true);
}

static void solve_skew(System *y, const SolveGoal *goal, SolveReport *report)
{
    solve_with(y, goal, report, false);
}

bool amg_exists(void)
{
    return true;
}
#else
void mns_multigrid_environment(void) {}

static MnsStatus (*const prepare_symmetric)(System *) = NULL;
static MnsStatus (*const prepare_skew)(System *) = NULL;

/* What does the work, and so is told to have done it. */
static const char symmetric_name[] = "cg", skew_name[] = "bicgstab";

static void solve_symmetric(System *y, const SolveGoal *goal, SolveReport *report)
{
    solve_cg.solve(y, goal, report);
}

static void solve_skew(System *y, const SolveGoal *goal, SolveReport *report)
{
    solve_bicgstab.solve(y, goal, report);
}

void amg_free(struct Amg *amg)
{
    (void)amg;
}

void amg_forget(struct Amg *amg)
{
    (void)amg;
}

bool amg_is_ready(const struct Amg *amg)
{
    return amg != NULL;
}

bool amg_exists(void)
{
    return false;
}
#endif

bool amg_holds(double rows, double entries)
{
    return amg_exists() && rows * (entries + 1) <= INT_MAX;
}

/* A copy of the entries, and as much again while it is made or for the coarse levels, of 8 bytes for a value and 4 for its place, a few of
 * them to spare; and the library itself. */
double amg_bytes(double rows, double entries)
{
    const double each = 20, itself = 16e6;
    return itself + each * rows * entries;
}

const SolveMethod solve_amg = {
    .name = symmetric_name,
    .equation = "conjugate gradients, preconditioned by algebraic multigrid",
    .solve = solve_symmetric,
    .prepare = prepare_symmetric,
};

const SolveMethod solve_amg_bicgstab = {
    .name = skew_name,
    .equation = "stabilised biconjugate gradients, preconditioned by algebraic multigrid",
    .solve = solve_skew,
    .prepare = prepare_skew,
};
