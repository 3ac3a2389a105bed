/* SPDX-License-Identifier: BSD-3-Clause */
/* A run that would never end, or fill any disk, is refused before it begins or when it is steered there, by a sentence that
 * names what is to blame; one that slows down without end counts as diverged; and what is hardly meant is said. */
#include "tests/support/check.h"
#include "tests/support/sims.h"
#include <omp.h>
#include <stdio.h>
#include <string.h>

static void assert_endless(const MnsCase *c, const char *path, const char *word)
{
    MnsSim *sim = NULL;
    MnsError error = {0};
    assert_int_equal(mns_sim_new(c, &sim, &error), MNS_E_LIMIT);
    assert_null(sim);
    assert_string_equal(error.path, path);
    if (!strstr(error.text, word)) fail_msg("\"%s\" does not say \"%s\"", error.text, word);
}

static void run_without_end_is_refused_with_what_limits_its_step(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = case_periodic(dim, 10);
        c->end_time = 1e300;
        assert_endless(c, "end_time", "sound_speed");
        c->end_time = 1;
        c->fluids[1].viscosity = 1e20;
        c->fluids[0].viscosity = 1e20;
        assert_endless(c, "end_time", "viscosity");
        c->fluids[0].viscosity = 0;
        c->fluids[1].viscosity = 0;
        case_set_text(&c->gravity[1], "-1e30");
        assert_endless(c, "end_time", "gravity");
        case_set_text(&c->gravity[1], "0");
        case_set_text(&c->fluids[0].velocity[0], "1e20"); /* known only when the particles are there */
        assert_endless(c, "end_time", "flow");
        mns_case_free(c);
    }
}

/* Without sound, at rest, with nothing that acts yet. */
static void run_of_one_step_without_bound_is_refused(void **state)
{
    (void)state;
    static const char *const schemes[] = {"incompressible", "differences"};
    for (int k = 0; k < 2; k++) {
        MnsCase *c = case_still(2, 10, MNS_DENSITY_SUMMATION), *other = case_still(2, 10, MNS_DENSITY_SUMMATION);
        MnsSim *sim = NULL;
        MnsError error = {0};
        char entry[64];
        snprintf(entry, sizeof entry, "scheme.%s.reference_speed", schemes[k]);
        c->scheme.name = other->scheme.name = schemes[k];
        case_set_text(&c->gravity[0], "sin(t)");
        for (int endless = 0; endless < 2; endless++) {
            c->end_time = endless ? INFINITY : 1;
            assert_int_equal(mns_sim_new(c, &sim, &error), MNS_E_INVALID);
            assert_string_equal(error.path, entry);
        }
        c->scheme.incompressible.reference_speed = c->scheme.differences.reference_speed = 1;
        sim = sim_of(c);
        case_set_text(&other->gravity[0], "sin(t)");
        other->scheme.incompressible.reference_speed = other->scheme.differences.reference_speed = 0;
        assert_int_equal(mns_sim_steer(sim, other, &error), MNS_E_INVALID);
        assert_string_equal(error.path, entry);
        mns_sim_free(sim);
        c->scheme.incompressible.reference_speed = c->scheme.differences.reference_speed = -1;
        case_set_text(&c->fluids[0].velocity[0], "1e-3*y"); /* which is known only when the particles are there */
        sim_done(sim_of(c), c);
        mns_case_free(other);
    }
}

/* The bound is on steps, not on seconds. */
static void long_run_of_long_steps_is_not_refused(void **state)
{
    (void)state;
    MnsCase *c = case_periodic(2, 10);
    const double dt = 0.25 * 0.13 / (10 + 0.7); /* cfl h / (c + fastest), about */
    c->end_time = 0.9e9 * dt;
    mns_sim_free(sim_of(c));
    c->end_time = 1.1e9 * dt;
    assert_endless(c, "end_time", "1e+09");
    c->end_time = INFINITY;
    mns_sim_free(sim_of(c));
    mns_case_free(c);
}

