/* SPDX-License-Identifier: BSD-3-Clause */
#include "sim/energy.h"
#include "base/array.h"
#include "sim/areas.h"
#include "sim/limits.h"
#include "sim/motion.h"
#include <math.h>
#include <string.h>

/* The energy is found after so many steps, and at the end: elastic energies and surfaces take as long as a tenth of a step. */
enum { EVERY = 40 };

/* Below this part of sum rho c^2 V nothing is said: at rest a scheme's noise is all the energy there is. */
static const double EVENED =
    1e-3; /* spacings by which what evens out still water moves it, in which fluids are apart */
static const double SILENT = 1e-6;

/* To which the area of an interface is known: particles that only change places change it by a fifth of that, and corners as sharp as spacings, which are seen as
 * round, by nearly all. */
static const double AREA = 0.03;

/* Of the domain, by which the middle of what fills it may be off: a hundredth is a gap of a fiftieth on one side. */
static const double OFF_MIDDLE = 0.01;

/* What is allowed unless a scheme says otherwise, over the largest of kinetic energy and change of potential energy. */
static const double MOST = 0.01;

/* Sums over the fluid: energies [J] and sum rho c^2 V [J]; power of walls [W]; volume at rest [m^dim]; of what gravity acts on its mass [kg] and, to tell how
 * unlike fluids are, its mass times its density; momentum [kg m/s]; of what gravity acts on its momentum and mass times position; volume times position. */
enum {
    KINETIC,
    ELASTIC,
    SURFACE,
    STIFFNESS,
    BY_WALLS,
    VOLUME,
    WEIGHT,
    UNLIKE,
    MOMENTUM,
    FALL = MOMENTUM + 3,
    MOMENT = FALL + 3,
    MIDDLE = MOMENT + 3,
    SUMS = MIDDLE + 3
};

_Static_assert((int)SUMS <= (int)SIM_SUMS, "room for partial sums");

/* Of a mass, from the volume it has at rest to that at a density [J/kg]: the integral of p / rho^2. With rho^gamma from the pressure, which is
 * there. */
static double elastic(const Phase *phase, double rho, double p)
{
    const double r = rho / phase->rho0, c2 = phase->c * phase->c, gamma = phase->exponent;
    const double background = phase->background / phase->rho0 * (1 - 1 / r);
    if (gamma == 1) { /* ln r as a series: it is 2 atanh u */
        const double u = (r - 1) / (r + 1), u2 = u * u;
        const double log = 2 * u * (1 + u2 * (1. / 3 + u2 * (1. / 5 + u2 * (1. / 7 + u2 / 9))));
        return c2 * (log + 1 / r - 1) + background;
    }
    const double power = (1 + gamma * (p - phase->background) / (phase->rho0 * c2)) / r;
    return c2 / gamma * ((power - 1) / (gamma - 1) + 1 / r - 1) + background;
}

/* What of the sums is found: the power of walls; also kinetic energy and what gravity acts on; also elastic energies and those of surfaces. */
typedef enum Extent { OF_WALLS, OF_MOTION, OF_ALL } Extent;

static double sum_of(const double *values, size_t first, size_t last)
{
    double sum = 0;
    for (size_t i = first; i < last; i++) sum += values[i];
    return sum;
}

static void add_particle(const MnsSim *sim, size_t i, Extent extent, double sums[static SUMS])
{
    const Particles *s = &sim->s;
    const Phase *phase = &sim->model.phase[s->phase[i]];
    const double m = s->m[i], V = m / phase->rho0, pulled = phase->rho0 - sim->model.differences.buoyancy;
    double v2 = 0;
    for (int d = 0; d < s->dim; d++) {
        const double v = s->v[d][i * s->v_step], x = s->x[d][i * s->x_step];
        sums[MIDDLE + d] += V * x;
        sums[MOMENT + d] += V * pulled * x;
        sums[FALL + d] += V * pulled * v;
        sums[MOMENTUM + d] += m * v;
        v2 += v * v;
    }
    sums[VOLUME] += V;
    sums[WEIGHT] += V * pulled;
    sums[UNLIKE] += V * pulled * pulled;
    sums[KINETIC] += 0.5 * m * v2;
    if (extent == OF_MOTION) return;
    const double c = sim->scheme->projects ? limits_expected_speed(&sim->model) : phase->c;
    sums[STIFFNESS] += m * c * c;
    if (!sim->scheme->projects) sums[ELASTIC] += m * elastic(phase, s->rho[i], s->p[i * s->p_step]);
}

