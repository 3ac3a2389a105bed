/* SPDX-License-Identifier: BSD-3-Clause */
/* Names of daemons become endpoints by the documented rule, and nothing but this host's daemons is ever addressed. */
#include "client/lib/endpoint.h"
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

typedef struct Fixture {
    char runtime[64], directory[128], socket[192];
} Fixture;

/* A runtime directory with a socket file of a daemon named "tank". */
static int set_up(void **state)
{
    Fixture *f = calloc(1, sizeof *f);
    strcpy(f->runtime, "/tmp/meniscus-test-XXXXXX");
    if (!mkdtemp(f->runtime)) return -1;
    snprintf(f->directory, sizeof f->directory, "%s/meniscus", f->runtime);
    mkdir(f->directory, 0700);
    strcat(f->directory, "/tank");
    mkdir(f->directory, 0700);
    snprintf(f->socket, sizeof f->socket, "%s/control.ipc", f->directory);
    FILE *file = fopen(f->socket, "w");
    if (file) fclose(file);
    setenv("XDG_RUNTIME_DIR", f->runtime, 1);
    unsetenv("MENISCUS_DAEMON");
    *state = f;
    return file ? 0 : -1;
}

static int tear_down(void **state)
{
    Fixture *f = *state;
    unlink(f->socket);
    rmdir(f->directory);
    *strrchr(f->directory, '/') = 0;
    rmdir(f->directory);
    rmdir(f->runtime);
    free(f);
    return 0;
}

static void a_name_is_a_socket_in_the_runtime_directory(void **state)
{
    const Fixture *f = *state;
    char endpoint[MNS_ENDPOINT_SIZE];
    assert_int_equal(mns_daemon_endpoint("tank", endpoint, NULL), MNS_OK);
    assert_memory_equal(endpoint, "ipc://", 6);
    assert_string_equal(endpoint + 6, f->socket);
}

static void the_environment_names_the_daemon_if_nobody_else_does(void **state)
{
    const Fixture *f = *state;
    char endpoint[MNS_ENDPOINT_SIZE];
    setenv("MENISCUS_DAEMON", "tank", 1);
    assert_int_equal(mns_daemon_endpoint(NULL, endpoint, NULL), MNS_OK);
    assert_string_equal(endpoint + 6, f->socket);
    setenv("MENISCUS_DAEMON", "tcp://127.0.0.1:4711", 1);
    assert_int_equal(mns_daemon_endpoint(NULL, endpoint, NULL), MNS_OK);
    assert_string_equal(endpoint, "tcp://127.0.0.1:4711");
    unsetenv("MENISCUS_DAEMON");
}

static void a_missing_daemon_is_unavailable_and_the_sentence_says_where_it_was_looked_for(void **state)
{
    const Fixture *f = *state;
    char endpoint[MNS_ENDPOINT_SIZE];
    MnsError error = {0};
    assert_int_equal(mns_daemon_endpoint("nobody", endpoint, &error), MNS_E_UNAVAILABLE);
    assert_non_null(strstr(error.text, f->runtime));
    assert_non_null(strstr(error.text, "/run/meniscus"));
    assert_non_null(strstr(error.text, "meniscusd --name nobody"));
}

static void what_is_no_endpoint_is_invalid(void **state)
{
    static const char *const bad[] = {"tcp://127.0.0.1",
                                      "tcp://127.0.0.1:",
                                      "tcp://127.0.0.1:0",
                                      "tcp://127.0.0.1:65534",
                                      "tcp://10.0.0.1:80:80",
                                      "tcp://a b:80",
                                      "tcp://[::1:80",
                                      "tcp://::1:80",
                                      "tcp://0.0.0.0:80",
                                      "tcp://*:80",
                                      "tcp://127.0.0.1:80x",
                                      "tcp://127.0.0.1: 80",
                                      "udp://127.0.0.1:80",
                                      "../tank",
                                      "a/b",
                                      "ipc://",
                                      "inproc://x",
                                      ".",
                                      "tcp://127.0.0.1:-1"};
    (void)state;
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        char endpoint[MNS_ENDPOINT_SIZE] = "untouched";
        MnsError error = {0};
        if (mns_daemon_endpoint(bad[k], endpoint, &error) != MNS_E_INVALID) fail_msg("%s was taken", bad[k]);
        assert_string_equal(endpoint, "untouched");
        assert_true(strlen(error.text) > 10);
    }
}

static void off_this_machine_there_is_no_way_without_a_key(void **state)
{
    static const char *const far[] = {"tcp://10.0.0.1:80", "tcp://host.example:80", "tcp://[2001:db8::7]:80",
                                      "tcp://127.0.0.1.example:80"};
    (void)state;
    unsetenv("MENISCUS_KEY");
    for (size_t k = 0; k < sizeof far / sizeof *far; k++) {
        char endpoint[MNS_ENDPOINT_SIZE];
        MnsClient *client = NULL;
        MnsError error = {0};
        assert_int_equal(mns_daemon_endpoint(far[k], endpoint, NULL), MNS_OK);
        assert_string_equal(endpoint, far[k]);
        assert_int_equal(mns_client_open(far[k], &client, &error), MNS_E_DENIED);
        assert_non_null(strstr(error.text, "meniscus keys new"));
        assert_int_equal(
            mns_client_open_with(&(MnsClientOptions){.daemon = far[k], .key_file = "/none"}, &client, &error),
            MNS_E_NOT_FOUND);
        assert_null(client);
    }
}

