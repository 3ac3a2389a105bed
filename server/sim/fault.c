/* SPDX-License-Identifier: BSD-3-Clause */
/* Why a run diverged: a particle that is not well, where it is, and the term that moves it most. Of several it is one whose density has left
 * its bounds, as what is no number comes from such a one, and of these the one with the smallest id. */
#include "base/array.h"
#include "sim/sim.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static double squared_speed(const Particles *s, size_t i)
{
    double v2 = 0;
    for (int d = 0; d < s->dim; d++) v2 += s->v[d][i * s->v_step] * s->v[d][i * s->v_step];
    return v2;
}

static double speed(const Particles *s, size_t i)
{
    return sqrt(squared_speed(s, i));
}

static size_t worst_particle(const MnsSim *sim)
{
    const Particles *s = &sim->s;
    const size_t n = particles_fluid(s);
    size_t worst = n;
    bool cause = false; /* is it one that the others may come from? */
    for (size_t i = 0; i < n; i++) {
        if (sim_is_well(s, &sim->model, i, squared_speed(s, i))) continue;
        const bool can_be = isfinite(s->rho[i]) && isfinite(speed(s, i));
        if (worst < n && (can_be == cause ? s->id[i] > s->id[worst] : cause)) continue;
        worst = i;
        cause = can_be;
    }
    return worst;
}

/* What one term alone does to a particle. */
typedef struct Effect {
    double acceleration; /* magnitude [m/s^2] */
    double rate;         /* of the density: of its rate or sum, or of what is added to it over a step's length */
} Effect;

/* Component d of a field of particle i, if there is one. */
static double *value(const Particles *s, int field, int d, size_t i)
{
    return mns_fields()[field].type == MNS_F64 ? particles_element(s, field, d, i) : NULL;
}

/* The effect of a term on particle i; what the particle had is put back. */
static Effect alone(MnsSim *sim, Row *row, const Term *term)
{
    Particles *s = &sim->s;
    const size_t i = row->i;
    double kept[FIELDS_END][3], a2 = 0;
    const double rate = s->rate[i];
    const Fields writes = term->writes | FIELD(A);
    for (int f = 0; f < FIELDS_END; f++)
        for (int d = 0; d < 3 && writes >> f & 1; d++)
            if (value(s, f, d, i)) kept[f][d] = *value(s, f, d, i);
    s->rate[i] = 0;
    for (int d = 0; d < s->dim; d++) s->a[d][i] = 0;
    term_row(term, row, s, &sim->model);
    for (int d = 0; d < s->dim; d++) a2 += s->a[d][i] * s->a[d][i];
    const bool adds = term->writes & FIELD(RHO); /* and has the rate for what it keeps */
    const Effect effect = {sqrt(a2), adds ? fabs(s->rho[i] - kept[F_RHO][0]) / sim->model.dt : fabs(s->rate[i])};
    for (int f = 0; f < FIELDS_END; f++)
        for (int d = 0; d < 3 && writes >> f & 1; d++)
            if (value(s, f, d, i)) *value(s, f, d, i) = kept[f][d];
    s->rate[i] = rate;
    return effect;
}

/* Of accelerations, those that write them: others fill rows of a pressure system that may not be laid out. */
static bool is_asked(const Term *term, bool density, unsigned group, const Model *model)
{
    return term->on & group && (density || term->writes & FIELD(A)) && term_needed(term, model);
}

/* The term that has most to do with the density of i, or with its acceleration; one that gives no number counts as most. Where the
 * pressure is solved for, no term has to do with densities, and the pressure is what is left if nothing else pushes. */
static const char *blame(MnsSim *sim, size_t i, bool density)
{
    const bool projects = sim->scheme->projects;
    const Model *model = &sim->model;
    double most = 0; /* of gravity to begin with, which is no term */
    for (int d = 0; d < model->dim; d++) {
        if (!isfinite(model->gravity[d])) return "gravity";
        if (!density) most = hypot(most, model->gravity[d]);
        for (size_t k = 0; k < model->n_walls; k++)
            if (!isfinite(model->wall[k].x[d] + model->wall[k].v[d] + model->wall[k].a[d] + model->wall[k].belt[d]))
                return "motion of a wall";
    }
    if (density && projects) return "number density";
    const char *name = density ? "density" : projects && most == 0 ? "pressure" : "gravity";
    Row *row = array_new(1, sizeof *row); /* aligned */
    if (!row) return "unknown";
    const unsigned needs = scheme_needs(sim->scheme, model);
    neighbours_refresh(&sim->nb, &sim->s, model, needs);
    const RowPlan plan = row_plan(&sim->nb, &sim->s, model, needs, ROW_LISTED);
    row_build(row, &plan, i);
    const unsigned group = i < sim->s.begin[GROUP_SUMMATION] ? ON_CONTINUITY : ON_SUMMATION;
    const Pass *passes = sim->scheme->rates;
    for (int p = 0; p < SCHEME_PASSES_MAX && passes[p].name; p++)
        for (int k = 0; k < PASS_TERMS_MAX && passes[p].terms[k]; k++) {
            const Term *term = passes[p].terms[k];
            if (!is_asked(term, density, group, model)) continue;
            const Effect effect = alone(sim, row, term);
            const double size = density ? effect.rate : effect.acceleration;
            if (size <= most) continue;
            most = isnan(size) ? INFINITY : size;
            name = term->name;
        }
    free(row);
    return name;
}

