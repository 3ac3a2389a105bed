/* SPDX-License-Identifier: BSD-3-Clause */
/* The door of a daemon that listens to those from afar: who has no key gets not one byte of data, who has one may do what its role
 * allows, and a change of the keys holds at once. */
#include "common/wire/frame.h"
#include "tests/support/castle.h"
#include "tests/support/check.h"
#include "tests/support/steer.h"
#include <arpa/inet.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <unistd.h>
#include <zmq.h>

enum { SILENCE_MS = 700 };

static void assert_code(void *socket, Meniscus__Request request, Meniscus__Code code, const char *part)
{
    Meniscus__Reply *reply = castle_ask(socket, request);
    assert_non_null(reply);
    if (reply->code != code) fail_msg("code %d: %s", (int)reply->code, reply->message);
    if (part && !strstr(reply->message, part)) fail_msg("\"%s\" does not say \"%s\"", reply->message, part);
    meniscus__reply__free_unpacked(reply, NULL);
}

/* Ask, if there is a connection to ask on: no answer comes. */
static void assert_no_answer(void *control)
{
    char frame[64];
    const int silence = SILENCE_MS;
    uint8_t id[16], packed[128];
    Meniscus__Request request = dialogue_status();
    dialogue_seal(&request, id);
    zmq_send(control, packed, meniscus__request__pack(&request, packed), ZMQ_DONTWAIT);
    zmq_setsockopt(control, ZMQ_RCVTIMEO, &silence, sizeof silence);
    assert_int_equal(zmq_recv(control, frame, sizeof frame, 0), -1);
}

/* Whatever comes within a while: how many messages. */
static int hear(void *telemetry, int milliseconds)
{
    int n = 0;
    char frame[64];
    zmq_setsockopt(telemetry, ZMQ_RCVTIMEO, &milliseconds, sizeof milliseconds);
    const double until = steer_now() + 1e-3 * milliseconds;
    while (steer_now() < until && zmq_recv(telemetry, frame, sizeof frame, 0) >= 0) n++;
    return n;
}

/* A first request gets no answer, and nothing is heard. */
static void assert_silence(Castle *castle, const KeyPair *pair)
{
    void *control = castle_connect(castle, ZMQ_DEALER, pair), *telemetry = castle_connect(castle, ZMQ_SUB, pair);
    assert_no_answer(control);
    assert_int_equal(hear(telemetry, SILENCE_MS), 0);
}

/* The run goes on by itself and tells of it all the time. */
static void set_in_motion(Castle *castle)
{
    dialogue_load(&castle->dialogue, (const char *const[]){"output.probe_interval=0.01", NULL});
    Meniscus__Request start = dialogue_start();
    assert_int_equal(dialogue_code(&castle->dialogue, &start), MENISCUS__CODE__OK);
}

/* --- facts ------------------------------------------------------------------------------------------------------------------- */

static void who_is_not_let_in_gets_no_answer_and_hears_nothing(void **state)
{
    Castle *castle = *state;
    set_in_motion(castle);
    KeyPair wrong_server = castle->admin;
    memcpy(wrong_server.server_key, castle->stranger.public_key, KEY_TEXT);
    assert_silence(castle, NULL);
    assert_silence(castle, &castle->stranger);
    assert_silence(castle, &wrong_server);
    void *control = castle_connect(castle, ZMQ_DEALER, &castle->viewer),
         *telemetry = castle_connect(castle, ZMQ_SUB, &castle->viewer);
    char topic[64];
    assert_code(control, dialogue_status(), MENISCUS__CODE__OK, NULL);
    assert_true(zmq_recv(telemetry, topic, sizeof topic, 0) > 0);
}

