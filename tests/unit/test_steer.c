/* SPDX-License-Identifier: BSD-3-Clause */
/* What is steered takes effect at the next step; what cannot change is refused and changes nothing. */
#include "sim/limits.h"
#include "tests/support/check.h"
#include "tests/support/memory.h"
#include "tests/support/sims.h"

static const char *const SCHEMES[] = {"riemann", "dissipation", "interfacial", "incompressible", "differences"};

/* All of the time since it was set, and none of it with the old. */
static void steered_gravity_acts_at_once(void **state)
{
    (void)state;
    for (size_t q = 0; q < sizeof SCHEMES / sizeof *SCHEMES; q++) {
        MnsCase *c[2];
        for (int k = 0; k < 2; k++) {
            c[k] = case_still(2, 12, MNS_DENSITY_SUMMATION);
            c[k]->scheme.name = SCHEMES[q];
            c[k]->scheme.incompressible.reference_speed = c[k]->scheme.differences.reference_speed = 1;
        }
        case_set_text(&c[0]->gravity[0], "-5");
        case_set_text(&c[0]->gravity[1], "3");
        case_set_text(&c[1]->gravity[0], "2 + 0*t");
        MnsSim *sim = sim_of(c[0]);
        sim_steps(sim, 3);
        const double before = mns_sim_progress(sim).t;
        assert_int_equal(mns_sim_steer(sim, c[1], NULL), MNS_OK);
        assert_ptr_equal(mns_sim_case(sim), c[1]);
        assert_true(sim->model.gravity[0] == 2); /* energies and the next time step know at once */
        sim_steps(sim, 5);
        const double since = mns_sim_progress(sim).t - before;
        for (size_t i = 0; i < sim->s.n; i++) { /* all fall alike: nothing but rounding, and what a solve leaves */
            assert_close(sim->s.v[0][i * sim->s.v_step], 2 * since - 5 * before, 1e-11);
            assert_close(sim->s.v[1][i * sim->s.v_step], 3 * before, 1e-11);
        }
        sim_done(sim, c[1]);
        mns_case_free(c[0]);
    }
}

/* A drop that falls freely, and not as part of all there is: from -1 to 1 at 0.2 s. */
static void a_falling_drop_turns_when_it_is_told(void **state)
{
    (void)state;
    for (int q = 0; q < 3; q++) {
        MnsCase *c[2];
        for (int k = 0; k < 2; k++) {
            c[k] = case_blank(2, 12);
            c[k]->scheme.name = SCHEMES[q];
            c[k]->max[0] = 2;
            case_add_fluid(c[k], "water", 1000, 20);
            MnsPart *drop = case_add_part(&c[k]->fluids[0].shape, MNS_BALL);
            drop->a[0] = 1;
            drop->a[1] = 0.6;
            drop->radius = 0.2;
            case_set_text(&c[k]->gravity[1], k == 0 ? "-1" : "1");
        }
        MnsSim *sim = sim_of(c[0]);
        while (mns_sim_progress(sim).t < 0.2) assert_int_equal(mns_sim_step(sim, 0.2, NULL), MNS_OK);
        assert_int_equal(mns_sim_steer(sim, c[1], NULL), MNS_OK);
        while (mns_sim_progress(sim).t < 0.5) assert_int_equal(mns_sim_step(sim, 0.5, NULL), MNS_OK);
        double mass = 0, momentum = 0;
        for (size_t i = 0; i < sim->s.n; i++) {
            mass += sim->s.m[i];
            momentum += sim->s.m[i] * sim->s.v[1][i * sim->s.v_step];
        }
        assert_close(momentum / mass, 0.1, 1e-6);
        sim_done(sim, c[1]);
        mns_case_free(c[0]);
    }
}

