/* SPDX-License-Identifier: BSD-3-Clause */
/* The state is the same to the last bit for any number of threads and over a restart, whatever the scheme; its hash sees every bit of
 * it, and the state of another case is refused. */
#include "tests/support/check.h"
#include "tests/support/sims.h"
#include <stdlib.h>
#include <string.h>

/* Name of scheme k, NULL after the last one. */
static const char *scheme_of(size_t k)
{
    char text[32768];
    return mns_scheme_describe(k, text, sizeof text);
}

/* A sanitizer sees what there is to see in a part of it. */
static bool is_slow(void)
{
    return getenv("MENISCUS_SANITIZED") != NULL;
}

static void bits_are_the_same_for_any_number_of_threads(void **state)
{
    (void)state;
    static const unsigned threads[] = {1, 3, 2, 7};
    const size_t n = check_at_length() ? 4 : 2;
    for (size_t scheme = 0; scheme_of(scheme); scheme++)
        for (int dim = 2; dim <= (is_slow() ? 2 : 3); dim++) {
            uint64_t hash = 0;
            for (size_t k = 0; k < n; k++) {
                MnsCase *c = case_shaken_by(scheme_of(scheme), dim, threads[k]);
                MnsSim *sim = sim_of(c);
                sim_steps(sim, 25);
                assert_true(mns_sim_progress(sim).rebuilds > 0);
                if (k > 0 && mns_sim_hash(sim) != hash)
                    fail_msg("%s in %d dimensions: %u threads find other bits", scheme_of(scheme), dim, threads[k]);
                hash = mns_sim_hash(sim);
                sim_done(sim, c);
            }
        }
}

/* A change of the case that changes what a step is made of; NULL: none. */
typedef void Option(MnsCase *c);

static MnsCase *case_with(Option *option, const char *scheme, int dim, unsigned threads)
{
    MnsCase *c = case_shaken_by(scheme, dim, threads);
    if (option) option(c);
    return c;
}

/* Stopped after `before` steps and gone on in another simulation, with other threads, for `after` more; from 25 on lists are made again
 * meanwhile. */
static void assert_restart_with(Option *option, const char *scheme, int dim, int before, int after, unsigned threads,
                                unsigned other_threads)
{
    MnsCase *c = case_with(option, scheme, dim, threads), *other = case_with(option, scheme, dim, other_threads);
    MnsSim *sim = sim_of(c), *again = sim_of(other);
    MnsCapture *capture = NULL;
    sim_steps(sim, before);
    sim_steps(again, 7); /* whatever it did before does not matter */
    assert_int_equal(mns_sim_capture(sim, mns_sim_state_fields(sim), &capture, NULL), MNS_OK);
    const uint64_t then = mns_sim_hash(sim), rebuilds = mns_sim_progress(sim).rebuilds;
    assert_true(mns_sim_hash(again) != then);
    assert_int_equal(mns_sim_restore(again, capture, NULL), MNS_OK);
    assert_true(mns_sim_hash(again) == then);
    for (size_t a = 0; a < sim->s.n_phases; a++) /* what the next step begins with besides */
        if (memcmp(again->s.p_wall[a], sim->s.p_wall[a], (sim->s.n - particles_fluid(&sim->s)) * sizeof(double)) != 0)
            fail_msg("%s in %d dimensions: walls show other pressures", scheme, dim);
    mns_capture_free(capture);
    sim_steps(sim, after);
    sim_steps(again, after);
    assert_true(mns_sim_progress(sim).rebuilds > rebuilds || after < 25);
    if (mns_sim_hash(again) != mns_sim_hash(sim))
        fail_msg("%s in %d dimensions: other bits after a restart", scheme, dim);
    assert_true(mns_sim_hash(again) != then);
    sim_done(again, other);
    sim_done(sim, c);
}

static void assert_restart(const char *scheme, int dim, int before, unsigned threads, unsigned other_threads)
{
    assert_restart_with(NULL, scheme, dim, before, 25, threads, other_threads);
}

static void restart_goes_on_as_if_never_stopped(void **state)
{
    (void)state;
    for (size_t k = 0; scheme_of(k); k++) {
        assert_restart(scheme_of(k), 2, is_slow() ? 11 : check_at_length() ? 61 : 31, 1, 3);
        assert_restart_with(NULL, scheme_of(k), 2, 0, 4, 1, 1);
        if (is_slow()) continue;
        assert_restart(scheme_of(k), 3, check_at_length() ? 40 : 5, 3, 2);
        if (!check_at_length()) continue;
        assert_restart(scheme_of(k), 2, 0, 1, 1);
        assert_restart(scheme_of(k), 2, 70, 2, 1);
    }
}