static void more_snapshots_than_a_disk_holds_are_refused(void **state)
{
    (void)state;
    MnsCase *c = case_periodic(2, 10);
    c->end_time = 1e5;
    c->output.snapshot_interval = 0.05;
    assert_endless(c, "output.snapshot_interval", "an interval of 0.1 s");
    c->output.snapshot_interval = 0.11;
    mns_sim_free(sim_of(c));
    c->output.snapshot_interval = 1e-300; /* no more than one for each step */
    assert_endless(c, "output.snapshot_interval", "e+07 files");
    c->end_time = 1;
    mns_sim_free(sim_of(c));
    mns_case_free(c);
}

static void run_is_not_steered_to_where_it_has_no_end(void **state)
{
    (void)state;
    MnsCase *c = case_periodic(2, 10), *other = case_periodic(2, 10);
    MnsSim *sim = sim_of(c);
    MnsError error = {0};
    other->end_time = 1e300;
    assert_int_equal(mns_sim_steer(sim, other, &error), MNS_E_LIMIT);
    assert_string_equal(error.path, "end_time");
    other->end_time = 1e6; /* 3e8 steps; not so with a hundredth of their length */
    other->scheme.cfl = 0.0025;
    assert_int_equal(mns_sim_steer(sim, other, &error), MNS_E_LIMIT);
    assert_ptr_equal(mns_sim_case(sim), c);
    assert_true(sim->model.cfl == 0.25);
    other->scheme.cfl = 0.25;
    case_set_text(&other->gravity[1], "-1e30");
    assert_int_equal(mns_sim_steer(sim, other, &error), MNS_E_LIMIT);
    assert_non_null(strstr(error.text, "gravity"));
    assert_true(sim->model.gravity[1] == 0);
    case_set_text(&other->gravity[1], "0");
    assert_int_equal(mns_sim_steer(sim, other, &error), MNS_OK);
    sim_done(sim, other);
    mns_case_free(c);
}

/* It was let in when its steps were longer, and may have slowed down since; but not without end. */
static void run_whose_steps_have_become_short_goes_on_from_its_state(void **state)
{
    (void)state;
    MnsCase *c = case_periodic(2, 10);
    MnsSim *sim, *again = NULL;
    MnsCapture *capture;
    MnsError error = {0};
    c->end_time = 1e6; /* 3e8 steps; the end is 1e9 away, and 1e11, with 10 and with 1000 times the speed of sound */
    sim = sim_of(c);
    assert_int_equal(mns_sim_capture(sim, mns_sim_state_fields(sim), &capture, NULL), MNS_OK);
    double *speed = capture->data[mns_field_find("velocity")][0];
    speed[0] = 100;
    assert_int_equal(mns_sim_resume(c, capture, &again, &error), MNS_OK);
    assert_true(mns_sim_progress(again).step == 0);
    mns_sim_free(again);
    speed[0] = 1e4;
    assert_int_equal(mns_sim_resume(c, capture, &again, &error), MNS_E_LIMIT);
    assert_string_equal(error.path, "end_time");
    mns_capture_free(capture);
    sim_done(sim, c);
}

/* By any option that bounds the step. */
static void run_is_not_steered_to_a_speed_that_has_no_end(void **state)
{
    (void)state;
    static const char *const schemes[] = {"incompressible", "differences"};
    for (int k = 0; k < 2; k++) {
        MnsCase *c = case_shaken_by(schemes[k], 2, 1), *other = case_shaken_by(schemes[k], 2, 1);
        c->end_time = other->end_time = 1;
        other->scheme.incompressible.reference_speed = other->scheme.differences.reference_speed = 1e30;
        MnsSim *sim = sim_of(c);
        MnsError error = {0};
        const double speed = sim->model.projection.speed;
        assert_int_equal(mns_sim_steer(sim, other, &error), MNS_E_LIMIT);
        assert_non_null(strstr(error.text, "reference_speed"));
        assert_true(sim->model.projection.speed == speed);
        sim_steps(sim, 1);
        sim_done(sim, c);
        mns_case_free(other);
    }
}

