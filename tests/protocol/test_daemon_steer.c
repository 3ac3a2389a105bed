/* SPDX-License-Identifier: BSD-3-Clause */
/* Breakpoints, questions and settings, and clients that die in the middle. */
#include "tests/support/check.h"
#include "tests/support/steer.h"
#include <hdf5.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>
#include <zmq.h>

static Meniscus__Reply *breakpoint(Dialogue *dialogue, const char *condition, double t)
{
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    Meniscus__SetBreakpoint point = MENISCUS__SET_BREAKPOINT__INIT;
    point.name = (char *)"b";
    point.condition = (char *)condition;
    point.has_time = !isnan(t);
    point.time = t;
    request.command_case = MENISCUS__REQUEST__COMMAND_BREAKPOINT;
    request.breakpoint = &point;
    return dialogue_ask(dialogue, &request);
}

static void start_and_wait(Dialogue *dialogue, Meniscus__State state)
{
    assert_int_equal(steer_code(dialogue, dialogue_start()), MENISCUS__CODE__OK);
    steer_wait_for(dialogue, state);
}

static double front_of(Dialogue *dialogue)
{
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    Meniscus__Query query = MENISCUS__QUERY__INIT;
    Meniscus__ProbeQuery probes = MENISCUS__PROBE_QUERY__INIT;
    char *names[1] = {(char *)"front"};
    probes.n_names = 1;
    probes.names = names;
    query.what_case = MENISCUS__QUERY__WHAT_PROBES;
    query.probes = &probes;
    request.command_case = MENISCUS__REQUEST__COMMAND_QUERY;
    request.query = &query;
    Meniscus__Reply *reply = dialogue_ask(dialogue, &request);
    assert_int_equal(reply->code, MENISCUS__CODE__OK);
    const double front = reply->values->values[0]->number;
    meniscus__reply__free_unpacked(reply, NULL);
    return front;
}

static const char large_case[] = "dimensions: 3\n"
                                 "resolution: 10\n"
                                 "domain: {min: [0, 0, 0], max: [1, 1, 1]}\n"
                                 "fluids: [{name: water, density: 1000, sound_speed: 20}]\n"
                                 "walls:\n"
                                 "  - {name: tank, shape: [{outside: true, box: {min: [0, 0, 0], max: [1, 1, 1]}}]}\n"
                                 "end_time: 1\n";

static void send_large_load(void *socket, const char *resolution)
{
    LoadRequest load;
    uint8_t id[16];
    dialogue_load_init(&load, "large", large_case, (const char *[]){resolution, NULL});
    dialogue_say(socket, &load.request, id);
    dialogue_load_done(&load);
}

/* --- breakpoints ------------------------------------------------------------------------------------------------------- */

static void a_breakpoint_in_time_pauses_at_the_first_step_after_it(void **state)
{
    Dialogue *dialogue = *state;
    dialogue_load(dialogue, NULL);
    steer_accepted(breakpoint(dialogue, NULL, 0.05));
    start_and_wait(dialogue, MENISCUS__STATE__PAUSED);
    Meniscus__Reply *reply = steer_status(dialogue);
    assert_true(reply->status->time >= 0.05);
    assert_true(reply->status->time - reply->status->time_step < 0.05);
    assert_int_equal(reply->status->n_breakpoints, 1);
    meniscus__reply__free_unpacked(reply, NULL);
}

static void a_condition_on_a_probe_pauses_when_it_comes_true(void **state)
{
    Dialogue *dialogue = *state;
    dialogue_load(dialogue, NULL);
    assert_true(front_of(dialogue) < 1.02);
    steer_accepted(breakpoint(dialogue, "front > 1.05", NAN));
    start_and_wait(dialogue, MENISCUS__STATE__PAUSED);
    assert_true(front_of(dialogue) > 1.05);
    assert_true(front_of(dialogue) < 1.06);
}

static void a_condition_that_is_no_formula_or_names_no_probe_is_refused(void **state)
{
    Dialogue *dialogue = *state;
    dialogue_load(dialogue, NULL);
    steer_refused(breakpoint(dialogue, "front > ", NAN), MENISCUS__CODE__INVALID_ARGUMENT, "front > ");
    steer_refused(breakpoint(dialogue, "fromt > 2.1", NAN), MENISCUS__CODE__INVALID_ARGUMENT, "fromt");
    steer_refused(breakpoint(dialogue, NULL, NAN), MENISCUS__CODE__INVALID_ARGUMENT, "condition");
    Meniscus__Reply *reply = steer_status(dialogue);
    assert_int_equal(reply->status->n_breakpoints, 0);
    meniscus__reply__free_unpacked(reply, NULL);
}

