/* SPDX-License-Identifier: BSD-3-Clause */
/* Whatever bytes arrive, the daemon answers with a sentence where it can, and is there afterwards. */
#include "common/wire/frame.h"
#include "tests/support/check.h"
#include "tests/support/steer.h"
#include <endian.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>
#include <zmq.h>

static void assert_alive(Dialogue *dialogue)
{
    Meniscus__Request request = dialogue_status();
    assert_int_equal(dialogue_code(dialogue, &request), MENISCUS__CODE__OK);
}

static void assert_refused(Dialogue *dialogue, Meniscus__Code code)
{
    Meniscus__Reply *reply = dialogue_receive(dialogue->control, NULL);
    assert_non_null(reply);
    assert_int_equal(reply->code, code);
    assert_true(strlen(reply->message) > 10);
    meniscus__reply__free_unpacked(reply, NULL);
    assert_alive(dialogue);
}

static void bytes_that_are_no_request_are_refused(void **state)
{
    Dialogue *dialogue = *state;
    zmq_send(dialogue->control, "\xff\xff\xff\xffgarbage", 11, 0);
    assert_refused(dialogue, MENISCUS__CODE__INVALID_ARGUMENT);
}

static void an_empty_frame_has_no_version(void **state)
{
    Dialogue *dialogue = *state;
    zmq_send(dialogue->control, "", 0, 0);
    assert_refused(dialogue, MENISCUS__CODE__UNIMPLEMENTED);
}

static void several_frames_are_refused(void **state)
{
    Dialogue *dialogue = *state;
    for (int k = 0; k < 5; k++) zmq_send(dialogue->control, "x", 1, k < 4 ? ZMQ_SNDMORE : 0);
    assert_refused(dialogue, MENISCUS__CODE__INVALID_ARGUMENT);
}

/* More parts than are read in one go, and another client's request behind them. */
static void a_message_of_many_parts_is_refused_with_their_number(void **state)
{
    Dialogue *dialogue = *state;
    enum { PARTS = 100000 };
    void *other = dialogue_connect(dialogue);
    for (int k = 0; k < PARTS; k++) assert_int_equal(zmq_send(other, "x", 1, k < PARTS - 1 ? ZMQ_SNDMORE : 0), 1);
    Meniscus__Reply *reply = dialogue_receive(other, NULL);
    assert_non_null(reply);
    assert_int_equal(reply->code, MENISCUS__CODE__INVALID_ARGUMENT);
    assert_non_null(strstr(reply->message, "100000"));
    meniscus__reply__free_unpacked(reply, NULL);
    assert_alive(dialogue);
}

/* By a client of its own making, as libzmq does not send a message that is not whole. */
static void a_message_without_end_keeps_nobody_waiting_and_goes_with_its_sender(void **state)
{
    Dialogue *dialogue = *state;
    static uint8_t parts[3 * 4096];
    for (size_t k = 0; k < sizeof parts; k += 3) parts[k] = parts[k + 1] = 1, parts[k + 2] = 'x';
    const int fd = dialogue_by_hand(dialogue->endpoint, "DEALER", NULL, 0);
    for (int k = 0; k < 32; k++) {
        assert_int_equal(send(fd, parts, sizeof parts, MSG_NOSIGNAL), sizeof parts);
        assert_alive(dialogue);
    }
    close(fd);
    assert_alive(dialogue);
}

static void another_version_is_refused_under_its_id(void **state)
{
    Dialogue *dialogue = *state;
    uint8_t id[16];
    Meniscus__Request request = dialogue_status();
    dialogue_seal(&request, id);
    request.major = 2;
    dialogue_send(dialogue->control, &request);
    Meniscus__Reply *reply = dialogue_receive(dialogue->control, NULL);
    assert_non_null(reply);
    assert_int_equal(reply->code, MENISCUS__CODE__UNIMPLEMENTED);
    assert_memory_equal(reply->id.data, id, sizeof id);
    meniscus__reply__free_unpacked(reply, NULL);
    assert_alive(dialogue);
}

static void a_request_without_an_id_is_refused(void **state)
{
    Dialogue *dialogue = *state;
    uint8_t id[16];
    Meniscus__Request request = dialogue_status();
    dialogue_seal(&request, id);
    request.id.len = 3;
    dialogue_send(dialogue->control, &request);
    assert_refused(dialogue, MENISCUS__CODE__INVALID_ARGUMENT);
}