static void plain(MnsCase *c)
{
    c->scheme.riemann.transport_stress = false;
    c->scheme.riemann.background_pressure = c->scheme.riemann.heavy_background_pressure = 0;
    c->scheme.interfacial.shifting = MNS_SHIFTING_OFF;
    c->scheme.differences.shifting_strength = 0;
    c->scheme.incompressible.mobility = MNS_MOBILITY_UNIT;
    c->tension[0][1] = c->tension[1][0] = 0;
}

static void without_dissipation(MnsCase *c)
{
    c->scheme.dissipation.delta = c->scheme.interfacial.delta = 0;
    c->scheme.interfacial.shifting_strength = 0;
}

/* Of fluids less unlike: corrected at a ratio of 1000, P2 blows up soon. */
static void corrected(MnsCase *c)
{
    c->fluids[1].density = 0.5;
    c->scheme.dissipation.gradient_correction = c->scheme.interfacial.gradient_correction = true;
}

static void corrected_and_still(MnsCase *c)
{
    corrected(c);
    c->scheme.dissipation.form = MNS_DISSIPATION_PLAIN;
    c->scheme.interfacial.shifting = MNS_SHIFTING_OFF;
}

static void as_printed(MnsCase *c)
{
    c->fluids[1].density = 0.5;
    c->scheme.interfacial.shifting = MNS_SHIFTING_ORIGINAL;
}

static void inviscid(MnsCase *c)
{
    c->fluids[0].viscosity = c->fluids[1].viscosity = 0;
    c->walls[0].no_slip = false;
    c->scheme.interfacial.shifting = MNS_SHIFTING_OFF;
}

static void all_continuity(MnsCase *c)
{
    for (size_t k = 0; k < c->n_fluids; k++) c->fluids[k].density_method = MNS_DENSITY_CONTINUITY;
}

static void all_summation(MnsCase *c)
{
    for (size_t k = 0; k < c->n_fluids; k++) c->fluids[k].density_method = MNS_DENSITY_SUMMATION;
}

static void harmonic(MnsCase *c)
{
    c->scheme.differences.diffusion = MNS_DIFFUSION_HARMONIC;
}

static void conservative(MnsCase *c)
{
    c->scheme.differences.diffusion = MNS_DIFFUSION_CONSERVATIVE;
}

static void as_in_sph(MnsCase *c)
{
    c->scheme.differences.diffusion = MNS_DIFFUSION_SPH;
}

/* Beside mirrors (mirrors.h) rows have images. */
static void gliding(MnsCase *c)
{
    c->walls[0].no_slip = false;
    c->walls[0].motion = (MnsMotion){.kind = MNS_STILL};
    case_set_text(&c->gravity[0], "0.4*sin(8*t)");
}

static void upright(MnsCase *c)
{
    gliding(c);
    case_set_text(&c->gravity[0], "0");
}

static void reconstructed(MnsCase *c)
{
    c->scheme.riemann.reconstruction = MNS_RECONSTRUCTION_VELOCITY;
}

static void all_reconstructed(MnsCase *c)
{
    c->scheme.riemann.reconstruction = MNS_RECONSTRUCTION_BOTH;
}

/* Beside mirrors, where gradients of images are turned. */
static void upright_and_reconstructed(MnsCase *c)
{
    upright(c);
    all_reconstructed(c);
}

/* Velocities of surfaces are by particles, which a restart puts in another order, though they do not change. */
static void belted(MnsCase *c)
{
    c->walls[0].no_slip = true;
    case_set_text(&c->walls[0].surface_velocity[0], "0.5");
    case_set_text(&c->walls[0].surface_velocity[1], "0.25");
}

/* Options leave terms out of passes, and so what is done again after a restart must do without them as well. */
static void restart_goes_on_with_any_options(void **state)
{
    (void)state;
    static const struct {
        const char *scheme;
        int before;          /* without shifting, differences end soon */
        Option *options[10]; /* end with NULL */
    } rows[] = {
        {"riemann",
         61,
         {plain, inviscid, all_continuity, all_summation, upright, belted, reconstructed, all_reconstructed,
          upright_and_reconstructed}},
        {"dissipation", 61, {plain, without_dissipation, corrected, corrected_and_still, inviscid, upright, belted}},
        {"interfacial",
         61,
         {plain, without_dissipation, corrected, corrected_and_still, as_printed, inviscid, upright, belted}},
        {"incompressible", 31, {plain, inviscid, gliding, belted}},
        {"differences", 31, {plain, inviscid, gliding, harmonic, conservative, as_in_sph, belted}},
    };
    for (size_t k = 0; scheme_of(k); k++) {
        assert_in_range(k, 0, sizeof rows / sizeof *rows - 1);
        assert_string_equal(scheme_of(k), rows[k].scheme);
        for (size_t q = 0; rows[k].options[q]; q++)
            assert_restart_with(rows[k].options[q], rows[k].scheme, 2,
                                is_slow() || !check_at_length() ? 11 : rows[k].before, 4, 1, 1);
    }
}

