/* SPDX-License-Identifier: BSD-3-Clause */
/* A case's name follows from its path in one way, and is always one that a run directory may have. */
#include "common/case/name.h"
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static void the_folder_and_the_ending_are_no_part_of_it(void **state)
{
    (void)state;
    static const char *const paths[][2] = {
        {"tank.yaml", "tank"}, {"cases/tank.yaml", "tank"},       {"/a.b/tank", "tank"},
        {"tank", "tank"},      {"../v1.2/tank.2.yaml", "tank.2"},
    };
    for (size_t k = 0; k < sizeof paths / sizeof *paths; k++) {
        char name[CASE_NAME_SIZE];
        case_name_from_path(paths[k][0], name);
        assert_string_equal(name, paths[k][1]);
    }
}

static void what_a_name_may_not_have_becomes_an_underscore(void **state)
{
    (void)state;
    static const char *const paths[][2] = {
        {"my case (2).yaml", "my_case__2_"},
        {"\xc3\xb6l.yaml", "__l"},
        {".hidden", "_hidden"},
        {"-o.yaml", "_o"},
        {"..", "_"},
        {"folder/", "_"},
    };
    for (size_t k = 0; k < sizeof paths / sizeof *paths; k++) {
        char name[CASE_NAME_SIZE];
        case_name_from_path(paths[k][0], name);
        assert_string_equal(name, paths[k][1]);
        assert_true(is_name(name));
    }
}

static void a_long_name_is_cut(void **state)
{
    (void)state;
    char path[300], name[CASE_NAME_SIZE];
    memset(path, 'n', sizeof path);
    strcpy(path + 250, ".yaml");
    case_name_from_path(path, name);
    assert_int_equal(strlen(name), 100);
    assert_int_equal(strspn(name, "n"), 100);
}

static void names_are_letters_digits_dots_dashes_and_underscores(void **state)
{
    (void)state;
    static const char *const good[] = {"a", "Z", "09", "P05", "a.b-c_d", "a-", "a.", "a..b"};
    static const char *const bad[] = {"",    " ",  "a b", "a/b", "a:b", "\xc3\xb6", "a\n",
                                      "a\"", "a*", ".",   "..",  ".a",  "-",        "-a"};
    for (size_t k = 0; k < sizeof good / sizeof *good; k++) assert_true(is_name(good[k]));
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) assert_false(is_name(bad[k]));
}

/* HDF5 takes a dot for the group itself, and longer names would be cut where they are used. */
static void what_cannot_be_a_file_or_a_link_in_one_is_no_name(void **state)
{
    (void)state;
    char name[CASE_NAME_SIZE + 1];
    memset(name, 'n', sizeof name);
    name[CASE_NAME_SIZE] = 0;
    assert_false(is_name(name));
    name[CASE_NAME_SIZE - 1] = 0;
    assert_true(is_name(name));
    assert_false(is_name("."));
    assert_false(is_name(".."));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_folder_and_the_ending_are_no_part_of_it),
        cmocka_unit_test(what_a_name_may_not_have_becomes_an_underscore),
        cmocka_unit_test(a_long_name_is_cut),
        cmocka_unit_test(what_cannot_be_a_file_or_a_link_in_one_is_no_name),
        cmocka_unit_test(names_are_letters_digits_dots_dashes_and_underscores),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
