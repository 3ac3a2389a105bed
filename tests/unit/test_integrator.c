/* SPDX-License-Identifier: BSD-3-Clause */
/* A step is what the paper says, particle by particle; no pair in reach is ever missed on the way, and walls are where their
 * motion has them. */
#include "tests/support/check.h"
#include "tests/support/sims.h"
#include <stdlib.h>

/* P3 eq. 15-18, particle by particle, from the fields before and after a step. */
static void a_step_is_kick_drift_kick(void **state)
{
    (void)state;
    MnsCase *c = case_periodic(3, 9);
    case_set_text(&c->gravity[1], "-3*t");
    MnsSim *sim = sim_in_arrays(c);
    sim_steps(sim, 12); /* away from the lattice, where b = 0 */
    const Particles *s = &sim->s;
    MnsCapture *before = NULL;
    assert_int_equal(mns_sim_capture(sim, mns_sim_state_fields(sim), &before, NULL), MNS_OK);
    const uint64_t rebuilds = mns_sim_progress(sim).rebuilds;
    sim_steps(sim, 1);
    assert_int_equal(mns_sim_progress(sim).rebuilds, rebuilds); /* so that the order is the same */
    const double dt = mns_sim_progress(sim).dt;
    const double later = 0.5 * (dt + before->progress.dt); /* of the means of gravity that two steps take */
    const double *rho = before->data[mns_field_find("density")][0];
    double pushed = 0;
    for (size_t i = 0; i < s->n; i++) {
        for (int d = 0; d < 3; d++) {
            const double *x = before->data[mns_field_find("position")][d],
                         *v = before->data[mns_field_find("velocity")][d];
            const double *a = before->data[mns_field_find("acceleration")][d];
            const double *b = before->data[mns_field_find("background_acceleration")][d];
            const double begins = a[i] + (d == 1 ? -3 * later : 0);
            /* Rounding of values of up to 10. */
            assert_close(s->x[d][i], x[i] + dt * (v[i] + 0.5 * dt * (begins + b[i])), 1e-15);
            assert_close(s->v[d][i], v[i] + 0.5 * dt * (begins + s->a[d][i]), 1e-14);
            pushed = fmax(pushed, dt * fabs(0.5 * dt * b[i]));
        }
        const bool summed = i >= s->begin[GROUP_SUMMATION];
        assert_close(s->rho[i], summed ? s->m[i] * s->rate[i] : rho[i] + dt * s->rate[i], 1e-15);
        assert_close(s->p[i], 100 * (s->rho[i] - (summed ? 0.1 : 1)), 1e-13);
    }
    assert_true(pushed > 1e-9); /* seen against the rounding above */
    /* The last half kick is seen by who asks for the neighbours' velocities now, to say whose fault it was. */
    neighbours_refresh(&sim->nb, &sim->s, &sim->model, NEED_V);
    const RowPlan plan = row_plan(&sim->nb, s, &sim->model, NEED_V, ROW_LISTED);
    static Row row;
    for (size_t i = 0; i < s->n; i++) {
        row_build(&row, &plan, i);
        for (size_t k = 0; k < row.n * LANES; k++)
            for (int d = 0; d < 3; d++) assert_true(row.block[k / LANES].v[d][k % LANES] == s->v[d][row.j[k]]);
    }
    mns_capture_free(before);
    sim_done(sim, c);
}

/* Two streams pass each other: no pair may come into reach without being in the lists, whenever these were built. */
static void every_pair_in_reach_is_listed_at_every_step(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = case_periodic(dim, dim == 2 ? 12 : 7);
        for (int k = 0; k < 2; k++) case_set_text(&c->fluids[k].velocity[0], "y < 0.5 and 2 or -2");
        MnsSim *sim = sim_in_arrays(c);
        const Particles *s = &sim->s;
        for (int k = 0; k < 50; k++) {
            sim_steps(sim, 1);
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
        sim_done(sim, c);
    }
}

