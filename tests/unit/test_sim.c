/* SPDX-License-Identifier: BSD-3-Clause */
/* A simulation as a whole: it conserves what it should, gives the same bits for any number of threads and over a
 * restart, ends steps where it is told, follows what is steered, keeps still what is at rest, and says why it stops. */
#include "sim/integrator.h"
#include "sim/limits.h"
#include "tests/support/cases.h"
#include "tests/support/check.h"
#include <stdlib.h>
#include <string.h>

static MnsSim *sim_of(const MnsCase *c)
{
    MnsSim *sim = NULL;
    MnsError error = {0};
    if (mns_sim_new(c, &sim, &error)) fail_msg("%s: %s", error.path, error.text);
    return sim;
}

static void done(MnsSim *sim, MnsCase *c)
{
    mns_sim_free(sim);
    mns_case_free(c);
}

static void steps(MnsSim *sim, int n)
{
    MnsError error = {0};
    for (int k = 0; k < n; k++)
        if (mns_sim_step(sim, INFINITY, &error)) fail_msg("%s", error.text);
}

/* A tank that shakes, sticky, with water and air: all the solver can do at once. */
static MnsCase *shaken(int dim, unsigned threads)
{
    MnsCase *c = case_dam_break(dim, dim == 2 ? 12 : 6);
    c->max[0] = c->walls[0].shape.parts[0].b[0] = 3;
    c->fluids[0].viscosity = 1e-3;
    c->fluids[1].viscosity = 1e-6;
    c->walls[0].no_slip = true;
    c->walls[0].motion = (MnsMotion){.kind = MNS_SINE, .amplitude = {0.05, 0.02, 0.01}, .frequency = 1.5, .phase = 0.3};
    c->threads = threads;
    return c;
}

/* Smallest and largest id, and for each id where it is stored. */
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

static void momentum_and_mass_stay_in_a_periodic_box(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = case_periodic(dim, dim == 2 ? 20 : 9);
        MnsSim *sim = sim_of(c);
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
        steps(sim, 200);
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
        /* Rounding of 200 sums of forces, none of which is larger than the momentum it makes in a step. */
        for (int d = 0; d < dim; d++) assert_close(after[d], before[d], 1e-13 * size);
        free(mass);
        done(sim, c);
    }
}

/* Two streams pass each other: no pair may come into reach without being in the lists, whenever these were built. */
static void every_pair_in_reach_is_listed_at_every_step(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = case_periodic(dim, dim == 2 ? 12 : 7);
        for (int k = 0; k < 2; k++) case_set_text(&c->fluids[k].velocity[0], "y < 0.5 and 2 or -2");
        MnsSim *sim = sim_of(c);
        const Particles *s = &sim->s;
        for (int k = 0; k < 50; k++) {
            steps(sim, 1);
            size_t pairs = 0;
            for (size_t i = 0; i < s->n; i++)
                for (size_t j = 0; j < s->n; j++) {
                    double r2 = 0;
                    for (int d = 0; d < dim; d++) r2 += pow(remainder(s->x[d][i] - s->x[d][j], 1), 2);
                    pairs += i != j && sqrt(r2) < sim->model.kernel.support;
                }
            assert_close(mns_sim_mean_neighbours(sim), (double)pairs / (double)s->n, 1e-12);
            for (size_t i = 0; i < s->n; i++)
                for (int d = 0; d < dim;
                     d++) /* in the domain, or as far outside as drifted since the lists were built */
                    assert_true(s->x[d][i] > -0.5 * sim->model.skin && s->x[d][i] < 1 + 0.5 * sim->model.skin);
        }
        assert_true(mns_sim_progress(sim).rebuilds > 5 && mns_sim_progress(sim).rebuilds < 50);
        done(sim, c);
    }
}

/* P3 eq. 15-18, particle by particle, from the fields before and after a step. */
static void a_step_is_kick_drift_kick(void **state)
{
    (void)state;
    MnsCase *c = case_periodic(3, 9);
    case_set_text(&c->gravity[1], "-3*t");
    MnsSim *sim = sim_of(c);
    steps(sim, 12); /* away from the lattice, where b = 0 */
    const Particles *s = &sim->s;
    MnsCapture *before = NULL;
    assert_int_equal(mns_sim_capture(sim, mns_state_fields(), &before, NULL), MNS_OK);
    const uint64_t rebuilds = mns_sim_progress(sim).rebuilds;
    steps(sim, 1);
    assert_int_equal(mns_sim_progress(sim).rebuilds, rebuilds); /* so that the order is the same */
    const double dt = mns_sim_progress(sim).dt;
    const double *rho = before->data[mns_field_find("density")][0];
    double pushed = 0;
    for (size_t i = 0; i < s->n; i++) {
        for (int d = 0; d < 3; d++) {
            const double *x = before->data[mns_field_find("position")][d],
                         *v = before->data[mns_field_find("velocity")][d];
            const double *a = before->data[mns_field_find("acceleration")][d];
            const double *b = before->data[mns_field_find("background_acceleration")][d];
            /* Rounding of values of up to 10. */
            assert_close(s->w[d][i], 0.5 * dt * b[i], 1e-15);
            assert_close(s->x[d][i], x[i] + dt * (v[i] + 0.5 * dt * (a[i] + b[i])), 1e-15);
            assert_close(s->v[d][i], v[i] + 0.5 * dt * (a[i] + s->a[d][i]), 1e-14);
            pushed = fmax(pushed, dt * fabs(s->w[d][i]));
        }
        const bool summed = i >= s->begin[GROUP_SUMMATION];
        assert_close(s->rho[i], summed ? s->m[i] * s->rate[i] : rho[i] + dt * s->rate[i], 1e-15);
        assert_close(s->p[i], 100 * (s->rho[i] - (summed ? 0.1 : 1)), 1e-13);
    }
    assert_true(pushed > 1e-9); /* seen against the rounding above */
    mns_capture_free(before);
    done(sim, c);
}

