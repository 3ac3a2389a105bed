/* SPDX-License-Identifier: BSD-3-Clause */
/* Fields that live in bundles are those that no pass writes where it loads them, nothing depends on where they are, and what people see of
 * them is the same. */
#include "sim/home.h"
#include "sim/shown.h"
#include "tests/support/bench_cases.h"
#include "tests/support/check.h"
#include "tests/support/memory.h"
#include "tests/support/sims.h"
#include <stdlib.h>
#include <string.h>

typedef MnsCase *(*Make)(int dim, double resolution);

static const Make MAKES[] = {bench_droplet, bench_tense_droplet, bench_drop_in_tank, bench_incompressible_droplet,
                             bench_differenced_droplet};
enum { N_MAKES = sizeof MAKES / sizeof *MAKES };

static MnsCase *case_of(Make make, int dim, unsigned threads)
{
    MnsCase *c = make(dim, dim == 2 ? 16 : 8);
    c->threads = threads;
    c->scheme.skin *= 0.02; /* lists are made again soon */
    return c;
}

static void a_pass_writes_no_bundle_that_it_loads(void **state)
{
    (void)state;
    static const Fields moved = FIELD(X) | FIELD(V), shown = FIELD(NORMAL) | FIELD(GRADIENT);
    static const Fields expected[N_MAKES] = {moved | FIELD(P), FIELD(X) | FIELD(P) | shown, moved | FIELD(P) | shown,
                                             FIELD(P) | FIELD(NORMAL), moved | FIELD(NORMAL) | FIELD(OFFSET)};
    for (size_t k = 0; k < N_MAKES; k++)
        for (int dim = 2; dim <= 3; dim++) {
            MnsCase *c = case_of(MAKES[k], dim, 1);
            MnsSim *sim = sim_of(c);
            const bool beside = k == 1 && dim == 3; /* gradients lie beside what their pass loads */
            const Fields due = beside ? expected[k] & ~FIELD(GRADIENT) : expected[k];
            assert_true(sim->s.housed == due);
            assert_true(home_fields(sim->scheme, &sim->model, dim) == due);
            sim_done(sim, c);
        }
}

/* With corrected gradients a pass of P1 loads velocities where it finds gradients: in space they lie together. */
static void options_decide_too(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = case_of(bench_drop_in_tank, dim, 1);
        MnsSim *sim = sim_of(c);
        Model corrected = sim->model;
        corrected.corrects_gradients = true;
        const Fields fields = home_fields(sim->scheme, &corrected, dim) & (FIELD(NORMAL) | FIELD(GRADIENT));
        assert_true(fields == (dim == 2 ? FIELD(NORMAL) | FIELD(GRADIENT) : FIELD(NORMAL)));
        sim_done(sim, c);
    }
}

/* All that can be seen, by id. */
static void assert_same(const MnsSim *a, const MnsSim *b)
{
    const size_t n = mns_sim_particles(a);
    assert_true(mns_sim_hash(a) == mns_sim_hash(b));
    assert_true(mns_sim_fields(a) == mns_sim_fields(b));
    MnsCapture *capture = NULL;
    assert_int_equal(mns_sim_capture(b, ALL_FIELDS, &capture, NULL), MNS_OK);
    for (int f = 0; mns_fields()[f].name; f++)
        for (int d = 0; d < mns_fields()[f].components; d++) {
            const void *x = mns_sim_field(a, f, d), *y = mns_sim_field(b, f, d), *copied = capture->data[f][d];
            const size_t bytes = n * field_size(&mns_fields()[f]);
            assert_true(!x == !y && !x == !copied);
            if (x && (memcmp(x, y, bytes) != 0 || memcmp(x, copied, bytes) != 0))
                fail_msg("%s: another %s", a->scheme->name, mns_fields()[f].name);
        }
    mns_capture_free(capture);
}

/* In bundles, or in arrays; over rebuilt lists. */
static void results_do_not_depend_on_where_fields_are(void **state)
{
    (void)state;
    for (size_t k = 0; k < N_MAKES; k++)
        for (int dim = 2; dim <= 3; dim++) {
            MnsCase *c = case_of(MAKES[k], dim, 1), *other = case_of(MAKES[k], dim, 3);
            MnsSim *sim = sim_of(c), *apart = sim_of(other);
            assert_true(home_leave(&apart->s, 3));
            assert_true(apart->s.housed == 0);
            assert_same(sim, apart);
            for (int step = 0; step < 4; step++) {
                sim_steps(sim, dim == 2 ? 5 : 2);
                sim_steps(apart, dim == 2 ? 5 : 2);
                assert_same(sim, apart);
            }
            assert_true(sim->progress.rebuilds > 0);
            home_enter(&apart->s, &apart->nb.bundles, apart->scheme, &apart->model, 3);
            assert_same(sim, apart);
            sim_done(apart, other);
            sim_done(sim, c);
        }
}