/* Moving dummy particles are where the motion says, and their velocity is what brings them there. */
static void walls_go_where_their_motion_has_them(void **state)
{
    (void)state;
    MnsCase *c = case_shaken(3, 1);
    MnsSim *sim = sim_in_arrays(c);
    double *start = malloc(3 * sim->s.n * sizeof *start), *last = malloc(3 * sim->s.n * sizeof *last);
    assert_true(start && last);
    for (size_t i = particles_fluid(&sim->s); i < sim->s.n; i++)
        for (int d = 0; d < 3; d++)
            start[3 * sim->s.id[i] + (size_t)d] = last[3 * sim->s.id[i] + (size_t)d] = sim->s.x[d][i];
    for (int k = 0; k < 25; k++) {
        sim_steps(sim, 1);
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
    sim_done(sim, c);
}

/* A simulation of this case by predictor and corrector after so many equal steps to this time. */
static MnsSim *predicted(const MnsCase *c, double to, int steps)
{
    MnsSim *sim = sim_in_arrays(c);
    MnsError error = {0};
    for (int k = 1; k <= steps; k++)
        if (mns_sim_step(sim, k == steps ? to : to * k / steps, &error)) fail_msg("%s", error.text);
    assert_int_equal(mns_sim_progress(sim).step, steps); /* or the limits were in the way */
    return sim;
}

static MnsCase *falling(const char *gravity)
{
    MnsCase *c = case_still(2, 10, MNS_DENSITY_CONTINUITY);
    c->scheme.name = "dissipation";
    c->scheme.dissipation.pair_average = MNS_AVERAGE_DENSITY;
    case_set_text(&c->gravity[1], gravity);
    return c;
}

/* Without walls nothing is in the way of a fall: exact under constant gravity, and under one that changes velocities still are, while places are
 * of second order. */
static void falls_are_exact_or_of_second_order(void **state)
{
    (void)state;
    MnsCase *c = falling("-3");
    MnsSim *start = sim_in_arrays(c), *sim = predicted(c, 0.04, 20);
    for (size_t i = 0; i < sim->s.n; i++) {
        size_t k = 0;
        while (start->s.id[k] != sim->s.id[i]) k++;
        assert_close(sim->s.v[1][i], -3 * 0.04, 1e-14);
        assert_close(remainder(sim->s.x[1][i] - start->s.x[1][k] + 1.5 * 0.04 * 0.04, 1), 0, 1e-14);
    }
    mns_sim_free(start);
    sim_done(sim, c);
    double off[2][2];
    for (int k = 0; k < 2; k++) {
        c = falling("cos(40*t)");
        sim = predicted(c, 0.04, k == 0 ? 20 : 40);
        const double y = remainder(sim->s.x[1][0], 0.1), exact = (1 - cos(1.6)) / 1600;
        off[k][0] = sim->s.v[1][0] - sin(1.6) / 40;
        off[k][1] = remainder(y - exact - 0.05, 0.1);
        sim_done(sim, c);
    }
    for (int k = 0; k < 2; k++) assert_close(off[k][0], 0, 1e-12);
    assert_less(1e-9, fabs(off[1][1]));
    assert_close(off[0][1] / off[1][1], 4, 0.02);
}

/* Halved steps leave a quarter of the error: of velocities, from three runs. */
static void assert_second_order(const MnsCase *c, double to, int steps)
{
    MnsSim *sim[3];
    for (int k = 0; k < 3; k++) sim[k] = predicted(c, to, steps << k);
    double difference[2] = {0, 0};
    for (int k = 0; k < 2; k++)
        for (size_t i = 0; i < particles_fluid(&sim[k]->s); i++) {
            size_t j = 0;
            while (sim[k + 1]->s.id[j] != sim[k]->s.id[i]) j++;
            for (int d = 0; d < 2; d++) difference[k] += pow(sim[k]->s.v[d][i] - sim[k + 1]->s.v[d][j], 2);
        }
    assert_close(sqrt(difference[0] / difference[1]), 4, 0.05);
    for (int k = 0; k < 3; k++) mns_sim_free(sim[k]);
}

/* Flow of two fluids, with all terms of P1 but friction. With tension nothing is shifted, which would be of first order. */
static void predictor_and_corrector_are_of_second_order_together(void **state)
{
    (void)state;
    MnsCase *c = case_periodic(2, 10);
    c->scheme.name = "dissipation";
    c->scheme.smoothing = 1.6;
    c->scheme.dissipation.pair_average = MNS_AVERAGE_DENSITY;
    c->tension[0][1] = c->tension[1][0] = 1e-6;
    assert_second_order(c, 0.04, 20); /* measured: 4.01 */
    mns_case_free(c);
}

/* Through periodic sides, fast: lists that are made again in the middle of a step are still good at its end, and particles inside. */
static void lists_are_made_once_a_step_where_particles_cross_a_periodic_side(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = case_still(dim, dim == 2 ? 12 : 7, MNS_DENSITY_CONTINUITY);
        c->scheme.name = "dissipation";
        c->scheme.dissipation.pair_average = MNS_AVERAGE_DENSITY;
        for (int k = 0; k < 2; k++)
            for (int d = 0; d < dim; d++) case_set_text(&c->fluids[k].velocity[d], d == 1 ? "-3" : "5");
        MnsSim *sim = sim_in_arrays(c);
        const Particles *s = &sim->s;
        uint64_t rebuilds = 0;
        for (int k = 0; k < 120; k++) {
            sim_steps(sim, 1);
            assert_in_range(mns_sim_progress(sim).rebuilds - rebuilds, 0, 1);
            rebuilds = mns_sim_progress(sim).rebuilds;
            for (size_t i = 0; i < s->n; i++)
                for (int d = 0; d < dim; d++) {
                    assert_true(s->x[d][i] > -0.5 * sim->model.skin && s->x[d][i] < 1 + 0.5 * sim->model.skin);
                    assert_close(s->v[d][i], d == 1 ? -3 : 5, 1e-11); /* and nothing has pushed them */
                }
        }
        assert_true(rebuilds > 10);
        sim_done(sim, c);
    }
}