static void a_path_longer_than_a_unix_socket_may_have_is_invalid(void **state)
{
    char daemon[200] = "ipc:///", endpoint[MNS_ENDPOINT_SIZE];
    (void)state;
    memset(daemon + 7, 'x', 106);
    assert_int_equal(mns_daemon_endpoint(daemon, endpoint, NULL), MNS_OK);
    daemon[113] = 'x';
    assert_int_equal(mns_daemon_endpoint(daemon, endpoint, NULL), MNS_E_INVALID);
}

static void telemetry_is_beside_the_control_socket(void **state)
{
    char endpoint[MNS_ENDPOINT_SIZE];
    (void)state;
    assert_int_equal(endpoint_telemetry("ipc:///run/x/control.ipc", endpoint, NULL), MNS_OK);
    assert_string_equal(endpoint, "ipc:///run/x/telemetry.ipc");
    assert_int_equal(endpoint_telemetry("tcp://127.0.0.1:4711", endpoint, NULL), MNS_OK);
    assert_string_equal(endpoint, "tcp://127.0.0.1:4712");
}

typedef struct Found {
    int n;
    char endpoint[MNS_ENDPOINT_SIZE];
} Found;

static bool note(void *arg, const char *name, const char *endpoint)
{
    Found *found = arg;
    if (strcmp(name, "tank") != 0) return true;
    found->n++;
    strcpy(found->endpoint, endpoint);
    return true;
}

static void daemons_of_this_host_are_listed(void **state)
{
    const Fixture *f = *state;
    Found found = {0};
    mns_daemon_list(note, &found);
    assert_int_equal(found.n, 1);
    assert_string_equal(found.endpoint + 6, f->socket);
}

/* Whoever may write where a socket is can put another in its place. */
static void what_others_may_write_is_not_asked_and_not_listed(void **state)
{
    const Fixture *f = *state;
    static const mode_t open_to_write[] = {0770, 0707, 01777};
    char endpoint[MNS_ENDPOINT_SIZE], base[128];
    snprintf(base, sizeof base, "%s/meniscus", f->runtime);
    const char *const places[] = {base, f->directory};
    for (size_t k = 0; k < 6; k++) {
        MnsError error = {0};
        Found found = {0};
        chmod(places[k % 2], open_to_write[k / 2]);
        assert_int_equal(mns_daemon_endpoint("tank", endpoint, &error), MNS_E_UNAVAILABLE);
        if (!strstr(error.text, "others may write")) fail_msg("%s", error.text);
        mns_daemon_list(note, &found);
        assert_int_equal(found.n, 0);
        chmod(places[k % 2], 0755);
        assert_int_equal(mns_daemon_endpoint("tank", endpoint, &error), MNS_OK);
    }
}

static void what_is_not_ours_or_leads_elsewhere_is_not_asked(void **state)
{
    const Fixture *f = *state;
    char endpoint[MNS_ENDPOINT_SIZE], base[128], moved[140];
    snprintf(base, sizeof base, "%s/meniscus", f->runtime);
    snprintf(moved, sizeof moved, "%s/moved", f->runtime);
    assert_int_equal(rename(base, moved) | symlink(moved, base), 0);
    const MnsStatus by_link = mns_daemon_endpoint("tank", endpoint, NULL);
    assert_int_equal(unlink(base) | rename(moved, base), 0);
    assert_int_equal(by_link, MNS_E_UNAVAILABLE);
    if (geteuid() != 0) return; /* only root gives things away, as CI does */
    assert_int_equal(chown(f->directory, 65534, 65534), 0);
    assert_int_equal(mns_daemon_endpoint("tank", endpoint, NULL), MNS_E_UNAVAILABLE);
    assert_int_equal(chown(f->directory, geteuid(), getegid()) | chown(base, 65534, 65534), 0);
    assert_int_equal(mns_daemon_endpoint("tank", endpoint, NULL), MNS_E_UNAVAILABLE);
}

static void a_dead_socket_is_unavailable_at_once(void **state)
{
    MnsClient *client = NULL;
    MnsError error = {0};
    (void)state;
    assert_int_equal(mns_client_open("tank", &client, &error), MNS_E_UNAVAILABLE);
    assert_null(client);
    assert_non_null(strstr(error.text, "nobody listens"));
}

static void states_have_names_and_names_have_states(void **state)
{
    MnsState found = MNS_STATE_EMPTY;
    (void)state;
    assert_string_equal(mns_state_name(MNS_STATE_DONE), "DONE");
    assert_true(mns_state_parse("done", &found));
    assert_int_equal(found, MNS_STATE_DONE);
    assert_false(mns_state_parse("finished", &found));
    assert_string_equal(mns_state_name(MNS_STATE_COUNT), "UNKNOWN");
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(a_name_is_a_socket_in_the_runtime_directory),
        TEST(the_environment_names_the_daemon_if_nobody_else_does),
        TEST(a_missing_daemon_is_unavailable_and_the_sentence_says_where_it_was_looked_for),
        TEST(what_is_no_endpoint_is_invalid),
        TEST(off_this_machine_there_is_no_way_without_a_key),
        TEST(a_path_longer_than_a_unix_socket_may_have_is_invalid),
        TEST(telemetry_is_beside_the_control_socket),
        TEST(daemons_of_this_host_are_listed),
        TEST(what_others_may_write_is_not_asked_and_not_listed),
        TEST(what_is_not_ours_or_leads_elsewhere_is_not_asked),
        TEST(a_dead_socket_is_unavailable_at_once),
        TEST(states_have_names_and_names_have_states),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
