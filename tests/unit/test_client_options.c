/* SPDX-License-Identifier: BSD-3-Clause */
/* The command line: words and options are told apart, mistakes are explained, and the table of commands fits the
 * protocol. */
#include "client/cli/command.h"
#include "meniscus.pb-c.h"
#include <meniscus/exit.h>
#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

/* Those of commands that talk to a daemon: further on, some share a name. */
#define EVERY_OPTION (OPTION(OPT_DIRECTORY) - 1)

/* Parse words after a command's name. */
static MnsStatus parse(Options *options, OptionSet allowed, int n, const char *const *words, MnsError *error)
{
    char *argv[16] = {(char *)"command"};
    int used;
    for (int k = 0; k < n; k++) argv[k + 1] = (char *)words[k];
    memset(options, 0, sizeof *options);
    return options_parse(options, n + 1, argv, allowed, false, &used, error);
}
#define PARSE(options, allowed, error, ...)                                                                            \
    parse(options, allowed, sizeof((const char *[]){__VA_ARGS__}) / sizeof(char *), (const char *[]){__VA_ARGS__},     \
          error)

static void options_and_words_may_mix(void **state)
{
    static Options options;
    (void)state;
    assert_int_equal(PARSE(&options, EVERY_OPTION, NULL, "one", "-o", "json", "two", "--limit=7", "three"), MNS_OK);
    assert_int_equal(options.n_words, 3);
    assert_string_equal(options.words[1], "two");
    assert_string_equal(options_get(&options, OPT_OUTPUT), "json");
    assert_string_equal(options_get(&options, OPT_LIMIT), "7");
    assert_null(options_get(&options, OPT_DAEMON));
}

static void negative_numbers_are_words(void **state)
{
    static Options options;
    (void)state;
    assert_int_equal(PARSE(&options, EVERY_OPTION, NULL, "at", "pressure", "-0.5,1", "-.5,-2", "-o", "json"), MNS_OK);
    assert_int_equal(options.n_words, 4);
    assert_string_equal(options.words[2], "-0.5,1");
    assert_string_equal(options.words[3], "-.5,-2");
    assert_string_equal(options_get(&options, OPT_OUTPUT), "json");
}

static void two_dashes_end_the_options(void **state)
{
    static Options options;
    (void)state;
    assert_int_equal(PARSE(&options, EVERY_OPTION, NULL, "--walls", "--", "--start"), MNS_OK);
    assert_int_equal(options.n_words, 1);
    assert_string_equal(options.words[0], "--start");
    assert_null(options_get(&options, OPT_START));
}

static void repeated_options_keep_their_order_and_the_last_one_counts(void **state)
{
    static Options options;
    const char *all[MAX_WORDS];
    (void)state;
    assert_int_equal(PARSE(&options, EVERY_OPTION, NULL, "--set", "a=1", "--set", "b=2"), MNS_OK);
    assert_int_equal(options_all(&options, OPT_SET, all), 2);
    assert_string_equal(all[0], "a=1");
    assert_string_equal(options_get(&options, OPT_SET), "b=2");
}

static void an_unknown_option_suggests_the_nearest(void **state)
{
    static Options options;
    MnsError error = {0};
    (void)state;
    assert_int_equal(PARSE(&options, OPTIONS_GLOBAL, &error, "--daemn=x"), MNS_E_INVALID);
    assert_non_null(strstr(error.text, "did you mean \"--daemon\""));
}

static void an_option_of_another_command_is_unknown(void **state)
{
    static Options options;
    MnsError error = {0};
    (void)state;
    assert_int_equal(PARSE(&options, OPTIONS_GLOBAL, &error, "--walls"), MNS_E_INVALID);
    assert_non_null(strstr(error.text, "--walls"));
}

static void an_option_without_its_value_is_refused(void **state)
{
    static Options options;
    MnsError error = {0};
    (void)state;
    assert_int_equal(PARSE(&options, EVERY_OPTION, &error, "--daemon"), MNS_E_INVALID);
    assert_non_null(strstr(error.text, "needs a value"));
}

static void numbers_are_whole_words(void **state)
{
    static const char *const bad[] = {"", "x", "1x", "nan", "inf", "1e999", " 1", "0x10", "1,"};
    double value = 7;
    (void)state;
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++)
        if (parse_number("t", bad[k], &value, NULL) != MNS_E_INVALID) fail_msg("\"%s\" was taken", bad[k]);
    assert_true(value > 6.5 && value < 7.5);
    assert_int_equal(parse_number("t", "-2.5e-1", &value, NULL), MNS_OK);
    assert_true(value > -0.2501 && value < -0.2499);
}

static void counts_are_whole_and_not_negative(void **state)
{
    static const char *const bad[] = {"", "-1", "1.5", "x", "99999999999999999999999", "+1", " 1"};
    uint64_t value = 7;
    (void)state;
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++)
        if (parse_count("n", bad[k], &value, NULL) != MNS_E_INVALID) fail_msg("\"%s\" was taken", bad[k]);
    assert_int_equal(value, 7);
    assert_int_equal(parse_count("n", "18446744073709551615", &value, NULL), MNS_OK);
    assert_true(value == UINT64_MAX);
}

static void points_have_commas_and_a_limit(void **state)
{
    double x[3];
    size_t n = 0;
    (void)state;
    assert_int_equal(parse_numbers("p", "1,-2.5", 3, x, &n, NULL), MNS_OK);
    assert_int_equal(n, 2);
    assert_true(x[1] < -2.4 && x[1] > -2.6);
    assert_int_equal(parse_numbers("p", "1,2,3,4", 3, x, &n, NULL), MNS_E_INVALID);
    assert_int_equal(parse_numbers("p", "1,,3", 3, x, &n, NULL), MNS_E_INVALID);
}