/* What a wall that swings does to the fluid beside it. */
static void so_they_are_beside_walls_that_move(void **state)
{
    (void)state;
    MnsCase *c = case_shaken_by("dissipation", 2, 1);
    c->walls[0].motion.frequency = 3;
    c->walls[0].motion.phase = 0.5 * acos(-1); /* from rest, or guards would meet the fluid */
    assert_second_order(c, 0.01, 320); /* measured: 4.02; of first order with velocities of half a step before: 2.08 */
    mns_case_free(c);
}

static double kinetic_energy(const MnsSim *sim)
{
    const Particles *s = &sim->s;
    double sum = 0;
    for (size_t i = 0; i < particles_fluid(s); i++)
        for (int d = 0; d < s->dim; d++) sum += 0.5 * s->m[i] * s->v[d][i] * s->v[d][i];
    return sum;
}

/* A sound wave under P2 without its dissipation, over twenty periods: it must not gain energy. With Gamma of the densities before, a part of the gas's
 * stiffness is late by a step, and it has 2.6 times as much in the end. */
static void sound_is_not_amplified(void **state)
{
    (void)state;
    MnsCase *c = case_blank(2, 20);
    case_add_fluid(c, "gas", 1, 10);
    case_set_text(&c->fluids[0].velocity[0], "0.1*sin(2*pi*x)");
    c->periodic[0] = c->periodic[1] = true;
    c->scheme.name = "interfacial";
    c->scheme.interfacial.background_pressure = 7;
    c->scheme.interfacial.delta = 0;
    c->scheme.interfacial.shifting = MNS_SHIFTING_OFF;
    MnsSim *sim = sim_in_arrays(c);
    const double start = kinetic_energy(sim);
    double last = 0;
    while (mns_sim_progress(sim).t < 2) {
        sim_steps(sim, 1);
        if (mns_sim_progress(sim).t > 1.9) last = fmax(last, kinetic_energy(sim));
    }
    assert_true(last < 1.01 * start);
    assert_true(last > 0.9 * start); /* 0.953 */
    sim_done(sim, c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_step_is_kick_drift_kick),
        cmocka_unit_test(every_pair_in_reach_is_listed_at_every_step),
        cmocka_unit_test(walls_go_where_their_motion_has_them),
        cmocka_unit_test(falls_are_exact_or_of_second_order),
        cmocka_unit_test(lists_are_made_once_a_step_where_particles_cross_a_periodic_side),
        cmocka_unit_test(predictor_and_corrector_are_of_second_order_together),
        cmocka_unit_test(so_they_are_beside_walls_that_move),
        cmocka_unit_test(sound_is_not_amplified),
    };
    return cmocka_run_group_tests_name("integrator", tests, NULL, NULL);
}
