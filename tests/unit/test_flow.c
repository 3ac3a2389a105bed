/* SPDX-License-Identifier: BSD-3-Clause */
/* Small flows do what theory says of them: momentum and mass stay, observers agree, rest stays rest, shear decays. */
#include "tests/support/check.h"
#include "tests/support/sims.h"
#include <stdlib.h>
#include <string.h>

static void momentum_and_mass_stay_in_a_periodic_box(void **state)
{
    (void)state;
    for (int way = 0; way < 4; way++) {
        const int dim = 2 + way % 2;
        const bool stressed = way >= 2;
        MnsCase *c = case_periodic(dim, dim == 2 ? 20 : 9);
        c->scheme.riemann.transport_stress = stressed;
        MnsSim *sim = sim_in_arrays(c);
        const Particles *s = &sim->s;
        double before[3] = {0}, after[3] = {0}, size = 0;
        double *mass = malloc(s->n * sizeof *mass);
        assert_non_null(mass);
        for (size_t i = 0; i < s->n; i++) {
            mass[s->id[i]] = s->m[i];
            for (int d = 0; d < dim; d++) {
                before[d] += s->m[i] * s->v[d][i];
                size += s->m[i] * fabs(s->v[d][i]);
            }
        }
        sim_steps(sim, 200);
        assert_true(mns_sim_progress(sim).rebuilds > 3);
        double moved = 0;
        for (size_t i = 0; i < s->n; i++) {
            assert_true(s->m[i] == mass[s->id[i]]);
            for (int d = 0; d < dim; d++) {
                after[d] += s->m[i] * s->v[d][i];
                moved = fmax(moved, fabs(s->a[d][i]));
            }
        }
        assert_true(moved > 1); /* it is no lattice at rest */
        /* Rounding of 200 sums of forces, none of which is larger than the momentum it makes in a step. The transport stress is made of differences, so that
         * every observer sees the same, and is not opposite for the two of a pair. */
        for (int d = 0; d < dim; d++) assert_close(after[d], before[d], (stressed ? 1e-2 : 1e-13) * size);
        free(mass);
        sim_done(sim, c);
    }
}

/* For each id where it is stored, to be freed. */
static uint32_t *places(const MnsSim *sim)
{
    uint32_t *place = malloc(sim->s.n * sizeof *place);
    if (!place) abort();
    memset(place, 0xff, sim->s.n * sizeof *place);
    for (size_t i = 0; i < sim->s.n; i++) {
        assert_in_range(sim->s.id[i], 0, sim->s.n - 1);
        assert_int_equal(place[sim->s.id[i]], UINT32_MAX);
        place[sim->s.id[i]] = (uint32_t)i;
    }
    return place;
}

/* Add a constant velocity: after a time t all is where it was, shifted by U t; with the stress of the transport velocity too, which as P3 prints it would
 * be another. */
static void moving_observers_see_the_same_flow(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        const double U[3] = {0.7, -0.4, 0.2};
        MnsSim *sims[2];
        MnsCase *cases[2];
        for (int k = 0; k < 2; k++) {
            cases[k] = case_periodic(dim, dim == 2 ? 16 : 8);
            sims[k] = sim_in_arrays(cases[k]);
            for (int d = 0; k == 1 && d < dim; d++)
                for (size_t i = 0; i < sims[k]->s.n; i++) sims[k]->s.v[d][i] += U[d];
        }
        const double dt = 0.25 * 1.3 / 16 / 14; /* below both limits; 2D is the finer one */
        for (int n = 1; n <= 60; n++)
            for (int k = 0; k < 2; k++) assert_int_equal(mns_sim_step(sims[k], n * dt, NULL), MNS_OK);
        assert_true(mns_sim_progress(sims[1]).step == 60);
        uint32_t *place[2] = {places(sims[0]), places(sims[1])};
        for (size_t id = 0; id < sims[0]->s.n; id++)
            for (int d = 0; d < dim; d++) {
                const size_t i = place[0][id], j = place[1][id];
                const double shift = sims[1]->s.x[d][j] - sims[0]->s.x[d][i] - U[d] * 60 * dt;
                /* Rounding of 60 steps; lists were rebuilt at other times, so sums ran in another order: of strains in single precision, which takes
                 * a millionth of what is not dissipated from one observer or the other. */
                assert_close(remainder(shift, 1), 0, 1e-11);
                assert_close(sims[1]->s.v[d][j] - U[d], sims[0]->s.v[d][i], 1e-10);
            }
        for (int k = 0; k < 2; k++) {
            free(place[k]);
            sim_done(sims[k], cases[k]);
        }
    }
}

