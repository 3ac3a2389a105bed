/* SPDX-License-Identifier: BSD-3-Clause */
/* How a daemon leaves: its last reply reaches whoever asked, and nobody who does not hang up can keep it. */
#include "tests/support/check.h"
#include "tests/support/steer.h"
#include <signal.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>
#include <zmq.h>

/* A connection such as clients make to notice a lost daemon: with it ZeroMQ drops what was received and not yet read. */
static void *connect_impatiently(Dialogue *dialogue)
{
    const int yes = 1, patience = 5000;
    void *socket = dialogue_socket(dialogue, ZMQ_DEALER);
    zmq_setsockopt(socket, ZMQ_IMMEDIATE, &yes, sizeof yes);
    zmq_setsockopt(socket, ZMQ_RCVTIMEO, &patience, sizeof patience);
    assert_int_equal(zmq_connect(socket, dialogue->endpoint), 0);
    return socket;
}

static void send_shutdown(void *socket)
{
    uint8_t id[16];
    Meniscus__Request request = dialogue_shutdown();
    dialogue_say(socket, &request, id);
}

/* Look once, as clients do, then be busy with something else. */
static void look_away(void *socket, long milliseconds)
{
    zmq_pollitem_t item = {.socket = socket, .events = ZMQ_POLLIN};
    zmq_poll(&item, 1, 0);
    nanosleep(&(struct timespec){.tv_nsec = 1000000 * milliseconds}, NULL);
}

static void assert_shutdown_right_after_stop_is_answered(Dialogue *dialogue, long slowness_ms)
{
    Meniscus__Request start = dialogue_start(), end_run = dialogue_stop();
    dialogue_load(dialogue, NULL);
    assert_int_equal(dialogue_code(dialogue, &start), MENISCUS__CODE__OK);
    assert_int_equal(dialogue_code(dialogue, &end_run), MENISCUS__CODE__OK);
    dialogue_hang_up(dialogue);
    void *socket = connect_impatiently(dialogue);
    send_shutdown(socket);
    look_away(socket, slowness_ms);
    Meniscus__Reply *reply = dialogue_receive(socket, NULL);
    assert_non_null(reply);
    assert_int_equal(reply->code, MENISCUS__CODE__OK);
    meniscus__reply__free_unpacked(reply, NULL);
    assert_int_equal(dialogue_join(dialogue), 0);
}

static void the_reply_to_shutdown_reaches_clients_quick_and_slow(void **state)
{
    (void)state;
    for (long k = 0; k < 20; k++) {
        Dialogue dialogue;
        dialogue_begin(&dialogue, NULL);
        assert_shutdown_right_after_stop_is_answered(&dialogue, k % 5 * 25);
        dialogue_end(&dialogue);
    }
}

/* Somebody else's wait ends with the daemon, and they hear of it. */
static void who_waits_is_told_before_the_daemon_leaves(void **state)
{
    Dialogue *dialogue = *state;
    uint8_t id[16];
    void *waiting = connect_impatiently(dialogue), *other = connect_impatiently(dialogue);
    dialogue_load(dialogue, NULL);
    steer_say_wait_for(waiting, MENISCUS__STATE__DONE, id);
    assert_int_equal(steer_code(dialogue, dialogue_status()), MENISCUS__CODE__OK);
    look_away(waiting, 0);
    send_shutdown(other);
    look_away(other, 100);
    Meniscus__Reply *reply = dialogue_receive(waiting, NULL);
    assert_non_null(reply);
    assert_memory_equal(reply->id.data, id, sizeof id);
    assert_int_equal(reply->code, MENISCUS__CODE__UNAVAILABLE);
    meniscus__reply__free_unpacked(reply, NULL);
}