static void bits_are_the_same_for_any_number_of_threads(void **state)
{
    (void)state;
    static const unsigned threads[] = {1, 2, 3, 7};
    for (int dim = 2; dim <= 3; dim++) {
        uint64_t hash = 0;
        for (size_t k = 0; k < 4; k++) {
            MnsCase *c = shaken(dim, threads[k]);
            MnsSim *sim = sim_of(c);
            steps(sim, 100);
            assert_true(mns_sim_progress(sim).rebuilds > 0);
            if (k > 0) assert_true(mns_sim_hash(sim) == hash);
            hash = mns_sim_hash(sim);
            done(sim, c);
        }
    }
}

/* Stopped after `before` steps and gone on in another simulation, with other threads, for 100 more. */
static void assert_restart(int dim, int before, unsigned threads, unsigned other_threads)
{
    MnsCase *c = shaken(dim, threads), *other = shaken(dim, other_threads);
    MnsSim *sim = sim_of(c), *again = sim_of(other);
    MnsCapture *capture = NULL;
    steps(sim, before);
    steps(again, 7); /* whatever it did before does not matter */
    assert_int_equal(mns_sim_capture(sim, mns_state_fields(), &capture, NULL), MNS_OK);
    const uint64_t then = mns_sim_hash(sim), rebuilds = mns_sim_progress(sim).rebuilds;
    assert_true(mns_sim_hash(again) != then);
    assert_int_equal(mns_sim_restore(again, capture, NULL), MNS_OK);
    assert_true(mns_sim_hash(again) == then);
    mns_capture_free(capture);
    steps(sim, 100);
    steps(again, 100);
    assert_true(mns_sim_progress(sim).rebuilds > rebuilds); /* over a list rebuild */
    assert_true(mns_sim_hash(again) == mns_sim_hash(sim));
    assert_true(mns_sim_hash(again) != then);
    done(again, other);
    done(sim, c);
}

static void restart_goes_on_as_if_never_stopped(void **state)
{
    (void)state;
    assert_restart(2, 0, 1, 1);
    assert_restart(2, 61, 1, 3);
    assert_restart(2, 130, 2, 1);
    assert_restart(3, 40, 3, 2);
}

/* What is derived is restored too, so that pictures and probes do not change. */
static void restart_shows_the_same_fields(void **state)
{
    (void)state;
    MnsCase *c = shaken(2, 1), *other = shaken(2, 1);
    MnsSim *sim = sim_of(c), *again = sim_of(other);
    MnsCapture *capture = NULL;
    steps(sim, 30);
    assert_int_equal(mns_sim_capture(sim, mns_state_fields(), &capture, NULL), MNS_OK);
    assert_int_equal(mns_sim_restore(again, capture, NULL), MNS_OK);
    static const char *const names[] = {"pressure", "volume", "impedance", "position", "density"};
    for (size_t k = 0; k < 5; k++) {
        const int field = mns_field_find(names[k]);
        assert_memory_equal(mns_sim_field(sim, field, 0), mns_sim_field(again, field, 0), sim->s.n * sizeof(double));
    }
    mns_capture_free(capture);
    done(again, other);
    done(sim, c);
}

static void hash_does_not_know_the_order_of_storage_but_every_bit_else(void **state)
{
    (void)state;
    MnsCase *c = shaken(2, 1);
    MnsSim *sim = sim_of(c);
    steps(sim, 3);
    const uint64_t hash = mns_sim_hash(sim);
    uint32_t *order = malloc(sim->s.n * sizeof *order);
    assert_non_null(order);
    for (int g = 0; g < GROUPS; g++)
        for (size_t k = sim->s.begin[g]; k < sim->s.begin[g + 1]; k++)
            order[k] = (uint32_t)(sim->s.begin[g] + sim->s.begin[g + 1] - 1 - k);
    particles_permute(&sim->s, order, 1);
    free(order);
    assert_true(mns_sim_hash(sim) == hash);
    sim->s.v[1][5] = nextafter(sim->s.v[1][5], 100);
    assert_true(mns_sim_hash(sim) != hash);
    sim->s.v[1][5] = nextafter(sim->s.v[1][5], -100);
    assert_true(mns_sim_hash(sim) == hash);
    sim->progress.guarded++;
    assert_true(mns_sim_hash(sim) != hash);
    done(sim, c);
}

