/* SPDX-License-Identifier: BSD-3-Clause */
/* Locks of files. */
#include "run/lock.h"
#include "tests/support/check.h"
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

static char place[64], path[80];

static int begin(void **state)
{
    (void)state;
    snprintf(place, sizeof place, "/tmp/mns-lock-XXXXXX");
    assert_non_null(mkdtemp(place));
    snprintf(path, sizeof path, "%s/lock", place);
    return 0;
}

static int end(void **state)
{
    (void)state;
    unlink(path);
    return rmdir(place);
}

static void who_comes_second_hears_who_came_first(void **state)
{
    (void)state;
    MnsError error;
    char holder[LOCK_HOLDER] = "", who[32];
    int fd, other = -7;
    assert_int_equal(lock_take(path, &fd, holder, &error), MNS_OK);
    assert_int_equal(lock_take(path, &other, holder, &error), MNS_E_STATE);
    assert_int_equal(other, -7);
    snprintf(who, sizeof who, "process %d on ", (int)getpid());
    assert_memory_equal(holder, who, strlen(who));
    assert_non_null(strstr(error.text, path));
    assert_false(lock_is_leaving(holder));
    lock_leave(fd);
    assert_int_equal(lock_take(path, &other, holder, &error), MNS_E_STATE);
    assert_memory_equal(holder, who, strlen(who));
    assert_true(lock_is_leaving(holder));
    close(fd);
    assert_int_equal(lock_take(path, &fd, holder, &error), MNS_OK);
    close(fd);
}

static void a_killed_process_holds_nothing(void **state)
{
    (void)state;
    MnsError error;
    char holder[LOCK_HOLDER];
    int fd, ready[2], how;
    assert_int_equal(pipe(ready), 0);
    const pid_t child = fork();
    if (!child) {
        if (!lock_take(path, &fd, holder, &error) && write(ready[1], "x", 1) == 1) pause();
        _exit(1);
    }
    assert_int_equal(read(ready[0], holder, 1), 1);
    assert_int_equal(lock_take(path, &fd, holder, &error), MNS_E_STATE);
    assert_int_equal(kill(child, SIGKILL), 0);
    assert_int_equal(waitpid(child, &how, 0), child);
    assert_int_equal(lock_take(path, &fd, holder, &error), MNS_OK);
    close(fd);
    close(ready[0]);
    close(ready[1]);
}

static void a_lock_that_cannot_be_made_names_its_place(void **state)
{
    (void)state;
    MnsError error;
    char holder[LOCK_HOLDER];
    int fd;
    assert_int_equal(lock_take("/dev/null/lock", &fd, holder, &error), MNS_E_IO);
    assert_non_null(strstr(error.text, "/dev/null/lock"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(who_comes_second_hears_who_came_first, begin, end),
        cmocka_unit_test_setup_teardown(a_killed_process_holds_nothing, begin, end),
        cmocka_unit_test(a_lock_that_cannot_be_made_names_its_place),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