static void nobody_keeps_a_daemon_by_not_hanging_up(void **state)
{
    Dialogue *dialogue = *state;
    for (size_t k = 0; k < 20; k++) dialogue_connect(dialogue);
    Meniscus__Request request = dialogue_status();
    assert_int_equal(dialogue_code(dialogue, &request), MENISCUS__CODE__OK);
    const double asked = steer_now();
    send_shutdown(dialogue->control);
    assert_int_equal(dialogue_join(dialogue), 0);
    assert_less(steer_now() - asked, 30); /* half a second is given to who has not read the answer */
}

/* Though the simulation is gone when it is answered. */
static void the_answer_to_a_shutdown_says_where_the_run_was(void **state)
{
    (void)state;
    Dialogue dialogue;
    dialogue_begin(&dialogue, NULL);
    dialogue_load(&dialogue, NULL);
    steer_go(&dialogue, 3);
    Meniscus__Request request = dialogue_shutdown();
    Meniscus__Reply *reply = dialogue_ask(&dialogue, &request);
    assert_non_null(reply);
    assert_int_equal(reply->state, MENISCUS__STATE__STOPPING);
    assert_int_equal(reply->step, 3);
    assert_true(reply->time > 0);
    meniscus__reply__free_unpacked(reply, NULL);
    dialogue_end(&dialogue);
}

/* Also while the first writes its checkpoint: what is answered to the second is no fault of the daemon's. */
static void who_sends_away_a_daemon_that_leaves_changes_nothing_of_how_it_ends(void **state)
{
    (void)state;
    static const char *const fine[] = {"resolution=60", NULL};
    for (int k = 0; k < 6; k++) {
        Dialogue dialogue;
        dialogue_begin(&dialogue, NULL);
        dialogue_load(&dialogue, fine);
        Meniscus__Request first = dialogue_shutdown(), second = first;
        Meniscus__Shutdown keep = MENISCUS__SHUTDOWN__INIT;
        uint8_t ids[2][16];
        keep.has_checkpoint = keep.checkpoint = true;
        first.shutdown = &keep;
        dialogue_say(dialogue.control, &first, ids[0]);
        if (k % 2) dialogue_say(dialogue.control, &second, ids[1]);
        else kill(dialogue.daemon, SIGTERM);
        assert_int_equal(dialogue_join(&dialogue), 0);
        dialogue_end(&dialogue);
    }
}

/* It answers before it is gone, as somebody may be slow to hear of it; who starts the next at once is not refused for that. */
static void the_next_daemon_waits_for_one_that_leaves(void **state)
{
    (void)state;
    Dialogue dialogue;
    dialogue_begin(&dialogue, NULL);
    for (size_t k = 0; k < 5; k++) {
        dialogue_connect(&dialogue);
        dialogue_load(&dialogue, NULL);
        Meniscus__Request request = dialogue_shutdown();
        assert_int_equal(dialogue_code(&dialogue, &request), MENISCUS__CODE__OK);
        const pid_t first = dialogue.daemon;
        dialogue_again(&dialogue, NULL);
        request = dialogue_status();
        assert_int_equal(dialogue_code(&dialogue, &request), MENISCUS__CODE__OK);
        assert_int_equal(waitpid(dialogue.daemon, NULL, WNOHANG), 0);
        assert_int_equal(waitpid(first, NULL, 0), first);
    }
    assert_int_equal(dialogue_end(&dialogue), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_reply_to_shutdown_reaches_clients_quick_and_slow),
        cmocka_unit_test(the_answer_to_a_shutdown_says_where_the_run_was),
        cmocka_unit_test(the_next_daemon_waits_for_one_that_leaves),
        cmocka_unit_test(who_sends_away_a_daemon_that_leaves_changes_nothing_of_how_it_ends),
        cmocka_unit_test_setup_teardown(who_waits_is_told_before_the_daemon_leaves, steer_begin, steer_end_somehow),
        cmocka_unit_test_setup_teardown(nobody_keeps_a_daemon_by_not_hanging_up, steer_begin, steer_end_somehow),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