static void a_condition_that_is_a_number_is_refused(void **state)
{
    Dialogue *dialogue = *state;
    dialogue_load(dialogue, NULL);
    steer_refused(breakpoint(dialogue, "front", NAN), MENISCUS__CODE__INVALID_ARGUMENT, "true or false");
    steer_refused(breakpoint(dialogue, "5", NAN), MENISCUS__CODE__INVALID_ARGUMENT, "true or false");
    steer_accepted(breakpoint(dialogue, "front > 5 and step > 1", NAN));
}

/* --- questions against a snapshot -------------------------------------------------------------------------------------- */

enum { N_MAX = 4000 };

/* Rows of a dataset of doubles in an HDF5 file. */
static size_t read_doubles(const char *path, const char *name, double *ret, size_t columns)
{
    const hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT), set = H5Dopen(file, name, H5P_DEFAULT);
    assert_true(file >= 0 && set >= 0);
    const hid_t space = H5Dget_space(set);
    const hssize_t n = H5Sget_simple_extent_npoints(space);
    assert_true(n > 0 && (size_t)n <= columns * N_MAX);
    assert_true(H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, ret) >= 0);
    H5Sclose(space);
    H5Dclose(set);
    H5Fclose(file);
    return (size_t)n / columns;
}

static void take_snapshot(Dialogue *dialogue, char path[static 256])
{
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    Meniscus__SnapshotNow now_ = MENISCUS__SNAPSHOT_NOW__INIT;
    char *fields[1] = {(char *)"pressure"};
    now_.n_fields = 1;
    now_.fields = fields;
    request.command_case = MENISCUS__REQUEST__COMMAND_SNAPSHOT;
    request.snapshot = &now_;
    Meniscus__Reply *reply = dialogue_ask(dialogue, &request);
    assert_int_equal(reply->code, MENISCUS__CODE__OK);
    snprintf(path, 256, "%.255s", reply->output->path);
    meniscus__reply__free_unpacked(reply, NULL);
}

/* Send a query and keep its raw frames: [n] of at most sizes[k] bytes. */
static Meniscus__Reply *ask_frames(Dialogue *dialogue, Meniscus__Query *query, size_t n, void *const *frames,
                                   const size_t *sizes)
{
    uint8_t id[16], packed[8192];
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    request.command_case = MENISCUS__REQUEST__COMMAND_QUERY;
    request.query = query;
    dialogue_say(dialogue->control, &request, id);
    const int size = zmq_recv(dialogue->control, packed, sizeof packed, 0);
    assert_true(size > 0 && size <= (int)sizeof packed);
    Meniscus__Reply *reply = meniscus__reply__unpack(NULL, (size_t)size, packed);
    assert_non_null(reply);
    if (reply->code != MENISCUS__CODE__OK) fail_msg("refused: %s", reply->message);
    assert_int_equal(reply->n_arrays, n);
    for (size_t k = 0; k < n; k++) {
        const int got = zmq_recv(dialogue->control, frames[k], sizes[k], 0);
        assert_true(got > 0 && got <= (int)sizes[k]);
    }
    return reply;
}

static void particles_of_a_box_are_those_of_a_snapshot(void **state)
{
    Dialogue *dialogue = *state;
    static double x[3 * N_MAX], p[N_MAX], box_x[2 * N_MAX], box_p[N_MAX];
    char path[256], *fields[2] = {(char *)"position", (char *)"pressure"};
    double min[2] = {0.2, 0.1}, max[2] = {0.9, 0.35};
    Meniscus__Query query = MENISCUS__QUERY__INIT;
    Meniscus__ParticleQuery which = MENISCUS__PARTICLE_QUERY__INIT;
    dialogue_load(dialogue, NULL);
    steer_go(dialogue, 10);
    take_snapshot(dialogue, path);
    which.n_min = which.n_max = which.n_fields = 2;
    which.min = min;
    which.max = max;
    which.fields = fields;
    query.what_case = MENISCUS__QUERY__WHAT_PARTICLES;
    query.particles = &which;
    void *const frames[2] = {box_x, box_p};
    const size_t sizes[2] = {sizeof box_x, sizeof box_p};
    Meniscus__Reply *reply = ask_frames(dialogue, &query, 2, frames, sizes);
    const size_t n = read_doubles(path, "/VTKHDF/Points", x, 3), n_box = reply->arrays[0]->shape[0];
    assert_int_equal(read_doubles(path, "/VTKHDF/PointData/pressure", p, 1), n);
    size_t found = 0;
    for (size_t k = 0; k < n; k++) {
        const double *at = &x[3 * k];
        if (at[0] < min[0] || at[0] > max[0] || at[1] < min[1] || at[1] > max[1]) continue;
        bool same = false;
        for (size_t j = 0; j < n_box; j++)
            same = same || (at[0] == box_x[2 * j] && at[1] == box_x[2 * j + 1] && p[k] == box_p[j]);
        assert_true(same);
        found++;
    }
    assert_true(found > 5);
    assert_int_equal(found, n_box);
    meniscus__reply__free_unpacked(reply, NULL);
}