static void uniform_fluids_side_by_side_stay_as_they_are(void **state)
{
    (void)state;
    for (int k = 0; k < 4; k++) {
        const int dim = 2 + k % 2;
        MnsCase *c = case_still(dim, 10, k < 2 ? MNS_DENSITY_CONTINUITY : MNS_DENSITY_SUMMATION);
        MnsSim *sim = sim_in_arrays(c);
        sim_steps(sim, 20);
        for (size_t i = 0; i < sim->s.n; i++) {
            const double rho0 = c->fluids[sim->s.phase[i]].density;
            assert_close(sim->s.rho[i], rho0,
                         1e-11 * rho0); /* rounding of the lattice sum, and what it sets in motion */
            for (int d = 0; d < dim; d++) assert_close(sim->s.v[d][i], 0, 1e-11);
        }
        sim_done(sim, c);
    }
}

/* Water fills a closed tank to the lid, with the pressure of its own weight. The lattice feels the slope of p exactly, so
 * what moves is left over by compression: of second order in rho / rho0 - 1 < g H / c^2, and gone when sound has crossed H. */
static void water_at_rest_stays_at_rest(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = case_blank(dim, dim == 2 ? 16 : 8);
        c->max[0] = 1.5;
        case_set_text(&c->gravity[1], "-3");
        case_add_fluid(c, "water", 1000, 25);
        case_set_text(&c->fluids[0].pressure, "hydrostatic");
        case_add_wall(c, "tank");
        MnsPart *side = case_add_part(&c->walls[0].shape, MNS_BOX);
        side->outside = true;
        for (int d = 0; d < 3; d++) side->b[d] = c->max[d];
        MnsSim *sim = sim_in_arrays(c);
        const double compression = 3 * 1 / (25.0 * 25), bound = 2 * compression * 3 * 1 / 25;
        double fastest = 0;
        for (int k = 0; k < (dim == 2 ? 400 : 150); k++) {
            sim_steps(sim, 1);
            fastest = fmax(fastest, sim->v_max);
        }
        assert_true(fastest > 0);
        assert_less(fastest, bound);
        assert_int_equal(mns_sim_progress(sim).guarded, 0);
        sim_done(sim, c);
    }
}

static MnsCase *full_tank(double resolution)
{
    MnsCase *c = case_blank(2, resolution);
    case_set_text(&c->gravity[1], "-10");
    case_add_fluid(c, "water", 1000, 45);
    case_set_text(&c->fluids[0].pressure, "hydrostatic");
    case_add_wall(c, "tank");
    MnsPart *side = case_add_part(&c->walls[0].shape, MNS_BOX);
    side->outside = true;
    for (int d = 0; d < 3; d++) side->b[d] = c->max[d];
    return c;
}

/* Stirred, so that particles are moved about by spreading and by the flow. Were the volume not kept, the mean pressure would climb
 * by tens of percents of rho g H in this time. */
static void mean_pressure_of_a_full_tank_stays(void **state)
{
    (void)state;
    MnsCase *c = full_tank(16);
    case_set_text(&c->fluids[0].velocity[0], "sin(pi*x)*cos(pi*y)");
    case_set_text(&c->fluids[0].velocity[1], "-cos(pi*x)*sin(pi*y)");
    MnsSim *sim = sim_in_arrays(c);
    const Particles *s = &sim->s;
    double mean[2] = {0, 0};
    for (int k = 0; k < 2; k++) {
        if (k) sim_steps(sim, 1500);
        for (size_t i = 0; i < particles_fluid(s); i++) mean[k] += s->p[i] / (double)particles_fluid(s);
    }
    assert_true(mns_sim_progress(sim).t > 0.5);
    assert_close(mean[1], mean[0], 0.02 * 1000 * 10 * 1);
    sim_done(sim, c);
}

