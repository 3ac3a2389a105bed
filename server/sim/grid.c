/* SPDX-License-Identifier: BSD-3-Clause */
/* A grid of cells. In two dimensions a cell is as wide as the neighbour distance; in three half as wide, so that fewer
 * particles out of reach are looked at. */
#include "sim/grid.h"
#include <math.h>

enum { CELLS_FEW = 1 << 12, CELLS_PER_PARTICLE = 8 };
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

/* As a product of sides it may be more than any integer. */
static double cells_of(const Grid *grid)
{
    return (double)grid->n[0] * grid->n[1] * grid->n[2];
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
    while (cells_of(&grid) > cells_for(s->n)) halve(&grid, model);
    grid.cells = (size_t)cells_of(&grid);
    for (int d = 0; d < model->dim; d++) grid.ratio = fmax(grid.ratio, distance * grid.per_length[d]);
    return grid;
}

size_t grid_cells_most(const Model *model, double distance, size_t n)
{
    const double edge = distance / (model->dim == 3 ? 2 : 1);
    double cells = 1;
    for (int d = 0; d < model->dim; d++) cells *= ceil((model->max[d] - model->min[d] + 2 * distance) / edge);
    return (size_t)fmin(cells, cells_for(n));
}

size_t grid_cell(const Grid *grid, const double x[3])
{
    size_t cell = 0;
    for (int d = grid->dim - 1; d >= 0; d--) {
        const double n = grid->n[d];
        double position = floor((x[d] - grid->min[d]) * grid->per_length[d]);
        if (grid->wraps[d]) position -= n * floor(position / n);
        /* NaN goes to cell 0: the run is about to be stopped for it. */
        const int k = position >= 0 ? (position < n ? (int)position : grid->n[d] - 1) : 0;
        cell = cell * (size_t)grid->n[d] + (size_t)k;
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

int grid_runs(const Grid *grid, size_t cell, Run runs[static GRID_RUNS_MAX])
{
    const int nx = grid->n[0], ny = grid->n[1];
    const int cx = (int)(cell % (size_t)nx), cy = (int)(cell / (size_t)nx % (size_t)ny),
              cz = (int)(cell / (size_t)nx / (size_t)ny);
    int zl[2] = {0, 0}, zh[2] = {0, 0}, yl[2], yh[2], xl[2], xh[2], count = 0;
    const int nz = grid->dim == 3 ? intervals(grid, 2, cz, grid->reach, zl, zh) : 1;
    const int nyi = intervals(grid, 1, cy, grid->reach, yl, yh);
    for (int a = 0; a < nz; a++)
        for (int z = zl[a]; z <= zh[a]; z++)
            for (int b = 0; b < nyi; b++)
                for (int y = yl[b]; y <= yh[b]; y++) {
                    const double gy = gap(grid, 1, y - cy), gz = grid->dim == 3 ? gap(grid, 2, z - cz) : 0;
                    const int reach = reach_along_x(grid, gy * gy + gz * gz);
                    if (reach < 0) continue;
                    const int nxi = intervals(grid, 0, cx, reach, xl, xh);
                    const size_t line = ((size_t)z * (size_t)ny + (size_t)y) * (size_t)nx;
                    for (int c = 0; c < nxi; c++) runs[count++] = (Run){line + (size_t)xl[c], line + (size_t)xh[c]};
                }
    return count;
}
