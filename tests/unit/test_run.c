/* SPDX-License-Identifier: BSD-3-Clause */
/* A whole run without sockets: what is ordered is answered, what is given up leaves nothing behind. */
#include "base/clock.h"
#include "common/case/file.h"
#include "run/history.h"
#include "run/run.h"
#include "tests/support/check.h"
#include "tests/support/io_fixture.h"
#include <omp.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

/* A run, and an order that goes there and back. */
typedef struct Bench {
    Order order; /* first, so that the order is the bench */
    Run *run;
    char *home;
    CaseFile *file;
    Note *answer;
    const Meniscus__Request *request; /* of the orders to come, for the journal; or NULL */
    int events, log_lines;            /* before the answer */
    char logged[640];                 /* the last line     */
} Bench;

static Note *next_note(const Bench *bench)
{
    struct pollfd wake = {.fd = run_outbox(bench->run)->wake, .events = POLLIN};
    for (;;) {
        Note *note = outbox_take(run_outbox(bench->run));
        if (note) return note;
        if (poll(&wake, 1, 60000) < 1) fail_msg("no answer in a minute");
    }
}

/* Have the runner serve an order, and wait for its answer. */
static MnsStatus perform(Bench *bench, void (*serve)(Run *run, Order *order))
{
    document_leave(bench->order.document);
    bench->order = (Order){.serve = serve, .deadline = INFINITY, .request = bench->request};
    bench->events = bench->log_lines = 0;
    assert_int_equal(run_post(bench->run, &bench->order, NULL), MNS_OK);
    for (;;) {
        Note *note = next_note(bench);
        if (note->kind == NOTE_ANSWER) {
            assert_ptr_equal(note->order, &bench->order);
            bench->answer = note;
            return bench->order.status;
        }
        bench->events += note->kind == NOTE_EVENT;
        bench->log_lines += note->kind == NOTE_LOG;
        if (note->kind == NOTE_LOG) snprintf(bench->logged, sizeof bench->logged, "%s", note->text);
        note_free(note);
    }
}

static void load(Run *run, Order *order)
{
    const RunLoad what = {.message = case_file_message(((Bench *)order)->file), .name = "small"};
    run_load(run, order, &what);
}

static void leave(Run *run, Order *order)
{
    run_leave(run, order, false);
}

static int begin(void **state)
{
    static const char *const settings[] = {"resolution=8", "end_time=0.05", "threads=1"};
    Bench *bench = calloc(1, sizeof *bench);
    if (!bench) return 1;
    *state = bench;
    bench->home = scratch_new();
    if (case_file_read("server/cases/dambreak2d.yaml", &bench->file, NULL)) return 1;
    for (size_t k = 0; k < sizeof settings / sizeof *settings; k++)
        if (case_file_set(bench->file, settings[k], NULL)) return 1;
    const RunOptions options = {.parent = bench->home};
    return (int)run_new(&options, &bench->run, NULL);
}

static int end(void **state)
{
    Bench *bench = *state;
    limit_files(SIZE_MAX);
    perform(bench, leave);
    run_join(bench->run);
    run_free(bench->run);
    case_file_free(bench->file);
    scratch_free(bench->home);
    free(bench);
    return 0;
}

/* A full disk has been seen before; else a crash would lead back to the run before this one. */
static void a_run_that_cannot_be_noted_as_the_current_one_leaves_none_noted(void **state)
{
    Bench *bench = *state;
    static Meniscus__Request request = MENISCUS__REQUEST__INIT;
    static Meniscus__Load message = MENISCUS__LOAD__INIT;
    char *current = path_in(bench->home, "current"), *in_the_way = path_in(bench->home, "current.tmp");
    request.command_case = MENISCUS__REQUEST__COMMAND_LOAD;
    request.load = &message;
    bench->request = &request;
    assert_int_equal(perform(bench, load), MNS_OK);
    assert_true(exists(current));
    assert_int_equal(mkdir(in_the_way, 0700), 0);
    assert_int_equal(perform(bench, load), MNS_E_IO);
    assert_true(exists(current));
    assert_int_equal(rmdir(in_the_way), 0);
    assert_int_equal(unlink(current), 0);
    assert_int_equal(mkdir(current, 0700), 0);
    assert_int_equal(perform(bench, load), MNS_E_IO);
    assert_non_null(strstr(bench->order.error.text, "would not find the run"));
    assert_int_equal(rmdir(current), 0);
    assert_int_equal(perform(bench, load), MNS_OK);
    assert_true(exists(current));
    bench->request = NULL;
    free(in_the_way);
    free(current);
}