/* With walls that move against each other nobody knows the volume: nothing is done to the density. */
static void space_of_a_piston_is_not_closed(void **state)
{
    (void)state;
    for (int moves = 0; moves < 2; moves++) {
        MnsCase *c = full_tank(10);
        case_add_wall(c, "piston");
        MnsPart *lid = case_add_part(&c->walls[1].shape, MNS_BOX);
        lid->a[1] = 1;
        lid->a[0] = -1;
        lid->b[0] = 2;
        lid->b[1] = c->walls[0].shape.parts[0].b[1] = 2; /* the tank leaves it room */
        if (moves) c->walls[1].motion = (MnsMotion){.kind = MNS_SINE, .amplitude = {0, 1e-3}, .frequency = 1};
        MnsSim *sim = sim_in_arrays(c);
        assert_int_equal(sim->model.closed, !moves);
        sim_done(sim, c);
    }
}

/* The advection velocity is dt/2 b, and dt goes with the greatest speed of sound of all. */
static void fluids_are_spread_as_fast_as_their_own_sound_beside_a_stiffer_one(void **state)
{
    (void)state;
    double spread[2];
    for (int stiff = 0; stiff < 2; stiff++) {
        MnsCase *c = case_periodic(2, 20);
        if (stiff) c->fluids[1].sound_speed = 35;
        MnsSim *sim = sim_in_arrays(c);
        sim_steps(sim, 1);
        const Phase *water = &sim->model.phase[0];
        /* w over |sum V grad W|; gravity and viscosity do not limit the step here */
        spread[stiff] = mns_sim_progress(sim).dt * water->p_b / water->rho0;
        assert_true(spread[stiff] > 0);
        sim_done(sim, c);
    }
    assert_close(spread[1], spread[0], 0.1 * spread[0]); /* the flow's own speed counts in dt too */
}

/* A channel along x between two plates; momentum after some steps over what it was. */
static double kept_momentum(int dim, bool no_slip, const char *belt)
{
    MnsCase *c = case_blank(dim, 10);
    c->periodic[0] = c->periodic[2] = true;
    c->periodic[2] = dim == 3;
    case_add_fluid(c, "oil", 1, 10);
    c->fluids[0].viscosity = 0.3;
    case_set_text(&c->fluids[0].velocity[0], "0.5");
    case_add_wall(c, "plates");
    MnsPart *gap = case_add_part(&c->walls[0].shape, MNS_BOX);
    gap->outside = true;
    gap->a[0] = gap->a[2] = -9;
    gap->b[0] = gap->b[2] = 9;
    gap->b[1] = 1;
    c->walls[0].no_slip = no_slip;
    case_set_text(&c->walls[0].surface_velocity[0], belt);
    MnsSim *sim = sim_in_arrays(c);
    double before = 0, after = 0;
    for (size_t i = 0; i < particles_fluid(&sim->s); i++) before += sim->s.m[i] * sim->s.v[0][i];
    sim_steps(sim, 50);
    for (size_t i = 0; i < particles_fluid(&sim->s); i++) {
        after += sim->s.m[i] * sim->s.v[0][i];
        assert_close(sim->s.v[1][i], 0, 0.01); /* the bumps of the wall's points are felt in passing, no more */
    }
    sim_done(sim, c);
    return after / before;
}

static void fluid_slips_along_free_walls_and_sticks_to_others(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        /* The bumps of the wall's points, along the flow. */
        assert_close(kept_momentum(dim, false, "0"), 1, 1e-4);
        assert_close(kept_momentum(dim, false, "3"), 1, 1e-4);
        assert_close(kept_momentum(dim, true, "0.5"), 1, 1e-4); /* goes along */
        assert_less(kept_momentum(dim, true, "0"), 0.8);
        assert_true(kept_momentum(dim, true, "1") > 1.2);
    }
}

/* u = U sin(2 pi y) decays with the rate mu/rho (2 pi)^2. */
static void viscosity_damps_a_shear_wave(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = case_blank(dim, dim == 2 ? 20 : 12);
        for (int d = 0; d < dim; d++) c->periodic[d] = true;
        case_add_fluid(c, "oil", 2, 10);
        c->fluids[0].viscosity = 0.1;
        case_set_text(&c->fluids[0].velocity[0], "0.1*sin(2*pi*y)");
        MnsSim *sim = sim_in_arrays(c);
        while (mns_sim_progress(sim).t < 0.2) assert_int_equal(mns_sim_step(sim, 0.2, NULL), MNS_OK);
        const double k = 2 * acos(-1);
        double amplitude = 0;
        for (size_t i = 0; i < sim->s.n; i++)
            amplitude += 2 * sim->s.v[0][i] * sin(k * sim->s.x[1][i]) / (double)sim->s.n;
        /* By steps, and by what of a sine is lost on 20 or 12 particles. */
        assert_close(amplitude / 0.1, exp(-0.05 * k * k * 0.2), dim == 2 ? 0.004 : 0.01);
        sim_done(sim, c);
    }
}