/* Is one of these walls listed for i? these: [walls] */
static bool is_beside(const MnsSim *sim, const bool *these, size_t i)
{
    const uint32_t *list = neighbours_of(&sim->nb, i);
    const uint8_t *phase = sim->s.phase;
    for (size_t k = sim->nb.end[i][END_FLUID]; k < sim->nb.end[i][END_WALLS]; k++)
        if (these[phase[list[k]] - sim->model.n_phases]) return true;
    return false;
}

/* Of the scheme's powers those that are not zero; returns what they need. */
static unsigned find_acting(const MnsSim *sim, const bool *moves, const Term *acting[static POWER_TERMS_MAX + 1])
{
    const Model *model = &sim->model;
    bool motion = false;
    unsigned needs = 0;
    for (size_t w = 0; w < model->n_walls; w++) motion |= moves[w];
    for (const Term *const *term = sim->scheme->power; *term; term++) {
        if (!term_needed(*term, model) || ((*term)->takes_motion && !motion)) continue;
        *acting++ = *term;
        needs |= (*term)->needs;
    }
    *acting = NULL;
    return needs;
}

/* Of each particle, by the forces that the scheme has between it and walls. */
static void find_power(MnsSim *sim)
{
    Particles *s = &sim->s;
    bool moves[MNS_MAX_WALLS], acts[MNS_MAX_WALLS];
    for (size_t w = 0; w < sim->model.n_walls; w++) {
        const WallState *wall = &sim->model.wall[w];
        moves[w] = wall->v[0] != 0 || wall->v[1] != 0 || wall->v[2] != 0;
        acts[w] = moves[w] || wall->has_belt;
    }
    const Term *acting[POWER_TERMS_MAX + 1];
    const unsigned needs = find_acting(sim, moves, acting);
    neighbours_refresh(&sim->nb, s, &sim->model, needs);
    const RowPlan plan = row_plan(&sim->nb, s, &sim->model, needs, ROW_WALLS);
#pragma omp parallel num_threads(sim->threads)
    {
        Row row;
#pragma omp for schedule(dynamic, 64)
        for (size_t i = 0; i < particles_fluid(s); i++) {
            s->power[i] = 0;
            if (!(sim->nb.has[i] & LIST_WALLS) || !is_beside(sim, acts, i)) continue;
            row_build(&row, &plan, i);
            for (const Term *const *term = acting; *term; term++) term_row(*term, &row, s, &sim->model);
        }
    }
}

/* Do fluids that are not compressed fill a space to its walls, which all move alike? */
static bool is_full(const MnsSim *sim)
{
    return sim->scheme->projects && sim->model.closed;
}

/* Of such fluids the density that all have in common has nowhere to fall: what moves particles and no
 * fluid, as what corrects number densities does, shall not pass for energy. 0: it may fall. */
static double common_density(const MnsSim *sim, const double sums[static SUMS])
{
    return is_full(sim) ? sums[WEIGHT] / sums[VOLUME] : 0;
}

/* By which walls that all move alike have taken the middle of all fluids along. */
static double taken(const MnsSim *sim, const double sums[static SUMS], int d)
{
    return sim->model.n_walls ? sums[VOLUME] * sim->model.wall[0].x[d] : 0;
}