static void captures_of_another_case_are_refused_and_change_nothing(void **state)
{
    (void)state;
    MnsCase *c = shaken(2, 1), *wider = shaken(2, 1), *flipped = shaken(2, 1), *thick = shaken(3, 1);
    wider->max[0] = wider->walls[0].shape.parts[0].b[0] = 3.25;
    flipped->fluids[1].density_method = MNS_DENSITY_CONTINUITY; /* as many particles, in other groups */
    MnsCase *others[3] = {wider, flipped, thick};
    MnsSim *sim = sim_of(c);
    steps(sim, 2);
    const uint64_t hash = mns_sim_hash(sim);
    MnsCapture *capture = NULL;
    for (int k = 0; k < 3; k++) {
        MnsSim *other = sim_of(others[k]);
        assert_int_equal(mns_sim_capture(other, mns_state_fields(), &capture, NULL), MNS_OK);
        assert_int_equal(mns_sim_restore(sim, capture, NULL), MNS_E_INVALID);
        mns_capture_free(capture);
        done(other, others[k]);
    }
    assert_int_equal(
        mns_sim_capture(sim, mns_state_fields() & ~(UINT64_C(1) << mns_field_find("velocity")), &capture, NULL),
        MNS_OK);
    assert_int_equal(mns_sim_restore(sim, capture, NULL), MNS_E_INVALID);
    mns_capture_free(capture);
    assert_true(mns_sim_hash(sim) == hash);
    done(sim, c);
}

/* Add a constant velocity: after a time t all is where it was, shifted by U t. The stress of the transport velocity,
 * as P3 prints it, is not invariant, so it is off. */
static void moving_observers_see_the_same_flow(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        const double U[3] = {0.7, -0.4, 0.2};
        MnsSim *sims[2];
        MnsCase *cases[2];
        for (int k = 0; k < 2; k++) {
            cases[k] = case_periodic(dim, dim == 2 ? 16 : 8);
            cases[k]->scheme.riemann.transport_stress = false;
            sims[k] = sim_of(cases[k]);
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
                /* Rounding of 60 steps; lists were rebuilt at other times, so sums ran in another order. */
                assert_close(remainder(shift, 1), 0, 1e-12);
                assert_close(sims[1]->s.v[d][j] - U[d], sims[0]->s.v[d][i], 1e-11);
            }
        for (int k = 0; k < 2; k++) {
            free(place[k]);
            done(sims[k], cases[k]);
        }
    }
}

/* Two fluids side by side at rest, both with their density found in the same way. */
static MnsCase *still(int dim, double resolution, MnsDensityMethod method)
{
    MnsCase *c = case_periodic(dim, resolution);
    for (int k = 0; k < 2; k++) {
        c->fluids[k].density_method = method;
        for (int d = 0; d < 3; d++) case_set_text(&c->fluids[k].velocity[d], "0");
    }
    return c;
}

static void uniform_fluids_side_by_side_stay_as_they_are(void **state)
{
    (void)state;
    for (int k = 0; k < 4; k++) {
        const int dim = 2 + k % 2;
        MnsCase *c = still(dim, 10, k < 2 ? MNS_DENSITY_CONTINUITY : MNS_DENSITY_SUMMATION);
        MnsSim *sim = sim_of(c);
        steps(sim, 20);
        for (size_t i = 0; i < sim->s.n; i++) {
            const double rho0 = c->fluids[sim->s.phase[i]].density;
            assert_close(sim->s.rho[i], rho0,
                         1e-11 * rho0); /* rounding of the lattice sum, and what it sets in motion */
            for (int d = 0; d < dim; d++) assert_close(sim->s.v[d][i], 0, 1e-11);
        }
        done(sim, c);
    }
}

static void steps_end_where_they_are_cut(void **state)
{
    (void)state;
    MnsCase *c = shaken(2, 1);
    MnsSim *sim = sim_of(c);
    const Limit *limit = NULL;
    const double dt = integrator_dt(sim, &limit);
    assert_int_equal(mns_sim_step(sim, 0.37 * dt, NULL), MNS_OK);
    assert_true(mns_sim_progress(sim).t == 0.37 * dt);
    assert_true(mns_sim_progress(sim).dt == 0.37 * dt);
    assert_true(mns_sim_progress(sim).dt_first == dt); /* what it would have been */
    const double whole = integrator_dt(sim, &limit), end = 0.37 * dt + whole;
    /* Longer by less than rounding: no second step of almost nothing. */
    assert_int_equal(mns_sim_step(sim, end * (1 + 1e-15), NULL), MNS_OK);
    assert_true(mns_sim_progress(sim).t == end * (1 + 1e-15));
    assert_int_equal(mns_sim_progress(sim).step, 2);
    /* Longer by a tenth: two steps, the second as short as it must be. */
    const double next = integrator_dt(sim, &limit), goal = mns_sim_progress(sim).t + 1.1 * next;
    assert_int_equal(mns_sim_step(sim, goal, NULL), MNS_OK);
    assert_close(mns_sim_progress(sim).dt, next, 1e-15 * next);
    assert_int_equal(mns_sim_step(sim, goal, NULL), MNS_OK);
    assert_true(mns_sim_progress(sim).t == goal);
    assert_int_equal(mns_sim_progress(sim).step, 4);
    assert_true(next != dt && mns_sim_progress(sim).dt_first == dt);
    done(sim, c);
}