/* Where the pressure is solved for, that of a full tank is the new weight's after one step, and nothing moves. */
static void a_full_tank_has_the_pressure_of_what_was_set(void **state)
{
    (void)state;
    for (int q = 3; q < 5; q++) {
        MnsCase *c[2];
        for (int k = 0; k < 2; k++) {
            c[k] = case_blank(2, 10);
            c[k]->scheme.name = SCHEMES[q];
            c[k]->scheme.smoothing = q == 3 ? 1.3 : 0.9;
            c[k]->scheme.incompressible.tolerance = c[k]->scheme.differences.tolerance = 1e-9;
            case_add_fluid(c[k], "water", 1000, 20);
            case_add_wall(c[k], "tank");
            MnsPart *tank = case_add_part(&c[k]->walls[0].shape, MNS_BOX);
            tank->outside = true;
            tank->b[0] = tank->b[1] = 1;
            case_add_part(&c[k]->fluids[0].shape, MNS_BOX)->b[0] = 1;
            c[k]->fluids[0].shape.parts[0].b[1] = 1;
            case_set_text(&c[k]->gravity[1], k == 0 ? "-1" : "2");
        }
        MnsSim *sim = sim_of(c[0]);
        sim_steps(sim, 3);
        assert_int_equal(mns_sim_steer(sim, c[1], NULL), MNS_OK);
        sim_steps(sim, 1);
        const Particles *s = &sim->s;
        double slope = 0, square = 0, most = 0;
        for (size_t i = 0; i < particles_fluid(s); i++) {
            const double y = s->x[1][i * s->x_step] - 0.5;
            slope += s->p[i * s->p_step] * y;
            square += y * y;
            for (int d = 0; d < 2; d++) most = fmax(most, fabs(s->v[d][i * s->v_step]));
        }
        assert_close(slope / square, 2000, q == 3 ? 20 : 1e-3); /* P4 has moved the particles before */
        assert_less(most, q == 3 ? 0.01 : 1e-8);
        sim_done(sim, c[1]);
        mns_case_free(c[0]);
    }
}

/* Entries that rates are made from. */
static bool set_entry(MnsCase *c, size_t scheme, int entry)
{
    MnsRiemann *r = &c->scheme.riemann;
    MnsDissipation *q = &c->scheme.dissipation;
    MnsInterfacial *f = &c->scheme.interfacial;
    MnsDifferences *g = &c->scheme.differences;
    switch (10 * (int)scheme + entry) {
    case 1: r->limiter = 0.5; return true;
    case 2: r->background_pressure = 1; return true;
    case 3: r->heavy_background_pressure = 0.1; return true;
    case 4: r->reconstruction = MNS_RECONSTRUCTION_VELOCITY; return true;
    case 5: r->reconstruction = MNS_RECONSTRUCTION_BOTH; return true;
    case 11: q->delta = 0.1; return true;
    case 12: q->repulsion = 0.5; return true;
    case 13: q->pair_average = MNS_AVERAGE_DENSITY; return true;
    case 14: q->form = MNS_DISSIPATION_PLAIN; return true;
    case 15: q->gradient_correction = true; return true;
    case 21: f->delta = 0.1; return true;
    case 22: f->repulsion = 0.5; return true;
    case 23: f->pair_average = MNS_AVERAGE_ARITHMETIC; return true;
    case 24: f->shifting_strength = 1; return true;
    case 25: f->gradient_correction = true; return true;
    case 41: g->diffusion = MNS_DIFFUSION_SPH; return true;
    case 42: g->interface_threshold = 0.5; return true;
    default: case_set_text(&c->gravity[1], "-4"); return entry == 0;
    }
}

/* What is set before the first step is as if the case had begun with it: all rates are its, of every entry that they are made from. */
static void what_is_set_has_its_own_rates(void **state)
{
    (void)state;
    for (size_t q = 0; q < sizeof SCHEMES / sizeof *SCHEMES; q++)
        for (int entry = 0; entry < 6; entry++) {
            MnsCase *c = case_shaken_by(SCHEMES[q], 2, 1), *set = case_shaken_by(SCHEMES[q], 2, 1),
                    *same = case_shaken_by(SCHEMES[q], 2, 1);
            if (set_entry(set, q, entry) && set_entry(same, q, entry)) {
                MnsSim *sim = sim_of(c), *twin = sim_of(same);
                assert_int_equal(mns_sim_steer(sim, set, NULL), MNS_OK);
                if (mns_sim_hash(sim) != mns_sim_hash(twin)) fail_msg("%s, entry %d: other rates", SCHEMES[q], entry);
                sim_steps(sim, 3);
                sim_steps(twin, 3);
                if (mns_sim_hash(sim) != mns_sim_hash(twin)) fail_msg("%s, entry %d: other steps", SCHEMES[q], entry);
                mns_sim_free(sim);
                mns_sim_free(twin);
            }
            mns_case_free(c);
            mns_case_free(set);
            mns_case_free(same);
        }
}

