/* SPDX-License-Identifier: BSD-3-Clause */
/* The area of an interface is the integral of how steep the share C of a fluid is, of which each side has a half:
 *   C_k = sum_j V_j W over fluid k / sum_j V_j W over fluids,   E = sum_i V_i / S_i sum_k sigma_ik |grad C_k|
 * k other fluids than that of i, S_i = sum_j V_j W over fluids and walls, sums with i itself: beside a gap between fluids S is less, and V / S has the gap as well. Without
 * the sum below, the slope is that of how many particles there are too: 6 % as they leave their lattice (schemes/README.md). */
#include "sim/areas.h"
#include <math.h>

/* Sums over what is around a particle and what is in walls, and their slopes. */
typedef struct Around {
    double walls, all, of[MNS_MAX_FLUIDS];
    double all_slope[3], slope[MNS_MAX_FLUIDS][3];
} Around;

static void look_around(const MnsSim *sim, const Row *row, Around *ret)
{
    const Particles *s = &sim->s;
    *ret = (Around){.all = particles_volume(s, &sim->model, row->i) * kernel_at_zero(&sim->model.kernel)};
    for (const Block *b = row->block; b < row->block + row->n; b++)
        for (int l = 0; l < LANES; l++) {
            const size_t j = row_j(row, b)[l];
            const double V = particles_volume(s, &sim->model, j), c = V * b->W[l], slope = V * b->F[l];
            if (b >= row->block + row->n_fluid) {
                ret->walls += c;
                continue;
            }
            ret->all += c;
            ret->of[s->phase[j]] += c;
            for (int d = 0; d < s->dim; d++) {
                ret->all_slope[d] += slope * b->x[d][l];
                ret->slope[s->phase[j]][d] += slope * b->x[d][l];
            }
        }
}

static double energy_at(const MnsSim *sim, const Row *row)
{
    const unsigned mine = sim->s.phase[row->i];
    Around around;
    double sum = 0;
    look_around(sim, row, &around);
    for (size_t k = 0; k < sim->model.n_phases; k++) {
        double g2 = 0;
        for (int d = 0; k != mine && d < sim->s.dim; d++) {
            const double g = around.slope[k][d] - around.of[k] / around.all * around.all_slope[d];
            g2 += g * g;
        }
        sum += sim->model.tension[mine][k] * sqrt(g2);
    }
    return particles_volume(&sim->s, &sim->model, row->i) / (around.all + around.walls) * sum / around.all;
}

/* Block by block, so that the number of threads changes no bit. */
double areas_energy(MnsSim *sim)
{
    const unsigned needs = NEED_F | NEED_W;
    const size_t n = particles_fluid(&sim->s), blocks = sim_blocks(n);
    double all = 0;
    neighbours_refresh(&sim->nb, &sim->s, &sim->model, needs);
    const RowPlan plan = row_plan(&sim->nb, &sim->s, &sim->model, needs, ROW_LISTED);
#pragma omp parallel num_threads(sim->threads)
    {
        Row row;
#pragma omp for schedule(static)
        for (size_t b = 0; b < blocks; b++) {
            sim->partial[b] = 0;
            for (size_t i = b * SIM_BLOCK; i < n && i < (b + 1) * SIM_BLOCK; i++) {
                if (sim->nb.tells_others && !(sim->nb.has[i] & LIST_OTHERS)) continue;
                row_build(&row, &plan, i);
                sim->partial[b] += energy_at(sim, &row);
            }
        }
    }
    for (size_t b = 0; b < blocks; b++) all += sim->partial[b];
    return all;
}
