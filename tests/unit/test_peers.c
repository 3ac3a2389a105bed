/* SPDX-License-Identifier: BSD-3-Clause */
/* Where there are too many connections, the process that has most of them loses one that says nothing. */
#include "net/peers.h"
#include "tests/support/check.h"
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

enum { PAIRS = 8, FILES = 1024, LARGE = 1001, SMALL = 1002, NEW = 1003 };

static int near_ends[PAIRS], far_ends[PAIRS];

static int begin(void **state)
{
    (void)state;
    peers_begin(FILES);
    for (int k = 0; k < PAIRS; k++) {
        int ends[2];
        if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, ends)) return 1;
        near_ends[k] = ends[0];
        far_ends[k] = ends[1];
    }
    return 0;
}

static int end(void **state)
{
    (void)state;
    for (int k = 0; k < PAIRS; k++) {
        if (near_ends[k] >= 0) close(near_ends[k]);
        close(far_ends[k]);
    }
    peers_begin(0);
    return 0;
}

static bool is_ended(int k)
{
    char byte;
    return recv(far_ends[k], &byte, 1, 0) == 0;
}

static void wait_for_a_word(void)
{
    nanosleep(&(struct timespec){.tv_nsec = 300000000}, NULL);
}

static void the_process_with_most_loses_the_first_that_never_spoke(void **state)
{
    (void)state;
    peers_add(near_ends[0], SMALL);
    for (int k = 1; k < 4; k++) peers_add(near_ends[k], LARGE);
    peers_heard(near_ends[1]);
    assert_true(peers_make_room(NEW));
    assert_true(is_ended(2));
    assert_false(is_ended(0) || is_ended(1) || is_ended(3));
    int n;
    assert_int_equal(peers_largest(&n), LARGE);
    assert_int_equal(n, 2);
    assert_true(peers_make_room(NEW));
    assert_true(is_ended(3));
}

static void the_process_with_most_gets_no_more(void **state)
{
    (void)state;
    for (int k = 0; k < 3; k++) peers_add(near_ends[k], LARGE);
    peers_add(near_ends[3], SMALL);
    wait_for_a_word();
    assert_false(peers_make_room(LARGE));
    assert_true(peers_make_room(SMALL));
    assert_true(is_ended(0));
}

static void of_processes_alike_the_one_that_is_silent_longest_goes(void **state)
{
    (void)state;
    for (int k = 0; k < 3; k++) peers_add(near_ends[k], LARGE + k);
    assert_false(peers_make_room(4711)); /* each still has time for its first word */
    wait_for_a_word();
    peers_add(near_ends[3], 4712);
    peers_heard(near_ends[0]);
    assert_true(peers_make_room(4711));
    assert_true(is_ended(1));
    assert_false(is_ended(0) || is_ended(2) || is_ended(3));
}

static void http_and_the_others_keep_their_places(void **state)
{
    (void)state;
    peers_add(near_ends[0], SMALL);
    for (int k = 1; k < 5; k++) peers_add(near_ends[k], PEER_HTTP);
    wait_for_a_word();
    assert_true(peers_make_room(NEW));
    assert_true(is_ended(0));
    assert_true(peers_make_room(PEER_HTTP));
    assert_true(is_ended(1));
    assert_false(is_ended(2));
}

static void what_is_closed_is_counted_no_more(void **state)
{
    (void)state;
    for (int k = 0; k < 3; k++) peers_add(near_ends[k], LARGE);
    assert_int_equal(peers_beyond(-1), 3);
    close(near_ends[1]);
    near_ends[1] = -1;
    assert_int_equal(peers_beyond(-1), 2);
    int n;
    peers_largest(&n);
    assert_int_equal(n, 2);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, begin, end)

int main(void)
{
    const struct CMUnitTest peers[] = {
        TEST(the_process_with_most_loses_the_first_that_never_spoke), TEST(the_process_with_most_gets_no_more),
        TEST(of_processes_alike_the_one_that_is_silent_longest_goes), TEST(http_and_the_others_keep_their_places),
        TEST(what_is_closed_is_counted_no_more)};
    return cmocka_run_group_tests(peers, NULL, NULL);
}
