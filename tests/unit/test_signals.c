/* SPDX-License-Identifier: BSD-3-Clause */
/* What is asked for by signals, and when twice means twice. */
#include "base/clock.h"
#include "base/signals.h"
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <cmocka.h>

static int begin(void **state)
{
    static Signals signals;
    signals_catch(&signals);
    *state = &signals;
    return signals.fd < 0;
}

static int end(void **state)
{
    signals_done(*state);
    return 0;
}

static void without_a_signal_nothing_is_asked(void **state)
{
    assert_int_equal(signals_take(*state), SIGNAL_NOTHING);
}

static void a_checkpoint_can_be_asked_for_often(void **state)
{
    for (int k = 0; k < 3; k++) {
        raise(SIGUSR1);
        assert_int_equal(signals_take(*state), SIGNAL_CHECKPOINT);
    }
    assert_false(((Signals *)*state)->leaving);
}

/* At once is within half a second: where the machine took longer between the two, it is tried again. */
static void the_same_again_at_once_is_one_wish(void **state)
{
    SignalWish again = SIGNAL_INSIST;
    double took = 1;
    for (int k = 0; k < 100 && took > 0.5; k++) {
        assert_int_equal(end(state), 0);
        assert_int_equal(begin(state), 0);
        const double began = clock_now();
        raise(SIGTERM);
        assert_int_equal(signals_take(*state), SIGNAL_LEAVE);
        raise(SIGINT);
        again = signals_take(*state);
        took = clock_now() - began;
    }
    assert_int_equal(again, SIGNAL_NOTHING);
}

static void later_it_is_meant(void **state)
{
    raise(SIGINT);
    assert_int_equal(signals_take(*state), SIGNAL_LEAVE);
    nanosleep(&(struct timespec){.tv_nsec = 600000000}, NULL);
    raise(SIGINT);
    assert_int_equal(signals_take(*state), SIGNAL_INSIST);
}

static void a_terminal_that_closes_ends_it_unless_that_is_ignored(void **state)
{
    (void)state;
    for (int ignored = 0; ignored < 2; ignored++) {
        const pid_t child = fork();
        if (child == 0) {
            Signals signals;
            signal(SIGHUP, ignored ? SIG_IGN : SIG_DFL);
            signals_catch(&signals);
            raise(SIGHUP);
            _exit(signals_take(&signals) == (ignored ? SIGNAL_NOTHING : SIGNAL_LEAVE) ? 0 : 1);
        }
        int how = 1;
        assert_true(child > 0);
        assert_int_equal(waitpid(child, &how, 0), child);
        assert_int_equal(how, 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(without_a_signal_nothing_is_asked, begin, end),
        cmocka_unit_test_setup_teardown(a_checkpoint_can_be_asked_for_often, begin, end),
        cmocka_unit_test_setup_teardown(the_same_again_at_once_is_one_wish, begin, end),
        cmocka_unit_test_setup_teardown(later_it_is_meant, begin, end),
        cmocka_unit_test(a_terminal_that_closes_ends_it_unless_that_is_ignored),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