/* A disc of liquid of ten spacings that turns as one body with 20/s, under the pressure that a cup holds it by; without a cup under riemann, which keeps
 * the volume of a full one. */
static MnsSim *turning(const char *scheme, double cfl, MnsCase **ret_case)
{
    MnsCase *c = *ret_case = case_blank(2, 100);
    c->scheme.name = scheme;
    c->scheme.cfl = cfl;
    if (strcmp(scheme, "interfacial") == 0) c->scheme.smoothing = 1.6;
    c->max[0] = c->max[1] = 0.3;
    case_add_fluid(c, "water", 1000, 20);
    MnsPart *liquid = case_add_part(&c->fluids[0].shape, MNS_BALL);
    case_set_text(&c->fluids[0].velocity[0], "-20*(y - 0.15)");
    case_set_text(&c->fluids[0].velocity[1], "20*(x - 0.15)");
    case_set_text(&c->fluids[0].pressure, "200000*((x - 0.15)^2 + (y - 0.15)^2)");
    liquid->a[0] = liquid->a[1] = 0.15;
    liquid->radius = 0.1;
    if (strcmp(scheme, "riemann") == 0) return sim_of(c);
    case_add_wall(c, "cup");
    MnsPart *cup = case_add_part(&c->walls[0].shape, MNS_BALL);
    cup->outside = true;
    cup->a[0] = cup->a[1] = 0.15;
    cup->radius = 0.1;
    return sim_of(c);
}

/* d ln rho / dt in its middle within the first millisecond, before its rim is heard there; and the first step. */
static double expansion(const char *scheme, double cfl, double *ret_dt)
{
    MnsCase *c;
    MnsSim *sim = turning(scheme, cfl, &c);
    double mean[2] = {0}, n = 0;
    for (int k = 0; k < 2; k++) {
        const Particles *s = &sim->s;
        n = 0;
        for (size_t i = 0; i < particles_fluid(s); i++) {
            if (hypot(s->x[0][i * s->x_step] - 0.15, s->x[1][i * s->x_step] - 0.15) > 0.03) continue;
            mean[k] += log(s->rho[i]);
            n++;
        }
        mean[k] /= n;
        while (k == 0 && mns_sim_progress(sim).t < 1e-3) assert_int_equal(mns_sim_step(sim, 1e-3, NULL), MNS_OK);
    }
    assert_true(n > 20);
    *ret_dt = mns_sim_progress(sim).dt_first;
    sim_done(sim, c);
    return (mean[1] - mean[0]) / 1e-3;
}

/* Not by the square of how far it turns in a step, and so not with a pressure that climbs by tens of kPa a second. What is left under riemann
 * is its dissipation in the curved pressure, whatever the step. */
static void liquid_that_turns_does_not_expand(void **state)
{
    (void)state;
    double dt, shorter;
    const double rate = expansion("interfacial", 0.25, &dt);
    assert_close(rate, 0, 0.02 * 400 * dt);
    const double riemann = expansion("riemann", 0.25, &dt), finer = expansion("riemann", 0.125, &shorter);
    assert_close(dt / shorter, 2, 1e-12);
    assert_close(riemann, finer, 0.05 * 400 * dt);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(momentum_and_mass_stay_in_a_periodic_box),
        cmocka_unit_test(moving_observers_see_the_same_flow),
        cmocka_unit_test(uniform_fluids_side_by_side_stay_as_they_are),
        cmocka_unit_test(water_at_rest_stays_at_rest),
        cmocka_unit_test(mean_pressure_of_a_full_tank_stays),
        cmocka_unit_test(space_of_a_piston_is_not_closed),
        cmocka_unit_test(fluids_are_spread_as_fast_as_their_own_sound_beside_a_stiffer_one),
        cmocka_unit_test(fluid_slips_along_free_walls_and_sticks_to_others),
        cmocka_unit_test(viscosity_damps_a_shear_wave),
        cmocka_unit_test(liquid_that_turns_does_not_expand),
    };
    return cmocka_run_group_tests_name("flow", tests, NULL, NULL);
}