/* Against the first step alone, a run of 3e8 steps could become one of 3e14. */
static void step_that_has_become_too_short_for_the_end_is_a_divergence(void **state)
{
    (void)state;
    MnsCase *c = case_periodic(2, 10);
    c->limits.time_step_floor = 1e-6;
    c->end_time = 1e6;
    MnsSim *sim = sim_of(c);
    MnsError error = {0};
    assert_int_equal(mns_sim_step(sim, INFINITY, &error), MNS_OK);
    sim->v_max = 1e4; /* a thousandth of the first step */
    assert_int_equal(mns_sim_step(sim, INFINITY, &error), MNS_E_DIVERGED);
    assert_non_null(strstr(error.text, "floor of 1e-05 s"));
    sim_done(sim, c);
}

/* Or there would be one warning more. */
static void put_on_lattice(MnsCase *c)
{
    c->fluids[0].shape.parts[0].b[0] = 0.4;
}

static void interval_shorter_than_a_step_is_said_to_be_one(void **state)
{
    (void)state;
    MnsCase *c = case_periodic(2, 10);
    put_on_lattice(c);
    c->end_time = 0.1;
    c->output.snapshot_interval = c->output.checkpoint_interval = c->output.probe_interval = 0.01;
    case_add_probe(c, MNS_PROBE_MASS);
    MnsSim *sim = sim_of(c);
    assert_null(mns_sim_warning(sim, 0));
    mns_sim_free(sim);
    c->output.snapshot_interval = c->output.checkpoint_interval = c->output.probe_interval = 1e-4;
    sim = sim_of(c);
    assert_true(sim_warns(sim, "output.snapshot_interval: ") && sim_warns(sim, "output.checkpoint_interval: "));
    assert_true(sim_warns(sim, "output.probe_interval: "));
    assert_null(mns_sim_warning(sim, 3));
    sim_done(sim, c);
}

static void an_entry_that_the_scheme_does_not_read_is_warned_of(void **state)
{
    (void)state;
    static const struct {
        const char *scheme;
        bool method, exponent; /* read */
    } rows[] = {{"riemann", true, false}, {"dissipation", false, false}, {"interfacial", false, true}};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        MnsCase *c = case_still(2, 10, MNS_DENSITY_AUTOMATIC);
        c->scheme.name = rows[k].scheme;
        c->fluids[1].density_method = MNS_DENSITY_CONTINUITY;
        c->fluids[0].exponent = 7;
        MnsSim *sim = sim_of(c);
        assert_int_equal(sim_warns(sim, "fluids[1].density_method: the scheme "), !rows[k].method);
        assert_int_equal(sim_warns(sim, "fluids[0].exponent: the scheme "), !rows[k].exponent);
        assert_false(sim_warns(sim, "fluids[0].density_method") || sim_warns(sim, "fluids[1].exponent"));
        sim_done(sim, c);
    }
}

static void a_probe_where_no_fluid_comes_is_warned_of(void **state)
{
    (void)state;
    MnsCase *c = case_dam_break(2, 10);
    c->max[0] = c->walls[0].shape.parts[0].b[0] = 5.4;
    case_add_probe(c, MNS_PROBE_PRESSURE);
    MnsProbe *probe = &c->probes[c->n_probes - 1];
    probe->at[0] = 5.4;
    probe->at[1] = 0.1;
    MnsSim *sim = sim_of(c);
    assert_null(mns_sim_warning(sim, 0));
    mns_sim_free(sim);
    probe->at[0] = 17;
    sim = sim_of(c);
    assert_true(sim_warns(sim, "is at x = 17 m, outside the domain"));
    assert_null(mns_sim_warning(sim, 1));
    mns_sim_free(sim);
    probe->kind = MNS_PROBE_HEIGHT; /* whose coordinate along its axis does not count */
    probe->axis = 0;
    sim = sim_of(c);
    assert_null(mns_sim_warning(sim, 0));
    sim_done(sim, c);
}