/* Else it would be lost when there is none. */
static void an_answer_needs_no_memory_of_its_own(void **state)
{
    Bench *bench = *state;
    assert_int_equal(perform(bench, load), MNS_OK);
    const char *answer = (const char *)bench->answer, *order = (const char *)&bench->order;
    assert_true(answer >= order && answer + sizeof *bench->answer <= order + sizeof bench->order);
}

static void a_run_that_cannot_begin_leaves_no_directory(void **state)
{
    Bench *bench = *state;
    char *directory = path_in(bench->home, "small");
    limit_files(0);
    assert_int_equal(perform(bench, load), MNS_E_NO_SPACE);
    limit_files(SIZE_MAX);
    assert_int_equal(access(directory, F_OK), -1);
    assert_int_equal(perform(bench, load), MNS_OK);
    assert_string_equal(bench->order.path, directory);
    free(directory);
}

static void restore(Run *run, Order *order)
{
    run_restore(run, order, NULL);
}

static void states_are_events_and_warnings_are_lines_of_the_log(void **state)
{
    Bench *bench = *state;
    assert_int_equal(perform(bench, load), MNS_OK);
    assert_int_equal(bench->events, 2); /* loading, ready */
    assert_int_equal(bench->log_lines, 0);
    char *path = path_in(bench->order.path, "checkpoint-0000000000.hdf");
    put_bytes(path, "no HDF5", 7);
    free(path);
    assert_int_equal(perform(bench, restore), MNS_E_NOT_FOUND);
    assert_int_equal(bench->events, 0);
    assert_int_equal(bench->log_lines, 1);
    assert_non_null(strstr(bench->logged, "checkpoint-0000000000.hdf"));
}

static void step(Run *run, Order *order)
{
    run_step(run, order, 2);
}

static void write_checkpoint(Run *run, Order *order)
{
    run_checkpoint(run, order);
}

static void write_snapshot(Run *run, Order *order)
{
    run_snapshot(run, order, 0, NULL);
}

static void reset(Run *run, Order *order)
{
    run_reset(run, order);
}

/* A checkpoint of step 2, a snapshot of step 4, which a restore moves aside; here. */
static void go_beyond_a_checkpoint(Bench *bench, char here[static 4096])
{
    assert_int_equal(perform(bench, load), MNS_OK);
    memcpy(here, bench->order.path, sizeof bench->order.path);
    assert_int_equal(perform(bench, step), MNS_OK);
    assert_int_equal(perform(bench, write_checkpoint), MNS_OK);
    assert_int_equal(perform(bench, step), MNS_OK);
    assert_int_equal(perform(bench, write_snapshot), MNS_OK);
}

/* Whatever was in the way, the run can go on, and so can its files. */
static void assert_untouched(const Bench *bench, const char *here)
{
    RunStatus *status = malloc(sizeof *status);
    assert_non_null(status);
    run_status(bench->run, status);
    assert_int_equal(status->state, RUN_PAUSED);
    assert_int_equal(status->progress.step, 4);
    assert_string_equal(status->directory, here);
    free(status);
    assert_true(holds(here, "checkpoint-0000000002.hdf") && holds(here, "snapshot-0000000004.hdf"));
    assert_false(holds(here, "abandoned"));
}

/* Have it refused while a directory stands where a file is to be written, and done when that is gone. */
static void assert_refused_by(Bench *bench, const char *here, const char *name, void (*serve)(Run *run, Order *order))
{
    char *path = path_in(here, name);
    assert_int_equal(mkdir(path, 0777), 0);
    assert_int_equal(perform(bench, serve), MNS_E_IO);
    assert_non_null(strstr(bench->order.error.text, name));
    assert_untouched(bench, here);
    assert_int_equal(rmdir(path), 0);
    free(path);
}