/* Bytes by hand: what comes back before the connection is closed is the greeting that everybody gets, and nothing else. */
static void assert_greeting_alone(int port, const void *data, size_t size)
{
    static const uint8_t signature[] = {0xff, 0, 0, 0, 0, 0, 0, 0, 1, 0x7f, 3};
    struct sockaddr_in address = {
        .sin_family = AF_INET, .sin_port = htons((uint16_t)port), .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    const struct timeval patience = {.tv_sec = 10};
    uint8_t got[4096];
    size_t n = 0;
    const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    assert_int_equal(connect(fd, (struct sockaddr *)&address, sizeof address), 0);
    if (size) assert_int_equal(send(fd, data, size, MSG_NOSIGNAL), size);
    for (ssize_t more; n < sizeof got && (more = recv(fd, got + n, sizeof got - n, 0)) > 0;) n += (size_t)more;
    close(fd);
    assert_true(n <= 64);
    assert_memory_equal(got, signature, n < sizeof signature ? n : sizeof signature);
    if (n > 12) assert_memory_equal(got + 12, "CURVE", n < 17 ? n - 12 : 5);
    for (size_t k = 17; k < n; k++) assert_int_equal(got[k] & ~1, 0);
}

static void bytes_by_hand_get_the_greeting_and_the_door(void **state)
{
    Castle *castle = *state;
    set_in_motion(castle);
    static const uint8_t null[] =
        "\xff\0\0\0\0\0\0\0\1\x7f\3\0NULL\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0"
        "\4\x1c\5READY\x0bSocket-Type\0\0\0\6DEALER\0\1x";
    static const uint8_t subscriber[] =
        "\xff\0\0\0\0\0\0\0\1\x7f\3\0NULL\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0"
        "\4\x19\5READY\x0bSocket-Type\0\0\0\3SUB\0\1\1";
    static const uint8_t old[] = "\xff\0\0\0\0\0\0\0\1\x7f\1\5\0\0\0\1x"; /* ZMTP 2.0 has no security */
    static const uint8_t ancient[] = "\1\0\2\0x";                         /* nor has 1.0              */
    uint8_t hello[64 + 202] = "\xff\0\0\0\0\0\0\0\1\x7f\3\0CURVE";        /* and a HELLO with no key in it */
    memcpy(hello + 64, "\4\xc8\5HELLO\1", 9);
    for (int port = castle->port; port <= castle->port + 1; port++) {
        assert_greeting_alone(port, null, sizeof null - 1);
        assert_greeting_alone(port, subscriber, sizeof subscriber - 1);
        assert_greeting_alone(port, old, sizeof old - 1);
        assert_greeting_alone(port, ancient, sizeof ancient - 1);
        assert_greeting_alone(port, hello, sizeof hello);
        assert_greeting_alone(port, "GET / HTTP/1.1\r\n\r\n", 18);
        assert_greeting_alone(port, NULL, 0); /* says nothing, and is shown out */
    }
    Meniscus__Request status = dialogue_status();
    assert_int_equal(dialogue_code(&castle->dialogue, &status), MENISCUS__CODE__OK);
}

static void a_role_may_do_so_much_and_is_told_which_one_may_more(void **state)
{
    Castle *castle = *state;
    LoadRequest load;
    void *viewer = castle_connect(castle, ZMQ_DEALER, &castle->viewer),
         *operator= castle_connect(castle, ZMQ_DEALER, &castle->operator),
         *admin = castle_connect(castle, ZMQ_DEALER, &castle->admin);
    dialogue_load_init(&load, "dam", dialogue_case, NULL);
    assert_code(viewer, load.request, MENISCUS__CODE__PERMISSION_DENIED, "admin");
    assert_code(operator, load.request, MENISCUS__CODE__PERMISSION_DENIED,
                "load takes the role admin, and \"otto\" is operator");
    assert_code(admin, load.request, MENISCUS__CODE__OK, NULL);
    dialogue_load_done(&load);
    assert_code(viewer, dialogue_status(), MENISCUS__CODE__OK, NULL);
    assert_code(viewer, dialogue_start(), MENISCUS__CODE__PERMISSION_DENIED,
                "start takes the role operator, and \"vera\" is viewer");
    assert_code(viewer, dialogue_stop(), MENISCUS__CODE__PERMISSION_DENIED, "operator");
    assert_code(operator, dialogue_start(), MENISCUS__CODE__OK, NULL);
    assert_code(viewer, dialogue_pause(), MENISCUS__CODE__PERMISSION_DENIED, "operator");
    assert_code(operator, dialogue_pause(), MENISCUS__CODE__OK, NULL);
    assert_code(operator, dialogue_shutdown(), MENISCUS__CODE__PERMISSION_DENIED, "admin");
}

/* An id that somebody has overheard is no way to what was replied. */
static void who_may_not_give_a_command_is_not_told_what_came_of_it(void **state)
{
    Castle *castle = *state;
    LoadRequest load;
    uint8_t id[16];
    void *viewer = castle_connect(castle, ZMQ_DEALER, &castle->viewer),
         *admin = castle_connect(castle, ZMQ_DEALER, &castle->admin);
    dialogue_load_init(&load, "dam", dialogue_case, NULL);
    dialogue_seal(&load.request, id);
    void *const sockets[] = {admin, viewer, admin};
    const Meniscus__Code codes[] = {MENISCUS__CODE__OK, MENISCUS__CODE__PERMISSION_DENIED, MENISCUS__CODE__OK};
    for (int k = 0; k < 3; k++) {
        dialogue_send(sockets[k], &load.request);
        Meniscus__Reply *reply = dialogue_receive(sockets[k], NULL);
        assert_non_null(reply);
        assert_int_equal(reply->code, codes[k]);
        meniscus__reply__free_unpacked(reply, NULL);
    }
    dialogue_load_done(&load);
}

/* Encryption makes frames longer: what is allowed is still the request. One that is longer is refused by a reply. */
static void a_request_may_be_as_long_as_on_this_machine(void **state)
{
    Castle *castle = *state;
    static const int sizes[] = {FRAME_MAX, FRAME_TAKEN_FAR};
    static const Meniscus__Code codes[] = {MENISCUS__CODE__INVALID_ARGUMENT, MENISCUS__CODE__RESOURCE_EXHAUSTED};
    void *viewer = castle_connect(castle, ZMQ_DEALER, &castle->viewer);
    for (size_t k = 0; k < 2; k++) {
        char *longest = calloc(1, (size_t)sizes[k]);
        assert_int_equal(zmq_send(viewer, longest, (size_t)sizes[k], 0), sizes[k]);
        free(longest);
        Meniscus__Reply *reply = dialogue_receive(viewer, NULL);
        assert_non_null(reply);
        assert_int_equal(reply->code, codes[k]);
        meniscus__reply__free_unpacked(reply, NULL);
    }
}

static void a_new_key_is_let_in_and_a_role_changes_on_a_connection_that_is_open(void **state)
{
    Castle *castle = *state;
    const Guest guests[] = {{"vera", ROLE_OPERATOR, &castle->viewer}, {"otto", ROLE_VIEWER, &castle->operator},
                                                                       {"ada", ROLE_ADMIN, &castle->admin},
                                                                       {"sam", ROLE_VIEWER, &castle->stranger}};
    void *vera = castle_connect(castle, ZMQ_DEALER, &castle->viewer),
         *otto = castle_connect(castle, ZMQ_DEALER, &castle->operator);
    assert_silence(castle, &castle->stranger);
    assert_code(vera, dialogue_pause(), MENISCUS__CODE__PERMISSION_DENIED, "operator");
    assert_code(otto, dialogue_pause(), MENISCUS__CODE__FAILED_PRECONDITION, "EMPTY");
    castle_let_in(castle, 4, guests);
    assert_code(vera, dialogue_pause(), MENISCUS__CODE__FAILED_PRECONDITION, "EMPTY");
    assert_code(otto, dialogue_pause(), MENISCUS__CODE__PERMISSION_DENIED, "operator");
    void *sam = castle_connect(castle, ZMQ_DEALER, &castle->stranger);
    assert_code(sam, dialogue_status(), MENISCUS__CODE__OK, NULL);
}

static void write_in_place(const char *path, const char *text)
{
    const int fd = open(path, O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
    assert_true(fd >= 0);
    assert_int_equal(pwrite(fd, text, strlen(text), 0), strlen(text));
    close(fd);
}

/* Text of the same length, in the same file and perhaps the same tick of the file system's clock: it is not taken for that before. */
static void a_change_in_place_is_noticed_however_small(void **state)
{
    Castle *castle = *state;
    char path[128], other[128], text[128];
    Meniscus__Request load = MENISCUS__REQUEST__INIT; /* of no case: an operator may not, an admin cannot */
    Meniscus__Load nothing = MENISCUS__LOAD__INIT;
    load.command_case = MENISCUS__REQUEST__COMMAND_LOAD;
    load.load = &nothing;
    snprintf(path, sizeof path, "%s/authorized", castle->keys);
    snprintf(other, sizeof other, "%s/other", castle->keys);
    snprintf(text, sizeof text, "vera operator %s\n", castle->viewer.public_key);
    write_in_place(other, text);
    assert_int_equal(rename(other, path), 0);
    void *vera = castle_connect(castle, ZMQ_DEALER, &castle->viewer);
    for (int k = 0; k < 50; k++) {
        assert_code(vera, load, MENISCUS__CODE__PERMISSION_DENIED, "vera");
        memcpy(text, "vera admin   ", 13);
        write_in_place(path, text);
        assert_code(vera, load, MENISCUS__CODE__INVALID_ARGUMENT, NULL);
        memcpy(text, "vera operator", 13);
        write_in_place(path, text);
    }
}

/* What is on its way may still come. */
static void assert_falls_silent(void *telemetry)
{
    for (int k = 0; k < 20 && hear(telemetry, 100); k++) continue;
    assert_int_equal(hear(telemetry, SILENCE_MS), 0);
}

static void a_key_that_is_gone_is_cut_off_at_once_on_open_connections_and_others_go_on(void **state)
{
    Castle *castle = *state;
    set_in_motion(castle);
    const Guest rest[] = {{"otto", ROLE_OPERATOR, &castle->operator}, {"ada", ROLE_ADMIN, &castle->admin}};
    void *vera = castle_connect(castle, ZMQ_DEALER, &castle->viewer),
         *listener = castle_connect(castle, ZMQ_SUB, &castle->viewer);
    void *otto = castle_connect(castle, ZMQ_DEALER, &castle->operator),
         *other = castle_connect(castle, ZMQ_SUB, &castle->operator);
    assert_code(vera, dialogue_status(), MENISCUS__CODE__OK, NULL);
    assert_code(otto, dialogue_status(), MENISCUS__CODE__OK, NULL);
    assert_true(hear(listener, 5000) > 0);
    castle_let_in(castle, 2, rest);
    assert_no_answer(vera);
    assert_falls_silent(listener);
    assert_code(otto, dialogue_status(), MENISCUS__CODE__OK, NULL);
    hear(other, 100);
    assert_true(hear(other, 5000) > 0);
}

static void keys_that_others_could_change_let_nobody_in_until_it_is_mended(void **state)
{
    Castle *castle = *state;
    char path[128];
    snprintf(path, sizeof path, "%s/authorized", castle->keys);
    assert_int_equal(chmod(path, 0666), 0);
    assert_silence(castle, &castle->admin);
    assert_int_equal(chmod(path, 0600), 0);
    void *admin = castle_connect(castle, ZMQ_DEALER, &castle->admin);
    assert_code(admin, dialogue_status(), MENISCUS__CODE__OK, NULL);
}

/* ZMTP lets a client say properties of itself. On this machine it may call itself what it likes, and stays "local". */
static void nobody_becomes_another_by_saying_so(void **state)
{
    Castle *castle = *state;
    uint8_t user[64] = "\7User-Id\0\0\0\x28", packed[128], answer[256], id[16];
    memcpy(user + 12, castle->viewer.public_key, 40);
    const int fd = dialogue_by_hand(castle->dialogue.endpoint, "DEALER", user, 12 + 40);
    Meniscus__Request request = dialogue_pause(); /* vera may not */
    dialogue_seal(&request, id);
    const size_t size = meniscus__request__pack(&request, packed + 2);
    packed[0] = 0; /* one short frame */
    packed[1] = (uint8_t)size;
    assert_int_equal(send(fd, packed, size + 2, MSG_NOSIGNAL), size + 2);
    assert_int_equal(recv(fd, answer, 2, MSG_WAITALL), 2);
    assert_int_equal(answer[0], 0);
    const size_t length = answer[1];
    assert_int_equal(recv(fd, answer, length, MSG_WAITALL), length);
    Meniscus__Reply *reply = meniscus__reply__unpack(NULL, length, answer);
    assert_non_null(reply);
    assert_int_equal(reply->code, MENISCUS__CODE__FAILED_PRECONDITION);
    meniscus__reply__free_unpacked(reply, NULL);
    close(fd);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, castle_begin, castle_end)
    const struct CMUnitTest tests[] = {
        TEST(who_is_not_let_in_gets_no_answer_and_hears_nothing),
        TEST(bytes_by_hand_get_the_greeting_and_the_door),
        TEST(a_role_may_do_so_much_and_is_told_which_one_may_more),
        TEST(who_may_not_give_a_command_is_not_told_what_came_of_it),
        TEST(a_request_may_be_as_long_as_on_this_machine),
        TEST(a_new_key_is_let_in_and_a_role_changes_on_a_connection_that_is_open),
        TEST(a_change_in_place_is_noticed_however_small),
        TEST(a_key_that_is_gone_is_cut_off_at_once_on_open_connections_and_others_go_on),
        TEST(keys_that_others_could_change_let_nobody_in_until_it_is_mended),
        TEST(nobody_becomes_another_by_saying_so),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
