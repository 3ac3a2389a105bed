/* SPDX-License-Identifier: BSD-3-Clause */
#include "sim/unlike.h"
#include <math.h>

/* The greatest ratio of densities of two fluids with tension between them; 0 without tension. */
static double tense_ratio(const Model *model)
{
    double ratio = 0;
    for (size_t a = 0; a < model->n_phases; a++)
        for (size_t b = 0; b < model->n_phases; b++)
            if (model->tension[a][b] > 0) ratio = fmax(ratio, model->phase[a].rho0 / model->phase[b].rho0);
    return ratio;
}

void unlike_look_at_averages(MnsSim *sim)
{
    const Model *model = &sim->model;
    const double most = sim->scheme->arithmetic_ratio, ratio = model->rho_max / model->rho_min;
    if (most == 0 || model->density_average > 0) return;
    if (ratio > most) /* a light fluid feels the heavy one's stiffness then, and is thrown about at rest */
        plan_warn(sim,
                  "scheme.%s.pair_average: the heaviest fluid is %.3g times as dense as the lightest, and arithmetic "
                  "averages burst a gas above %g, even at rest; take density",
                  sim->scheme->name, ratio, most);
    else if (tense_ratio(model) > 1)
        plan_warn(
            sim,
            "scheme.%s.pair_average: arithmetic averages make bubbles and drops with surface tension too fast, by "
            "13 %% at a ratio of densities of 10 (%.3g here); take density",
            sim->scheme->name, tense_ratio(model));
}

/* Part of the pressure jump of tension that a unit of repulsion takes, about. Drops at rest lack 1.0, 4.3 and 8.8 % with 0.01, 0.04 and 0.08
 * under `interfacial`, 3.7 and 6.6 % with the last two under `dissipation`, if the gas has half of its highest background pressure. */
static const double JUMP_LOST = 1;

void unlike_look_at_repulsion(MnsSim *sim)
{
    const Model *model = &sim->model;
    if (!model->tense || !(model->repulsion > 0)) return;
    plan_warn(
        sim,
        "scheme.%s.repulsion: %g pushes unlike fluids apart where surface tension holds them, and takes about %.2g %% "
        "of the pressure jump of a drop at rest, and more without background pressure; take 0",
        sim->scheme->name, model->repulsion, 100 * JUMP_LOST * model->repulsion);
}