static void a_refused_way_back_leaves_the_run_and_its_files_as_they_were(void **state)
{
    Bench *bench = *state;
    char here[4096];
    go_beyond_a_checkpoint(bench, here);
    assert_refused_by(bench, here, "case.yaml.tmp", reset);
    assert_refused_by(bench, here, "case.yaml.tmp", restore);
    assert_refused_by(bench, here, "snapshots.hdf.series.tmp", restore);
    assert_int_equal(perform(bench, restore), MNS_OK);
    assert_int_equal(bench->order.effect_step, 2);
    assert_true(holds(here, "abandoned"));
}

static void a_damaged_series_refuses_a_restore_and_the_run_stays(void **state)
{
    Bench *bench = *state;
    char here[4096];
    go_beyond_a_checkpoint(bench, here);
    char *series = path_in(here, "probes.hdf");
    put_bytes(series, "no HDF5", 7);
    assert_int_equal(perform(bench, restore), MNS_E_CORRUPT);
    assert_untouched(bench, here);
    assert_int_equal(unlink(series), 0);
    assert_int_equal(perform(bench, restore), MNS_OK);
    free(series);
}

/* Another run would go to another directory, where there is no room. */
static void a_full_disk_refuses_a_load_and_the_run_stays(void **state)
{
    Bench *bench = *state;
    char here[4096];
    go_beyond_a_checkpoint(bench, here);
    limit_files(0);
    assert_int_equal(perform(bench, load), MNS_E_NO_SPACE);
    limit_files(SIZE_MAX);
    assert_untouched(bench, here);
    assert_int_equal(perform(bench, step), MNS_OK);
    assert_int_equal(bench->order.effect_step, 6);
    assert_false(holds(bench->home, "small.2"));
}

static void go(Run *run, Order *order)
{
    run_go(run, order);
}

static void await_a_step(Run *run, Order *order)
{
    run_wait(run, order, &(RunWait){.t = INFINITY, .step = 1});
}

/* What others see right after an order was answered, and whether that is the hash of the state. */
typedef struct Sight {
    RunStatus status;
    bool is_hash;
} Sight;
static Sight sight;

static void look(Run *run)
{
    run_status(run, &sight.status);
    sight.is_hash = sight.status.hash == mns_sim_hash(run_sim(run));
}

static void pause_and_look(Run *run, Order *order)
{
    run_pause(run, order);
    look(run);
}

static void only_look(Run *run, Order *order)
{
    look(run);
    run_answer(run, order, MNS_OK, NULL);
}

static void set_and_look(Run *run, Order *order)
{
    Meniscus__Assignment made[] = {MENISCUS__ASSIGNMENT__INIT, MENISCUS__ASSIGNMENT__INIT};
    Meniscus__Set set = MENISCUS__SET__INIT;
    made[0].path = "gravity", made[0].value = "[0.5, -2]";
    made[1].path = "scheme.cfl", made[1].value = "0.1";
    set.n_assignments = 2;
    set.assignments = (Meniscus__Assignment *[]){&made[0], &made[1]};
    run_set(run, order, &set);
    look(run);
}

/* What it saw is read when another order has come back, as the runner looks after the answer. */
static void a_pause_is_answered_before_the_state_is_hashed(void **state)
{
    Bench *bench = *state;
    assert_int_equal(case_file_set(bench->file, "end_time=50", NULL), MNS_OK);
    assert_int_equal(perform(bench, load), MNS_OK);
    assert_int_equal(perform(bench, go), MNS_OK);
    assert_int_equal(perform(bench, await_a_step), MNS_OK); /* until then the hash is known */
    assert_int_equal(perform(bench, pause_and_look), MNS_OK);
    assert_int_equal(perform(bench, write_checkpoint), MNS_OK);
    assert_true(sight.status.hash == 0 && sight.status.hash_due);
    assert_int_equal(perform(bench, only_look), MNS_OK);
    assert_true(sight.is_hash && !sight.status.hash_due);
}

static void set_the_end_and_look(Run *run, Order *order)
{
    Meniscus__Assignment end = MENISCUS__ASSIGNMENT__INIT;
    Meniscus__Set set = MENISCUS__SET__INIT;
    end.path = "end_time", end.value = "60";
    set.n_assignments = 1;
    set.assignments = (Meniscus__Assignment *[]){&end};
    run_set(run, order, &set);
    look(run);
}