/* Sums of many steps meet round numbers to the bit. */
static void output_times_are_met_exactly(void **state)
{
    (void)state;
    MnsCase *c = shaken(2, 1);
    MnsSim *sim = sim_of(c);
    for (int k = 1; k <= 20; k++) {
        const double goal = k * 0.01;
        double shortest = INFINITY;
        while (mns_sim_progress(sim).t < goal) {
            assert_int_equal(mns_sim_step(sim, goal, NULL), MNS_OK);
            shortest = fmin(shortest, mns_sim_progress(sim).dt);
        }
        assert_true(mns_sim_progress(sim).t == goal);
        assert_true(shortest > 1e-9 * mns_sim_progress(sim).dt_first);
    }
    done(sim, c);
}

static void steps_into_the_past_are_refused_and_forgotten(void **state)
{
    (void)state;
    MnsCase *c = shaken(2, 1);
    MnsSim *sim = sim_of(c);
    steps(sim, 2);
    const uint64_t hash = mns_sim_hash(sim);
    assert_int_equal(mns_sim_step(sim, mns_sim_progress(sim).t, NULL), MNS_E_INVALID);
    assert_int_equal(mns_sim_step(sim, -1, NULL), MNS_E_INVALID);
    assert_int_equal(mns_sim_step(sim, NAN, NULL), MNS_E_INVALID);
    assert_true(mns_sim_hash(sim) == hash);
    steps(sim, 1);
    done(sim, c);
}

/* dt of the first step for a box of fluid with these numbers. */
static double first_dt(double resolution, double c0, const char *gravity, double mu, const char *speed,
                       const Limit *expected)
{
    MnsCase *c = case_blank(2, resolution);
    c->periodic[0] = c->periodic[1] = true;
    case_add_fluid(c, "a", 3, c0);
    c->fluids[0].viscosity = mu;
    case_set_text(&c->fluids[0].velocity[1], speed);
    case_set_text(&c->gravity[0], gravity);
    MnsSim *sim = sim_of(c);
    const Limit *limit = NULL;
    const double dt = integrator_dt(sim, &limit);
    if (limit != expected) fail_msg("the limit is \"%s\", not \"%s\"", limit->name, expected->name);
    steps(sim, 1);
    assert_true(mns_sim_progress(sim).dt == dt);
    done(sim, c);
    return dt;
}

static void time_step_is_that_of_the_papers(void **state)
{
    (void)state;
    const double h = 1.3 / 10, tiny = 1e-15;
    assert_close(first_dt(10, 20, "0", 0, "0", &acoustic_limit), 0.25 * h / 20, tiny);
    assert_close(first_dt(20, 20, "0", 0, "0", &acoustic_limit), 0.25 * 0.5 * h / 20, tiny);
    assert_close(first_dt(10, 20, "0", 0, "-5", &acoustic_limit), 0.25 * h / 25, tiny);
    assert_close(first_dt(10, 5, "-900", 0, "0", &body_force_limit), 0.25 * sqrt(h / 900), tiny);
    assert_close(first_dt(10, 20, "-4808", 0, "0", &body_force_limit), 0.25 * sqrt(h / 4808),
                 tiny); /* just below that of sound */
    assert_close(first_dt(40, 5, "3600", 0, "0", &body_force_limit), 0.25 * sqrt(h / 4 / 3600), tiny);
    assert_close(first_dt(10, 5, "0", 3, "0", &viscous_limit), 0.125 * h * h * 3 / 3, tiny);
    assert_close(first_dt(20, 5, "0", 6, "0", &viscous_limit), 0.125 * 0.25 * h * h * 3 / 6, tiny);
}

/* Between two fluids the harmonic mean of the viscosities acts on the lighter; the faster sound counts. */
static void time_step_follows_the_worst_pair_of_fluids(void **state)
{
    (void)state;
    MnsCase *c = case_periodic(2, 10);
    c->scheme.cfl = 0.5;
    c->fluids[1].sound_speed = 40;
    for (int k = 0; k < 2; k++)
        for (int d = 0; d < 3; d++) case_set_text(&c->fluids[k].velocity[d], "0");
    MnsSim *sim = sim_of(c);
    const Limit *limit = NULL;
    assert_close(integrator_dt(sim, &limit), 0.5 * 0.13 / 40, 1e-15);
    mns_sim_free(sim);
    c->fluids[0].viscosity = 2; /* nu = 2, 2 * 2 * 1 / 3 / 0.1 = 13.3, 1 / 0.1 = 10 */
    c->fluids[1].viscosity = 1;
    sim = sim_of(c);
    assert_close(integrator_dt(sim, &limit), 0.125 * 0.13 * 0.13 * 0.1 * 3 / 4, 1e-15);
    done(sim, c);
}