static void a_request_without_a_command_is_refused(void **state)
{
    Dialogue *dialogue = *state;
    uint8_t id[16];
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    dialogue_say(dialogue->control, &request, id);
    assert_refused(dialogue, MENISCUS__CODE__UNIMPLEMENTED);
}

/* By hand: a client of libzmq would connect again, and nobody would know. */
static void an_oversized_frame_costs_its_sender_the_connection_only(void **state)
{
    Dialogue *dialogue = *state;
    const uint64_t size = htobe64(FRAME_TAKEN + 1);
    uint8_t head[9] = {2}; /* a long frame, and the last one */
    char byte;
    memcpy(head + 1, &size, sizeof size);
    const int fd = dialogue_by_hand(dialogue->endpoint, "DEALER", NULL, 0);
    assert_int_equal(send(fd, head, sizeof head, MSG_NOSIGNAL), sizeof head);
    assert_int_equal(recv(fd, &byte, 1, 0), 0);
    close(fd);
    assert_alive(dialogue);
}

/* Every command with nothing in it: refused or harmless, never a crash. */
static void commands_without_entries_are_answered(void **state)
{
    Dialogue *dialogue = *state;
    dialogue_load(dialogue, NULL);
    for (unsigned k = 0; k < meniscus__request__descriptor.n_fields; k++) {
        const ProtobufCFieldDescriptor *field = &meniscus__request__descriptor.fields[k];
        const unsigned tag = field->id;
        uint8_t id[16], frame[64], *at = frame;
        if (!(field->flags & PROTOBUF_C_FIELD_FLAG_ONEOF)) continue;
        if (tag == MENISCUS__REQUEST__COMMAND_SHUTDOWN || tag == MENISCUS__REQUEST__COMMAND_WAIT) continue;
        Meniscus__Request request = MENISCUS__REQUEST__INIT;
        dialogue_seal(&request, id);
        at += meniscus__request__pack(&request, frame);
        const unsigned key = tag << 3 | 2;
        *at++ = (uint8_t)(key | 0x80);
        *at++ = (uint8_t)(key >> 7);
        *at++ = 0;
        zmq_send(dialogue->control, frame, (size_t)(at - frame), 0);
        Meniscus__Reply *reply = dialogue_receive(dialogue->control, NULL);
        assert_non_null(reply);
        assert_memory_equal(reply->id.data, id, sizeof id);
        assert_true(reply->code == MENISCUS__CODE__OK || strlen(reply->message) > 10);
        meniscus__reply__free_unpacked(reply, NULL);
    }
    assert_alive(dialogue);
}

/* How many replies have come, without a wait for more. */
static int count_replies(void *socket, long patience_ms)
{
    int n = 0;
    zmq_pollitem_t item = {.socket = socket, .events = ZMQ_POLLIN};
    while (zmq_poll(&item, 1, patience_ms) == 1) {
        size_t frames;
        Meniscus__Reply *reply = dialogue_receive(socket, &frames);
        assert_non_null(reply);
        meniscus__reply__free_unpacked(reply, NULL);
        n++;
    }
    return n;
}

/* A query with bytes changed at random: most are refused, all are answered but one that became a wait. */
static void requests_with_flipped_bytes_do_no_harm(void **state)
{
    Dialogue *dialogue = *state;
    uint8_t id[16], packed[256];
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    Meniscus__Query query = MENISCUS__QUERY__INIT;
    Meniscus__ParticleQuery which = MENISCUS__PARTICLE_QUERY__INIT;
    double corner[2] = {0, 0};
    dialogue_load(dialogue, NULL);
    which.n_min = which.n_max = 2;
    which.min = which.max = corner;
    query.what_case = MENISCUS__QUERY__WHAT_PARTICLES;
    query.particles = &which;
    request.command_case = MENISCUS__REQUEST__COMMAND_QUERY;
    request.query = &query;
    srand(7);
    void *other = dialogue_connect(dialogue);
    int answered = 0;
    for (int k = 0; k < 2000; k++) {
        dialogue_seal(&request, id);
        const size_t size = meniscus__request__pack(&request, packed);
        for (int j = 0; j < 3; j++) packed[(size_t)rand() % size] = (uint8_t)rand();
        assert_int_equal(zmq_send(other, packed, size, 0), size);
        answered += count_replies(other, 0);
    }
    for (const double until = steer_now() + 60; answered < 1990 && steer_now() < until;)
        answered += count_replies(other, 100);
    answered += count_replies(other, 100);
    assert_in_range(answered, 1990, 2000);
    assert_alive(dialogue);
}