/* Rates are of the state: what pushes otherwise from now on has another. */
static void a_change_of_what_pushes_has_a_hash_of_its_own(void **state)
{
    Bench *bench = *state;
    assert_int_equal(perform(bench, load), MNS_OK);
    assert_int_equal(perform(bench, step), MNS_OK);
    assert_int_equal(perform(bench, set_the_end_and_look), MNS_OK);
    assert_int_equal(perform(bench, write_checkpoint), MNS_OK);
    assert_true(sight.is_hash && !sight.status.hash_due);
    const uint64_t before = sight.status.hash;
    assert_int_equal(perform(bench, set_and_look), MNS_OK);
    assert_int_equal(perform(bench, only_look), MNS_OK);
    assert_int_equal(perform(bench, write_checkpoint), MNS_OK);
    assert_true(sight.is_hash && !sight.status.hash_due && sight.status.hash != before);
}

/* As OpenMP may be told to use fewer than there are processors. */
static void load_with_three(Run *run, Order *order)
{
    omp_set_num_threads(3);
    load(run, order);
}

static void threads_are_counted_as_the_solver_does(void **state)
{
    Bench *bench = *state;
    RunStatus *status = malloc(sizeof *status);
    assert_non_null(status);
    assert_int_equal(case_file_set(bench->file, "threads=0", NULL), MNS_OK);
    assert_int_equal(perform(bench, load_with_three), MNS_OK);
    run_status(bench->run, status);
    assert_int_equal(status->threads, 3);
    free(status);
}

static Meniscus__Lease lease_message = MENISCUS__LEASE__INIT;
static Meniscus__Request lease_request = MENISCUS__REQUEST__INIT;

static void take_lease(Run *run, Order *order)
{
    run_lease(run, order, &(LeaseWish){.ttl_ms = 60000, .holder = "anna"});
}

static double lease_left(const Bench *bench)
{
    RunStatus *status = malloc(sizeof *status);
    assert_non_null(status);
    run_status(bench->run, status);
    const double left = status->lease.until - clock_now();
    free(status);
    return left;
}

/* Of how many leases the journal says that somebody was told, of `ret_n`. */
static size_t told_in_journal(const Bench *bench, size_t *ret_n)
{
    History history;
    size_t told = 0;
    char boot[HISTORY_BOOT], *directory = path_in(bench->home, "small");
    *ret_n = 0;
    history_boot(boot);
    assert_int_equal(strlen(boot), 36);
    assert_int_equal(history_read(directory, &history, NULL), MNS_OK);
    for (size_t k = 0; k < history.n; k++) {
        const Meniscus__Request *request = history.records[k].message->request;
        const bool lease = request && request->command_case == MENISCUS__REQUEST__COMMAND_LEASE;
        *ret_n += lease;
        told += lease && !history_untold(&history, k, boot);
    }
    history_done(&history);
    free(directory);
    return told;
}

/* Its holder was told that there is none. */
static void a_lease_that_the_journal_refuses_is_nobodys(void **state)
{
    Bench *bench = *state;
    size_t n;
    assert_int_equal(perform(bench, load), MNS_OK);
    lease_request.command_case = MENISCUS__REQUEST__COMMAND_LEASE;
    lease_request.lease = &lease_message;
    bench->request = &lease_request;
    limit_files(0);
    assert_int_equal(perform(bench, take_lease), MNS_E_NO_SPACE);
    assert_true(lease_left(bench) <= 0);
    limit_files(SIZE_MAX);
    bench->request = NULL;
    assert_int_equal(perform(bench, go), MNS_OK); /* tries the journal again */
    bench->request = &lease_request;
    assert_int_equal(perform(bench, take_lease), MNS_OK);
    assert_true(lease_left(bench) > 50);
    assert_int_equal(told_in_journal(bench, &n), 1); /* of the first nobody, and no crash makes it somebody's */
    assert_int_equal(n, 2);
    limit_files(0);
    assert_int_equal(perform(bench, take_lease), MNS_E_HELD);
    limit_files(SIZE_MAX);
    bench->request = NULL;
}

static void give_lease_back(Run *run, Order *order)
{
    RunStatus *status = malloc(sizeof *status);
    assert_non_null(status);
    run_status(run, status);
    run_lease(run, order, &(LeaseWish){.epoch = status->lease.epoch, .release = true});
    free(status);
}