static void more_warnings_than_there_is_room_for_are_not_lost_without_a_word(void **state)
{
    (void)state;
    MnsCase *c = case_dam_break(2, 10);
    for (int k = 0; k < 2 * SIM_WARNINGS_MAX; k++) case_add_probe(c, MNS_PROBE_PRESSURE)->at[0] = 100 + k;
    MnsSim *sim = sim_of(c);
    for (size_t k = 0; k < SIM_WARNINGS_MAX - 1; k++)
        assert_non_null(strstr(mns_sim_warning(sim, k), "outside the domain"));
    assert_non_null(strstr(mns_sim_warning(sim, SIM_WARNINGS_MAX - 1), "more to warn of than these 15"));
    assert_null(mns_sim_warning(sim, SIM_WARNINGS_MAX));
    sim_done(sim, c);
}

static void fluid_at_an_open_side_is_warned_of_once(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = case_dam_break(dim, 10);
        c->max[0] = c->walls[0].shape.parts[0].b[0] = 5.4;
        MnsSim *sim = sim_of(c);
        assert_null(mns_sim_warning(sim, 0));
        mns_sim_free(sim);
        c->walls[0].shape.parts[0].b[0] = 6; /* no wall at the upper x side */
        sim = sim_of(c);
        assert_true(sim_warns(sim, "domain: air touches the upper x side"));
        assert_null(mns_sim_warning(sim, 1));
        mns_sim_free(sim);
        c->n_fluids = 1; /* without the air nothing is there */
        sim = sim_of(c);
        assert_null(mns_sim_warning(sim, 0));
        mns_sim_free(sim);
        c->n_fluids = 2;
        c->walls[0].shape.parts[0].b[0] = 5.4;
        c->walls[0].shape.parts[0].a[1] = -1; /* a tank without a floor */
        sim = sim_of(c);
        assert_true(sim_warns(sim, "water touches the lower y side") || sim_warns(sim, "air touches the lower y side"));
        assert_null(mns_sim_warning(sim, 1));
        sim_done(sim, c);
        c = case_periodic(dim, 10);
        put_on_lattice(c);
        c->periodic[0] = false;
        sim = sim_of(c);
        assert_true(sim_warns(sim, "lower x side") && sim_warns(sim, "upper x side"));
        assert_null(mns_sim_warning(sim, 2));
        sim_done(sim, c);
    }
}

static void threads_beyond_the_processors_are_said_and_bounded(void **state)
{
    (void)state;
    const int processors = omp_get_num_procs(), most = processors > 64 ? processors : 64;
    MnsCase *c = case_periodic(2, 10);
    c->threads = (unsigned)processors;
    MnsSim *sim = sim_of(c);
    assert_false(sim_warns(sim, "threads: "));
    mns_sim_free(sim);
    c->threads = 1024;
    sim = sim_of(c);
    assert_true(sim_warns(sim, "threads: "));
    assert_int_equal(mns_sim_threads(sim), most);
    sim_done(sim, c);
}

/* rho c^2 = 100. At 28 and -49.45 c must be sqrt(2.8) and sqrt(4.945) times as great for a tenth: 16.7 and 22.2. */
static void pressure_that_the_speed_of_sound_cannot_carry_is_warned_of(void **state)
{
    (void)state;
    static const struct {
        const char *pressure, *words;
    } rows[] = {{"80*x",
                 "fluids[0].sound_speed: with 10 m/s the pressure at the start makes water 28 % denser than its "
                 "reference; 17 m/s would be enough"},
                {"11*x - 50", "makes water 49 % thinner than its reference; 23 m/s would be enough"},
                {"9.9", NULL},
                {"-9.9", NULL}};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        MnsCase *c = case_periodic(2, 10);
        put_on_lattice(c);
        case_set_text(&c->fluids[0].pressure, rows[k].pressure);
        MnsSim *sim = sim_of(c);
        const char *text = mns_sim_warning(sim, 0);
        if (!rows[k].words) assert_null(text);
        else if (!text || !strstr(text, rows[k].words)) fail_msg("%s", text);
        assert_null(mns_sim_warning(sim, 1));
        sim_done(sim, c);
    }
}