static void random_frames_do_no_harm(void **state)
{
    Dialogue *dialogue = *state;
    uint8_t frame[512];
    srand(3);
    void *other = dialogue_connect(dialogue);
    for (int k = 0; k < 3000; k++) {
        const size_t size = (size_t)rand() % sizeof frame;
        for (size_t j = 0; j < size; j++) frame[j] = (uint8_t)rand();
        assert_int_equal(zmq_send(other, frame, size, rand() % 4 ? 0 : ZMQ_SNDMORE), size);
        count_replies(other, 0);
    }
    assert_alive(dialogue);
}

static void a_client_that_vanishes_leaves_its_command_running(void **state)
{
    Dialogue *dialogue = *state;
    uint8_t id[16];
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    Meniscus__Step step = MENISCUS__STEP__INIT;
    dialogue_load(dialogue, NULL);
    step.has_count = 1;
    step.count = 40;
    request.command_case = MENISCUS__REQUEST__COMMAND_STEP;
    request.step = &step;
    void *other = dialogue_connect(dialogue);
    dialogue_say(other, &request, id);
    nanosleep(&(struct timespec){.tv_nsec = 50000000}, NULL);
    assert_int_equal(zmq_disconnect(other, dialogue->endpoint), 0);
    dialogue_send(dialogue->control, &request); /* the same id, from elsewhere */
    Meniscus__Reply *reply = dialogue_receive(dialogue->control, NULL);
    assert_non_null(reply);
    assert_int_equal(reply->effect_step, 40);
    meniscus__reply__free_unpacked(reply, NULL);
}

static void rubbish_on_the_telemetry_socket_does_no_harm(void **state)
{
    Dialogue *dialogue = *state;
    char endpoint[160];
    void *socket = dialogue_socket(dialogue, ZMQ_XSUB);
    snprintf(endpoint, sizeof endpoint, "ipc://%s/meniscus/t/telemetry.ipc", dialogue->home);
    assert_int_equal(zmq_connect(socket, endpoint), 0);
    for (int k = 0; k < 200; k++) assert_int_equal(zmq_send(socket, "\x01progress\xff\xfe and more", 20, 0), 20);
    for (int k = 0; k < 200; k++) assert_int_equal(zmq_send(socket, "\x07\x00\x01", 3, 0), 3);
    assert_alive(dialogue);
}

/* Else a machine that is switched off would be a listener for good: where nothing is published, nothing is sent to it that could fail. */
static void a_listener_is_asked_whether_it_is_there_when_nothing_is_published(void **state)
{
    static const char subscribe[] = "\0\6\1quiet", ping[] = "\4PING";
    const Dialogue *dialogue = *state;
    char endpoint[160], got[64];
    const char *name = strrchr(dialogue->endpoint, '/');
    snprintf(endpoint, sizeof endpoint, "%.*s/telemetry.ipc", (int)(name - dialogue->endpoint), dialogue->endpoint);
    const int fd = dialogue_by_hand(endpoint, "SUB", NULL, 0);
    assert_int_equal(send(fd, subscribe, sizeof subscribe - 1, MSG_NOSIGNAL), sizeof subscribe - 1);
    assert_int_equal(recv(fd, got, 2, MSG_WAITALL), 2); /* within ten seconds */
    assert_int_equal(got[0], 4);
    assert_int_equal(recv(fd, got, sizeof ping - 1, MSG_WAITALL), sizeof ping - 1);
    assert_memory_equal(got, ping, sizeof ping - 1);
    close(fd);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(bytes_that_are_no_request_are_refused, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(an_empty_frame_has_no_version, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(several_frames_are_refused, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(a_message_of_many_parts_is_refused_with_their_number, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(a_message_without_end_keeps_nobody_waiting_and_goes_with_its_sender,
                                        steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(another_version_is_refused_under_its_id, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(a_request_without_an_id_is_refused, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(a_request_without_a_command_is_refused, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(an_oversized_frame_costs_its_sender_the_connection_only, steer_begin,
                                        steer_end),
        cmocka_unit_test_setup_teardown(commands_without_entries_are_answered, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(requests_with_flipped_bytes_do_no_harm, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(random_frames_do_no_harm, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(a_client_that_vanishes_leaves_its_command_running, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(rubbish_on_the_telemetry_socket_does_no_harm, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(a_listener_is_asked_whether_it_is_there_when_nothing_is_published, steer_begin,
                                        steer_end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
