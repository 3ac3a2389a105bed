/* SPDX-License-Identifier: BSD-3-Clause */
/* The client library over a real socket, against a daemon that misbehaves on demand. */
#include "tests/support/fake_daemon.h"
#include <math.h>
#include <meniscus/client.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <xxhash.h>

#include <cmocka.h>

/* What the daemon's thread reads and writes; the test looks at it between two calls of settle(). */
typedef struct Fixture {
    pthread_mutex_t lock;
    FakeDaemon *daemon;
    MnsClient *client;
    FakeManner manners[4]; /* of the first, second ... request; zero is FAKE_ANSWER */
    atomic_int n;          /* requests heard                                         */
    uint8_t ids[4][16];
    bool conditional[4];
    bool said[4]; /* any condition or schedule came with it */
    Meniscus__Request__CommandCase commands[4];
    uint64_t deadline_ms;
    Meniscus__Code code;
    char *path, *reason;
    bool damage; /* the array's checksum is wrong */
    bool forget_array;
    uint64_t shape[2]; /* of the array */
    bool no_code;      /* the reply has none */
    bool restart;      /* the daemon that comes back is another one */
} Fixture;

static const double numbers[6] = {1, 2, 3, 4, 5, NAN};

static void add_array(Fixture *fixture, FakeAnswer *answer)
{
    static Meniscus__Array array;
    static Meniscus__Array *list[] = {&array};
    meniscus__array__init(&array);
    array.name = "position";
    array.type = "<f8";
    array.unit = "m";
    array.n_shape = 2;
    array.shape = fixture->shape;
    array.has_xxh64 = true;
    array.xxh64 = XXH64(numbers, sizeof numbers, 0) + fixture->damage;
    answer->reply->n_arrays = 1;
    answer->reply->arrays = list;
    answer->frame = fixture->forget_array ? NULL : numbers;
    answer->frame_size = sizeof numbers;
}

/* Let the other thread see what this one wrote, and this one what the other did. */
static void settle(Fixture *fixture)
{
    pthread_mutex_lock(&fixture->lock);
    pthread_mutex_unlock(&fixture->lock);
}

static void handle(void *arg, const Meniscus__Request *request, FakeAnswer *answer)
{
    Fixture *fixture = arg;
    pthread_mutex_lock(&fixture->lock);
    const int k = atomic_load(&fixture->n);
    if (k < 4 && request->id.len == 16) {
        memcpy(fixture->ids[k], request->id.data, 16);
        fixture->commands[k] = request->command_case;
        fixture->conditional[k] = request->has_if_step;
        fixture->said[k] = request->has_if_step || request->has_if_version || request->has_at_step ||
                           request->has_at_time || request->has_no_wait;
        answer->manner = fixture->manners[k];
    }
    fixture->deadline_ms = request->deadline_ms;
    answer->reply->code = fixture->code;
    answer->reply->has_code = !fixture->no_code;
    answer->reply->path = fixture->path;
    answer->reply->reason = fixture->reason;
    answer->reply->message = fixture->code == MENISCUS__CODE__OK ? "" : "no, because";
    answer->reply->has_effect_step = answer->reply->has_state = true;
    answer->reply->effect_step = 41;
    answer->reply->state = MENISCUS__STATE__PAUSED;
    if (request->command_case == MENISCUS__REQUEST__COMMAND_QUERY) add_array(fixture, answer);
    if (fixture->restart) fake_daemon_set_epoch(fixture->daemon, 2 + (uint64_t)k);
    atomic_fetch_add(&fixture->n, 1);
    pthread_mutex_unlock(&fixture->lock);
}