/* Else the one record of all that is to be done again would be too large. */
static void what_a_way_back_has_to_tell_is_bounded(void **state)
{
    enum { MIB = 1 << 20 };
    Bench *bench = *state;
    static char padding[MIB];
    Meniscus__Request large = MENISCUS__REQUEST__INIT;
    Meniscus__Lease lease = MENISCUS__LEASE__INIT;
    memset(padding, 'x', sizeof padding - 1);
    lease.holder = padding;
    large.command_case = MENISCUS__REQUEST__COMMAND_LEASE;
    large.lease = &lease;
    assert_int_equal(case_file_set(bench->file, "end_time=50", NULL), MNS_OK);
    assert_int_equal(case_file_set(bench->file, "output.checkpoint_interval=50", NULL), MNS_OK);
    assert_int_equal(perform(bench, load), MNS_OK);
    assert_int_equal(perform(bench, step), MNS_OK);
    bench->request = &large;
    int done = 0;
    while (done < 20 && !perform(bench, done % 2 ? give_lease_back : take_lease)) done++;
    assert_int_equal(bench->order.status, MNS_E_LIMIT);
    assert_in_range(done, 9, 11);
    bench->request = NULL;
    char *directory = path_in(bench->home, "small");
    char *name = path_in(directory, "checkpoint-0000000003.hdf");
    assert_false(exists(name));
    assert_int_equal(perform(bench, step), MNS_OK);
    bench->request = &large;
    assert_int_equal(perform(bench, done % 2 ? give_lease_back : take_lease), MNS_OK);
    bench->request = NULL;
    assert_int_equal(perform(bench, write_checkpoint), MNS_OK); /* and with it those before are written */
    assert_true(exists(name));
    free(name);
    free(directory);
}

/* Longer than a tenth of any step of these. */
static void look_long(Run *run, Order *order)
{
    nanosleep(&(struct timespec){.tv_nsec = 20000000}, NULL);
    run_answer(run, order, MNS_OK, NULL);
}

/* Post them all before the run looks; their answers come back in the order in which they are given. */
static void take_answers(const Bench *bench, size_t n, const Order **ret)
{
    for (size_t k = 0; k < n;) {
        Note *note = next_note(bench);
        if (note->kind == NOTE_ANSWER) ret[k++] = note->order;
        else note_free(note);
    }
}

/* Each takes longer than all may at one boundary. */
static void who_only_looks_does_not_hold_up_a_run_in_motion(void **state)
{
    enum { N = 20 };
    Bench *bench = *state;
    Order orders[N];
    const Order *answered[N];
    assert_int_equal(case_file_set(bench->file, "end_time=50", NULL), MNS_OK);
    assert_int_equal(perform(bench, load), MNS_OK);
    assert_int_equal(perform(bench, go), MNS_OK);
    for (size_t k = 0; k < N; k++) {
        orders[k] = (Order){.serve = look_long, .looks = true, .deadline = INFINITY};
        assert_int_equal(run_post(bench->run, &orders[k], NULL), MNS_OK);
    }
    take_answers(bench, N, answered);
    for (size_t k = 1; k < N; k++) assert_true(orders[k].effect_step > orders[k - 1].effect_step);
}

static void await_a_case(Run *run, Order *order)
{
    run_wait(run, order, &(RunWait){.states = 1 << RUN_READY, .t = INFINITY, .step = UINT64_MAX});
}

static void of_too_many_who_wait_the_first_is_let_go(void **state)
{
    enum { WAITERS = 1024, BEYOND = 3 };
    Bench *bench = *state;
    static Order orders[WAITERS + BEYOND];
    const Order *answered[WAITERS + 1];
    for (size_t k = 0; k < WAITERS + BEYOND; k++) {
        orders[k] = (Order){.serve = await_a_case, .looks = true, .deadline = INFINITY};
        while (run_post(bench->run, &orders[k], NULL)) nanosleep(&(struct timespec){.tv_nsec = 100000}, NULL);
    }
    take_answers(bench, BEYOND, answered);
    for (size_t k = 0; k < BEYOND; k++) {
        assert_ptr_equal(answered[k], &orders[k]);
        assert_int_equal(orders[k].status, MNS_E_LIMIT);
    }
    bench->order = (Order){.serve = load, .deadline = INFINITY};
    assert_int_equal(run_post(bench->run, &bench->order, NULL), MNS_OK);
    take_answers(bench, WAITERS + 1, answered);
    for (size_t k = BEYOND; k < WAITERS + BEYOND; k++) assert_int_equal(orders[k].status, MNS_OK);
    assert_ptr_equal(answered[WAITERS], &bench->order);
}