static void steered_gravity_acts_from_the_next_rates_on(void **state)
{
    (void)state;
    MnsCase *c = still(2, 12, MNS_DENSITY_SUMMATION), *steered = still(2, 12, MNS_DENSITY_SUMMATION);
    case_set_text(&steered->gravity[0], "2 + 0*t");
    MnsSim *sim = sim_of(c);
    steps(sim, 1);
    assert_int_equal(mns_sim_steer(sim, steered, NULL), MNS_OK);
    mns_case_free(c);
    assert_ptr_equal(mns_sim_case(sim), steered);
    assert_true(sim->model.gravity[0] == 2); /* energies and the next time step know at once */
    double time = 0;
    for (int k = 0; k < 5; k++) {
        steps(sim, 1);
        time += mns_sim_progress(sim).dt * (k == 0 ? 0.5 : 1); /* the first half kick was before */
    }
    for (size_t i = 0; i < sim->s.n; i++) {
        assert_close(sim->s.v[0][i], 2 * time, 1e-11); /* all fall alike: nothing but rounding */
        assert_close(sim->s.v[1][i], 0, 1e-11);
    }
    done(sim, steered);
}

static void steering_refuses_what_cannot_change_and_changes_nothing_then(void **state)
{
    (void)state;
    MnsCase *c = shaken(2, 1);
    MnsSim *sim = sim_of(c);
    steps(sim, 2);
    for (int k = 0; k < 13; k++) {
        MnsCase *other = shaken(k == 1 ? 3 : 2, 1);
        if (k == 0) other->resolution = 24;
        if (k == 2) case_add_fluid(other, "oil", 1, 20);
        if (k == 2) case_add_part(&other->fluids[2].shape, MNS_BALL)->radius = 1;
        if (k == 3) case_set_text(&other->gravity[1], "-g");
        if (k == 4) other->fluids[0].density = 1.5;
        if (k == 5) other->fluids[1].viscosity = 0;
        if (k == 6) other->fluids[1].sound_speed = 30;
        if (k == 7) other->fluids[1].density_method = MNS_DENSITY_CONTINUITY;
        if (k == 8) other->scheme.kernel = MNS_QUINTIC_SPLINE;
        if (k == 9) other->scheme.smoothing = 1.5;
        if (k == 10) other->scheme.skin = 0.2;
        if (k == 11) other->max[1] = 2.5;
        if (k == 12) other->periodic[0] = true;
        MnsError error = {0};
        assert_int_equal(mns_sim_steer(sim, other, &error), MNS_E_INVALID);
        assert_true(error.text[0] != 0);
        assert_ptr_equal(mns_sim_case(sim), c);
        mns_case_free(other);
    }
    steps(sim, 10);
    MnsCase *same = shaken(2, 1);
    MnsSim *twin = sim_of(same);
    steps(twin, 12);
    assert_true(mns_sim_hash(sim) == mns_sim_hash(twin));
    done(twin, same);
    done(sim, c);
}

static void steered_threads_and_limits_do_not_change_the_bits(void **state)
{
    (void)state;
    MnsCase *c = shaken(2, 1), *steered = shaken(2, 3), *same = shaken(2, 1);
    MnsSim *sim = sim_of(c), *twin = sim_of(same);
    steered->end_time = 77;
    steps(sim, 20);
    assert_int_equal(mns_sim_steer(sim, steered, NULL), MNS_OK);
    mns_case_free(c);
    steps(sim, 60);
    steps(twin, 80);
    assert_true(mns_sim_hash(sim) == mns_sim_hash(twin));
    done(twin, same);
    done(sim, steered);
}

static void steered_options_take_effect(void **state)
{
    (void)state;
    MnsCase *c = shaken(2, 1), *steered = shaken(2, 1);
    MnsSim *sim = sim_of(c);
    steps(sim, 2);
    const Limit *limit = NULL;
    const double before = integrator_dt(sim, &limit);
    steered->scheme.cfl = 0.125;
    steered->scheme.riemann = (MnsRiemann){.limiter = 5, .background_pressure = 1, .guard = 0.1};
    assert_int_equal(mns_sim_steer(sim, steered, NULL), MNS_OK);
    assert_close(integrator_dt(sim, &limit), 0.5 * before, 1e-15);
    assert_true(sim->model.limiter == 5);
    assert_close(sim->model.phase[1].p_b, 1e-3 * 400, 1e-15);
    assert_close(sim->model.guard, 0.1 / 12, 1e-15);
    done(sim, steered);
    mns_case_free(c);
}