/* Under way: a state saved just before, and set anew after a restart, as a journal does it, comes to the same bits as the run itself; and so does
 * one saved just after. */
static void what_is_set_again_after_a_restart_gives_the_same_bits(void **state)
{
    (void)state;
    for (size_t q = 0; q < sizeof SCHEMES / sizeof *SCHEMES; q++)
        for (int entry = 0; entry < 6; entry++) {
            MnsCase *c = case_shaken_by(SCHEMES[q], 2, 2), *set = case_shaken_by(SCHEMES[q], 2, 2);
            if (set_entry(set, q, entry)) {
                MnsSim *sim = sim_of(c), *again = NULL, *after = NULL;
                MnsCapture *capture = NULL;
                sim_steps(sim, 7);
                assert_int_equal(mns_sim_capture(sim, mns_sim_state_fields(sim), &capture, NULL), MNS_OK);
                assert_int_equal(mns_sim_resume(c, capture, &again, NULL), MNS_OK);
                mns_capture_free(capture);
                assert_int_equal(mns_sim_steer(sim, set, NULL), MNS_OK);
                assert_int_equal(mns_sim_steer(again, set, NULL), MNS_OK);
                assert_int_equal(mns_sim_capture(sim, mns_sim_state_fields(sim), &capture, NULL), MNS_OK);
                assert_int_equal(mns_sim_resume(set, capture, &after, NULL), MNS_OK);
                mns_capture_free(capture);
                for (int k = 0; k < 2; k++) {
                    if (mns_sim_hash(sim) != mns_sim_hash(again) || mns_sim_hash(sim) != mns_sim_hash(after))
                        fail_msg("%s, entry %d: other bits, %d", SCHEMES[q], entry, k);
                    sim_steps(sim, 4);
                    sim_steps(again, 4);
                    sim_steps(after, 4);
                }
                mns_sim_free(sim);
                mns_sim_free(again);
                mns_sim_free(after);
            }
            mns_case_free(c);
            mns_case_free(set);
        }
}

static void steering_refuses_what_cannot_change_and_changes_nothing_then(void **state)
{
    (void)state;
    MnsCase *c = case_shaken(2, 1);
    MnsSim *sim = sim_of(c);
    sim_steps(sim, 2);
    for (int k = 0; k < 14; k++) {
        MnsCase *other = case_shaken(k == 1 ? 3 : 2, 1);
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
        if (k == 13) case_set_text(&other->displacement[0], "0.1*x*(2 - x)");
        MnsError error = {0};
        assert_int_equal(mns_sim_steer(sim, other, &error), MNS_E_INVALID);
        assert_true(error.text[0] != 0);
        assert_ptr_equal(mns_sim_case(sim), c);
        mns_case_free(other);
    }
    sim_steps(sim, 10);
    MnsCase *same = case_shaken(2, 1);
    MnsSim *twin = sim_of(same);
    sim_steps(twin, 12);
    assert_true(mns_sim_hash(sim) == mns_sim_hash(twin));
    sim_done(twin, same);
    sim_done(sim, c);
}

static void steered_threads_and_limits_do_not_change_the_bits(void **state)
{
    (void)state;
    MnsCase *c = case_shaken(2, 1), *steered = case_shaken(2, 3), *same = case_shaken(2, 1);
    MnsSim *sim = sim_of(c), *twin = sim_of(same);
    steered->end_time = 77;
    sim_steps(sim, 20);
    assert_int_equal(mns_sim_steer(sim, steered, NULL), MNS_OK);
    mns_case_free(c);
    sim_steps(sim, 60);
    sim_steps(twin, 80);
    assert_true(mns_sim_hash(sim) == mns_sim_hash(twin));
    sim_done(twin, same);
    sim_done(sim, steered);
}

