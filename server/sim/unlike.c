/* SPDX-License-Identifier: BSD-3-Clause */
#include "sim/unlike.h"
#include "sim/terms/terms.h"
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

void unlike_look_at_tension(MnsSim *sim)
{
    const double most = sim->scheme->tense_ratio, ratio = tense_ratio(&sim->model);
    if (most == 0 || ratio <= most) return;
    plan_warn(
        sim,
        "interfaces: fluids with surface tension differ in density by a factor of %.4g, and the scheme %s is "
        "known to hold it up to %g: at 1000 the pressure jump of a drop at rest is 5 to 12 %% too large, its volume "
        "grows and longer runs break up; take interfacial or incompressible",
        ratio, sim->scheme->name, most);
}

/* Of the tension of a and b, the least and the largest that is of a beside a third fluid, and which these are. */
typedef struct Spread {
    double least, most;
    size_t by_least, by_most;
} Spread;

static Spread shares_of(const Model *model, size_t a, size_t b)
{
    Spread spread = {INFINITY, -INFINITY, 0, 0};
    for (size_t k = 0; k < model->n_phases; k++) {
        if (k == a || k == b) continue;
        const double share = tension_share_beside(model, a, b, k);
        if (share < spread.least) spread.by_least = k;
        if (share > spread.most) spread.by_most = k;
        spread.least = fmin(spread.least, share);
        spread.most = fmax(spread.most, share);
    }
    return spread;
}

static const double UNLIKE_SHARES = 0.02; /* of the largest tension */

void unlike_look_at_lines(MnsSim *sim)
{
    const Model *model = &sim->model;
    double largest = 0;
    for (size_t a = 0; a < model->n_phases; a++)
        for (size_t b = 0; b < a; b++) largest = fmax(largest, model->tension[a][b]);
    if (model->n_phases < 4 || !(largest > 0)) return;
    for (size_t a = 0; a < model->n_phases; a++)
        for (size_t b = 0; b < a; b++) {
            const Spread spread = shares_of(model, a, b);
            if (!(spread.most - spread.least > UNLIKE_SHARES * largest)) continue;
            const MnsFluid *f = sim->c->fluids;
            plan_warn(
                sim,
                "interfaces: where %.30s and %.30s meet %.30s, %.3g N/m of their tension are of %.30s, and %.3g N/m "
                "where they meet %.30s; the mean over all fluids is taken, so lines where three of them meet are "
                "drawn aside; have at most three fluids, or tensions that are sums of a part of either fluid",
                f[a].name, f[b].name, f[spread.by_least].name, spread.least, f[a].name, spread.most,
                f[spread.by_most].name);
            return; /* one says it all */
        }
}