/* Where a particle is, the field is about what that particle says; a point outside has no value. */
static void points_are_between_the_particles_around_them(void **state)
{
    Dialogue *dialogue = *state;
    static double x[3 * N_MAX], p[N_MAX];
    char path[256];
    double values[2], points[4] = {0.5, 0.25, 0.8, 0.1};
    Meniscus__Query query = MENISCUS__QUERY__INIT;
    Meniscus__PointQuery where = MENISCUS__POINT_QUERY__INIT;
    dialogue_load(dialogue, NULL);
    steer_go(dialogue, 10);
    take_snapshot(dialogue, path);
    where.field = (char *)"pressure";
    where.n_points = 4;
    where.points = points;
    query.what_case = MENISCUS__QUERY__WHAT_POINTS;
    query.points = &where;
    Meniscus__Reply *reply = ask_frames(dialogue, &query, 1, (void *const[]){values}, (const size_t[]){sizeof values});
    assert_string_equal(reply->arrays[0]->unit, "Pa");
    meniscus__reply__free_unpacked(reply, NULL);
    const size_t n = read_doubles(path, "/VTKHDF/Points", x, 3);
    read_doubles(path, "/VTKHDF/PointData/pressure", p, 1);
    for (size_t k = 0; k < 2; k++) {
        double least = INFINITY, most = -INFINITY;
        for (size_t j = 0; j < n; j++)
            if (hypot(x[3 * j] - points[2 * k], x[3 * j + 1] - points[2 * k + 1]) < 0.26) {
                least = fmin(least, p[j]);
                most = fmax(most, p[j]);
            }
        assert_true(values[k] >= least && values[k] <= most);
    }
}

/* --- settings ---------------------------------------------------------------------------------------------------------- */

static void threads_can_be_set_within_bounds(void **state)
{
    Dialogue *dialogue = *state;
    dialogue_load(dialogue, NULL);
    steer_accepted(steer_set(dialogue, "threads", "2"));
    steer_go(dialogue, 2);
    Meniscus__Reply *reply = steer_status(dialogue);
    assert_int_equal(reply->status->threads, 2);
    meniscus__reply__free_unpacked(reply, NULL);
    steer_refused(steer_set(dialogue, "threads", "100000"), MENISCUS__CODE__INVALID_ARGUMENT, "[0, 1024]");
    steer_refused(steer_set(dialogue, "threads", "-1"), MENISCUS__CODE__INVALID_ARGUMENT, "0");
}

/* Those the daemon was started with are for cases that do not say. */
/* All at once, so that the last has taken effect before the first is replied to. */
static void send_changes_and_a_reset(const Dialogue *dialogue, unsigned n)
{
    uint8_t id[16];
    for (unsigned k = 0; k < n; k++) {
        char end[16];
        snprintf(end, sizeof end, "%u", 100 + k);
        const char *const pairs[2][2] = {{"end_time", end}, {"threads", k % 2 ? "2" : "1"}};
        steer_say_set(dialogue->control, 2, pairs, id);
    }
    Meniscus__Request reset = dialogue_reset();
    dialogue_say(dialogue->control, &reset, id);
}

static void each_change_is_answered_with_its_own_values_whatever_follows(void **state)
{
    enum { CHANGES = 50 };
    Dialogue *dialogue = *state;
    dialogue_load(dialogue, NULL);
    send_changes_and_a_reset(dialogue, CHANGES);
    for (unsigned k = 0; k < CHANGES; k++) {
        Meniscus__Reply *reply = dialogue_receive(dialogue->control, NULL);
        assert_non_null(reply);
        assert_int_equal(reply->code, MENISCUS__CODE__OK);
        assert_int_equal(reply->values->n_values, 2);
        assert_true(reply->values->values[0]->number == 100 + k);
        assert_true(reply->values->values[1]->number == (k % 2 ? 2 : 1));
        meniscus__reply__free_unpacked(reply, NULL);
    }
    steer_accepted(dialogue_receive(dialogue->control, NULL));
    assert_true(steer_get(dialogue, "end_time") == 1000);
}

