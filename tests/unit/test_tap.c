/* SPDX-License-Identifier: BSD-3-Clause */
/* Copies for streams stay within their limit, whoever wants what, and are made again when there is room. */
#include "run/tap.h"
#include "tests/support/check.h"
#include "tests/support/sims.h"
#include <pthread.h>
#include <unistd.h>

static uint64_t bit(const char *field)
{
    return UINT64_C(1) << mns_field_find(field);
}

/* The generation of the simulation that is there now. */
static uint64_t place(Tap *tap, const MnsSim *sim)
{
    TapCase now;
    tap_place(tap, sim, NULL, false);
    tap_case(tap, &now);
    return now.generation;
}

static Feed *open_feed(Tap *tap, uint64_t generation, uint64_t fields)
{
    Feed *feed = tap_open(tap, generation, &(Wish){.fields = fields});
    assert_non_null(feed);
    return feed;
}

/* What is asked for now; NULL: there is no room. */
static const Shot *shot_of(Tap *tap, const MnsSim *sim, Feed *feed)
{
    uint64_t due;
    tap_ask(tap, feed);
    tap_look(tap, sim, false, NULL);
    return tap_take(tap, feed, &due);
}

static size_t arrays_of(const MnsCapture *capture)
{
    size_t n = 0;
    for (int f = 0; mns_fields()[f].name; f++)
        for (int d = 0; d < 3; d++) n += capture->data[f][d] != NULL;
    return n;
}

static void wishes_that_have_nothing_in_common_stay_within_the_limit_together(void **state)
{
    (void)state;
    MnsCase *c = case_shaken_by("riemann", 2, 1);
    MnsSim *sim = sim_of(c);
    const size_t one = mns_sim_capture_size(sim, bit("position"));
    Tap *tap = tap_new(one + one / 2);
    const uint64_t generation = place(tap, sim);
    Feed *first = open_feed(tap, generation, bit("position")), *second = open_feed(tap, generation, bit("velocity"));
    const Shot *shot = shot_of(tap, sim, first);
    assert_int_equal(arrays_of(shot->capture), 2);
    tap_leave(tap, shot);
    shot = shot_of(tap, sim, second);
    assert_non_null(shot->capture->data[mns_field_find("velocity")][1]);
    assert_int_equal(arrays_of(shot->capture), 2);
    assert_int_equal(tap_tally(tap)->bytes, one);
    assert_null(shot_of(tap, sim, first)); /* while that is held there is no room */
    tap_leave(tap, shot);
    tap_free(tap);
    sim_done(sim, c);
}

static void room_beyond_the_first_gives_way_to_a_wish_that_is_larger(void **state)
{
    (void)state;
    MnsCase *c = case_shaken_by("riemann", 2, 1);
    MnsSim *sim = sim_of(c);
    const size_t one = mns_sim_capture_size(sim, bit("position"));
    Tap *tap = tap_new(2 * one);
    const uint64_t generation = place(tap, sim);
    Feed *small = open_feed(tap, generation, bit("position"));
    Feed *large = open_feed(tap, generation, bit("position") | bit("velocity"));
    const Shot *a = shot_of(tap, sim, small), *b = shot_of(tap, sim, small);
    tap_leave(tap, a);
    tap_leave(tap, b);
    const Shot *shot = shot_of(tap, sim, large);
    assert_non_null(shot);
    assert_int_equal(arrays_of(shot->capture), 4);
    assert_int_equal(tap_tally(tap)->bytes, 2 * one);
    tap_leave(tap, shot);
    tap_free(tap);
    sim_done(sim, c);
}

static void room_for_the_case_before_is_not_in_the_way_of_another(void **state)
{
    (void)state;
    MnsCase *c = case_shaken_by("riemann", 2, 1), *other = case_shaken_by("riemann", 3, 1);
    MnsSim *sim = sim_of(c), *next = sim_of(other);
    const size_t most = mns_sim_capture_size(next, bit("position"));
    const size_t one = mns_sim_capture_size(sim, bit("position"));
    Tap *tap = tap_new(most > 2 * one ? most : 2 * one);
    const Shot *shots[2];
    Feed *feed = open_feed(tap, place(tap, sim), bit("position"));
    assert_int_not_equal(mns_sim_particles(sim), mns_sim_particles(next));
    for (int k = 0; k < 2; k++) assert_non_null(shots[k] = shot_of(tap, sim, feed));
    Feed *later = open_feed(tap, place(tap, next), bit("position"));
    if (most > one) assert_null(shot_of(tap, next, later)); /* those are still held, and counted */
    for (int k = 0; k < 2; k++) tap_leave(tap, shots[k]);
    const Shot *shot = shot_of(tap, next, later);
    assert_non_null(shot);
    assert_int_equal(tap_tally(tap)->bytes, most);
    tap_leave(tap, shot);
    tap_close(tap, feed);
    tap_close(tap, later);
    tap_look(tap, next, false, NULL); /* nobody watches */
    assert_int_equal(tap_tally(tap)->bytes, 0);
    tap_free(tap);
    sim_done(sim, c);
    sim_done(next, other);
}