static int set_up(void **state)
{
    Fixture *fixture = calloc(1, sizeof *fixture);
    pthread_mutex_init(&fixture->lock, NULL);
    fixture->shape[0] = 3;
    fixture->shape[1] = 2;
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

static double seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void a_reply_carries_state_and_step_of_the_effect(void **state)
{
    Fixture *fixture = *state;
    MnsReply *reply = NULL;
    assert_int_equal(mns_client_pause(fixture->client, &reply, NULL), MNS_OK);
    assert_int_equal(reply->state, MNS_STATE_PAUSED);
    assert_int_equal(reply->effect_step, 41);
    settle(fixture);
    assert_int_equal(fixture->commands[0], MENISCUS__REQUEST__COMMAND_PAUSE);
    mns_reply_free(reply);
}

static void every_command_has_an_id_of_its_own(void **state)
{
    Fixture *fixture = *state;
    assert_int_equal(mns_client_pause(fixture->client, NULL, NULL), MNS_OK);
    assert_int_equal(mns_client_pause(fixture->client, NULL, NULL), MNS_OK);
    settle(fixture);
    assert_memory_not_equal(fixture->ids[0], fixture->ids[1], 16);
}

static void a_chosen_id_is_used_once(void **state)
{
    Fixture *fixture = *state;
    const uint8_t id[16] = {9, 8, 7, 6, 5, 4, 3, 2, 1, 9, 8, 7, 6, 5, 4, 3};
    mns_client_set_request_id(fixture->client, id);
    assert_int_equal(mns_client_step(fixture->client, 3, NULL, NULL), MNS_OK);
    assert_int_equal(mns_client_step(fixture->client, 3, NULL, NULL), MNS_OK);
    settle(fixture);
    assert_memory_equal(fixture->ids[0], id, 16);
    assert_memory_not_equal(fixture->ids[1], id, 16);
}

static void a_condition_goes_with_one_command(void **state)
{
    Fixture *fixture = *state;
    mns_client_set_if_step(fixture->client, 0);
    assert_int_equal(mns_client_step(fixture->client, 3, NULL, NULL), MNS_OK);
    assert_int_equal(mns_client_step(fixture->client, 3, NULL, NULL), MNS_OK);
    settle(fixture);
    assert_true(fixture->conditional[0]);
    assert_false(fixture->conditional[1]);
}

static void codes_become_statuses_with_sentence_and_path(void **state)
{
    static const struct {
        Meniscus__Code code;
        MnsStatus status;
    } table[] = {{MENISCUS__CODE__INVALID_ARGUMENT, MNS_E_INVALID}, {MENISCUS__CODE__OUT_OF_RANGE, MNS_E_INVALID},
                 {MENISCUS__CODE__NOT_FOUND, MNS_E_NOT_FOUND},      {MENISCUS__CODE__FAILED_PRECONDITION, MNS_E_STATE},
                 {MENISCUS__CODE__RESOURCE_EXHAUSTED, MNS_E_LIMIT}, {MENISCUS__CODE__DEADLINE_EXCEEDED, MNS_E_TIMEOUT},
                 {MENISCUS__CODE__ABORTED, MNS_E_INTERRUPTED},      {MENISCUS__CODE__DATA_LOSS, MNS_E_CORRUPT},
                 {MENISCUS__CODE__UNAVAILABLE, MNS_E_UNAVAILABLE},  {MENISCUS__CODE__UNIMPLEMENTED, MNS_E_VERSION},
                 {MENISCUS__CODE__INTERNAL, MNS_E_INTERNAL}};
    Fixture *fixture = *state;
    for (size_t k = 0; k < sizeof table / sizeof *table; k++) {
        MnsError error = {0};
        settle(fixture);
        fixture->code = table[k].code;
        fixture->path = "fluids[1].density";
        settle(fixture);
        assert_int_equal(mns_client_pause(fixture->client, NULL, &error), table[k].status);
        assert_int_equal(error.status, table[k].status);
        assert_string_equal(error.text, "no, because");
        assert_string_equal(error.path, "fluids[1].density");
    }
}

static void a_code_nobody_knows_is_a_failure(void **state)
{
    Fixture *fixture = *state;
    fixture->code = (Meniscus__Code)1;
    settle(fixture);
    assert_int_equal(mns_client_pause(fixture->client, NULL, NULL), MNS_E_INTERNAL);
}

/* Protobuf reads as OK what is not there. */
static void a_reply_without_a_code_is_no_success(void **state)
{
    Fixture *fixture = *state;
    MnsError error;
    fixture->no_code = true;
    fixture->manners[1] = FAKE_EMPTY;
    settle(fixture);
    assert_int_equal(mns_client_pause(fixture->client, NULL, &error), MNS_E_VERSION);
    assert_non_null(strstr(error.text, "neither"));
    mns_client_set_timeout(fixture->client, 0.25);
    assert_int_equal(mns_client_pause(fixture->client, NULL, NULL), MNS_E_TIMEOUT);
}

static void the_reason_is_more_exact_than_the_code(void **state)
{
    Fixture *fixture = *state;
    fixture->code = MENISCUS__CODE__ABORTED;
    fixture->reason = "diverged";
    settle(fixture);
    assert_int_equal(mns_client_step(fixture->client, 1, NULL, NULL), MNS_E_DIVERGED);
    settle(fixture);
    fixture->reason = "of a kind yet to come";
    settle(fixture);
    assert_int_equal(mns_client_step(fixture->client, 1, NULL, NULL), MNS_E_INTERRUPTED);
}

static void a_lost_connection_repeats_the_request_under_the_same_id(void **state)
{
    Fixture *fixture = *state;
    fixture->manners[0] = FAKE_DISCONNECT;
    settle(fixture);
    assert_int_equal(mns_client_step(fixture->client, 5, NULL, NULL), MNS_OK);
    assert_int_equal(atomic_load(&fixture->n), 2);
    settle(fixture);
    assert_memory_equal(fixture->ids[0], fixture->ids[1], 16);
    assert_int_equal(fixture->commands[1], MENISCUS__REQUEST__COMMAND_STEP);
}

static void a_restarted_daemon_is_given_the_command_again_under_its_id(void **state)
{
    Fixture *fixture = *state;
    fixture->manners[0] = FAKE_DISCONNECT;
    fixture->restart = true;
    settle(fixture);
    assert_int_equal(mns_client_step(fixture->client, 5, NULL, NULL), MNS_OK);
    assert_int_equal(atomic_load(&fixture->n), 2);
    settle(fixture);
    assert_memory_equal(fixture->ids[0], fixture->ids[1], 16);
    assert_int_equal(fixture->commands[1], MENISCUS__REQUEST__COMMAND_STEP);
}

static void a_command_that_ends_every_daemon_is_not_given_to_each(void **state)
{
    Fixture *fixture = *state;
    MnsError error = {0};
    for (int k = 0; k < 4; k++) fixture->manners[k] = FAKE_DISCONNECT;
    fixture->restart = true;
    settle(fixture);
    assert_int_equal(mns_client_step(fixture->client, 5, NULL, &error), MNS_E_UNAVAILABLE);
    assert_int_equal(atomic_load(&fixture->n), 2);
    assert_non_null(strstr(error.text, "ended 2 times"));
}

static void a_wait_is_given_to_every_daemon_that_comes(void **state)
{
    Fixture *fixture = *state;
    for (int k = 0; k < 3; k++) fixture->manners[k] = FAKE_DISCONNECT;
    fixture->restart = true;
    settle(fixture);
    assert_int_equal(mns_client_wait(fixture->client, 1u << MNS_STATE_DONE, NAN, MNS_NO_STEP, NULL, NULL), MNS_OK);
    assert_int_equal(atomic_load(&fixture->n), 4);
}

static void a_shutdown_does_not_end_the_daemon_that_is_started_after_it(void **state)
{
    Fixture *fixture = *state;
    MnsError error = {0};
    fixture->manners[0] = FAKE_DISCONNECT;
    fixture->restart = true;
    settle(fixture);
    assert_int_equal(mns_client_shutdown(fixture->client, false, NULL, &error), MNS_E_UNAVAILABLE);
    assert_int_equal(atomic_load(&fixture->n), 1);
    assert_non_null(strstr(error.text, "another was started"));
}

static void answers_to_other_requests_are_passed_over(void **state)
{
    Fixture *fixture = *state;
    fixture->manners[0] = FAKE_STALE_FIRST;
    settle(fixture);
    assert_int_equal(mns_client_pause(fixture->client, NULL, NULL), MNS_OK);
}

static void silence_ends_with_the_time_limit(void **state)
{
    Fixture *fixture = *state;
    const double begin = seconds();
    fixture->manners[0] = FAKE_SILENCE;
    settle(fixture);
    mns_client_set_timeout(fixture->client, 0.25);
    assert_int_equal(mns_client_pause(fixture->client, NULL, NULL), MNS_E_TIMEOUT);
    settle(fixture);
    assert_int_equal(fixture->deadline_ms, 250);
    assert_true(seconds() - begin >= 0.25 && seconds() - begin < 8);
    assert_int_equal(mns_client_pause(fixture->client, NULL, NULL), MNS_OK);
}

static void a_daemon_that_dies_is_noticed_without_a_time_limit(void **state)
{
    Fixture *fixture = *state;
    MnsError error = {0};
    fake_daemon_free(fixture->daemon);
    const double begin = seconds();
    assert_int_equal(mns_client_pause(fixture->client, NULL, &error), MNS_E_UNAVAILABLE);
    assert_true(seconds() - begin < 10);
    fixture->daemon = fake_daemon_new(handle, fixture);
}

static void a_daemon_that_dies_is_waited_for_no_longer_than_wanted(void **state)
{
    Fixture *fixture = *state;
    MnsError error = {0};
    mns_client_set_reconnect(fixture->client, 0.1);
    fake_daemon_free(fixture->daemon);
    const double begin = seconds();
    assert_int_equal(mns_client_pause(fixture->client, NULL, &error), MNS_E_UNAVAILABLE);
    assert_true(seconds() - begin < 3);
    fixture->daemon = fake_daemon_new(handle, fixture);
}

static void it_can_be_told_for_how_long_a_daemon_is_away(void **state)
{
    Fixture *fixture = *state;
    assert_true(mns_client_away(fixture->client) <= 0);
    fake_daemon_free(fixture->daemon);
    const double begin = seconds();
    while (mns_client_away(fixture->client) < 0.1) assert_true(seconds() - begin < 10);
    assert_true(mns_client_away(fixture->client) < seconds() - begin + 0.1);
    fixture->daemon = fake_daemon_new(handle, fixture);
}

static void arrays_come_whole_and_aligned(void **state)
{
    Fixture *fixture = *state;
    MnsReply *reply = NULL;
    const MnsParticleQuery everywhere = {0};
    assert_int_equal(mns_client_query_particles(fixture->client, &everywhere, &reply, NULL), MNS_OK);
    const MnsArray *array = mns_reply_array(reply, "position");
    assert_non_null(array);
    assert_int_equal(array->n_dims, 2);
    assert_int_equal(array->shape[0], 3);
    assert_string_equal(array->unit, "m");
    assert_int_equal((uintptr_t)array->data % _Alignof(double), 0);
    assert_memory_equal(array->data, numbers, sizeof numbers);
    assert_null(mns_reply_array(reply, "velocity"));
    mns_reply_free(reply);
}

static void a_damaged_array_is_refused(void **state)
{
    Fixture *fixture = *state;
    MnsError error = {0};
    const double point[2] = {0.5, 0.25};
    fixture->damage = true;
    settle(fixture);
    assert_int_equal(mns_client_query_points(fixture->client, "pressure", 1, 2, point, NULL, &error), MNS_E_CORRUPT);
    assert_non_null(strstr(error.text, "checksum"));
}

static void a_missing_array_is_refused(void **state)
{
    Fixture *fixture = *state;
    const double point[3] = {0.5, 0.25, 1};
    fixture->forget_array = true;
    settle(fixture);
    assert_int_equal(mns_client_query_points(fixture->client, "pressure", 1, 3, point, NULL, NULL), MNS_E_CORRUPT);
}

static void a_shape_that_does_not_fit_its_frame_is_refused(void **state)
{
    static const uint64_t shapes[][2] = {{4, 2}, {3, 1}, {UINT64_MAX, UINT64_MAX}, {0, 0}};
    Fixture *fixture = *state;
    const MnsParticleQuery everywhere = {0};
    for (size_t k = 0; k < sizeof shapes / sizeof *shapes; k++) {
        memcpy(fixture->shape, shapes[k], sizeof fixture->shape);
        settle(fixture);
        assert_int_equal(mns_client_query_particles(fixture->client, &everywhere, NULL, NULL), MNS_E_CORRUPT);
    }
}

static void a_reply_that_is_none_is_refused_and_the_next_is_read(void **state)
{
    Fixture *fixture = *state;
    fixture->manners[0] = FAKE_GARBAGE;
    settle(fixture);
    assert_int_equal(mns_client_pause(fixture->client, NULL, NULL), MNS_E_VERSION);
    assert_int_equal(mns_client_pause(fixture->client, NULL, NULL), MNS_OK);
}

static void an_assignment_without_equals_sign_is_not_sent(void **state)
{
    Fixture *fixture = *state;
    const char *const words[] = {"end_time=3", "gravity"};
    MnsError error = {0};
    assert_int_equal(mns_client_set(fixture->client, 2, words, NULL, &error), MNS_E_INVALID);
    assert_non_null(strstr(error.text, "\"gravity\""));
    assert_int_equal(atomic_load(&fixture->n), 0);
}

static void say_all_that_can_be_said(MnsClient *client, const uint8_t id[16])
{
    mns_client_set_request_id(client, id);
    mns_client_set_if_step(client, 40);
    mns_client_set_if_version(client, 3);
    mns_client_set_at_step(client, 100);
    mns_client_set_at_time(client, 0.5);
    mns_client_set_no_wait(client);
}

static MnsStatus set_without_equals_sign(MnsClient *client)
{
    return mns_client_set(client, 1, (const char *const[]){"gravity"}, NULL, NULL);
}

static MnsStatus take_a_lease_of_no_time(MnsClient *client)
{
    return mns_client_lease(client, 0, "me", NULL, NULL);
}

static MnsStatus ask_at_points_of_a_line(MnsClient *client)
{
    return mns_client_query_points(client, "pressure", 1, 1, (const double[]){0.5}, NULL, NULL);
}

static MnsStatus ask_in_a_box_of_a_line(MnsClient *client)
{
    return mns_client_query_particles(client, &(MnsParticleQuery){.dim = 1}, NULL, NULL);
}

static MnsStatus wait_for_a_time_before_all(MnsClient *client)
{
    return mns_client_wait(client, 0, -1, MNS_NO_STEP, NULL, NULL);
}

static MnsStatus load_no_file(MnsClient *client)
{
    return mns_client_load(client, &(MnsLoad){.file = "/nowhere/case.yaml"}, NULL, NULL);
}

static MnsStatus load_with_a_wrong_setting(MnsClient *client)
{
    return mns_client_load(
        client, &(MnsLoad){.file = "/dev/null", .n_sets = 1, .sets = (const char *const[]){"gravity"}}, NULL, NULL);
}

static void what_is_said_for_a_command_that_is_not_sent_is_for_no_other(void **state)
{
    static MnsStatus (*const refused[])(MnsClient * client) = {set_without_equals_sign,    take_a_lease_of_no_time,
                                                               ask_at_points_of_a_line,    ask_in_a_box_of_a_line,
                                                               wait_for_a_time_before_all, load_no_file,
                                                               load_with_a_wrong_setting};
    const uint8_t id[16] = {9, 8, 7, 6, 5, 4, 3, 2, 1, 9, 8, 7, 6, 5, 4, 3};
    Fixture *fixture = *state;
    for (size_t k = 0; k < sizeof refused / sizeof *refused; k++) {
        atomic_store(&fixture->n, 0);
        say_all_that_can_be_said(fixture->client, id);
        assert_int_not_equal(refused[k](fixture->client), MNS_OK);
        assert_int_equal(atomic_load(&fixture->n), 0);
        assert_int_equal(mns_client_pause(fixture->client, NULL, NULL), MNS_OK);
        settle(fixture);
        assert_false(fixture->said[0]);
        assert_memory_not_equal(fixture->ids[0], id, 16);
    }
    atomic_store(&fixture->n, 0);
    say_all_that_can_be_said(fixture->client, id);
    assert_int_equal(mns_client_pause(fixture->client, NULL, NULL), MNS_OK);
    settle(fixture);
    assert_true(fixture->said[0]);
    assert_memory_equal(fixture->ids[0], id, 16);
}

/* --- telemetry ---------------------------------------------------------------------------------------------------- */

static void publish_progress(Fixture *fixture, uint64_t epoch, uint64_t sequence)
{
    Meniscus__Telemetry message = MENISCUS__TELEMETRY__INIT;
    Meniscus__Progress progress = MENISCUS__PROGRESS__INIT;
    message.has_daemon_epoch = message.has_sequence = progress.has_fraction = true;
    message.daemon_epoch = epoch;
    message.sequence = sequence;
    message.item_case = MENISCUS__TELEMETRY__ITEM_PROGRESS;
    message.progress = &progress;
    progress.fraction = 0.5;
    fake_daemon_publish(fixture->daemon, "progress", &message);
}

/* How many messages the client says it lost before the next one. */
static uint64_t next_lost(MnsClient *client)
{
    MnsTelemetry *telemetry = NULL;
    assert_int_equal(mns_client_next(client, 5, &telemetry, NULL), MNS_OK);
    assert_int_equal(telemetry->topic, MNS_TOPIC_PROGRESS);
    assert_true(telemetry->fraction > 0.49 && telemetry->fraction < 0.51);
    assert_true(isnan(telemetry->eta_s));
    const uint64_t lost = telemetry->lost;
    mns_telemetry_free(telemetry);
    return lost;
}

static void gaps_in_telemetry_are_counted(void **state)
{
    Fixture *fixture = *state;
    assert_int_equal(mns_client_subscribe(fixture->client, MNS_TOPIC_PROGRESS, NULL), MNS_OK);
    fake_daemon_await_subscribers(fixture->daemon, 1);
    const uint64_t sequences[] = {7, 8, 12, 13}, lost[] = {0, 0, 3, 0};
    for (int k = 0; k < 4; k++) publish_progress(fixture, 1, sequences[k]);
    for (int k = 0; k < 4; k++) assert_int_equal(next_lost(fixture->client), lost[k]);
}

static void a_restarted_daemon_begins_to_count_anew(void **state)
{
    Fixture *fixture = *state;
    assert_int_equal(mns_client_subscribe(fixture->client, MNS_TOPIC_PROGRESS, NULL), MNS_OK);
    fake_daemon_await_subscribers(fixture->daemon, 1);
    publish_progress(fixture, 1, 5);
    publish_progress(fixture, 2, 900);
    publish_progress(fixture, 2, 902);
    assert_int_equal(next_lost(fixture->client), 0);
    assert_int_equal(next_lost(fixture->client), 0);
    assert_int_equal(next_lost(fixture->client), 1);
}

static void unreadable_telemetry_is_reported_and_the_next_is_read(void **state)
{
    Fixture *fixture = *state;
    MnsTelemetry *telemetry = NULL;
    assert_int_equal(mns_client_subscribe(fixture->client, MNS_TOPIC_PROGRESS, NULL), MNS_OK);
    fake_daemon_await_subscribers(fixture->daemon, 1);
    fake_daemon_publish_bytes(fixture->daemon, "progress", "\xff\xff\xff", 3);
    publish_progress(fixture, 1, 1);
    assert_int_equal(mns_client_next(fixture->client, 5, &telemetry, NULL), MNS_E_CORRUPT);
    assert_int_equal(next_lost(fixture->client), 0);
}

static void listening_without_subscription_or_messages_says_so(void **state)
{
    Fixture *fixture = *state;
    MnsTelemetry *telemetry = NULL;
    assert_int_equal(mns_client_next(fixture->client, 0, &telemetry, NULL), MNS_E_STATE);
    assert_int_equal(mns_client_subscribe(fixture->client, 0, NULL), MNS_E_INVALID);
    assert_int_equal(mns_client_subscribe(fixture->client, MNS_TOPIC_ALL, NULL), MNS_OK);
    assert_int_equal(mns_client_next(fixture->client, 0.05, &telemetry, NULL), MNS_E_TIMEOUT);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(a_reply_carries_state_and_step_of_the_effect),
        TEST(every_command_has_an_id_of_its_own),
        TEST(a_chosen_id_is_used_once),
        TEST(a_condition_goes_with_one_command),
        TEST(codes_become_statuses_with_sentence_and_path),
        TEST(a_code_nobody_knows_is_a_failure),
        TEST(a_reply_without_a_code_is_no_success),
        TEST(the_reason_is_more_exact_than_the_code),
        TEST(a_lost_connection_repeats_the_request_under_the_same_id),
        TEST(a_restarted_daemon_is_given_the_command_again_under_its_id),
        TEST(a_command_that_ends_every_daemon_is_not_given_to_each),
        TEST(a_wait_is_given_to_every_daemon_that_comes),
        TEST(a_shutdown_does_not_end_the_daemon_that_is_started_after_it),
        TEST(answers_to_other_requests_are_passed_over),
        TEST(silence_ends_with_the_time_limit),
        TEST(a_daemon_that_dies_is_noticed_without_a_time_limit),
        TEST(a_daemon_that_dies_is_waited_for_no_longer_than_wanted),
        TEST(it_can_be_told_for_how_long_a_daemon_is_away),
        TEST(arrays_come_whole_and_aligned),
        TEST(a_damaged_array_is_refused),
        TEST(a_missing_array_is_refused),
        TEST(a_shape_that_does_not_fit_its_frame_is_refused),
        TEST(a_reply_that_is_none_is_refused_and_the_next_is_read),
        TEST(an_assignment_without_equals_sign_is_not_sent),
        TEST(what_is_said_for_a_command_that_is_not_sent_is_for_no_other),
        TEST(gaps_in_telemetry_are_counted),
        TEST(a_restarted_daemon_begins_to_count_anew),
        TEST(unreadable_telemetry_is_reported_and_the_next_is_read),
        TEST(listening_without_subscription_or_messages_says_so),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