static void rest(Run *run, Order *order)
{
    nanosleep(&(struct timespec){.tv_nsec = 100000000}, NULL);
    run_answer(run, order, MNS_OK, NULL);
}

static void stop(Run *run, Order *order)
{
    run_stop(run, order, false);
}

/* That its holder is told stands where the run was, and not behind its end, whatever is commanded at once. */
static void a_lease_is_settled_before_the_run_is_stopped(void **state)
{
    enum { N = 3 };
    Bench *bench = *state;
    static Meniscus__Request stop_request = MENISCUS__REQUEST__INIT;
    static Meniscus__Stop stop_message = MENISCUS__STOP__INIT;
    const Order *answered[N];
    History history;
    stop_request.command_case = MENISCUS__REQUEST__COMMAND_STOP;
    stop_request.stop = &stop_message;
    lease_request.command_case = MENISCUS__REQUEST__COMMAND_LEASE;
    lease_request.lease = &lease_message;
    assert_int_equal(perform(bench, load), MNS_OK);
    assert_int_equal(perform(bench, step), MNS_OK);
    Order orders[N] = {{.serve = rest, .deadline = INFINITY}, /* both of the others wait behind it */
                       {.serve = take_lease, .deadline = INFINITY, .request = &lease_request},
                       {.serve = stop, .deadline = INFINITY, .request = &stop_request}};
    for (size_t k = 0; k < N; k++) assert_int_equal(run_post(bench->run, &orders[k], NULL), MNS_OK);
    take_answers(bench, N, answered);
    char *directory = path_in(bench->home, "small");
    assert_int_equal(history_read(directory, &history, NULL), MNS_OK);
    const HistoryRecord *last = &history.records[history.n - 1];
    assert_int_equal(last[0].message->request->command_case, MENISCUS__REQUEST__COMMAND_STOP);
    assert_int_equal(last[-1].message->kind, MENISCUS__JOURNAL_RECORD__KIND__LEASE);
    assert_int_equal(last[-1].message->step, 2);
    assert_int_equal(last[-2].message->request->command_case, MENISCUS__REQUEST__COMMAND_LEASE);
    history_done(&history);
    free(directory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_run_that_cannot_be_noted_as_the_current_one_leaves_none_noted, begin, end),
        cmocka_unit_test_setup_teardown(an_answer_needs_no_memory_of_its_own, begin, end),
        cmocka_unit_test_setup_teardown(a_run_that_cannot_begin_leaves_no_directory, begin, end),
        cmocka_unit_test_setup_teardown(states_are_events_and_warnings_are_lines_of_the_log, begin, end),
        cmocka_unit_test_setup_teardown(a_refused_way_back_leaves_the_run_and_its_files_as_they_were, begin, end),
        cmocka_unit_test_setup_teardown(a_damaged_series_refuses_a_restore_and_the_run_stays, begin, end),
        cmocka_unit_test_setup_teardown(a_full_disk_refuses_a_load_and_the_run_stays, begin, end),
        cmocka_unit_test_setup_teardown(a_pause_is_answered_before_the_state_is_hashed, begin, end),
        cmocka_unit_test_setup_teardown(a_change_of_what_pushes_has_a_hash_of_its_own, begin, end),
        cmocka_unit_test_setup_teardown(threads_are_counted_as_the_solver_does, begin, end),
        cmocka_unit_test_setup_teardown(who_only_looks_does_not_hold_up_a_run_in_motion, begin, end),
        cmocka_unit_test_setup_teardown(of_too_many_who_wait_the_first_is_let_go, begin, end),
        cmocka_unit_test_setup_teardown(a_lease_that_the_journal_refuses_is_nobodys, begin, end),
        cmocka_unit_test_setup_teardown(what_a_way_back_has_to_tell_is_bounded, begin, end),
        cmocka_unit_test_setup_teardown(a_lease_is_settled_before_the_run_is_stopped, begin, end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