/* There is one copy of a formula for each thread that there was at the start; one that is no constant is not for several at once. */
static void a_run_that_gets_threads_shares_no_formula(void **state)
{
    (void)state;
    MnsCase *cases[2];
    for (unsigned k = 0; k < 2; k++) {
        cases[k] = case_shaken(2, 1 + 3 * k);
        cases[k]->resolution = 100; /* several blocks of particles */
        case_set_text(&case_add_probe(cases[k], MNS_PROBE_PRESSURE_DEVIATION)->formula, "3*x + sin(y)*t");
    }
    MnsSim *sim = sim_of(cases[0]);
    sim_steps(sim, 1);
    const double before = mns_sim_probe(sim, 0);
    assert_true(before > 0);
    assert_int_equal(mns_sim_steer(sim, cases[1], NULL), MNS_OK);
    mns_case_free(cases[0]);
    assert_int_equal(mns_sim_threads(sim), 4);
    for (int k = 0; k < 20; k++) assert_true(mns_sim_probe(sim, 0) == before);
    sim_done(sim, cases[1]);
}

static void steered_options_take_effect(void **state)
{
    (void)state;
    MnsCase *c = case_shaken(2, 1), *steered = case_shaken(2, 1);
    MnsSim *sim = sim_of(c);
    sim_steps(sim, 2);
    const Limit *limit = NULL;
    const double before = limits_dt(sim, &limit);
    steered->scheme.cfl = 0.125;
    steered->scheme.riemann = (MnsRiemann){.limiter = 5, .background_pressure = 1, .guard = 0.1};
    assert_int_equal(mns_sim_steer(sim, steered, NULL), MNS_OK);
    assert_close(limits_dt(sim, &limit), 0.5 * before, 1e-15);
    assert_true(sim->model.limiter == 5);
    assert_close(sim->model.phase[1].p_b, 1e-3 * 400, 1e-15);
    assert_close(sim->model.guard, 0.1 / 12, 1e-15);
    sim_done(sim, steered);
    mns_case_free(c);
}

/* A state saved after gravity was changed goes on to the same bits, and even where the case as it is now could not begin: oblique
 * gravity under a hydrostatic start, a formula of no use at t = 0. */
static void steered_runs_resume_bit_for_bit(void **state)
{
    (void)state;
    static const char *const gravity[][2] = {{"0", "-2"}, {"0.7", "-1"}, {"0", "-0.1/t"}};
    for (int dim = 2; dim <= 3; dim++)
        for (int k = 0; k < 3; k++) {
            MnsCase *c = case_dam_break(dim, dim == 2 ? 10 : 5), *steered = case_dam_break(dim, dim == 2 ? 10 : 5);
            case_set_text(&c->fluids[0].pressure, "hydrostatic");
            case_set_text(&steered->fluids[0].pressure, "hydrostatic");
            for (int d = 0; d < 2; d++) case_set_text(&steered->gravity[d], gravity[k][d]);
            MnsSim *sim = sim_of(c), *resumed = NULL;
            sim_steps(sim, 20);
            assert_int_equal(mns_sim_steer(sim, steered, NULL), MNS_OK);
            MnsCapture *capture = NULL;
            assert_int_equal(mns_sim_capture(sim, mns_sim_state_fields(sim), &capture, NULL), MNS_OK);
            assert_int_equal(mns_sim_resume(steered, capture, &resumed, NULL), MNS_OK);
            mns_capture_free(capture);
            assert_true(mns_sim_hash(sim) == mns_sim_hash(resumed));
            sim_steps(sim, 15);
            sim_steps(resumed, 15);
            assert_true(mns_sim_hash(sim) == mns_sim_hash(resumed));
            mns_sim_free(resumed);
            sim_done(sim, steered);
            mns_case_free(c);
        }
}