static void a_request_id_has_32_hex_digits(void **state)
{
    uint8_t id[MNS_REQUEST_ID_SIZE];
    (void)state;
    assert_int_equal(parse_id("--id", "000102030405060708090a0b0c0d0eFF", id, NULL), MNS_OK);
    assert_int_equal(id[1], 1);
    assert_int_equal(id[15], 255);
    assert_int_equal(parse_id("--id", "0001", id, NULL), MNS_E_INVALID);
    assert_int_equal(parse_id("--id", "g00102030405060708090a0b0c0d0e0f", id, NULL), MNS_E_INVALID);
}

/* --- the table ---------------------------------------------------------------------------------------------------- */

static void every_command_of_the_protocol_is_a_command_of_the_line(void **state)
{
    const ProtobufCMessageDescriptor *request = &meniscus__request__descriptor;
    unsigned n = 0;
    (void)state;
    for (unsigned k = 0; k < request->n_fields; k++) {
        if (!(request->fields[k].flags & PROTOBUF_C_FIELD_FLAG_ONEOF)) continue;
        const Command *command = command_table;
        while (command->name && (!command->request || strcmp(command->request, request->fields[k].name) != 0))
            command++;
        if (!command->name) fail_msg("no command sends %s", request->fields[k].name);
        n++;
    }
    assert_true(n >= 20);
}

static void every_request_in_the_table_is_in_the_protocol(void **state)
{
    (void)state;
    for (const Command *command = command_table; command->name; command++)
        if (command->request &&
            !protobuf_c_message_descriptor_get_field_by_name(&meniscus__request__descriptor, command->request))
            fail_msg("%s sends %s, which is not in the protocol", command->name, command->request);
    assert_non_null(command_table[0].name);
}

static void every_command_can_be_run_and_is_explained(void **state)
{
    (void)state;
    for (const Command *command = command_table; command->name; command++) {
        assert_non_null(command->run);
        assert_true(command->help && strlen(command->help) > 10);
        if (command->min_words) assert_non_null(command->arguments);
    }
}

static void no_command_takes_two_options_of_one_letter(void **state)
{
    int seen[128] = {0};
    (void)state;
    for (int k = 0; k < OPTION_COUNT; k++) {
        const char letter = option_table[k].letter;
        if (letter) assert_int_equal(seen[(int)letter]++, 0);
    }
    assert_int_equal(seen['o'], 1);
}

static void no_command_takes_two_options_of_one_name(void **state)
{
    (void)state;
    for (const Command *command = command_table; command->name; command++)
        for (int k = 0; k < OPTION_COUNT; k++)
            for (int l = 0; l < k; l++)
                if (command_options(command) & OPTION(k) && command_options(command) & OPTION(l))
                    assert_string_not_equal(option_table[k].name, option_table[l].name);
}

static void an_unknown_command_suggests_the_nearest(void **state)
{
    const Command *command = NULL;
    MnsError error = {0};
    (void)state;
    assert_int_equal(command_find("run_until", &command, &error), MNS_E_INVALID);
    assert_non_null(strstr(error.text, "did you mean \"run-until\"?"));
    assert_null(command);
    assert_int_equal(command_find("lod", &command, &error), MNS_E_INVALID);
    assert_non_null(strstr(error.text, "did you mean \"log\" or \"load\"?"));
}

static void failures_have_the_documented_exit_codes(void **state)
{
    (void)state;
    assert_int_equal(command_exit_code(MNS_E_UNAVAILABLE, false), MNS_EXIT_UNREACHABLE);
    assert_int_equal(command_exit_code(MNS_E_DIVERGED, false), MNS_EXIT_DIVERGED);
    assert_int_equal(command_exit_code(MNS_E_TIMEOUT, false), MNS_EXIT_TIMEOUT);
    assert_int_equal(command_exit_code(MNS_E_INVALID, true), MNS_EXIT_BAD_CASE);
    assert_int_equal(command_exit_code(MNS_E_INVALID, false), MNS_EXIT_FAILED);
    assert_int_equal(command_exit_code(MNS_E_NO_SPACE, false), MNS_EXIT_IO);
    for (int k = 1; k <= MNS_E_INTERNAL; k++)
        assert_int_not_equal(command_exit_code((MnsStatus)k, false), MNS_EXIT_DONE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(options_and_words_may_mix),
        cmocka_unit_test(negative_numbers_are_words),
        cmocka_unit_test(two_dashes_end_the_options),
        cmocka_unit_test(repeated_options_keep_their_order_and_the_last_one_counts),
        cmocka_unit_test(an_unknown_option_suggests_the_nearest),
        cmocka_unit_test(an_option_of_another_command_is_unknown),
        cmocka_unit_test(an_option_without_its_value_is_refused),
        cmocka_unit_test(numbers_are_whole_words),
        cmocka_unit_test(counts_are_whole_and_not_negative),
        cmocka_unit_test(points_have_commas_and_a_limit),
        cmocka_unit_test(a_request_id_has_32_hex_digits),
        cmocka_unit_test(every_command_of_the_protocol_is_a_command_of_the_line),
        cmocka_unit_test(every_request_in_the_table_is_in_the_protocol),
        cmocka_unit_test(every_command_can_be_run_and_is_explained),
        cmocka_unit_test(no_command_takes_two_options_of_one_letter),
        cmocka_unit_test(no_command_takes_two_options_of_one_name),
        cmocka_unit_test(an_unknown_command_suggests_the_nearest),
        cmocka_unit_test(failures_have_the_documented_exit_codes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