/* Water fills a closed tank to the lid, with the pressure of its own weight. The lattice feels a slope of p that is
 * off by a factor 1 + delta (kernel sum below), so that delta g is left over until sound has crossed the depth H and
 * built up what is missing: v < delta g H / c. Twice that allows for its reflection. */
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
        MnsSim *sim = sim_of(c);
        const Kernel *kernel = &sim->model.kernel;
        double slope = 0;
        for (int x = -3; x <= 3; x++)
            for (int y = -3; y <= 3; y++)
                for (int z = dim == 3 ? -3 : 0; z <= (dim == 3 ? 3 : 0); z++) {
                    const double r = sim->model.dx * sqrt(x * x + y * y + z * z);
                    double W = 0, F = 0;
                    kernel_eval(kernel, 1, &r, &W, &F);
                    slope -= F * pow(x * sim->model.dx, 2) * pow(sim->model.dx, dim);
                }
        const double bound = 2 * fabs(slope - 1) * 3 * 1 / 25;
        double fastest = 0;
        for (int k = 0; k < (dim == 2 ? 400 : 150); k++) {
            steps(sim, 1);
            fastest = fmax(fastest, sim->v_max);
        }
        assert_true(fastest > 0);
        assert_less(fastest, bound);
        assert_int_equal(mns_sim_progress(sim).guarded, 0);
        done(sim, c);
    }
}

static void divergence_names_particle_place_and_term_and_stays(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = case_periodic(dim, 10);
        c->limits.density_max = 1.3;
        c->limits.time_step_floor = 1e-6;
        case_set_text(&c->fluids[0].velocity[0], "-400*(x - 0.2)"); /* all of it into one line */
        MnsSim *sim = sim_of(c);
        MnsError error = {0}, again = {0};
        MnsStatus status = MNS_OK;
        for (int k = 0; k < 100 && !status; k++) status = mns_sim_step(sim, INFINITY, &error);
        assert_int_equal(status, MNS_E_DIVERGED);
        assert_int_equal(error.status, MNS_E_DIVERGED);
        static const char *const words[] = {"particle", "of water", "at (", "bounds of density", "Riemann continuity"};
        for (size_t k = 0; k < sizeof words / sizeof *words; k++)
            if (!strstr(error.text, words[k])) fail_msg("\"%s\" does not say \"%s\"", error.text, words[k]);
        /* The state is that of the step that failed, and stays. */
        const MnsProgress progress = mns_sim_progress(sim);
        const uint64_t hash = mns_sim_hash(sim);
        assert_true(progress.step > 0 && progress.t > 0);
        assert_int_equal(mns_sim_step(sim, INFINITY, &again), MNS_E_DIVERGED);
        assert_string_equal(again.text, error.text);
        assert_int_equal(mns_sim_step(sim, INFINITY, NULL), MNS_E_DIVERGED);
        assert_true(mns_sim_hash(sim) == hash && mns_sim_progress(sim).step == progress.step);
        MnsCapture *capture = NULL;
        assert_int_equal(mns_sim_capture(sim, mns_state_fields(), &capture, NULL), MNS_OK);
        mns_capture_free(capture);
        done(sim, c);
    }
}

static void velocity_that_is_no_number_is_found_at_once(void **state)
{
    (void)state;
    MnsCase *c = shaken(2, 2);
    MnsSim *sim = sim_of(c);
    steps(sim, 3);
    const size_t i = 40;
    /* Alone in the air, so that it is the only one: no neighbour takes it over in one step. */
    for (int d = 0; d < 2; d++) sim->s.v[d][i] = NAN;
    MnsError error = {0};
    assert_int_equal(mns_sim_step(sim, INFINITY, &error), MNS_E_DIVERGED);
    assert_non_null(strstr(error.text, "no number"));
    assert_non_null(strstr(error.text, "step 4 "));
    done(sim, c);
}

static void time_step_below_its_floor_is_a_divergence(void **state)
{
    (void)state;
    MnsCase *c = case_periodic(2, 10);
    c->limits.time_step_floor = 0.5;
    MnsSim *sim = sim_of(c);
    steps(sim, 1);
    for (size_t i = 0; i < sim->s.n; i++) sim->s.v[0][i] += 30; /* with c = 10 */
    steps(sim, 1);
    MnsError error = {0};
    const uint64_t hash = mns_sim_hash(sim);
    assert_int_equal(mns_sim_step(sim, INFINITY, &error), MNS_E_DIVERGED);
    assert_non_null(strstr(error.text, "floor"));
    assert_non_null(strstr(error.text, "sound and flow"));
    assert_true(mns_sim_hash(sim) == hash); /* no step was made */
    done(sim, c);
}

static void restore_takes_a_fault_away(void **state)
{
    (void)state;
    MnsCase *c = shaken(2, 1);
    MnsSim *sim = sim_of(c);
    MnsCapture *capture = NULL;
    steps(sim, 3);
    assert_int_equal(mns_sim_capture(sim, mns_state_fields(), &capture, NULL), MNS_OK);
    sim->s.v[0][9] = NAN;
    assert_int_equal(mns_sim_step(sim, INFINITY, NULL), MNS_E_DIVERGED);
    assert_int_equal(mns_sim_restore(sim, capture, NULL), MNS_OK);
    mns_capture_free(capture);
    steps(sim, 10);
    done(sim, c);
}