/* c^2 = 100 is 100 g H for a height of 1 and g = 1. */
static void speed_of_sound_that_is_small_for_the_height_of_a_fluid_is_warned_of(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int small = 0; small < 2; small++) {
            MnsCase *c = case_still(dim, 10, MNS_DENSITY_CONTINUITY);
            put_on_lattice(c);
            case_set_text(&c->gravity[1], small ? "-1.03" : "-1.01");
            MnsSim *sim = sim_of(c);
            if (small) {
                assert_true(sim_warns(
                    sim, "fluids[0].sound_speed: 10 m/s is less than ten times sqrt(g H) of water, 1 m high"));
                assert_true(sim_warns(sim, "of oil, 1 m high: it may be compressed; 11 m/s would be enough"));
            } else assert_null(mns_sim_warning(sim, 0));
            sim_done(sim, c);
        }
}

/* Of the oil in a drop of radius R = 0.2, about: c^2 = 100 = 100 sigma/(rho R) for sigma = 0.02; whatever start it has. */
static void speed_of_sound_that_is_small_for_the_tension_of_a_drop_is_warned_of(void **state)
{
    (void)state;
    static const char *const starts[] = {"laplace", "0"};
    for (int k = 0; k < 8; k++) {
        const bool small = k & 1;
        const int dim = k & 2 ? 3 : 2;
        MnsCase *c = case_still(dim, 20, MNS_DENSITY_AUTOMATIC);
        MnsPart *ball = case_add_part(&c->fluids[1].shape, MNS_BALL);
        ball->radius = 0.203; /* which the lattice has as much of */
        for (int d = 0; d < dim; d++) ball->a[d] = 0.5;
        c->fluids[0].shape.parts[0].primitive = MNS_BALL; /* all but this ball */
        c->fluids[0].shape.parts[0].outside = true;
        c->fluids[0].shape.parts[0].radius = 0.203;
        for (int d = 0; d < dim; d++) c->fluids[0].shape.parts[0].a[d] = 0.5;
        case_set_text(&c->fluids[1].pressure, starts[k / 4]);
        c->tension[0][1] = c->tension[1][0] = small ? 0.022 : 0.018;
        c->scheme.name = "dissipation"; /* the Riemann scheme has no tension */
        c->scheme.kernel = MNS_TRUNCATED_GAUSSIAN;
        c->scheme.smoothing = 1.1;
        c->scheme.dissipation.repulsion = 0;
        c->scheme.dissipation.pair_average = MNS_AVERAGE_DENSITY;
        c->fluids[1].sound_speed = 10;
        MnsSim *sim = sim_of(c);
        if (small) {
            assert_true(
                sim_warns(sim, "fluids[1].sound_speed: 10 m/s is less than ten times sqrt(sigma/(rho R)) of oil, "));
            assert_true(sim_warns(sim, "m across: it may be compressed; 11 m/s would be enough"));
            assert_null(mns_sim_warning(sim, 1));
        } else assert_null(mns_sim_warning(sim, 0));
        sim_done(sim, c);
    }
}

/* Two fluids that fill a box, or water with nothing above. */
static MnsCase *corrected_or_not(const char *scheme, bool full, bool corrected)
{
    MnsCase *c = full ? case_still(2, 10, MNS_DENSITY_AUTOMATIC) : case_dam_break(2, 6);
    if (!full) { /* a heap of air beside the column */
        MnsPart *heap = case_add_part(&c->fluids[1].shape, MNS_BOX);
        heap->a[0] = 3;
        heap->b[0] = 4;
        heap->b[1] = heap->b[2] = 0.5;
    }
    c->scheme.name = scheme;
    c->scheme.dissipation.gradient_correction = c->scheme.interfacial.gradient_correction = corrected;
    return c;
}

/* Told when it is loaded so, and when a run is steered to it. */
static void corrected_gradients_at_a_free_surface_are_warned_of(void **state)
{
    (void)state;
    static const char *const schemes[] = {"dissipation", "interfacial"};
    for (int k = 0; k < 8; k++) {
        const bool full = k & 1, later = k & 2;
        MnsCase *c = corrected_or_not(schemes[k / 4], full, !later),
                *other = corrected_or_not(schemes[k / 4], full, true);
        MnsSim *sim = sim_of(c);
        char words[64];
        snprintf(words, sizeof words, "scheme.%s.gradient_correction: ", schemes[k / 4]);
        assert_int_equal(sim_warns(sim, words), !full && !later);
        assert_int_equal(mns_sim_steer(sim, other, NULL), MNS_OK);
        assert_int_equal(sim_warns(sim, words), !full);
        mns_case_free(c);
        sim_done(sim, other);
    }
}