/* Whatever is shown at the end of a step has a place of its own. */
static void fields_that_are_shown_share_nothing(void **state)
{
    (void)state;
    for (size_t k = 0; k < N_MAKES; k++) {
        MnsCase *c = case_of(MAKES[k], 2, 1);
        MnsSim *sim = sim_of(c);
        for (int f = 0; f < FIELDS_END; f++)
            for (int g = 0; g < f; g++)
                for (int d = 0; d < 2; d++)
                    for (int e = 0; e < 2; e++) {
                        const void *x = particles_element(&sim->s, f, d, 0), *y = particles_element(&sim->s, g, e, 0);
                        assert_true(!x || x != y);
                    }
        sim_done(sim, c);
    }
}

static void without_memory_fields_stay_where_they_are(void **state)
{
    (void)state;
    if (!memory_can_fail) skip();
    MnsCase *c = case_of(bench_drop_in_tank, 3, 1), *other = case_of(bench_drop_in_tank, 3, 1);
    MnsSim *sim = sim_of(c), *same = sim_of(other);
    const Fields housed = sim->s.housed;
    for (long n = 0; n < 13; n++) { /* arrays of five fields */
        memory_fails_after(n);
        const bool left = home_leave(&sim->s, 1);
        memory_fails_after(-1);
        assert_false(left);
        assert_true(sim->s.housed == housed);
    }
    sim_steps(sim, 3);
    sim_steps(same, 3);
    assert_same(sim, same);
    sim_done(same, other);
    sim_done(sim, c);
}

/* Walls are no fluid and the other way round: there is room for neither's fields with the other, and they are shown as 0 there. */
static void fields_of_fluid_alone_are_0_of_walls(void **state)
{
    (void)state;
    static const Make makes[] = {bench_drop_in_tank, bench_differenced_tank};
    static const int fields[] = {F_A, F_TO_SURFACE};
    for (size_t k = 0; k < 2; k++) {
        MnsCase *c = case_of(makes[k], 3, 2);
        MnsSim *sim = sim_of(c);
        sim_steps(sim, 2);
        const size_t n = particles_fluid(&sim->s), owner = k == 0 ? 0 : n;
        const double *shown = mns_sim_field(sim, fields[k], 1), *own = particles_field(&sim->s, fields[k], 1);
        size_t some = 0;
        for (size_t i = 0; i < sim->s.n; i++) {
            const bool has = k == 0 ? i < n : i >= n;
            some += has && shown[i] != 0;
            assert_true(shown[i] == (has ? own[i - owner] : 0));
            assert_true(!particles_element(&sim->s, fields[k], 1, i) == !has);
        }
        assert_true(n < sim->s.n && some > 20);
        sim_done(sim, c);
    }
}

static MnsCase *tense_drop_in_tank(int dim, double resolution)
{
    MnsCase *c = bench_drop_in_tank(dim, resolution);
    c->scheme.name = "interfacial";
    return c;
}

/* What is promised of each scheme, beside walls or not, where there are so many that what is not theirs does not count; besides their lists
 * and the pressure's system, which has a row for each list. */
static void a_particle_in_space_takes_310_bytes_besides_its_list(void **state)
{
    (void)state;
    static const Make makes[] = {
        bench_dam_break,        bench_droplet,      bench_narrow_droplet,         bench_tense_droplet,
        bench_drop_in_tank,     tense_drop_in_tank, bench_incompressible_droplet, bench_differenced_droplet,
        bench_differenced_tank,
    };
    for (size_t k = 0; k < sizeof makes / sizeof *makes; k++) {
        MnsCase *c = makes[k](3, k == 0 ? 20 : 46);
        MnsSim *sim = sim_of(c);
        const double bytes =
            (double)(mns_sim_bytes(sim) - slabs_bytes(&sim->nb.slabs) - system_bytes(&sim->system)) / (double)sim->s.n;
        print_message("%s: %.1f bytes\n", sim->scheme->name, bytes);
        assert_less(bytes, 310);
        const double list = (double)slabs_bytes(&sim->nb.slabs) / (double)neighbours_pairs(&sim->nb);
        if (sim->s.n > 90000) assert_less(list, 4.5); /* of few a thread's last slab counts, which is not full */
        sim_done(sim, c);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_pass_writes_no_bundle_that_it_loads),
        cmocka_unit_test(options_decide_too),
        cmocka_unit_test(results_do_not_depend_on_where_fields_are),
        cmocka_unit_test(fields_that_are_shown_share_nothing),
        cmocka_unit_test(without_memory_fields_stay_where_they_are),
        cmocka_unit_test(fields_of_fluid_alone_are_0_of_walls),
        cmocka_unit_test(a_particle_in_space_takes_310_bytes_besides_its_list),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