static void take_out_common(const MnsSim *sim, double sums[static SUMS])
{
    const double common = common_density(sim, sums);
    for (int d = 0; d < sim->model.dim && common != 0; d++)
        sums[MOMENT + d] += common * (sim->progress.energy.middle[d] + taken(sim, sums, d) - sums[MIDDLE + d]);
}

/* Block by block, so that the number of threads changes no bit. */
static void add_up(MnsSim *sim, Extent extent, double ret[static SUMS])
{
    if (sim->s.power) find_power(sim);
    const double surface = extent == OF_ALL && sim->model.tense ? areas_energy(sim) : 0;
    const size_t n = particles_fluid(&sim->s), blocks = sim_blocks(n);
    double(*partial)[SUMS] = (double(*)[SUMS])sim->partial;
#pragma omp parallel for schedule(static) num_threads(sim->threads)
    for (size_t b = 0; b < blocks; b++) {
        double sums[SUMS] = {0};
        const size_t first = b * SIM_BLOCK, last = first + SIM_BLOCK < n ? first + SIM_BLOCK : n;
        if (sim->s.power) sums[BY_WALLS] = sum_of(sim->s.power, first, last);
        for (size_t i = first; extent != OF_WALLS && i < last; i++) add_particle(sim, i, extent, sums);
        memcpy(partial[b], sums, sizeof sums);
    }
    memset(ret, 0, SUMS * sizeof *ret);
    for (size_t b = 0; b < blocks; b++)
        for (int k = 0; k < SUMS; k++) ret[k] += partial[b][k];
    ret[SURFACE] = surface;
}

static void find_sums(MnsSim *sim, Extent extent, double ret[static SUMS])
{
    add_up(sim, extent, ret);
    if (extent != OF_WALLS) take_out_common(sim, ret);
}

/* Where a direction is periodic there is no potential: what gravity does along it is work. */
static double potential(const MnsSim *sim, const double sums[static SUMS])
{
    double gx = 0;
    for (int d = 0; d < sim->model.dim; d++)
        if (sim->model.period[d] == 0) gx += sim->progress.energy.gravity[d] * sums[MOMENT + d];
    return -gx;
}

/* Number densities are kept within a tolerance, and so positions within that part of a spacing. Of what pulls strongest it counts once; of gravity that changes,
 * each time, as work may be off to the same side in every step, but only of what fluids do not have in common. */
static void add_doubt(MnsSim *sim, const double sums[static SUMS])
{
    const Model *model = &sim->model;
    MnsEnergy *account = &sim->progress.energy;
    const double known = fmax(model->projection.density_tolerance, sim->scheme->projects ? EVENED : 0),
                 off = known * model->dx, mean = common_density(sim, sums) * sums[VOLUME],
                 apart = sqrt(fmax(sums[VOLUME] * sums[UNLIKE] - mean * mean, 0));
    double g2 = 0, change2 = 0;
    for (int d = 0; d < model->dim; d++) {
        const double g = model->period[d] > 0 ? 0 : model->gravity[d];
        const double change = model->period[d] > 0 ? 0 : g - account->gravity[d];
        g2 += g * g;
        change2 += change * change;
    }
    account->misplaced = fmax(account->misplaced, off * sqrt(g2) * fabs(sums[WEIGHT]));
    account->lifted += off * sqrt(change2) * apart;
}

static double whole_energy(const MnsSim *sim, const double sums[static SUMS])
{
    return sums[KINETIC] + sums[ELASTIC] + sums[SURFACE] + potential(sim, sums);
}

/* If all walls move alike and there is no belt, their force is the rate at which the momentum of the fluid changes, and no sum over pairs is needed; but where
 * particles go elsewhere than their momentum does. */
bool energy_needs_power(const MnsSim *sim)
{
    const MnsCase *c = sim->c;
    for (size_t k = 0; k < c->n_walls; k++)
        if (sim->model.wall[k].has_belt) return true;
    return !motion_of_all(c) || (sim->model.transport_stress && c->n_walls > 0 && c->walls[0].motion.kind != MNS_STILL);
}

