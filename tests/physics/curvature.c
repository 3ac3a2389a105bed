/* SPDX-License-Identifier: BSD-3-Clause */
/* How well a scheme knows the curvature of a round body of the first fluid of a case, radius 1, as it starts: of the curvature that the jump of the
 * pressure has, over (dimensions - 1)/radius, the mean over the pairs across the surface and the standard deviation.
 *
 * usage: curvature CASE */
#include "cases/translate.h"
#include "common/case/file.h"
#include "sim/home.h"
#include "sim/scheme.h"
#include "sim/sim.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

static MnsStatus read_case(const char *path, MnsCase **ret, MnsError *error)
{
    CaseFile *file = NULL;
    MnsStatus status = case_file_read(path, &file, error);
    if (!status) status = case_translate(case_file_message(file), ret, error);
    case_file_free(file);
    return status;
}

typedef struct Pairs {
    double sum, squares, n;
} Pairs;

static bool in_reach(const Particles *s, const Model *model, size_t i, size_t j)
{
    double r2 = 0;
    for (int d = 0; d < s->dim; d++) r2 += pow(s->x[d][i] - s->x[d][j], 2);
    return r2 < model->kernel.support * model->kernel.support;
}

/* P5 has one sign for both fluids, the others have each fluid's own. */
static Pairs pairs_of(const MnsSim *sim)
{
    const Particles *s = &sim->s;
    const double of_other = strcmp(sim->scheme->name, "differences") == 0 ? 1 : -1;
    Pairs pairs = {0};
    for (size_t i = 0; i < s->n; i++)
        for (size_t k = 0; s->phase[i] == 0 && k < sim->nb.end[i][END_FLUID]; k++) {
            const uint32_t j = neighbours_of(&sim->nb, i)[k];
            if (s->phase[j] == 0 || !in_reach(s, &sim->model, i, j)) continue;
            const double found = 0.5 * (s->curvature[i] + of_other * s->curvature[j]) / (s->dim - 1);
            pairs.sum += found;
            pairs.squares += found * found;
            pairs.n++;
        }
    return pairs;
}

/* A first step, however short, has the curvatures of the start. */
static MnsStatus find(MnsSim *sim, Pairs *ret, MnsError *error)
{
    const MnsStatus status = mns_sim_step(sim, 1e-9, error);
    if (status) return status;
    if (!home_leave(&sim->s, sim->threads)) return MNS_E_MEMORY;
    *ret = pairs_of(sim);
    return MNS_OK;
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        fprintf(stderr, "usage: curvature CASE\n");
        return 64;
    }
    MnsCase *c = NULL;
    MnsSim *sim = NULL;
    MnsError error = {0};
    Pairs pairs = {0};
    MnsStatus status = read_case(argv[1], &c, &error);
    if (!status) status = mns_sim_new(c, &sim, &error);
    if (!status) status = find(sim, &pairs, &error);
    mns_sim_free(sim);
    mns_case_free(c);
    if (status) {
        fprintf(stderr, "curvature: %s\n", error.text);
        return 65;
    }
    const double mean = pairs.sum / pairs.n;
    printf("%.6f %.6f\n", mean, sqrt(fmax(pairs.squares / pairs.n - mean * mean, 0)));
    return 0;
}