static void by_multigrid(MnsCase *c)
{
    c->scheme.incompressible.solver = c->scheme.differences.solver = MNS_SOLVER_AMG;
}

/* Multigrid keeps what it has made until the lists are made again. */
static void restart_makes_the_multigrid_that_there_was(void **state)
{
    (void)state;
    if (!amg_exists()) skip();
    for (int dim = 2; dim <= (is_slow() ? 2 : 3); dim++) {
        const unsigned threads = dim == 2 ? 1 : 2;
        assert_restart_with(by_multigrid, "incompressible", dim, dim == 2 ? 33 : 5, 25, threads, 3 - threads);
        assert_restart_with(by_multigrid, "differences", dim, dim == 2 ? 21 : 5, 25, threads, 3 - threads);
    }
}

/* Particles hardly move from one step to the next, and so nor does the matrix. */
static void multigrid_of_differences_is_made_when_the_lists_are(void **state)
{
    (void)state;
    enum { STEPS = 20 };
    if (!amg_exists() || is_slow()) skip();
    MnsCase *c = case_shaken_by("differences", 2, 1);
    by_multigrid(c);
    c->scheme.skin = 0.5;
    MnsSim *sim = sim_of(c);
    sim_steps(sim, STEPS);
    const uint64_t made = sim->timers[sim->timer_setup].calls;
    assert_in_range(made, 1, sim->progress.rebuilds + 1);
    assert_in_range(sim->progress.rebuilds, 0, STEPS / 2);
    sim_done(sim, c);
}

/* What is derived is restored too, so that pictures and probes do not change; rates of strain, which are in none, are those of the velocity of half a step before. */
static void restart_shows_the_same_fields(void **state)
{
    (void)state;
    for (size_t scheme = 0; scheme_of(scheme); scheme++) {
        MnsCase *c = case_shaken_by(scheme_of(scheme), 2, 1), *other = case_shaken_by(scheme_of(scheme), 2, 1);
        MnsSim *sim = sim_of(c), *again = sim_of(other);
        MnsCapture *capture = NULL;
        sim_steps(sim, 20);
        assert_int_equal(mns_sim_capture(sim, mns_sim_state_fields(sim), &capture, NULL), MNS_OK);
        assert_int_equal(mns_sim_restore(again, capture, NULL), MNS_OK);
        for (int f = 0; mns_fields()[f].name; f++)
            for (int d = 0; d < mns_fields()[f].components; d++) {
                const void *field = mns_sim_field(sim, f, d), *restored = mns_sim_field(again, f, d);
                if (!field || (sim->scheme->integrator->works | FIELD(STRAIN) | FIELD(STRAIN_OFF)) >> f & 1) continue;
                if (memcmp(field, restored, sim->s.n * field_size(&mns_fields()[f])) != 0)
                    fail_msg("%s: another %s", scheme_of(scheme), mns_fields()[f].name);
            }
        mns_capture_free(capture);
        sim_done(again, other);
        sim_done(sim, c);
    }
}

static void hash_does_not_know_the_order_of_storage_but_every_bit_else(void **state)
{
    (void)state;
    MnsCase *c = case_shaken(2, 1);
    MnsSim *sim = sim_of(c);
    sim_steps(sim, 3);
    const uint64_t hash = mns_sim_hash(sim);
    uint32_t *order = malloc(sim->s.n * sizeof *order);
    assert_non_null(order);
    for (int g = 0; g < GROUPS; g++)
        for (size_t k = sim->s.begin[g]; k < sim->s.begin[g + 1]; k++)
            order[k] = (uint32_t)(sim->s.begin[g] + sim->s.begin[g + 1] - 1 - k);
    particles_permute(&sim->s, order, 1);
    free(order);
    assert_true(mns_sim_hash(sim) == hash);
    sim->s.v[1][5 * sim->s.v_step] = nextafter(sim->s.v[1][5 * sim->s.v_step], 100);
    assert_true(mns_sim_hash(sim) != hash);
    sim->s.v[1][5 * sim->s.v_step] = nextafter(sim->s.v[1][5 * sim->s.v_step], -100);
    assert_true(mns_sim_hash(sim) == hash);
    MnsProgress *const p = &sim->progress;
    double *const times[] = {&p->t, &p->dt, &p->dt_first};
    for (size_t k = 0; k < sizeof times / sizeof *times; k++) {
        const double was = *times[k];
        *times[k] = nextafter(was, 100);
        assert_true(mns_sim_hash(sim) != hash);
        *times[k] = was;
    }
    uint64_t *const counts[] = {&p->step, &p->rebuilds, &p->guarded};
    for (size_t k = 0; k < sizeof counts / sizeof *counts; k++) {
        ++*counts[k];
        assert_true(mns_sim_hash(sim) != hash);
        --*counts[k];
    }
    assert_true(mns_sim_hash(sim) == hash);
    sim_done(sim, c);
}