/* Nearest a fluid particle is to the tank's walls. */
static double nearest_to_wall(const MnsSim *sim)
{
    double nearest = INFINITY;
    for (size_t i = 0; i < particles_fluid(&sim->s); i++) {
        double x[3] = {0, 0, 0};
        for (int d = 0; d < sim->s.dim; d++) x[d] = sim->s.x[d][i] - sim->model.wall[0].x[d];
        nearest = fmin(nearest, shape_distance(&sim->solid[0], x));
    }
    return nearest;
}

/* Throw what is near the floor at it, with half the speed of sound. */
static void throw_down(MnsSim *sim)
{
    for (size_t i = 0; i < particles_fluid(&sim->s); i++) {
        if (sim->s.x[1][i] > 1.5 * sim->model.dx) continue;
        sim->s.v[0][i] = 1;
        sim->s.v[1][i] = -10;
    }
}

static void guard_keeps_what_is_thrown_at_a_wall_inside_and_counts(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int guarded = 1; guarded >= 0; guarded--) {
            MnsCase *c = shaken(dim, 2);
            if (!guarded) c->scheme.riemann.guard = 0;
            c->limits.density_max = 100;
            MnsSim *sim = sim_of(c);
            throw_down(sim);
            double nearest = INFINITY;
            for (int k = 0; k < 8; k++) {
                assert_int_equal(mns_sim_step(sim, INFINITY, NULL), MNS_OK);
                nearest = fmin(nearest, nearest_to_wall(sim));
            }
            const double distance = 0.25 * sim->model.dx;
            if (guarded) assert_true(nearest > distance * (1 - 1e-9)); /* rounding of the way back */
            else assert_true(nearest < distance);
            assert_int_equal(mns_sim_progress(sim).guarded > 0, guarded);
            done(sim, c);
        }
}

/* Only the velocity into the wall goes, relative to the wall, and not that away from it. */
static void guard_takes_only_the_velocity_into_the_wall(void **state)
{
    (void)state;
    MnsCase *c = shaken(3, 1);
    MnsSim *sim = sim_of(c);
    sim->model.wall[0] = (WallState){.x = {0.01, 0.02, -0.01}, .v = {0.1, -0.5, 0.2}, .no_slip = true};
    size_t floor[2] = {0}, n = 0;
    for (size_t i = 0; i < particles_fluid(&sim->s) && n < 2; i++)
        if (sim->s.x[1][i] < sim->model.dx && sim->s.x[0][i] > 1 && sim->s.x[2][i] > 0.3 && sim->s.x[2][i] < 0.7)
            floor[n++] = i;
    assert_int_equal(n, 2);
    const double speeds[2] = {-3, 2};
    for (size_t k = 0; k < 2; k++) {
        sim->s.x[1][floor[k]] = 0.02 - 0.4 * sim->model.dx; /* the floor is at 0.02 now */
        for (int d = 0; d < 3; d++) sim->s.v[d][floor[k]] = d == 1 ? speeds[k] : 0.7 + d;
    }
    const double x = sim->s.x[0][floor[0]];
    assert_int_equal(guard_walls(sim), 2);
    for (size_t k = 0; k < 2; k++) {
        assert_close(sim->s.x[1][floor[k]], 0.02 + 0.25 * sim->model.dx, 1e-12);
        assert_close(sim->s.v[0][floor[k]], 0.7, 1e-9); /* the normal is a difference quotient */
        assert_close(sim->s.v[2][floor[k]], 2.7, 1e-9);
        assert_close(sim->s.v[1][floor[k]], k == 0 ? -0.5 : 2, 1e-9);
    }
    assert_close(sim->s.x[0][floor[0]], x, 1e-12);
    done(sim, c);
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
    MnsSim *sim = sim_of(c);
    double before = 0, after = 0;
    for (size_t i = 0; i < particles_fluid(&sim->s); i++) before += sim->s.m[i] * sim->s.v[0][i];
    steps(sim, 50);
    for (size_t i = 0; i < particles_fluid(&sim->s); i++) {
        after += sim->s.m[i] * sim->s.v[0][i];
        assert_close(sim->s.v[1][i], 0, 0.01); /* the bumps of the wall's points are felt in passing, no more */
    }
    done(sim, c);
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
        MnsSim *sim = sim_of(c);
        while (mns_sim_progress(sim).t < 0.2) assert_int_equal(mns_sim_step(sim, 0.2, NULL), MNS_OK);
        const double k = 2 * acos(-1);
        double amplitude = 0;
        for (size_t i = 0; i < sim->s.n; i++)
            amplitude += 2 * sim->s.v[0][i] * sin(k * sim->s.x[1][i]) / (double)sim->s.n;
        /* The Laplacian on a lattice is some percent off (test_viscosity), of a decay of a third. */
        assert_close(amplitude / 0.1, exp(-0.05 * k * k * 0.2), 0.03);
        done(sim, c);
    }
}

