/* SPDX-License-Identifier: BSD-3-Clause */
/* Files of keys: what is written is read again, and what others could have read or changed is refused. */
#include "common/wire/keys.h"
#include "tests/support/check.h"
#include "tests/support/io_fixture.h"
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#define ADA "rq:rM>}U?@Lns47E1%kR.o@n%FcmmsL/@{H8]yf7"
#define BEN "Yne@$w-vo<fVvi]a<NY6T1ed:M$fCG*[IaLV{hID"

static char *home;

static int begin(void **state)
{
    (void)state;
    home = scratch_new();
    return home ? 0 : 1;
}

static int end(void **state)
{
    (void)state;
    scratch_free(home);
    return 0;
}

static void place(const char *name, char ret[static 256])
{
    snprintf(ret, 256, "%s/%s", home, name);
}

static void put(const char *name, const char *text, mode_t mode)
{
    char path[256];
    place(name, path);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
    assert_int_equal(chmod(path, mode), 0);
}

static void assert_no_keys(MnsStatus status, const char *part)
{
    Keys keys = {.n = 7};
    MnsError error;
    assert_int_equal(keys_read(home, &keys, &error), status);
    if (!strstr(error.text, part)) fail_msg("\"%s\" does not say \"%s\"", error.text, part);
    assert_int_equal(keys.n, 7); /* untouched */
}

static void what_is_written_is_read_again_and_others_cannot_read_it(void **state)
{
    (void)state;
    Key list[] = {{"ada", ROLE_OPERATOR, ADA}, {"b.e-n_2", ROLE_VIEWER, BEN}};
    Keys keys;
    MnsError error;
    char path[256];
    struct stat info;
    assert_int_equal(keys_write(home, &(Keys){2, list}, &error), MNS_OK);
    place("authorized", path);
    assert_int_equal(stat(path, &info), 0);
    assert_int_equal(info.st_mode & 07777, 0600);
    assert_int_equal(keys_read(home, &keys, &error), MNS_OK);
    assert_int_equal(keys.n, 2);
    assert_string_equal(keys_find(&keys, BEN)->name, "b.e-n_2");
    assert_int_equal(keys_find(&keys, BEN)->role, ROLE_VIEWER);
    assert_string_equal(keys_named(&keys, "ada")->public_key, ADA);
    assert_null(keys_named(&keys, "Ada"));
    keys_done(&keys);
}

static void no_file_is_no_keys(void **state)
{
    (void)state;
    Keys keys = {.n = 7};
    MnsError error;
    assert_int_equal(keys_read(home, &keys, &error), MNS_OK);
    assert_int_equal(keys.n, 0);
}

static void files_that_others_can_reach_are_refused_and_the_sentence_says_what_to_do(void **state)
{
    (void)state;
    static const mode_t modes[] = {0644, 0640, 0620, 0601, 0604};
    for (size_t k = 0; k < sizeof modes / sizeof *modes; k++) {
        put("authorized", "ada operator " ADA "\n", modes[k]);
        assert_no_keys(MNS_E_STATE, "chmod 600");
    }
    put("authorized", "ada operator " ADA "\n", 0400);
    Keys keys;
    MnsError error;
    assert_int_equal(keys_read(home, &keys, &error), MNS_OK);
    keys_done(&keys);
}

static void a_long_comment_is_one_line(void **state)
{
    (void)state;
    static const char line[] = "\nada operator " ADA "\n";
    char text[1024] = "# ";
    memset(text + 2, 'x', 600);
    memcpy(text + 602, line, sizeof line);
    put("authorized", text, 0600);
    Keys keys;
    MnsError error;
    assert_int_equal(keys_read(home, &keys, &error), MNS_OK);
    assert_int_equal(keys.n, 1);
    keys_done(&keys);
}