static void volumes_that_a_scheme_evens_out_are_warned_of(void **state)
{
    (void)state;
    static const struct {
        const char *scheme, *moved;
        bool said;
    } rows[] = {{"incompressible", "0.1*y*(1 - y)", true},
                {"incompressible", "0", false},
                {"interfacial", "0.1*y*(1 - y)", false}};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        MnsCase *c = case_still(2, 10, MNS_DENSITY_AUTOMATIC);
        c->scheme.name = rows[k].scheme;
        c->fluids[1].sound_speed = 1000;
        c->scheme.incompressible.reference_speed = 1;
        case_set_text(&c->displacement[1], rows[k].moved);
        MnsSim *sim = sim_of(c);
        assert_int_equal(sim_warns(sim, "domain.displacement: particles stand for up to 9 % more or less than a cell"),
                         rows[k].said);
        sim_done(sim, c);
    }
}

/* By each scheme's own table, which is that of schemes/README.md. */
static void a_kernel_that_a_scheme_was_not_measured_with_is_warned_of(void **state)
{
    (void)state;
    static const struct {
        const char *scheme;
        MnsKernel kernel;
        double smoothing;
        const char *words; /* NULL: it is as it should be */
    } rows[] = {
        {"riemann", MNS_WENDLAND_C2, 1.3, NULL},
        {"riemann", MNS_WENDLAND_C2, 2, NULL},
        {"riemann", MNS_WENDLAND_C2, 1.2,
         "scheme.smoothing: with wendland-c2 and a smoothing of 1.2 the scheme riemann"},
        {"riemann", MNS_QUINTIC_SPLINE, 1,
         "scheme.kernel: the scheme riemann was not measured with quintic-spline; take "
         "wendland-c2 with a smoothing of 1.3"},
        {"dissipation", MNS_TRUNCATED_GAUSSIAN, 1.1, NULL},
        {"dissipation", MNS_TRUNCATED_GAUSSIAN, 1, "but with from 1.1 to 1.5; take 1.1"},
        {"dissipation", MNS_WENDLAND_C2, 2, NULL},
        {"dissipation", MNS_WENDLAND_C2, 1.3, "but with from 1.6 to 2; take 1.6"},
        {"interfacial", MNS_WENDLAND_C2, 1.6, NULL},
        {"interfacial", MNS_WENDLAND_C2, 2.1, "but with from 1.6 to 2; take 1.6"},
        {"interfacial", MNS_TRUNCATED_GAUSSIAN, 1.6, "take wendland-c2 with a smoothing of 1.6"},
        {"incompressible", MNS_QUINTIC_SPLINE, 1, NULL},
        {"incompressible", MNS_QUINTIC_SPLINE, 1.3, "but with 1; take 1"},
        {"differences", MNS_QUINTIC_SPLINE, 0.9, NULL},
        {"differences", MNS_QUINTIC_SPLINE, 1.1, "but with from 0.83 to 0.9; take 0.9"},
    };
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        MnsCase *c = case_still(2, 20, MNS_DENSITY_AUTOMATIC);
        c->scheme.name = rows[k].scheme;
        c->scheme.kernel = rows[k].kernel;
        c->scheme.smoothing = rows[k].smoothing;
        c->scheme.incompressible.reference_speed = c->scheme.differences.reference_speed = 1;
        MnsSim *sim = sim_of(c);
        assert_int_equal(sim_warns(sim, "scheme.kernel: ") || sim_warns(sim, "scheme.smoothing: "),
                         rows[k].words != NULL);
        if (rows[k].words) assert_true(sim_warns(sim, rows[k].words));
        sim_done(sim, c);
    }
}