/* Room for the power of walls, where that has to be found by their forces; false: no memory, and no account. */
static bool make_room(MnsSim *sim)
{
    if (!energy_needs_power(sim) || sim->s.power) return true;
    return (sim->s.power = array_new(particles_fluid(&sim->s), sizeof *sim->s.power)) != NULL;
}

/* Does gravity change or act along a periodic direction, or do all walls move alike? The work of these is found from sums over the fluid in each
 * step. */
static bool is_driven(const MnsSim *sim)
{
    static const MnsMotion none = {0};
    for (int d = 0; d < sim->model.dim; d++)
        if (!formula_is_constant(sim->gravity[d]) || sim->model.gravity[d] != sim->progress.energy.gravity[d] ||
            (sim->model.period[d] > 0 && sim->model.gravity[d] != 0))
            return true;
    return !sim->s.power && sim->c->n_walls > 0 && !motion_same(&sim->c->walls[0].motion, &none);
}

/* What the next step is compared with. */
static void keep(MnsSim *sim, const double sums[static SUMS])
{
    for (int d = 0; d < 3; d++) {
        sim->before.moment[d] = sums[MOMENT + d];
        sim->before.momentum[d] = sums[MOMENTUM + d];
        sim->before.fall[d] = sums[FALL + d];
        sim->before.wall[d] = sim->model.n_walls ? sim->model.wall[0].v[d] : 0;
    }
}

void energy_begin(MnsSim *sim)
{
    MnsEnergy *account = &sim->progress.energy;
    const bool goes_on = account->known;
    double sums[SUMS];
    if (!make_room(sim)) {
        account->known = false;
        plan_tell(sim, "energy: no memory for its account: what a scheme makes of nothing would not be noticed");
        return;
    }
    add_up(sim, OF_ALL, sums);
    if (!goes_on) {
        memcpy(account->gravity, sim->model.gravity, sizeof account->gravity);
        for (int d = 0; d < 3; d++) account->middle[d] = sums[MIDDLE + d] - taken(sim, sums, d);
    }
    take_out_common(sim, sums);
    keep(sim, sums);
    if (goes_on) return;
    account->known = true;
    account->power = sums[BY_WALLS];
    account->start = whole_energy(sim, sums);
    account->potential = potential(sim, sums);
}

/* Of the step that has ended. Gravity is one for all of it, and where it changes from one to the next, it does at the positions between them. */
static void add_work(MnsSim *sim, const double sums[static SUMS])
{
    const Model *model = &sim->model;
    const double dt = sim->progress.dt;
    MnsEnergy *account = &sim->progress.energy;
    for (int d = 0; d < model->dim; d++) {
        const double g = model->gravity[d], lift = (g - account->gravity[d]) * sim->before.moment[d];
        if (model->period[d] > 0) account->work += 0.5 * dt * g * (sim->before.fall[d] + sums[FALL + d]);
        else {
            account->work -= lift;
            account->potential -= lift;
        }
        account->gravity[d] = g;
        if (!model->n_walls || sim->s.power) continue;
        const double push = sums[MOMENTUM + d] - sim->before.momentum[d] - dt * g * sums[WEIGHT];
        /* What projects gives the fluid the velocity of its walls, from that of the step before; forces act at both ends of a step. */
        const double v = model->wall[0].v[d], mean = sim->scheme->projects ? 0.5 * (sim->before.wall[d] + v) : v;
        account->work += push * mean;
    }
    account->work += 0.5 * dt * (account->power + sums[BY_WALLS]);
    account->power = sums[BY_WALLS];
}

