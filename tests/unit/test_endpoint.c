/* SPDX-License-Identifier: BSD-3-Clause */
/* Where a daemon listens. */
#include "net/endpoint.h"
#include "tests/support/check.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static char place[64];

static int begin(void **state)
{
    (void)state;
    snprintf(place, sizeof place, "/tmp/mns-endpoint-XXXXXX");
    assert_non_null(mkdtemp(place));
    unsetenv("RUNTIME_DIRECTORY");
    return setenv("XDG_RUNTIME_DIR", place, 1);
}

static int end(void **state)
{
    (void)state;
    char command[80];
    unsetenv("XDG_RUNTIME_DIR");
    snprintf(command, sizeof command, "rm -rf %s", place);
    return system(command);
}

static void assert_refused(const char *name, const char *tcp, MnsStatus status, const char *part)
{
    Endpoint endpoint;
    MnsError error;
    assert_int_equal(endpoint_open(&(EndpointOptions){.name = name, .tcp = tcp}, &endpoint, &error), status);
    if (!strstr(error.text, part)) fail_msg("\"%s\" does not say \"%s\"", error.text, part);
}

static void a_daemon_has_a_private_directory_of_its_name(void **state)
{
    (void)state;
    Endpoint endpoint;
    MnsError error;
    char wanted[160];
    struct stat info;
    assert_int_equal(endpoint_open(&(EndpointOptions){.name = "a.b"}, &endpoint, &error), MNS_OK);
    snprintf(wanted, sizeof wanted, "ipc://%s/meniscus/a.b/control.ipc", place);
    assert_string_equal(endpoint.control, wanted);
    snprintf(wanted, sizeof wanted, "ipc://%s/meniscus/a.b/telemetry.ipc", place);
    assert_string_equal(endpoint.telemetry, wanted);
    assert_string_equal(endpoint.tcp_control, "");
    assert_int_equal(stat(endpoint.directory, &info), 0);
    assert_int_equal(info.st_mode & 0777, 0700);
    endpoint_close(&endpoint);
}

static void systemd_says_where_if_it_does(void **state)
{
    (void)state;
    Endpoint endpoint;
    MnsError error;
    char wanted[160];
    setenv("RUNTIME_DIRECTORY", place, 1);
    const MnsStatus status = endpoint_open(&(EndpointOptions){.name = "n"}, &endpoint, &error);
    unsetenv("RUNTIME_DIRECTORY");
    assert_int_equal(status, MNS_OK);
    snprintf(wanted, sizeof wanted, "ipc://%s/control.ipc", place);
    assert_string_equal(endpoint.control, wanted);
    endpoint_close(&endpoint);
}

static void a_name_is_had_by_one_and_the_other_hears_by_whom(void **state)
{
    (void)state;
    Endpoint endpoint;
    MnsError error;
    char who[32];
    assert_int_equal(endpoint_open(&(EndpointOptions){.name = "n"}, &endpoint, &error), MNS_OK);
    snprintf(who, sizeof who, "process %d on ", (int)getpid());
    assert_refused("n", NULL, MNS_E_STATE, who);
    endpoint_close(&endpoint);
    assert_int_equal(endpoint_open(&(EndpointOptions){.name = "n"}, &endpoint, &error), MNS_OK);
    endpoint_close(&endpoint);
}

static void names_and_paths_that_cannot_be_are_refused(void **state)
{
    (void)state;
    char longest[120];
    assert_refused("", NULL, MNS_E_INVALID, "1 to 64");
    assert_refused("../up", NULL, MNS_E_INVALID, "../up");
    assert_refused(".hidden", NULL, MNS_E_INVALID, "dot");
    memset(longest, 'x', sizeof longest - 1);
    longest[sizeof longest - 1] = 0;
    longest[0] = '/';
    setenv("XDG_RUNTIME_DIR", longest, 1);
    assert_refused("n", NULL, MNS_E_LIMIT, "a socket's path may have 107");
}