static void a_directory_that_others_can_write_to_is_refused(void **state)
{
    (void)state;
    static const mode_t modes[] = {0777, 0770, 0702};
    put("authorized", "ada operator " ADA "\n", 0600);
    for (size_t k = 0; k < sizeof modes / sizeof *modes; k++) {
        assert_int_equal(chmod(home, modes[k]), 0);
        assert_no_keys(MNS_E_STATE, "chmod 700");
    }
    Keys keys;
    MnsError error;
    assert_int_equal(chmod(home, 0755), 0); /* to look is no harm: there is no secret in the names of files */
    assert_int_equal(keys_read(home, &keys, &error), MNS_OK);
    keys_done(&keys);
}

static void files_of_somebody_else_are_refused(void **state)
{
    (void)state;
    char path[256];
    if (geteuid()) return; /* only root can give files away */
    put("authorized", "ada operator " ADA "\n", 0600);
    place("authorized", path);
    assert_int_equal(chown(path, 4711, (gid_t)-1), 0);
    assert_no_keys(MNS_E_STATE, "belongs to user 4711");
}

static void what_is_no_file_is_not_waited_for(void **state)
{
    (void)state;
    char path[256];
    place("authorized", path);
    assert_int_equal(mkfifo(path, 0600), 0);
    assert_no_keys(MNS_E_STATE, "is no file");
}

static void a_wrong_line_is_named_and_lets_nobody_in(void **state)
{
    (void)state;
    static const char *const wrong[][2] = {
        {"ada operator " ADA "\nben viewer\n", "authorized:2: a line has"},
        {"# a comment\n\nada wizard " ADA "\n", "authorized:3: a role is"},
        {"ada viewer abc\n", "authorized:1: a public key"},
        {"ada viewer " ADA "x\n", "a public key"},
        {"../ada viewer " ADA "\n", "authorized:1: the name of a key"},
        {"local admin " ADA "\n", "taken"},
        {"daemon admin " ADA "\n", "taken"},
        {"ada viewer " ADA "\nada admin " BEN "\n", "authorized:2: the name, or the key"},
        {"ada viewer " ADA "\nben admin " ADA "\n", "authorized:2: the name, or the key"},
        {"ada viewer " ADA " more\n", "a line has"},
    };
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
        put("authorized", wrong[k][0], 0600);
        assert_no_keys(MNS_E_INVALID, wrong[k][1]);
    }
}

static void a_secret_file_has_both_keys_and_perhaps_the_daemons(void **state)
{
    (void)state;
    char path[KEYS_PATH];
    KeyPair pair = {ADA, BEN, ADA}, found = {.public_key = ""};
    MnsError error;
    struct stat info;
    key_path(home, "ada", path);
    assert_int_equal(key_file_read(path, &found, &error), MNS_E_NOT_FOUND);
    assert_int_equal(key_file_write(path, &pair, &error), MNS_OK);
    assert_int_equal(stat(path, &info), 0);
    assert_int_equal(info.st_mode & 07777, 0600);
    assert_int_equal(key_file_read(path, &found, &error), MNS_OK);
    assert_memory_equal(&found, &pair, sizeof pair);
    pair.server_key[0] = 0;
    assert_int_equal(key_file_write(path, &pair, &error), MNS_OK);
    assert_int_equal(key_file_read(path, &found, &error), MNS_OK);
    assert_string_equal(found.server_key, "");
    assert_int_equal(chmod(path, 0640), 0);
    assert_int_equal(key_file_read(path, &found, &error), MNS_E_STATE);
    put("ada.key", "public-key " ADA "\n", 0600);
    assert_int_equal(key_file_read(path, &found, &error), MNS_E_INVALID);
    assert_non_null(strstr(error.text, "secret-key"));
    put("ada.key", "public-key " ADA "\nsecret " BEN "\n", 0600);
    assert_int_equal(key_file_read(path, &found, &error), MNS_E_INVALID);
    assert_non_null(strstr(error.text, "ada.key:2"));
}

