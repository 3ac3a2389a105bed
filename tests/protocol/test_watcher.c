/* SPDX-License-Identifier: BSD-3-Clause */
/* What the dashboard's gateway asks a daemon, against one that does not answer all of it at once. */
#include "client/dashboard/about.h"
#include "client/dashboard/watcher.h"
#include "tests/support/check.h"
#include "tests/support/fake_daemon.h"
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { FLUIDS = 3, MOST_PATHS = 8, PATIENCE_S = 60 };

/* What the daemon's thread reads; the test writes it under the lock. */
typedef struct Fixture {
    pthread_mutex_t lock;
    FakeDaemon *daemon;
    MnsClient *client;
    const char *refused; /* entry, or "capabilities", that is refused; NULL: none */
    Meniscus__Code code; /* with which                                            */
    int times;           /* that often                                            */
} Fixture;

/* NULL: there is no such entry. */
static const char *entry(const char *path)
{
    static const char *const fluids[FLUIDS] = {"water", "oil", "air"};
    unsigned k;
    char end;
    if (sscanf(path, "fluids[%u].nam%c", &k, &end) == 2) return k < FLUIDS ? fluids[k] : NULL;
    if (sscanf(path, "walls[%u].nam%c", &k, &end) == 2) return k < 1 ? "tank" : NULL;
    return "1";
}

static void answer_get(const Meniscus__Get *get, Meniscus__Reply *reply)
{
    static Meniscus__Values values;
    static Meniscus__Value items[MOST_PATHS], *list[MOST_PATHS];
    meniscus__values__init(&values);
    values.values = list;
    for (size_t k = 0; k < get->n_paths && k < MOST_PATHS; k++) {
        const char *text = entry(get->paths[k]);
        if (!text) reply->code = MENISCUS__CODE__NOT_FOUND;
        list[k] = &items[k];
        meniscus__value__init(list[k]);
        list[k]->name = get->paths[k];
        list[k]->text = (char *)text;
        values.n_values++;
    }
    reply->result_case = MENISCUS__REPLY__RESULT_VALUES;
    reply->values = &values;
}

static bool is_refused(Fixture *fixture, const Meniscus__Request *request)
{
    const bool is_get = request->command_case == MENISCUS__REQUEST__COMMAND_GET;
    const char *what = is_get ? request->get->paths[0] : "capabilities";
    const bool refused = fixture->refused && !strcmp(what, fixture->refused) && fixture->times > 0;
    if (refused) fixture->times--;
    return refused;
}

static void handle(void *arg, const Meniscus__Request *request, FakeAnswer *answer)
{
    static Meniscus__Capabilities capabilities;
    Fixture *fixture = arg;
    Meniscus__Reply *reply = answer->reply;
    pthread_mutex_lock(&fixture->lock);
    if (request->command_case == MENISCUS__REQUEST__COMMAND_QUERY) {
        reply->code = MENISCUS__CODE__NOT_FOUND;
    } else if (is_refused(fixture, request)) {
        reply->code = fixture->code;
    } else if (request->command_case == MENISCUS__REQUEST__COMMAND_GET) {
        answer_get(request->get, reply);
    } else {
        meniscus__capabilities__init(&capabilities);
        reply->result_case = MENISCUS__REPLY__RESULT_CAPABILITIES;
        reply->capabilities = &capabilities;
    }
    pthread_mutex_unlock(&fixture->lock);
}

static void refuse(Fixture *fixture, const char *what, Meniscus__Code code)
{
    pthread_mutex_lock(&fixture->lock);
    fixture->refused = what;
    fixture->code = code;
    fixture->times = 1;
    pthread_mutex_unlock(&fixture->lock);
}

static int set_up(void **state)
{
    Fixture *fixture = calloc(1, sizeof *fixture);
    pthread_mutex_init(&fixture->lock, NULL);
    fixture->daemon = fake_daemon_new(handle, fixture);
    *state = fixture;
    return mns_client_open(fake_daemon_endpoint(fixture->daemon), &fixture->client, NULL) == MNS_OK ? 0 : -1;
}

static int tear_down(void **state)
{
    Fixture *fixture = *state;
    mns_client_close(fixture->client);
    fake_daemon_free(fixture->daemon);
    free(fixture);
    return 0;
}

static const MnsReply ready = {.state = MNS_STATE_READY};

