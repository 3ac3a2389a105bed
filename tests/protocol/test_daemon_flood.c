/* SPDX-License-Identifier: BSD-3-Clause */
/* Whoever begins handshakes and ends none, as fast as a machine can, keeps nobody from steering: neither on the daemon's machine nor those
 * from afar who are let in already. What it costs is bounded, and given back. */
#include "tests/support/castle.h"
#include "tests/support/check.h"
#include "tests/support/flood.h"
#include "tests/support/steer.h"
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <zmq.h>

enum { RATE = 10000, NOT_SHUT_OUT_S = 8 };

static const double flood_s = 2;

static int count_descriptors(pid_t daemon)
{
    char path[64];
    snprintf(path, sizeof path, "/proc/%d/fd", (int)daemon);
    return steer_count(path, "");
}

static void assert_quick(void *socket, double most_s)
{
    const double began = steer_now();
    Meniscus__Reply *reply = castle_ask(socket, dialogue_status());
    assert_non_null(reply);
    assert_int_equal(reply->code, MENISCUS__CODE__OK);
    meniscus__reply__free_unpacked(reply, NULL);
    assert_less(steer_now() - began, most_s);
}

/* Who takes longer is not busy but shut out. */
static void ten_thousand_half_open_handshakes_a_second_keep_nobody_from_steering(void **state)
{
    Castle *castle = *state;
    void *far = castle_connect(castle, ZMQ_DEALER, &castle->operator);
    assert_quick(far, 20);
    const pid_t gate = castle_gate(castle, 0);
    const int before = count_descriptors(gate), daemon = count_descriptors(castle->dialogue.daemon);
    const pid_t attacker = fork();
    if (attacker == 0) {
        prctl(PR_SET_PDEATHSIG, SIGKILL);
        flood_handshakes(castle->port, RATE, 10 * flood_s);
        _exit(0);
    }
    int most = 0, asked = 0;
    for (const double until = steer_now() + flood_s; steer_now() < until; asked++) {
        assert_quick(castle->dialogue.control, NOT_SHUT_OUT_S);
        assert_quick(far, NOT_SHUT_OUT_S);
        const int now = count_descriptors(gate);
        if (now > most) most = now;
        steer_sleep(5);
    }
    kill(attacker, SIGKILL);
    waitpid(attacker, NULL, 0);
    print_message("%d rounds, %d descriptors before, %d at most\n", asked, before, most);
    assert_true(asked > 2);
    assert_true(most > before + 20);                                        /* it was an attack */
    assert_true(count_descriptors(castle->dialogue.daemon) <= daemon + 10); /* and not on the daemon */
    assert_quick(castle_connect(castle, ZMQ_DEALER, &castle->viewer), 30);
    for (int k = 0; k < 100 && count_descriptors(gate) > before + 10; k++) steer_sleep(100);
    assert_true(count_descriptors(gate) <= before + 10);
    assert_int_equal(castle_gate(castle, 0), gate);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(ten_thousand_half_open_handshakes_a_second_keep_nobody_from_steering,
                                        castle_begin, castle_end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