/* Nobody pays for the fields of an option that is off. */
static void assert_fields_come(const char *scheme)
{
    MnsCase *c = case_shaken_by(scheme, 3, 1), *steered = case_shaken_by(scheme, 3, 1);
    steered->scheme.interfacial.gradient_correction = steered->scheme.dissipation.gradient_correction = true;
    MnsSim *sim = sim_of(c);
    const size_t before = particles_bytes(&sim->s);
    sim_steps(sim, 2);
    assert_null(sim->s.correction[0]);
    assert_null(sim->s.correction_off[2]);
    assert_int_equal(mns_sim_steer(sim, steered, NULL), MNS_OK);
    mns_case_free(c);
    sim_steps(sim, 2);
    assert_true(particles_bytes(&sim->s) >= before + 6 * sizeof(double) * particles_fluid(&sim->s));
    for (int d = 0; d < 3; d++) {
        assert_non_null(sim->s.correction[d]);
        assert_non_null(sim->s.correction_off[d]);
        assert_true(sim->s.correction[d][0] > 0.5);
    }
    sim_done(sim, steered);
}

/* As if it had been off from the beginning: fields, what is shown, bytes; and the run goes on to the bits of one that is resumed from here. */
static void assert_fields_go(const char *scheme, unsigned threads)
{
    const int field = mns_field_find("correction");
    MnsCase *c = case_shaken_by(scheme, 3, 1), *off = case_shaken_by(scheme, 3, threads);
    c->scheme.interfacial.gradient_correction = c->scheme.dissipation.gradient_correction = true;
    MnsSim *sim = sim_of(c), *resumed = NULL;
    MnsCapture *capture = NULL;
    sim_steps(sim, 3);
    assert_true(mns_sim_fields(sim) >> field & 1);
    assert_non_null(mns_sim_field(sim, field, 0));
    assert_int_equal(mns_sim_steer(sim, off, NULL), MNS_OK);
    mns_case_free(c);
    assert_false(mns_sim_fields(sim) >> field & 1);
    assert_null(mns_sim_field(sim, field, 0));
    assert_int_equal(mns_sim_capture(sim, mns_sim_state_fields(sim) | UINT64_C(1) << field, &capture, NULL), MNS_OK);
    assert_null(capture->data[field][0]);
    assert_int_equal(mns_sim_resume(off, capture, &resumed, NULL), MNS_OK);
    mns_capture_free(capture);
    assert_true(mns_sim_fields(sim) == mns_sim_fields(resumed));
    assert_int_equal(particles_bytes(&sim->s), particles_bytes(&resumed->s));
    sim_steps(sim, 3);
    sim_steps(resumed, 3);
    assert_true(mns_sim_hash(sim) == mns_sim_hash(resumed));
    mns_sim_free(resumed);
    sim_done(sim, off);
}

static void fields_are_gone_once_no_option_needs_them(void **state)
{
    (void)state;
    for (unsigned threads = 1; threads <= 2; threads++) {
        assert_fields_go("interfacial", threads);
        assert_fields_go("dissipation", threads);
    }
}

static void fields_are_there_once_an_option_needs_them(void **state)
{
    (void)state;
    assert_fields_come("interfacial");
    assert_fields_come("dissipation");
}