static void a_daemon_has_threads_for_cases_that_do_not_say(void **state)
{
    (void)state;
    Dialogue dialogue;
    static const char *const options[] = {"--threads", "2", NULL}, *const own[] = {"threads=1", NULL};
    dialogue_begin(&dialogue, options);
    dialogue_load(&dialogue, own);
    assert_true(steer_get(&dialogue, "threads") == 1);
    send_large_load(dialogue.control, "resolution=10");
    steer_accepted(dialogue_receive(dialogue.control, NULL));
    assert_true(steer_get(&dialogue, "threads") == 2);
    assert_int_equal(dialogue_end(&dialogue), 0);
}

static void options_of_the_scheme_out_of_bounds_are_refused_with_the_bounds(void **state)
{
    Dialogue *dialogue = *state;
    dialogue_load(dialogue, NULL);
    steer_accepted(steer_set(dialogue, "scheme.cfl", "0.2"));
    steer_refused(steer_set(dialogue, "scheme.cfl", "7"), MENISCUS__CODE__INVALID_ARGUMENT, "[1e-3, 1]");
    steer_refused(steer_set(dialogue, "scheme.riemann.limiter", "-1"), MENISCUS__CODE__INVALID_ARGUMENT, "[0, 100]");
}

/* --- clients that die, and loads that take long -------------------------------------------------------------------------- */

/* A process of its own that asks for something long and is killed in the middle of it. */
static void die_in_the_middle(Dialogue *dialogue)
{
    const pid_t child = fork();
    if (child == 0) {
        Dialogue own = *dialogue;
        uint8_t id[16];
        own.context = zmq_ctx_new();
        own.control = dialogue_connect(&own);
        steer_say_until(own.control, 500, id);
        dialogue_receive(own.control, NULL);
        _exit(1);
    }
    steer_wait_for(dialogue, MENISCUS__STATE__RUNNING);
    kill(child, SIGKILL);
    int how;
    waitpid(child, &how, 0);
    assert_true(WIFSIGNALED(how));
}

static void a_client_killed_in_the_middle_leaves_the_daemon_to_others(void **state)
{
    Dialogue *dialogue = *state;
    const char *sanitizer = getenv("MENISCUS_SANITIZED");
    if (sanitizer && !strcmp(sanitizer, "thread")) skip(); /* which allows no threads after a fork */
    dialogue_load(dialogue, NULL);
    die_in_the_middle(dialogue);
    Meniscus__Reply *reply = steer_status(dialogue);
    assert_int_equal(reply->status->state, MENISCUS__STATE__RUNNING);
    meniscus__reply__free_unpacked(reply, NULL);
    Meniscus__Request request = dialogue_pause();
    assert_int_equal(dialogue_code(dialogue, &request), MENISCUS__CODE__OK);
}

static void status_is_answered_while_particles_are_placed(void **state)
{
    Dialogue *dialogue = *state;
    void *loader = dialogue_connect(dialogue);
    int loading = 0;
    bool ready = false;
    send_large_load(loader, "resolution=60");
    for (const double until = steer_now() + 180; !ready && steer_now() < until;) { /* sanitizers on a busy machine */
        Meniscus__Reply *reply = steer_status(dialogue);
        loading += reply->status->state == MENISCUS__STATE__LOADING;
        ready = reply->status->state == MENISCUS__STATE__READY;
        meniscus__reply__free_unpacked(reply, NULL);
        nanosleep(&(struct timespec){.tv_nsec = 2000000}, NULL);
    }
    assert_true(ready);
    assert_true(loading >= 10); /* one at most if they waited for the particles */
    Meniscus__Reply *reply = dialogue_receive(loader, NULL);
    steer_accepted(reply);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_breakpoint_in_time_pauses_at_the_first_step_after_it, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(a_condition_on_a_probe_pauses_when_it_comes_true, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(a_condition_that_is_no_formula_or_names_no_probe_is_refused, steer_begin,
                                        steer_end),
        cmocka_unit_test_setup_teardown(a_condition_that_is_a_number_is_refused, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(particles_of_a_box_are_those_of_a_snapshot, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(points_are_between_the_particles_around_them, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(threads_can_be_set_within_bounds, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(each_change_is_answered_with_its_own_values_whatever_follows, steer_begin,
                                        steer_end),
        cmocka_unit_test(a_daemon_has_threads_for_cases_that_do_not_say),
        cmocka_unit_test_setup_teardown(options_of_the_scheme_out_of_bounds_are_refused_with_the_bounds, steer_begin,
                                        steer_end),
        cmocka_unit_test_setup_teardown(a_client_killed_in_the_middle_leaves_the_daemon_to_others, steer_begin,
                                        steer_end),
        cmocka_unit_test_setup_teardown(status_is_answered_while_particles_are_placed, steer_begin, steer_end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
