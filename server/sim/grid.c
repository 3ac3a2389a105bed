/* SPDX-License-Identifier: BSD-3-Clause */
/* A grid of cells. In two dimensions a cell is as wide as the neighbour distance; in three half as wide, so that fewer
 * particles out of reach are looked at.
 * In two dimensions cells are stored line by line. In three they are stored column by column, and within a column layer by layer:
 * a few layers of one column and of its rim are about what a processor's own cache holds, whatever the size of the domain, and
 * layers of the whole domain are not. */
#include "sim/grid.h"
#include <math.h>

enum { CELLS_FEW = 1 << 12, CELLS_PER_PARTICLE = 8, COLUMN_X = 24, COLUMN_Y = 16 };
enum { REACH_MAX = 2, LINES_MAX = 2 * REACH_MAX + 1, PIECES_MAX = 3 };
_Static_assert(GRID_RUNS_MAX == PIECES_MAX * LINES_MAX * LINES_MAX, "runs of a cell");
/* Keys of the sort (sort.c) are of a group and a cell, in 32 bits. */
static const double CELLS_MAX = UINT32_MAX / GROUPS;

/* Is there fluid beyond what the grid covers along d? */
static bool is_passed(const Particles *s, int d, double low, double high, int threads)
{
    const double *ref = s->ref[d];
    size_t outside = 0;
#pragma omp parallel for simd reduction(+ : outside) num_threads(threads)
    for (size_t k = 0; k < s->begin[GROUP_WALL]; k++) outside += (size_t)((ref[k] < low) | (ref[k] > high));
    return outside > 0;
}

/* What the grid must cover along d: the domain and the walls, which may have moved away from it. */
static void extent(const Particles *s, const Model *model, int d, int threads, double *low, double *high)
{
    double least = model->min[d], most = model->max[d];
    if (model->period[d] == 0) {
        const double *ref = s->ref[d];
/* Not `simd`: clang 14 at -O1 gets the least and the most of such loops wrong. */
#pragma omp parallel for reduction(min : least) reduction(max : most) num_threads(threads)
        for (size_t k = s->begin[GROUP_WALL]; k < s->n; k++) {
            least = ref[k] < least ? ref[k] : least;
            most = ref[k] > most ? ref[k] : most;
        }
    }
    *low = least;
    *high = most;
}

/* Columns of about the same width over all cells, of which the last may be larger than what is left for it. Along z there is one. */
static void cut_into_columns(Grid *grid)
{
    static const int widest[] = {COLUMN_X, COLUMN_Y};
    for (int d = 0; d < 3; d++) {
        const int columns = grid->dim == 3 && d < 2 ? (grid->n[d] - 1) / widest[d] + 1 : 1;
        grid->width[d] = (grid->n[d] - 1) / columns + 1;
        grid->columns[d] = columns;
    }
    size_t cells = 1;
    for (int d = 0; d < 3; d++) {
        grid->step[d] = cells;
        cells *= (size_t)grid->width[d];
    }
    for (int d = 0; d < 3; d++) {
        grid->stride[d] = cells;
        cells *= (size_t)grid->columns[d];
    }
}

/* As a product of sides it may be more than any integer. */
static double cells_of(const Grid *grid)
{
    double cells = 1;
    for (int d = 0; d < 3; d++) cells *= (double)grid->width[d] * grid->columns[d];
    return cells;
}

static double cells_for(size_t n)
{
    return fmin(CELLS_MAX, CELLS_FEW + (double)CELLS_PER_PARTICLE * (double)n);
}

/* Halve the cells along the direction that has most of them: open ones repeat themselves twice as often then, periodic ones,
 * which must fit, become twice as wide. */
static void halve(Grid *grid, const Model *model)
{
    int d = 0;
    for (int e = 1; e < grid->dim; e++)
        if (grid->n[e] > grid->n[d]) d = e;
    const int n = (grid->n[d] + 1) / 2;
    if (model->period[d] > 0) grid->per_length[d] *= (double)n / grid->n[d];
    grid->n[d] = n;
    grid->wraps[d] = true;
}

Grid grid_make(const Particles *s, const Model *model, double distance, int threads)
{
    Grid grid = {.dim = model->dim, .n = {1, 1, 1}, .reach = model->dim == 3 ? 2 : 1};
    for (int d = 0; d < model->dim; d++) {
        double low, high;
        extent(s, model, d, threads, &low, &high);
        const double edge = distance / grid.reach, count = fmax(1, fmin(CELLS_MAX, floor((high - low) / edge)));
        grid.n[d] = (int)count;
        grid.min[d] = low;
        grid.per_length[d] = count / (high - low);
        grid.wraps[d] = model->period[d] > 0 || is_passed(s, d, low, high, threads);
    }
    cut_into_columns(&grid);
    while (cells_of(&grid) > cells_for(s->n)) {
        halve(&grid, model);
        cut_into_columns(&grid);
    }
    grid.cells = (size_t)cells_of(&grid);
    for (int d = 0; d < model->dim; d++) grid.ratio = fmax(grid.ratio, distance * grid.per_length[d]);
    return grid;
}

size_t grid_cells_most(const Model *model, double distance, size_t n)
{
    const double edge = distance / (model->dim == 3 ? 2 : 1);
    double cells = 1;
    for (int d = 0; d < model->dim; d++) {
        const double count = ceil((model->max[d] - model->min[d] + 2 * distance) / edge);
        cells *= model->dim == 3 ? count + ceil(count / COLUMN_Y) : count;
    }
    return (size_t)fmin(cells, cells_for(n));
}