static void ports_are_of_this_machine_alone(void **state)
{
    (void)state;
    Endpoint endpoint;
    MnsError error;
    assert_int_equal(endpoint_open(&(EndpointOptions){.name = "n", .tcp = "localhost:5555"}, &endpoint, &error),
                     MNS_OK);
    assert_string_equal(endpoint.tcp_control, "tcp://127.0.0.1:5555");
    assert_string_equal(endpoint.tcp_telemetry, "tcp://127.0.0.1:5556");
    assert_string_equal(endpoint.tcp_data, "tcp://127.0.0.1:5557");
    endpoint_close(&endpoint);
    assert_int_equal(
        endpoint_open(&(EndpointOptions){.name = "n", .tcp = "[::ffff:127.3.0.1]:5555"}, &endpoint, &error), MNS_OK);
    assert_string_equal(endpoint.tcp_control, "tcp://127.3.0.1:5555");
    endpoint_close(&endpoint);
    assert_refused("n", "[::1]:5555", MNS_E_INVALID, "use 127.0.0.1");
    assert_refused("n", "0.0.0.0:5555", MNS_E_INVALID, "0.0.0.0");
    assert_refused("n", "127.0.0.1.evil.example:5555", MNS_E_INVALID, "this machine");
    assert_refused("n", "65535", MNS_E_INVALID, "1 to 65533");
    assert_refused("n", "0", MNS_E_INVALID, "found \"0\"");
    assert_refused("n", "55x", MNS_E_INVALID, "55x");
    assert_refused("n", "", MNS_E_INVALID, "port");
}

static void plain_text_off_this_machine_is_refused_and_the_sentence_says_how_to_make_keys(void **state)
{
    (void)state;
    static const char *const far[] = {"0.0.0.0:5555", "192.0.2.7:5555", "*:5555", "[::]:5555", "tcp://0.0.0.0:5555"};
    for (size_t k = 0; k < sizeof far / sizeof *far; k++) {
        assert_refused("n", far[k], MNS_E_INVALID, "meniscus keys new NAME");
        assert_refused("n", far[k], MNS_E_INVALID, "--listen tcp://");
    }
}

static void with_keys_any_address_will_do(void **state)
{
    (void)state;
    static const char *const good[][2] = {{"tcp://192.0.2.7:5555", "tcp://192.0.2.7:5556"},
                                          {"*:5555", "tcp://*:5556"},
                                          {"tcp://[2001:db8::7]:65533", "tcp://[2001:db8::7]:65534"}};
    static const char *const bad[] = {
        "",          "5555",           "tcp://:5555",        "host.example:5555", "192.0.2:5555",
        "[*]:5555",  "192.0.2.7:0",    "192.0.2.7:65534",    "2001:db8::7:5555",  "[192.0.2.7]:5555",
        "tcp://*:x", "ipc:///tmp/x:1", "tcp://192.0.2.7:55 "};
    Endpoint endpoint;
    MnsError error;
    for (size_t k = 0; k < sizeof good / sizeof *good; k++) {
        const EndpointOptions options = {.name = "n", .listen = good[k][0], .keys = "/k"};
        assert_int_equal(endpoint_open(&options, &endpoint, &error), MNS_OK);
        assert_string_equal(endpoint.far_telemetry, good[k][1]);
        assert_string_equal(endpoint.keys, "/k");
        assert_string_equal(endpoint.tcp_control, "");
        endpoint_close(&endpoint);
    }
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        const EndpointOptions options = {.name = "n", .listen = bad[k], .keys = "/k"};
        if (endpoint_open(&options, &endpoint, &error) != MNS_E_INVALID) fail_msg("\"%s\" was taken", bad[k]);
        assert_string_equal(error.path, "listen");
    }
}

static void a_directory_of_somebody_else_is_a_trap(void **state)
{
    (void)state;
    char path[128];
    snprintf(path, sizeof path, "%s/meniscus", place);
    assert_int_equal(symlink("/tmp", path), 0);
    assert_refused("n", NULL, MNS_E_IO, "not a directory of this user");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_daemon_has_a_private_directory_of_its_name, begin, end),
        cmocka_unit_test_setup_teardown(systemd_says_where_if_it_does, begin, end),
        cmocka_unit_test_setup_teardown(a_name_is_had_by_one_and_the_other_hears_by_whom, begin, end),
        cmocka_unit_test_setup_teardown(names_and_paths_that_cannot_be_are_refused, begin, end),
        cmocka_unit_test_setup_teardown(ports_are_of_this_machine_alone, begin, end),
        cmocka_unit_test_setup_teardown(plain_text_off_this_machine_is_refused_and_the_sentence_says_how_to_make_keys,
                                        begin, end),
        cmocka_unit_test_setup_teardown(with_keys_any_address_will_do, begin, end),
        cmocka_unit_test_setup_teardown(a_directory_of_somebody_else_is_a_trap, begin, end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