/* The thread of streams: asks again and again, and looks at what it gets. */
typedef struct Asker {
    Tap *tap;
    Feed *feed;
    _Atomic bool done;
    _Atomic uint64_t shots;
    uint64_t empty, stale;
} Asker;

static void *ask_on(void *arg)
{
    Asker *asker = arg;
    while (!asker->done) {
        uint64_t due;
        tap_ask(asker->tap, asker->feed);
        const Shot *shot = tap_take(asker->tap, asker->feed, &due);
        if (!shot) continue;
        asker->shots++;
        if (!shot->values) asker->empty++;
        else asker->stale += shot->values[0] != 7;
        tap_leave(asker->tap, shot);
        usleep(20); /* so that it asks at any moment of a look */
    }
    return NULL;
}

/* Between the look at who is due and the handing out there is a copy, and time to ask. */
static void who_asks_while_a_shot_is_taken_gets_none_without_what_it_wants(void **state)
{
    (void)state;
    enum { LOOKS = 4000, SHOTS = 200 };
    MnsCase *c = case_shaken_by("riemann", 3, 1);
    case_add_probe(c, MNS_PROBE_KINETIC_ENERGY);
    MnsSim *sim = sim_of(c);
    Tap *tap = tap_new((size_t)1 << 30);
    const uint64_t generation = place(tap, sim);
    double known[MNS_MAX_PROBES];
    for (size_t k = 0; k < MNS_MAX_PROBES; k++) known[k] = 7;
    Feed *fields = open_feed(tap, generation, bit("position") | bit("velocity") | bit("density"));
    Asker asker = {.tap = tap, .feed = tap_open(tap, generation, &(Wish){.probes = {1}})};
    pthread_t thread;
    assert_int_equal(pthread_create(&thread, NULL, ask_on, &asker), 0);
    for (int k = 0; k < LOOKS || asker.shots < SHOTS; k++) {
        uint64_t due;
        tap_ask(tap, fields);
        tap_look(tap, sim, false, known);
        const Shot *shot = tap_take(tap, fields, &due);
        if (!shot) continue;
        assert_non_null(shot->capture);
        tap_leave(tap, shot);
    }
    asker.done = true;
    pthread_join(thread, NULL);
    assert_int_equal(asker.empty, 0);
    assert_int_equal(asker.stale, 0);
    tap_free(tap);
    sim_done(sim, c);
}

/* A gap, and never what the field was: it is counted, and shots go on when the option is on again. */
static void who_wants_a_field_that_an_option_took_away_gets_a_gap(void **state)
{
    (void)state;
    MnsCase *c[2];
    for (int k = 0; k < 2; k++) {
        c[k] = case_shaken_by("interfacial", 2, 1);
        c[k]->scheme.interfacial.gradient_correction = k == 0;
    }
    MnsSim *sim = sim_of(c[0]);
    Tap *tap = tap_new((size_t)1 << 30);
    const uint64_t generation = place(tap, sim);
    Feed *gone = open_feed(tap, generation, bit("position") | bit("correction"));
    Feed *rest = open_feed(tap, generation, bit("position"));
    const Shot *shot = shot_of(tap, sim, gone);
    assert_non_null(shot);
    tap_leave(tap, shot);
    for (int k = 1; k >= 0; k--) {
        uint64_t before, due;
        assert_null(tap_take(tap, gone, &before));
        assert_int_equal(mns_sim_steer(sim, c[k], NULL), MNS_OK);
        tap_ask(tap, gone);
        shot = shot_of(tap, sim, rest);
        assert_non_null(shot);
        tap_leave(tap, shot);
        shot = tap_take(tap, gone, &due);
        assert_true(k == 1 ? !shot : shot && shot->capture->data[mns_field_find("correction")][0]);
        if (shot) tap_leave(tap, shot);
        assert_int_equal(due, before + 1);
    }
    tap_free(tap);
    mns_case_free(c[1]);
    sim_done(sim, c[0]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(wishes_that_have_nothing_in_common_stay_within_the_limit_together),
        cmocka_unit_test(room_beyond_the_first_gives_way_to_a_wish_that_is_larger),
        cmocka_unit_test(room_for_the_case_before_is_not_in_the_way_of_another),
        cmocka_unit_test(who_wants_a_field_that_an_option_took_away_gets_a_gap),
        cmocka_unit_test(who_asks_while_a_shot_is_taken_gets_none_without_what_it_wants),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