/* What number k along d adds to the place of a cell in the order of storage. */
static size_t along(const Grid *grid, int d, int k)
{
    const unsigned width = (unsigned)grid->width[d], column = (unsigned)k / width;
    return column * grid->stride[d] + ((unsigned)k - column * width) * grid->step[d];
}

/* The numbers of a cell; false for what is only there to make the last columns as wide as the others. */
static bool numbers(const Grid *grid, size_t cell, int k[3])
{
    bool is_cell = true;
    for (int d = 0; d < 3; d++) {
        const size_t column = cell / grid->stride[d] % (size_t)grid->columns[d];
        k[d] = (int)(column * (size_t)grid->width[d] + cell / grid->step[d] % (size_t)grid->width[d]);
        is_cell &= k[d] < grid->n[d];
    }
    return is_cell;
}

size_t grid_cell(const Grid *grid, const double x[3])
{
    size_t cell = 0;
    for (int d = 0; d < grid->dim; d++) {
        const double n = grid->n[d];
        double position = floor((x[d] - grid->min[d]) * grid->per_length[d]);
        if (grid->wraps[d]) position -= n * floor(position / n);
        /* NaN goes to cell 0: the run is about to be stopped for it. */
        cell += along(grid, d, position >= 0 ? (position < n ? (int)position : grid->n[d] - 1) : 0);
    }
    return cell;
}

/* Cells k + offset along d for offsets -reach .. reach, each once, as up to two intervals [low, high]. */
static int intervals(const Grid *grid, int d, int k, int reach, int low[2], int high[2])
{
    const int n = grid->n[d], last = n - 1;
    low[0] = k - reach;
    high[0] = k + reach;
    if (!grid->wraps[d]) {
        low[0] = low[0] < 0 ? 0 : low[0];
        high[0] = high[0] > last ? last : high[0];
        return 1;
    }
    if (2 * reach + 1 >= n) {
        low[0] = 0;
        high[0] = last;
        return 1;
    }
    if (low[0] >= 0 && high[0] <= last) return 1;
    low[1] = low[0] < 0 ? low[0] + n : low[0];
    high[1] = last;
    high[0] = high[0] > last ? high[0] - n : high[0];
    low[0] = 0;
    return 2;
}

/* Smallest distance in cells between a cell and one `offset` further along a direction, the shorter way round if it wraps. */
static double gap(const Grid *grid, int d, int offset)
{
    int apart = offset < 0 ? -offset : offset;
    if (grid->wraps[d] && grid->n[d] - apart < apart) apart = grid->n[d] - apart;
    return apart > 1 ? apart - 1 : 0;
}

/* How many cells along x can be in reach at this gap across; -1 for none. */
static int reach_along_x(const Grid *grid, double across2)
{
    const double left = grid->ratio * grid->ratio - across2;
    if (left <= 0) return -1;
    const int reach = (int)ceil(sqrt(left));
    return reach < grid->reach ? reach : grid->reach;
}

/* Numbers along y or z that are in reach: what each adds to the place of a cell, and how far it is [cells^2]. */
typedef struct Lines {
    int n;
    size_t at[LINES_MAX];
    double gap2[LINES_MAX];
} Lines;

static Lines lines_around(const Grid *grid, int d, int k)
{
    Lines lines = {0};
    int low[2] = {0, 0}, high[2] = {0, 0};
    const int n = d < grid->dim ? intervals(grid, d, k, grid->reach, low, high) : 1;
    for (int a = 0; a < n; a++)
        for (int m = low[a]; m <= high[a]; m++) {
            const double apart = gap(grid, d, m - k);
            lines.at[lines.n] = along(grid, d, m);
            lines.gap2[lines.n++] = apart * apart;
        }
    return lines;
}

/* Cells up to `reach` from number k along x, in pieces that lie in one column; returns how many. */
static int pieces_around(const Grid *grid, int k, int reach, Run pieces[static PIECES_MAX])
{
    int low[2], high[2], count = 0;
    const int n = intervals(grid, 0, k, reach, low, high), width = grid->width[0];
    for (int a = 0; a < n; a++)
        for (int x = low[a], to; x <= high[a]; x = to + 1) {
            const int end = (x / width + 1) * width - 1;
            to = end < high[a] ? end : high[a];
            pieces[count++] = (Run){along(grid, 0, x), along(grid, 0, to)};
        }
    return count;
}

int grid_runs(const Grid *grid, size_t cell, Run runs[static GRID_RUNS_MAX])
{
    Run pieces[REACH_MAX + 1][PIECES_MAX]; /* [reach], from 1 on */
    int n_pieces[REACH_MAX + 1], at[3], count = 0;
    if (!numbers(grid, cell, at)) return 0;
    for (int reach = 1; reach <= grid->reach; reach++)
        n_pieces[reach] = pieces_around(grid, at[0], reach, pieces[reach]);
    const Lines ys = lines_around(grid, 1, at[1]), zs = lines_around(grid, 2, at[2]);
    for (int z = 0; z < zs.n; z++)
        for (int y = 0; y < ys.n; y++) {
            const int reach = reach_along_x(grid, ys.gap2[y] + zs.gap2[z]);
            const size_t line = ys.at[y] + zs.at[z];
            for (int k = 0; reach >= 0 && k < n_pieces[reach]; k++)
                runs[count++] = (Run){line + pieces[reach][k].first, line + pieces[reach][k].last};
        }
    return count;
}