/* Is there anything that would hold a fluid together where pressures fall below zero, and is it not asked for? What is there of such a scheme is in all
 * pressures, not in those of a transport alone. */
static bool could_be_held(const MnsSim *sim, const Phase *phase, double ratio)
{
    return sim->scheme->takes_background && phase->background == 0 && ratio <= sim->model.density_min;
}

/* Densities that only the case's own bounds forbid are not mended by smaller steps: all that could be may be right. */
static const char *remedy(const Scheme *scheme, bool dense, double ratio)
{
    const bool by_case = dense && ratio > 0.1 && ratio < 10; /* within the bounds of a case that says nothing of them */
    if (scheme->projects)
        return by_case ? "wider limits.density_min and density_max, a smaller scheme.cfl or a finer resolution"
                       : "a smaller scheme.cfl, a higher reference_speed or a finer resolution";
    return by_case ? "wider limits.density_min and density_max, or a higher sound_speed"
                   : "a higher sound_speed, a smaller scheme.cfl or a finer resolution";
}

MnsStatus fault_particle(MnsSim *sim, MnsError *error)
{
    const Particles *s = &sim->s;
    const size_t i = worst_particle(sim);
    if (i == particles_fluid(s)) return mns_fail(error, MNS_E_INTERNAL, "a particle was not well, then none was");
    const Phase *phase = &sim->model.phase[s->phase[i]];
    const double ratio = s->rho[i] / phase->rho0;
    const bool dense = !(ratio > sim->model.density_min && ratio < sim->model.density_max);
    const double z = s->dim == 3 ? s->x[2][i * s->x_step] : 0;
    char held[128] = "";
    if (could_be_held(sim, phase, ratio))
        snprintf(held, sizeof held, "a scheme.%s.background_pressure of up to %g Pa, ", sim->scheme->name,
                 0.5 * phase->rho0 * phase->c * phase->c / phase->exponent);
    return mns_fail(
        error, MNS_E_DIVERGED,
        "diverged in step %llu at t = %g s: particle %u of %s at (%g, %g, %g) m has %s (density %g times its "
        "reference, allowed (%g, %g); speed %g m/s); most is due to \"%s\". Look at the snapshot, then try %s%s",
        (unsigned long long)sim->progress.step + 1, sim->model.t, s->id[i], sim->c->fluids[s->phase[i]].name,
        s->x[0][i * s->x_step], s->x[1][i * s->x_step], z,
        dense ? "left the bounds of density" : "a velocity that is no number", ratio, sim->model.density_min,
        sim->model.density_max, speed(s, i), blame(sim, i, dense), held, remedy(sim->scheme, dense, ratio));
}

MnsStatus fault_time_step(MnsSim *sim, double dt, const Limit *limit, MnsError *error)
{
    const Particles *s = &sim->s;
    size_t fast = 0;
    for (size_t i = 0; i < particles_fluid(s); i++)
        if (speed(s, i) > speed(s, fast)) fast = i;
    return mns_fail(
        error, MNS_E_DIVERGED,
        "diverged after step %llu at t = %g s: the time step fell to %g s, under the floor of %g s (limit: %s, %s; "
        "set by %s); "
        "fastest is particle %u of %s at (%g, %g, %g) m with %g m/s, most due to \"%s\". Look at the snapshot, then "
        "mend "
        "that, or lower limits.time_step_floor",
        (unsigned long long)sim->progress.step, sim->progress.t, dt, plan_floor(sim), limit->name, limit->source,
        limit->entries, s->id[fast], sim->c->fluids[s->phase[fast]].name, s->x[0][fast * s->x_step],
        s->x[1][fast * s->x_step], s->dim == 3 ? s->x[2][fast * s->x_step] : 0, speed(s, fast),
        blame(sim, fast, false));
}