static void captures_of_another_case_are_refused_and_change_nothing(void **state)
{
    (void)state;
    MnsCase *c = case_shaken(2, 1), *wider = case_shaken(2, 1), *flipped = case_shaken(2, 1),
            *thick = case_shaken(3, 1);
    wider->max[0] = wider->walls[0].shape.parts[0].b[0] = 3.25;
    flipped->fluids[1].density_method = MNS_DENSITY_CONTINUITY; /* as many particles, in other groups */
    MnsCase *others[3] = {wider, flipped, thick};
    MnsSim *sim = sim_of(c);
    sim_steps(sim, 2);
    const uint64_t hash = mns_sim_hash(sim);
    MnsCapture *capture = NULL;
    for (int k = 0; k < 3; k++) {
        MnsSim *other = sim_of(others[k]);
        assert_int_equal(mns_sim_capture(other, mns_sim_state_fields(other), &capture, NULL), MNS_OK);
        assert_int_equal(mns_sim_restore(sim, capture, NULL), MNS_E_INVALID);
        mns_capture_free(capture);
        sim_done(other, others[k]);
    }
    assert_int_equal(
        mns_sim_capture(sim, mns_sim_state_fields(sim) & ~(UINT64_C(1) << mns_field_find("velocity")), &capture, NULL),
        MNS_OK);
    MnsError error;
    assert_int_equal(mns_sim_restore(sim, capture, &error), MNS_E_VERSION);
    assert_non_null(strstr(error.text, "no velocity"));
    mns_capture_free(capture);
    assert_true(mns_sim_hash(sim) == hash);
    sim_done(sim, c);
}

/* All in one place: there is no list of that, so nothing goes on from it, until another state is put back. */
static void a_state_without_lists_is_not_gone_on_from(void **state)
{
    (void)state;
    MnsCase *c = case_dam_break(2, 16);
    MnsSim *sim = sim_of(c);
    MnsCapture *well = NULL, *heap = NULL;
    MnsError error;
    assert_int_equal(mns_sim_capture(sim, mns_sim_state_fields(sim), &well, NULL), MNS_OK);
    assert_int_equal(mns_sim_capture(sim, mns_sim_state_fields(sim), &heap, NULL), MNS_OK);
    static const char *const places[] = {"position", "list_position"}; /* lists are of the second */
    for (int k = 0; k < 2; k++)
        for (int d = 0; d < 2; d++)
            for (size_t i = 0; i < heap->n; i++) ((double *)(void *)heap->data[mns_field_find(places[k])][d])[i] = 0.5;
    assert_int_equal(mns_sim_restore(sim, heap, &error), MNS_E_LIMIT);
    assert_int_equal(mns_sim_step(sim, INFINITY, &error), MNS_E_LIMIT);
    assert_int_equal(mns_sim_restore(sim, well, &error), MNS_OK);
    assert_int_equal(mns_sim_step(sim, INFINITY, &error), MNS_OK);
    mns_capture_free(well);
    mns_capture_free(heap);
    sim_done(sim, c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bits_are_the_same_for_any_number_of_threads),
        cmocka_unit_test(restart_goes_on_as_if_never_stopped),
        cmocka_unit_test(restart_goes_on_with_any_options),
        cmocka_unit_test(restart_makes_the_multigrid_that_there_was),
        cmocka_unit_test(multigrid_of_differences_is_made_when_the_lists_are),
        cmocka_unit_test(restart_shows_the_same_fields),
        cmocka_unit_test(hash_does_not_know_the_order_of_storage_but_every_bit_else),
        cmocka_unit_test(captures_of_another_case_are_refused_and_change_nothing),
        cmocka_unit_test(a_state_without_lists_is_not_gone_on_from),
    };
    return cmocka_run_group_tests_name("restart", tests, NULL, NULL);
}