/* Not where nothing flows along itself, nor where a gas is above. */
static void a_short_reach_at_the_free_surface_of_a_viscous_fluid_is_warned_of(void **state)
{
    (void)state;
    for (int k = 0; k < 8; k++) {
        const bool viscous = k & 1, empty = k & 2, far = k & 4;
        MnsCase *c = case_dam_break(2, 10);
        if (empty) c->n_fluids = 1;
        if (viscous) c->fluids[0].viscosity = 0.01;
        if (far) c->scheme.smoothing = 1.6;
        MnsSim *sim = sim_of(c);
        assert_int_equal(sim_warns(sim,
                                   "was not measured at the free surface of a viscous fluid, but with from 1.6 to 2; "
                                   "take 1.6"),
                         viscous && empty && !far);
        c->n_fluids = 2;
        sim_done(sim, c);
    }
}

/* Of the transport velocity, when it is loaded so and when it is steered there. */
static void particles_that_are_hardly_spread_are_warned_of(void **state)
{
    (void)state;
    static const double strengths[][2] = {{4, 0.5}, {0.4, 0.05}, {0, 0.5}, {4, 0}};
    static const char *const words[] = {"scheme.riemann.background_pressure: with 0 particles are hardly spread, and "
                                        "voids open where flows stretch; take 4",
                                        "scheme.riemann.heavy_background_pressure: with 0 "};
    for (int later = 0; later < 2; later++)
        for (size_t k = 0; k < sizeof strengths / sizeof *strengths; k++) {
            MnsCase *c = case_dam_break(2, 10), *other = case_dam_break(2, 10);
            other->scheme.riemann.background_pressure = strengths[k][0];
            other->scheme.riemann.heavy_background_pressure = strengths[k][1];
            MnsSim *sim = sim_of(later ? c : other);
            if (later) assert_int_equal(mns_sim_steer(sim, other, NULL), MNS_OK);
            for (int q = 0; q < 2; q++) assert_int_equal(sim_warns(sim, words[q]), strengths[k][q] == 0);
            mns_case_free(c);
            sim_done(sim, other);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(run_without_end_is_refused_with_what_limits_its_step),
        cmocka_unit_test(run_of_one_step_without_bound_is_refused),
        cmocka_unit_test(long_run_of_long_steps_is_not_refused),
        cmocka_unit_test(more_snapshots_than_a_disk_holds_are_refused),
        cmocka_unit_test(run_is_not_steered_to_where_it_has_no_end),
        cmocka_unit_test(run_whose_steps_have_become_short_goes_on_from_its_state),
        cmocka_unit_test(run_is_not_steered_to_a_speed_that_has_no_end),
        cmocka_unit_test(step_that_has_become_too_short_for_the_end_is_a_divergence),
        cmocka_unit_test(interval_shorter_than_a_step_is_said_to_be_one),
        cmocka_unit_test(an_entry_that_the_scheme_does_not_read_is_warned_of),
        cmocka_unit_test(a_probe_where_no_fluid_comes_is_warned_of),
        cmocka_unit_test(more_warnings_than_there_is_room_for_are_not_lost_without_a_word),
        cmocka_unit_test(fluid_at_an_open_side_is_warned_of_once),
        cmocka_unit_test(threads_beyond_the_processors_are_said_and_bounded),
        cmocka_unit_test(pressure_that_the_speed_of_sound_cannot_carry_is_warned_of),
        cmocka_unit_test(speed_of_sound_that_is_small_for_the_height_of_a_fluid_is_warned_of),
        cmocka_unit_test(speed_of_sound_that_is_small_for_the_tension_of_a_drop_is_warned_of),
        cmocka_unit_test(corrected_gradients_at_a_free_surface_are_warned_of),
        cmocka_unit_test(volumes_that_a_scheme_evens_out_are_warned_of),
        cmocka_unit_test(a_kernel_that_a_scheme_was_not_measured_with_is_warned_of),
        cmocka_unit_test(a_short_reach_at_the_free_surface_of_a_viscous_fluid_is_warned_of),
        cmocka_unit_test(particles_that_are_hardly_spread_are_warned_of),
    };
    return cmocka_run_group_tests_name("plan", tests, NULL, NULL);
}