/* Whoever comes second waits for the first, also where the directory is not there yet. */
static void changes_are_made_one_after_the_other(void **state)
{
    (void)state;
    char directory[256];
    int lock, how;
    MnsError error;
    place("a/b", directory);
    assert_int_equal(keys_lock(directory, &lock, &error), MNS_OK);
    const pid_t other = fork();
    if (other == 0) {
        alarm(1); /* it is still waiting then */
        _exit(keys_lock(directory, &lock, &error) ? 1 : 2);
    }
    assert_int_equal(waitpid(other, &how, 0), other);
    assert_true(WIFSIGNALED(how));
    keys_unlock(lock);
    assert_int_equal(keys_lock(directory, &lock, &error), MNS_OK);
    keys_unlock(lock);
}

/* A limit on the size of files takes a part of what is written, as a disk does that fills up. */
static void a_disk_that_takes_a_part_is_told_and_the_old_keys_stay(void **state)
{
    (void)state;
    char path[256];
    struct rlimit before, small;
    KeyPair pair = {.public_key = ADA, .secret_key = BEN}, other = {.public_key = BEN, .secret_key = ADA}, read;
    MnsError error;
    place("part.key", path);
    assert_int_equal(key_file_write(path, &pair, &error), MNS_OK);
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    small = before;
    small.rlim_cur = 50;
    signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    errno = EACCES; /* of something else */
    const MnsStatus status = key_file_write(path, &other, &error);
    setrlimit(RLIMIT_FSIZE, &before);
    assert_int_equal(status, MNS_E_NO_SPACE);
    if (!strstr(error.text, strerror(EFBIG))) fail_msg("\"%s\" does not say why", error.text);
    assert_int_equal(key_file_read(path, &read, &error), MNS_OK);
    assert_string_equal(read.public_key, ADA);
}

static void where_keys_are_is_up_to_the_environment(void **state)
{
    (void)state;
    char found[KEYS_PATH];
    MnsError error;
    unsetenv("MENISCUS_KEYS");
    unsetenv("XDG_CONFIG_HOME");
    setenv("HOME", "/h", 1);
    assert_int_equal(keys_directory(found, &error), MNS_OK);
    assert_string_equal(found, "/h/.config/meniscus/keys");
    setenv("XDG_CONFIG_HOME", "/c", 1);
    assert_int_equal(keys_directory(found, &error), MNS_OK);
    assert_string_equal(found, "/c/meniscus/keys");
    setenv("XDG_CONFIG_HOME", "c", 1); /* relative: as if it were not set */
    assert_int_equal(keys_directory(found, &error), MNS_OK);
    assert_string_equal(found, "/h/.config/meniscus/keys");
    setenv("MENISCUS_KEYS", "/k", 1);
    assert_int_equal(keys_directory(found, &error), MNS_OK);
    assert_string_equal(found, "/k");
    unsetenv("MENISCUS_KEYS");
    unsetenv("XDG_CONFIG_HOME");
    unsetenv("HOME");
    assert_int_equal(keys_directory(found, &error), MNS_E_INVALID);
    setenv("HOME", ".", 1);
    assert_int_equal(keys_directory(found, &error), MNS_E_INVALID);
    assert_non_null(strstr(error.text, "HOME is no absolute path"));
    unsetenv("HOME");
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, begin, end)
    const struct CMUnitTest tests[] = {
        TEST(what_is_written_is_read_again_and_others_cannot_read_it),
        TEST(no_file_is_no_keys),
        TEST(files_that_others_can_reach_are_refused_and_the_sentence_says_what_to_do),
        TEST(a_long_comment_is_one_line),
        TEST(a_directory_that_others_can_write_to_is_refused),
        TEST(files_of_somebody_else_are_refused),
        TEST(what_is_no_file_is_not_waited_for),
        TEST(a_wrong_line_is_named_and_lets_nobody_in),
        TEST(a_secret_file_has_both_keys_and_perhaps_the_daemons),
        TEST(changes_are_made_one_after_the_other),
        TEST(a_disk_that_takes_a_part_is_told_and_the_old_keys_stay),
        TEST(where_keys_are_is_up_to_the_environment),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