/* Moving dummy particles are where the motion says, and their velocity is what brings them there. */
static void walls_go_where_their_motion_has_them(void **state)
{
    (void)state;
    MnsCase *c = shaken(3, 1);
    MnsSim *sim = sim_of(c);
    double *start = malloc(3 * sim->s.n * sizeof *start), *last = malloc(3 * sim->s.n * sizeof *last);
    assert_true(start && last);
    for (size_t i = particles_fluid(&sim->s); i < sim->s.n; i++)
        for (int d = 0; d < 3; d++)
            start[3 * sim->s.id[i] + (size_t)d] = last[3 * sim->s.id[i] + (size_t)d] = sim->s.x[d][i];
    for (int k = 0; k < 25; k++) {
        steps(sim, 1);
        const MnsProgress p = mns_sim_progress(sim);
        const double angle = 2 * acos(-1) * 1.5 * p.t + 0.3, shift = sin(angle) - sin(0.3);
        for (size_t i = particles_fluid(&sim->s); i < sim->s.n; i++)
            for (int d = 0; d < 3; d++) {
                const size_t at = 3 * sim->s.id[i] + (size_t)d;
                assert_close(sim->s.x[d][i], start[at] + c->walls[0].motion.amplitude[d] * shift, 1e-13); /* rounding */
                assert_close(sim->s.v[d][i] * p.dt, sim->s.x[d][i] - last[at], 1e-14);
                last[at] = sim->s.x[d][i];
            }
    }
    free(start);
    free(last);
    done(sim, c);
}

static void sizes_are_as_counted(void **state)
{
    (void)state;
    static const double neighbours[2] = {20, 80}; /* server/sim/schemes/README.md */
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = case_periodic(dim, 10);
        MnsSim *sim = sim_of(c);
        assert_int_equal(mns_sim_particles(sim), dim == 2 ? 100 : 1000);
        assert_int_equal(mns_sim_fluid_particles(sim), dim == 2 ? 100 : 1000);
        assert_close(mns_sim_spacing(sim), 0.1, 1e-15);
        assert_close(mns_sim_mean_neighbours(sim), neighbours[dim - 2], 1e-12);
        assert_true(mns_sim_bytes(sim) > mns_sim_particles(sim) * 100);
        size_t n = 0;
        steps(sim, 4);
        const MnsTimer *timers = mns_sim_timers(sim, &n);
        assert_true(n >= 5);
        for (size_t k = 0; k < n; k++) assert_true(timers[k].name && timers[k].seconds >= 0);
        done(sim, c);
    }
    mns_sim_free(NULL);
    mns_capture_free(NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(momentum_and_mass_stay_in_a_periodic_box),
        cmocka_unit_test(every_pair_in_reach_is_listed_at_every_step),
        cmocka_unit_test(a_step_is_kick_drift_kick),
        cmocka_unit_test(bits_are_the_same_for_any_number_of_threads),
        cmocka_unit_test(restart_goes_on_as_if_never_stopped),
        cmocka_unit_test(restart_shows_the_same_fields),
        cmocka_unit_test(hash_does_not_know_the_order_of_storage_but_every_bit_else),
        cmocka_unit_test(captures_of_another_case_are_refused_and_change_nothing),
        cmocka_unit_test(moving_observers_see_the_same_flow),
        cmocka_unit_test(uniform_fluids_side_by_side_stay_as_they_are),
        cmocka_unit_test(steps_end_where_they_are_cut),
        cmocka_unit_test(output_times_are_met_exactly),
        cmocka_unit_test(steps_into_the_past_are_refused_and_forgotten),
        cmocka_unit_test(time_step_is_that_of_the_papers),
        cmocka_unit_test(time_step_follows_the_worst_pair_of_fluids),
        cmocka_unit_test(steered_gravity_acts_from_the_next_rates_on),
        cmocka_unit_test(steering_refuses_what_cannot_change_and_changes_nothing_then),
        cmocka_unit_test(steered_threads_and_limits_do_not_change_the_bits),
        cmocka_unit_test(steered_options_take_effect),
        cmocka_unit_test(water_at_rest_stays_at_rest),
        cmocka_unit_test(divergence_names_particle_place_and_term_and_stays),
        cmocka_unit_test(velocity_that_is_no_number_is_found_at_once),
        cmocka_unit_test(time_step_below_its_floor_is_a_divergence),
        cmocka_unit_test(restore_takes_a_fault_away),
        cmocka_unit_test(guard_keeps_what_is_thrown_at_a_wall_inside_and_counts),
        cmocka_unit_test(guard_takes_only_the_velocity_into_the_wall),
        cmocka_unit_test(fluid_slips_along_free_walls_and_sticks_to_others),
        cmocka_unit_test(viscosity_damps_a_shear_wave),
        cmocka_unit_test(walls_go_where_their_motion_has_them),
        cmocka_unit_test(sizes_are_as_counted),
    };
    return cmocka_run_group_tests_name("sim", tests, NULL, NULL);
}