/* Those of P3's reconstructions, from one to the next; the run goes on to the bits of one that is resumed from here. */
static void fields_come_and_go_with_reconstructions(void **state)
{
    (void)state;
    static const MnsReconstruction ways[] = {MNS_RECONSTRUCTION_NONE, MNS_RECONSTRUCTION_BOTH,
                                             MNS_RECONSTRUCTION_VELOCITY, MNS_RECONSTRUCTION_BOTH,
                                             MNS_RECONSTRUCTION_NONE};
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = case_shaken_by("riemann", dim, 1);
        MnsSim *sim = sim_of(c), *resumed = NULL;
        for (size_t k = 0; k < sizeof ways / sizeof *ways; k++) {
            MnsCase *steered = case_shaken_by("riemann", dim, 1), *same = case_shaken_by("riemann", dim, 1);
            MnsCapture *capture = NULL;
            steered->scheme.riemann.reconstruction = same->scheme.riemann.reconstruction = ways[k];
            assert_int_equal(mns_sim_steer(sim, steered, NULL), MNS_OK);
            mns_case_free(c);
            c = steered;
            assert_int_equal(mns_sim_capture(sim, mns_sim_state_fields(sim), &capture, NULL), MNS_OK);
            assert_int_equal(mns_sim_resume(same, capture, &resumed, NULL), MNS_OK);
            mns_capture_free(capture);
            sim_steps(sim, 3);
            sim_steps(resumed, 3);
            assert_true(!sim->s.strain[1] == (ways[k] == MNS_RECONSTRUCTION_NONE));
            assert_true(!sim->s.gradient[1] == (ways[k] != MNS_RECONSTRUCTION_BOTH));
            if (sim->s.gradient[1]) assert_true(sim->s.gradient[1][1] != 0);
            if (sim->s.strain[1]) assert_true(sim->s.strain[1][1] != 0);
            assert_int_equal(particles_bytes(&sim->s), particles_bytes(&resumed->s));
            assert_true(mns_sim_hash(sim) == mns_sim_hash(resumed));
            sim_done(resumed, same);
        }
        sim_done(sim, c);
    }
}

/* What a restart could not measure: the field would not be there any more. */
static void options_that_a_probe_needs_cannot_be_turned_off(void **state)
{
    (void)state;
    MnsCase *c[2];
    for (int k = 0; k < 2; k++) {
        c[k] = case_shaken_by("interfacial", 2, 1);
        c[k]->scheme.interfacial.gradient_correction = k == 0;
        case_set_text(&case_add_probe(c[k], MNS_PROBE_EXTREMUM)->field, "correction");
    }
    MnsSim *sim = sim_of(c[0]);
    sim_steps(sim, 2);
    const double value = mns_sim_probe(sim, 0);
    assert_true(value > 0);
    MnsError error = {0};
    assert_int_equal(mns_sim_steer(sim, c[1], &error), MNS_E_INVALID);
    assert_string_equal(error.path, "probes[0].extremum.field");
    assert_ptr_equal(mns_sim_case(sim), c[0]);
    assert_true(mns_sim_probe(sim, 0) == value && sim->model.corrects_gradients);
    sim_done(sim, c[0]);
    mns_case_free(c[1]);
}

/* More threads and another option, while memory ends after n allocations. Once refused it goes on as if nobody had asked. Returns whether it
 * was refused. */
static bool assert_refused_without_effect(const char *scheme, long n)
{
    MnsCase *c = case_shaken_by(scheme, 2, 1), *same = case_shaken_by(scheme, 2, 1),
            *steered = case_shaken_by(scheme, 2, 2);
    steered->scheme.interfacial.gradient_correction = steered->scheme.dissipation.gradient_correction = true;
    MnsSim *sim = sim_of(c), *twin = sim_of(same);
    sim_steps(sim, 7);
    sim_steps(twin, 7);
    memory_fails_after(n);
    const MnsStatus status = mns_sim_steer(sim, steered, NULL);
    memory_fails_after(-1);
    if (status) {
        assert_int_equal(status, MNS_E_MEMORY);
        assert_ptr_equal(mns_sim_case(sim), c);
        assert_int_equal(mns_sim_threads(sim), 1);
        assert_true(sim->s.fields == twin->s.fields);
        sim_steps(sim, 3);
        sim_steps(twin, 3);
        if (mns_sim_hash(sim) != mns_sim_hash(twin)) fail_msg("%s, allocation %ld: other bits", scheme, n);
    }
    mns_sim_free(sim);
    mns_case_free(steered);
    mns_case_free(c);
    sim_done(twin, same);
    return status != MNS_OK;
}