static void fluids_and_walls_are_asked_for_until_there_are_no_more(void **state)
{
    Fixture *fixture = *state;
    json_t *about = NULL;
    assert_int_equal(about_ask(fixture->client, &ready, &about, NULL), MNS_OK);
    const json_t *fluids = json_object_get(about, "fluids");
    assert_int_equal(json_array_size(fluids), FLUIDS);
    assert_string_equal(json_string_value(json_object_get(json_array_get(fluids, 2), "name")), "air");
    assert_int_equal(json_array_size(json_object_get(about, "walls")), 1);
    json_decref(about);
}

static void a_name_that_could_not_be_asked_for_is_not_the_end_of_the_names(void **state)
{
    static const char *const names[] = {"fluids[0].name", "fluids[1].name", "fluids[3].name", "walls[0].name"};
    Fixture *fixture = *state;
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        MnsError error = {0};
        json_t *about = NULL;
        refuse(fixture, names[k], MENISCUS__CODE__DEADLINE_EXCEEDED);
        assert_int_equal(about_ask(fixture->client, &ready, &about, &error), MNS_E_TIMEOUT);
        assert_int_equal(error.status, MNS_E_TIMEOUT);
        assert_null(about);
    }
}

static void of_a_case_that_goes_meanwhile_nothing_is_told(void **state)
{
    Fixture *fixture = *state;
    json_t *about = NULL;
    refuse(fixture, "walls[0].name", MENISCUS__CODE__FAILED_PRECONDITION);
    assert_int_equal(about_ask(fixture->client, &ready, &about, NULL), MNS_OK);
    assert_non_null(json_object_get(about, "capabilities"));
    assert_null(json_object_get(about, "case"));
    assert_null(json_object_get(about, "fluids"));
    json_decref(about);
}

static void nobody_wakes(void *arg)
{
    (void)arg;
}

/* Is something told of that topic before patience ends? */
static bool is_told(Hub *hub, const char *topic)
{
    const time_t end = time(NULL) + PATIENCE_S;
    bool found = false;
    char last[300] = "nothing";
    while (!found && time(NULL) < end) {
        uint64_t browser;
        Text *text = hub_take_text(hub, &browser);
        if (!text) {
            nanosleep(&(struct timespec){.tv_nsec = 20000000}, NULL);
            continue;
        }
        json_t *told = json_loadb((const char *)text->bytes + FRAME_HEADROOM, text->size, 0, NULL);
        const char *about = json_string_value(json_object_get(told, "topic"));
        found = about && !strcmp(about, topic);
        json_decref(told);
        snprintf(last, sizeof last, "%s", (const char *)text->bytes + FRAME_HEADROOM);
        text_release(text);
    }
    if (!found) print_error("nothing is told of %s; the last was %s\n", topic, last);
    return found;
}

/* Its thread ends with the program. */
static void what_the_daemon_could_not_say_is_asked_again_until_it_is_known(void **state)
{
    static Hub *hub;
    static Meniscus__Status at_first = MENISCUS__STATUS__INIT, later;
    Fixture *fixture = *state;
    at_first.has_state = at_first.has_case_version = true;
    at_first.state = MENISCUS__STATE__READY;
    at_first.case_version = 1;
    at_first.run_directory = "/nowhere/dam";
    later = at_first;
    later.case_version = 2;
    fake_daemon_set_status(fixture->daemon, &at_first);
    refuse(fixture, "capabilities", MENISCUS__CODE__UNAVAILABLE); /* as by a break: the connection is made anew */
    hub = hub_new(strdup(fake_daemon_endpoint(fixture->daemon)));
    hub_set_wake(hub, nobody_wakes, NULL);
    assert_int_equal(watcher_start(hub, NULL), MNS_OK);
    assert_true(is_told(hub, "about"));
    refuse(fixture, "walls[0].name", MENISCUS__CODE__DEADLINE_EXCEEDED); /* and by one that is busy */
    fake_daemon_set_status(fixture->daemon, &later);
    assert_true(is_told(hub, "about"));
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(fluids_and_walls_are_asked_for_until_there_are_no_more),
        TEST(a_name_that_could_not_be_asked_for_is_not_the_end_of_the_names),
        TEST(of_a_case_that_goes_meanwhile_nothing_is_told),
        TEST(what_the_daemon_could_not_say_is_asked_again_until_it_is_known),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