static void look(MnsSim *sim, const double sums[static SUMS])
{
    MnsEnergy *account = &sim->progress.energy;
    const double made = whole_energy(sim, sums) - account->start - account->work,
                 change = fabs(potential(sim, sums) - account->potential);
    account->scale = fmax(account->scale, fmax(sums[KINETIC], change));
    const double noise = SILENT * sums[STIFFNESS] + AREA * sums[SURFACE] + account->misplaced + account->lifted;
    if (made > noise) account->excess = fmax(account->excess, made);
    const double most = sim->scheme->energy_excess > 0 ? sim->scheme->energy_excess : MOST,
                 excess = mns_sim_energy_excess(sim);
    if (!(excess > most) || sim->told.energy) return;
    sim->told.energy = true;
    plan_tell(
        sim,
        "energy: after step %llu the fluid has %.3g J more than it had and was given, %.2g %% of the largest of its "
        "kinetic energy and the change of its potential energy, allowed: %g %%. What follows is not to be trusted: a "
        "smaller scheme.cfl, a finer resolution or the scheme's defaults may mend it",
        (unsigned long long)sim->progress.step, account->excess, 100 * excess, 100 * most);
}

/* Fluids that fill a space have their middle where that has it, each volume counted alike: else particles crowd on one side, which what projects velocities need not
 * notice, and potential energy goes with them. */
static void look_at_middle(MnsSim *sim, const double sums[static SUMS])
{
    const Model *model = &sim->model;
    if (!is_full(sim) || sim->told.crowded) return;
    for (int d = 0; d < model->dim; d++) {
        const double due = sim->progress.energy.middle[d] + taken(sim, sums, d),
                     off = (sums[MIDDLE + d] - due) / sums[VOLUME] / (model->max[d] - model->min[d]);
        if (model->period[d] > 0 || !(fabs(off) > OFF_MIDDLE)) continue;
        sim->told.crowded = true;
        plan_tell(
            sim,
            "crowding: after step %llu the middle of all fluids is off by %.2g %% of the domain along %c, allowed: "
            "%g %%, though they fill it: particles are closer to each other on one side. What keeps them evenly "
            "apart is too weak: see shifting_strength of differences, density_tolerance of incompressible",
            (unsigned long long)sim->progress.step, 100 * off, "xyz"[d], 100 * OFF_MIDDLE);
        return;
    }
}

void energy_step(MnsSim *sim)
{
    MnsEnergy *account = &sim->progress.energy;
    const bool whole = sim->progress.step % EVERY == 0 || sim->progress.t >= sim->c->end_time;
    if (!account->known) return;
    const bool driven = is_driven(sim);
    if (!whole && !driven && !sim->s.power) return;
    double sums[SUMS];
    find_sums(sim, whole ? OF_ALL : driven ? OF_MOTION : OF_WALLS, sums);
    if (whole || driven) add_doubt(sim, sums);
    if (driven || sim->s.power) add_work(sim, sums);
    if (whole || driven) keep(sim, sums);
    if (whole) look(sim, sums);
    if (whole) look_at_middle(sim, sums);
}

double energy_of(MnsSim *sim)
{
    double sums[SUMS];
    if (!sim->progress.energy.known) return 0;
    find_sums(sim, OF_ALL, sums);
    return whole_energy(sim, sums);
}

void energy_steered(MnsSim *sim, double before)
{
    MnsEnergy *account = &sim->progress.energy;
    double sums[SUMS];
    if (!account->known) return;
    find_sums(sim, OF_ALL, sums);
    const double held = potential(sim, sums);
    memcpy(account->gravity, sim->model.gravity, sizeof account->gravity);
    keep(sim, sums);
    account->potential += potential(sim, sums) - held;
    account->work += whole_energy(sim, sums) - before;
    /* What projects pushes with the pressure of its last step, which steering does not undo, and a run that goes on from here does not have. */
    if (!sim->scheme->projects) account->power = sums[BY_WALLS];
}

double mns_sim_energy_excess(const MnsSim *sim)
{
    const MnsEnergy *account = &sim->progress.energy;
    if (!account->known) return NAN;
    return account->excess > 0 ? account->excess / account->scale : 0;
}