static void steering_without_memory_changes_nothing(void **state)
{
    (void)state;
    if (!memory_can_fail) skip();
    for (size_t k = 0; k < sizeof SCHEMES / sizeof *SCHEMES; k++) {
        const long by = check_at_length() ? 1 : 3;
        long n = 0;
        while (assert_refused_without_effect(SCHEMES[k], n)) n += by;
        /* After the last of them all that is to be undone has been done. */
        for (long last = n - by + 1; last < n; last++) (void)assert_refused_without_effect(SCHEMES[k], last);
        assert_in_range(n, 10, 200);
    }
}

/* Without sound too: options of the projections take effect, what a restart could not tell from the case is refused, and a state saved
 * afterwards goes on to the same bits. */
static void projections_are_steered(void **state)
{
    (void)state;
    static const char *const schemes[] = {"incompressible", "differences"};
    for (int k = 0; k < 2; k++)
        for (int dim = 2; dim <= 3; dim++) {
            MnsCase *c = case_shaken_by(schemes[k], dim, 1), *other = case_shaken_by(schemes[k], dim, 2);
            MnsSim *sim = sim_of(c), *resumed = NULL;
            MnsError error = {0};
            const Limit *limit = NULL;
            const double before = flow_limit.of(sim);
            sim_steps(sim, 3);
            if (k == 0) other->scheme.incompressible.density_tolerance = -1; /* and of the other, what a run keeps */
            else other->scheme.differences.holds_pressure = true;
            assert_int_equal(mns_sim_steer(sim, other, &error), MNS_E_INVALID);
            assert_ptr_equal(mns_sim_case(sim), c);
            other->scheme.differences.holds_pressure = false;
            other->scheme.incompressible.density_tolerance = c->scheme.incompressible.density_tolerance;
            other->scheme.incompressible.tolerance = other->scheme.differences.tolerance = 1e-7;
            other->scheme.incompressible.reference_speed = other->scheme.differences.reference_speed = 1000;
            other->scheme.incompressible.iterations = other->scheme.differences.iterations = 777;
            case_set_text(&other->gravity[0], "0.2");
            assert_int_equal(mns_sim_steer(sim, other, &error), MNS_OK);
            mns_case_free(c);
            assert_true(sim->model.projection.tolerance == 1e-7 && sim->model.projection.iterations == 777);
            assert_less(limits_dt(sim, &limit), 0.1 * before);
            assert_ptr_equal(limit, &flow_limit);
            sim_steps(sim, 2);
            assert_less(sim->solved.residual, 1.0001e-7);
            MnsCapture *capture = NULL;
            assert_int_equal(mns_sim_capture(sim, mns_sim_state_fields(sim), &capture, NULL), MNS_OK);
            assert_int_equal(mns_sim_resume(other, capture, &resumed, NULL), MNS_OK);
            mns_capture_free(capture);
            sim_steps(sim, 3);
            sim_steps(resumed, 3);
            assert_true(mns_sim_hash(sim) == mns_sim_hash(resumed));
            mns_sim_free(resumed);
            sim_done(sim, other);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(steered_gravity_acts_at_once),
        cmocka_unit_test(a_falling_drop_turns_when_it_is_told),
        cmocka_unit_test(a_full_tank_has_the_pressure_of_what_was_set),
        cmocka_unit_test(what_is_set_has_its_own_rates),
        cmocka_unit_test(what_is_set_again_after_a_restart_gives_the_same_bits),
        cmocka_unit_test(steering_refuses_what_cannot_change_and_changes_nothing_then),
        cmocka_unit_test(steered_threads_and_limits_do_not_change_the_bits),
        cmocka_unit_test(a_run_that_gets_threads_shares_no_formula),
        cmocka_unit_test(steered_options_take_effect),
        cmocka_unit_test(fields_are_there_once_an_option_needs_them),
        cmocka_unit_test(fields_come_and_go_with_reconstructions),
        cmocka_unit_test(fields_are_gone_once_no_option_needs_them),
        cmocka_unit_test(options_that_a_probe_needs_cannot_be_turned_off),
        cmocka_unit_test(steering_without_memory_changes_nothing),
        cmocka_unit_test(steered_runs_resume_bit_for_bit),
        cmocka_unit_test(projections_are_steered),
    };
    return cmocka_run_group_tests_name("steer", tests, NULL, NULL);
}
