/* SPDX-License-Identifier: BSD-3-Clause */
/* All that comes from afar goes through a process of its own, and whatever becomes of that, the run goes on: no step is lost, no command is, and none is
 * done twice. */
#include "tests/support/castle.h"
#include "tests/support/check.h"
#include "tests/support/steer.h"
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zmq.h>

enum { KILLS = 8, PART = 1 << 20, PARTS = 200, GUESTS = 12, NEVER_HELD_S = 8 };

static int count_descriptors(pid_t process)
{
    char path[64];
    snprintf(path, sizeof path, "/proc/%d/fd", (int)process);
    return steer_count(path, "");
}

/* Resident memory in MiB. */
static long memory_of(pid_t process)
{
    char path[64];
    long pages = 0;
    snprintf(path, sizeof path, "/proc/%d/statm", (int)process);
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    assert_int_equal(fscanf(file, "%*d %ld", &pages), 1);
    fclose(file);
    return pages * sysconf(_SC_PAGESIZE) >> 20;
}

/* Soon; what is left of it may wait for somebody to take note. */
static void assert_ends(pid_t process)
{
    char path[64], state = 'R';
    snprintf(path, sizeof path, "/proc/%d/stat", (int)process);
    for (int k = 0; k < 3000 && state != 'Z'; k++) {
        FILE *file = fopen(path, "r");
        if (!file) return;
        if (fscanf(file, "%*d %*s %c", &state) != 1) state = 'Z';
        fclose(file);
        if (state != 'Z') steer_sleep(20);
    }
    assert_int_equal(state, 'Z');
}

static void assert_here(void *socket)
{
    Meniscus__Reply *reply = castle_ask(socket, dialogue_status());
    assert_non_null(reply);
    assert_int_equal(reply->code, MENISCUS__CODE__OK);
    meniscus__reply__free_unpacked(reply, NULL);
}

/* Status over the local socket, with how long it took at most so far. */
static uint64_t step_of(Castle *castle, double *longest)
{
    const double began = steer_now();
    Meniscus__Request request = dialogue_status();
    Meniscus__Reply *reply = dialogue_ask(&castle->dialogue, &request);
    assert_non_null(reply);
    const uint64_t step = reply->step;
    assert_int_equal(reply->state, MENISCUS__STATE__RUNNING);
    meniscus__reply__free_unpacked(reply, NULL);
    if (steer_now() - began > *longest) *longest = steer_now() - began;
    return step;
}

static void set_in_motion(Castle *castle)
{
    dialogue_load(&castle->dialogue, (const char *const[]){"output.probe_interval=0.01", NULL});
    Meniscus__Request start = dialogue_start();
    assert_int_equal(dialogue_code(&castle->dialogue, &start), MENISCUS__CODE__OK);
}

static Meniscus__Request set_gravity(Meniscus__Set *set, Meniscus__Assignment *assignment, Meniscus__Assignment **list,
                                     char value[static 32], int k)
{
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    meniscus__set__init(set);
    meniscus__assignment__init(assignment);
    snprintf(value, 32, "[0, -1.%03d]", k);
    assignment->path = (char *)"gravity";
    assignment->value = value;
    *list = assignment;
    set->n_assignments = 1;
    set->assignments = list;
    request.command_case = MENISCUS__REQUEST__COMMAND_SET;
    request.set = set;
    return request;
}

/* --- facts ------------------------------------------------------------------------------------------------------------------- */

/* Commands from afar are sent as the gate dies, and each is done once, however often it is sent. */
static void a_gate_that_is_killed_costs_no_step_and_no_command(void **state)
{
    Castle *castle = *state;
    void *far = castle_connect(castle, ZMQ_DEALER, &castle->operator);
    double longest = 0;
    uint64_t version = 0;
    set_in_motion(castle);
    assert_here(far);
    uint64_t step = step_of(castle, &longest);
    pid_t gate = castle_gate(castle, 0);
    for (int k = 1; k <= KILLS; k++) {
        Meniscus__Set set;
        Meniscus__Assignment assignment, *list;
        char value[32];
        assert_true(gate > 0);
        kill(gate, SIGKILL);
        Meniscus__Reply *reply = castle_ask(far, set_gravity(&set, &assignment, &list, value, k));
        assert_non_null(reply);
        if (reply->code != MENISCUS__CODE__OK) fail_msg("%d: %s", k, reply->message);
        if (version) assert_int_equal(reply->case_version, version + 1);
        version = reply->case_version;
        meniscus__reply__free_unpacked(reply, NULL);
        const uint64_t before = step;
        for (int look = 0; look < 10 || step == before; look++) {
            const uint64_t now = step_of(castle, &longest);
            assert_true(now >= step);
            step = now;
            steer_sleep(10);
        }
        gate = castle_gate(castle, gate);
    }
    print_message("status took %.1f ms at most\n", 1e3 * longest);
    assert_less(longest, NEVER_HELD_S);
}

/* The parts of a message after the first. */
static void hear_the_rest(void *listener)
{
    char part[64];
    for (int more = 1; more;) {
        size_t size = sizeof more;
        zmq_getsockopt(listener, ZMQ_RCVMORE, &more, &size);
        if (more) assert_true(zmq_recv(listener, part, sizeof part, 0) >= 0);
    }
}

/* The topic of an event, which progress may be ahead of. */
static void hear_of_an_event(void *listener)
{
    char topic[64];
    for (;;) {
        assert_true(zmq_recv(listener, topic, sizeof topic, 0) >= 5);
        if (!memcmp(topic, "event", 5)) return;
        assert_memory_equal(topic, "progr", 5);
        hear_the_rest(listener);
    }
}

static void who_listens_from_afar_hears_again_what_was_last(void **state)
{
    Castle *castle = *state;
    char topic[64];
    dialogue_load(&castle->dialogue, NULL);
    for (int k = 0; k < 3; k++) {
        void *listener = castle_connect(castle, ZMQ_SUB, &castle->viewer);
        hear_of_an_event(listener);
    }
    void *listener = castle_connect(castle, ZMQ_SUB, &castle->viewer);
    hear_of_an_event(listener);
    kill(castle_gate(castle, 0), SIGKILL);
    hear_the_rest(listener);
    Meniscus__Request step = dialogue_start();
    assert_int_equal(dialogue_code(&castle->dialogue, &step), MENISCUS__CODE__OK);
    for (int heard = 0; heard < 4;)
        heard += zmq_recv(listener, topic, sizeof topic, 0) > 0 && !strncmp(topic, "prog", 4);
}

/* Parts of a message, which this side sends when it has the last one: so many that whoever gets them must not keep them. */
static void send_without_end(void *socket, size_t parts)
{
    static char part[PART];
    for (size_t k = 0; k < parts; k++) assert_int_equal(zmq_send(socket, part, PART, ZMQ_SNDMORE), PART);
    assert_int_equal(zmq_send(socket, part, 1, 0), 1);
}

static void a_message_of_endless_parts_is_ended_and_others_go_on(void **state)
{
    Castle *castle = *state;
    double longest = 0;
    void *viewer = castle_connect(castle, ZMQ_DEALER, &castle->viewer),
         *far = castle_connect(castle, ZMQ_DEALER, &castle->operator);
    set_in_motion(castle);
    assert_here(viewer);
    assert_here(far);
    const pid_t gate = castle_gate(castle, 0);
    const long before = memory_of(castle->dialogue.daemon);
    send_without_end(viewer, PARTS);
    for (int k = 0; k < 50; k++) {
        step_of(castle, &longest);
        steer_sleep(20);
    }
    assert_here(far);
    assert_here(viewer); /* over another connection */
    assert_int_equal(castle_gate(castle, 0), gate);
    print_message("status took %.1f ms at most; the daemon has %ld MiB more\n", 1e3 * longest,
                  memory_of(castle->dialogue.daemon) - before);
    assert_true(memory_of(castle->dialogue.daemon) < before + PARTS / 2);
}

/* As if there were a way to fill its memory after all. */
static void a_gate_without_memory_ends_by_itself_and_alone(void **state)
{
    Castle *castle = *state;
    double longest = 0;
    void *viewer = castle_connect(castle, ZMQ_DEALER, &castle->viewer);
    if (getenv("MENISCUS_SANITIZED")) skip();
    set_in_motion(castle);
    assert_here(viewer);
    const pid_t gate = castle_gate(castle, 0);
    const struct rlimit little = {1 << 20, 1 << 20};
    assert_int_equal(prlimit(gate, RLIMIT_DATA, &little, NULL), 0);
    send_without_end(viewer, PARTS);
    assert_true(castle_gate(castle, gate) > 0);
    const uint64_t step = step_of(castle, &longest);
    void *other = castle_connect(castle, ZMQ_DEALER, &castle->viewer);
    assert_here(other);
    for (int k = 0; k < 500 && step_of(castle, &longest) == step; k++) steer_sleep(20);
    assert_true(step_of(castle, &longest) > step);
    assert_less(longest, NEVER_HELD_S);
}

/* A connection beyond those that a castle has. */
static void *guest(const Castle *castle, void *context, const KeyPair *key)
{
    const int none = 0, patience = 20000;
    char address[64];
    void *socket = zmq_socket(context, ZMQ_DEALER);
    snprintf(address, sizeof address, "tcp://127.0.0.1:%d", castle->port);
    zmq_setsockopt(socket, ZMQ_LINGER, &none, sizeof none);
    zmq_setsockopt(socket, ZMQ_RCVTIMEO, &patience, sizeof patience);
    zmq_setsockopt(socket, ZMQ_CURVE_SERVERKEY, key->server_key, KEY_TEXT);
    zmq_setsockopt(socket, ZMQ_CURVE_PUBLICKEY, key->public_key, KEY_TEXT);
    zmq_setsockopt(socket, ZMQ_CURVE_SECRETKEY, key->secret_key, KEY_TEXT);
    assert_int_equal(zmq_connect(socket, address), 0);
    return socket;
}

/* However many look on. */
static void who_may_steer_always_finds_a_place(void **state)
{
    enum { LOOKERS = 500 };
    Castle *castle = *state;
    void *context = zmq_ctx_new(), *lookers[LOOKERS];
    uint8_t id[16];
    for (int k = 0; k < LOOKERS; k++) {
        Meniscus__Request status = dialogue_status();
        lookers[k] = guest(castle, context, &castle->viewer);
        dialogue_say(lookers[k], &status, id);
    }
    steer_sleep(3000); /* until all have come for whom there is a place */
    assert_here(castle_connect(castle, ZMQ_DEALER, &castle->operator));
    for (int k = 0; k < LOOKERS; k++) zmq_close(lookers[k]);
    zmq_ctx_term(context);
}

static void who_hangs_up_leaves_nothing_behind(void **state)
{
    Castle *castle = *state;
    assert_here(castle_connect(castle, ZMQ_DEALER, &castle->viewer));
    const pid_t daemon = castle->dialogue.daemon, gate = castle_gate(castle, 0);
    const int before = count_descriptors(daemon), at_gate = count_descriptors(gate);
    void *context = zmq_ctx_new(), *guests[GUESTS];
    for (int k = 0; k < GUESTS; k++) {
        guests[k] = guest(castle, context, &castle->viewer);
        assert_here(guests[k]);
    }
    assert_true(count_descriptors(daemon) >= before + GUESTS);
    for (int k = 0; k < GUESTS; k++) zmq_close(guests[k]);
    zmq_ctx_term(context);
    for (int k = 0; k < 600 && count_descriptors(daemon) > before; k++) steer_sleep(100);
    assert_true(count_descriptors(daemon) <= before);
    for (int k = 0; k < 600 && count_descriptors(gate) > at_gate; k++) steer_sleep(100);
    assert_true(count_descriptors(gate) <= at_gate);
}

/* Without a word in return, and gone at once: what was sent is done. */
static void a_command_of_who_does_not_wait_is_done(void **state)
{
    Castle *castle = *state;
    uint8_t id[16];
    set_in_motion(castle);
    void *far = castle_connect(castle, ZMQ_DEALER, &castle->operator);
    assert_here(far);
    Meniscus__Request pause = dialogue_pause();
    dialogue_say(far, &pause, id);
    const int all = -1;
    zmq_setsockopt(far, ZMQ_LINGER, &all, sizeof all);
    castle->dialogue.n_sockets--;
    zmq_close(far);
    steer_wait_for(&castle->dialogue, MENISCUS__STATE__PAUSED);
}

static void who_ends_the_daemon_from_afar_is_told_so(void **state)
{
    Castle *castle = *state;
    void *far = castle_connect(castle, ZMQ_DEALER, &castle->admin);
    assert_here(far);
    const pid_t gate = castle_gate(castle, 0);
    Meniscus__Reply *reply = castle_ask(far, dialogue_shutdown());
    assert_non_null(reply);
    assert_int_equal(reply->code, MENISCUS__CODE__OK);
    meniscus__reply__free_unpacked(reply, NULL);
    dialogue_hang_up(&castle->dialogue);
    assert_int_equal(dialogue_join(&castle->dialogue), 0);
    assert_ends(gate);
}

static void *connect_as(Castle *castle, const KeyPair *pair, const char *name)
{
    char address[64];
    const int patience = 1000;
    void *socket = dialogue_socket(&castle->dialogue, ZMQ_DEALER);
    zmq_setsockopt(socket, ZMQ_RCVTIMEO, &patience, sizeof patience);
    zmq_setsockopt(socket, ZMQ_ROUTING_ID, name, strlen(name));
    zmq_setsockopt(socket, ZMQ_CURVE_SERVERKEY, pair->server_key, KEY_TEXT);
    zmq_setsockopt(socket, ZMQ_CURVE_PUBLICKEY, pair->public_key, KEY_TEXT);
    zmq_setsockopt(socket, ZMQ_CURVE_SECRETKEY, pair->secret_key, KEY_TEXT);
    snprintf(address, sizeof address, "tcp://127.0.0.1:%d", castle->port);
    assert_int_equal(zmq_connect(socket, address), 0);
    return socket;
}

/* The code of a pause; 0: there is no answer, as ZeroMQ gives none to who comes under a name that it holds for taken. */
static int ask_as(Castle *castle, const KeyPair *pair, const char *name)
{
    uint8_t id[16];
    void *socket = connect_as(castle, pair, name);
    Meniscus__Request pause = dialogue_pause();
    dialogue_say(socket, &pause, id);
    Meniscus__Reply *reply = dialogue_receive(socket, NULL);
    const int code = reply ? (int)reply->code : 0;
    if (reply) meniscus__reply__free_unpacked(reply, NULL);
    castle->dialogue.n_sockets--;
    zmq_close(socket);
    return code;
}

/* Connections have names that clients may choose. Whoever takes that of another who has just gone does not get what the other may. */
static void nobody_becomes_another_by_taking_the_name(void **state)
{
    Castle *castle = *state;
    const KeyPair *const pairs[] = {&castle->admin, &castle->viewer};
    const Meniscus__Code codes[] = {MENISCUS__CODE__FAILED_PRECONDITION, MENISCUS__CODE__PERMISSION_DENIED};
    int answers = 0;
    assert_here(castle_connect(castle, ZMQ_DEALER, &castle->viewer));
    for (int k = 0; k < 40 || answers < 10; k++) {
        const int code = ask_as(castle, pairs[k % 2], "somebody");
        if (code) assert_int_equal(code, codes[k % 2]);
        answers += code != 0;
        assert_true(k < 200);
        steer_sleep(k % 4 * 5);
    }
}

/* It is not waited for: neither by the run, nor by those on this machine, nor when the daemon leaves. */
static void a_gate_that_hangs_holds_up_nobody(void **state)
{
    Castle *castle = *state;
    double longest = 0;
    const Guest rest[] = {{"otto", ROLE_OPERATOR, &castle->operator} };
    void *far = castle_connect(castle, ZMQ_DEALER, &castle->operator);
    set_in_motion(castle);
    assert_here(far);
    const pid_t gate = castle_gate(castle, 0);
    kill(gate, SIGSTOP);
    const uint64_t step = step_of(castle, &longest);
    for (int k = 0; k < 50; k++) {
        step_of(castle, &longest);
        steer_sleep(20);
    }
    for (int k = 0; k < 500 && step_of(castle, &longest) == step; k++) steer_sleep(20);
    assert_true(step_of(castle, &longest) > step);
    assert_less(longest, NEVER_HELD_S);
    castle_let_in(castle, 1, rest); /* whose connections end, hang as it may */
    assert_here(far);
    kill(castle_gate(castle, gate), SIGSTOP);
}

/* Once for one that was stopped; what it cost is an end like any other. */
static void a_gate_that_hangs_is_followed_by_another(void **state)
{
    Castle *castle = *state;
    double longest = 0;
    void *far = castle_connect(castle, ZMQ_DEALER, &castle->operator);
    set_in_motion(castle);
    assert_here(far);
    const pid_t gate = castle_gate(castle, 0);
    const double began = steer_now();
    kill(gate, SIGSTOP);
    for (int k = 0; k < 400 && kill(gate, 0) == 0; k++) {
        step_of(castle, &longest);
        steer_sleep(20);
    }
    print_message("it was found out after %.1f s\n", steer_now() - began);
    assert_ends(gate);
    assert_true(steer_now() - began > 2);
    assert_here(far);
    assert_less(longest, NEVER_HELD_S);
    castle_shows(castle, "meniscus_gate_restarts_total 1");
}

/* As when the machine sleeps, or a whole service is frozen: nobody has hung. */
static void a_gate_that_was_stopped_with_the_daemon_goes_on_with_it(void **state)
{
    Castle *castle = *state;
    void *far = castle_connect(castle, ZMQ_DEALER, &castle->operator);
    assert_here(far);
    const pid_t gate = castle_gate(castle, 0), daemon = castle->dialogue.daemon;
    kill(daemon, SIGSTOP);
    kill(gate, SIGSTOP);
    steer_sleep(5000);
    kill(daemon, SIGCONT);
    steer_sleep(500); /* the daemon looks first */
    kill(gate, SIGCONT);
    steer_sleep(4000); /* and nobody says anything */
    assert_here(far);
    assert_int_equal(castle_gate(castle, 0), gate);
    castle_shows(castle, "meniscus_gate_restarts_total 0");
}

static void nobody_else_can_open_what_the_gate_brings_them_in_by(void **state)
{
    Castle *castle = *state;
    struct stat info;
    static const char *const names[] = {"gate-ctrl.ipc", "gate-news.ipc", "gate-data.ipc"};
    char path[160];
    assert_here(castle_connect(castle, ZMQ_DEALER, &castle->viewer)); /* or the last of them may not be there yet */
    for (int k = 0; k < 3; k++) {
        snprintf(path, sizeof path, "%s/meniscus/t/%s", castle->dialogue.home, names[k]);
        assert_int_equal(stat(path, &info), 0);
        assert_int_equal(info.st_mode & 0777, 0600);
    }
}

static void the_gate_of_a_daemon_that_is_killed_makes_way_for_the_next(void **state)
{
    Castle *castle = *state;
    char listen[64], keys[96];
    assert_here(castle_connect(castle, ZMQ_DEALER, &castle->viewer));
    const pid_t gate = castle_gate(castle, 0);
    kill(castle->dialogue.daemon, SIGKILL);
    dialogue_join(&castle->dialogue);
    snprintf(listen, sizeof listen, "--listen=tcp://127.0.0.1:%d", castle->port);
    snprintf(keys, sizeof keys, "--keys=%s", castle->keys);
    dialogue_again(&castle->dialogue, (const char *const[]){listen, keys, NULL});
    assert_here(castle_connect(castle, ZMQ_DEALER, &castle->viewer));
    assert_true(castle_gate(castle, gate) > 0);
    assert_ends(gate);
}

static int end_somehow(void **state)
{
    castle_end(state);
    return 0;
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, castle_begin, castle_end)
    const struct CMUnitTest tests[] = {
        TEST(a_gate_that_is_killed_costs_no_step_and_no_command),
        TEST(who_listens_from_afar_hears_again_what_was_last),
        TEST(a_message_of_endless_parts_is_ended_and_others_go_on),
        TEST(a_gate_without_memory_ends_by_itself_and_alone),
        TEST(who_may_steer_always_finds_a_place),
        TEST(who_hangs_up_leaves_nothing_behind),
        TEST(a_command_of_who_does_not_wait_is_done),
        cmocka_unit_test_setup_teardown(who_ends_the_daemon_from_afar_is_told_so, castle_begin, end_somehow),
        TEST(nobody_becomes_another_by_taking_the_name),
        TEST(a_gate_that_hangs_holds_up_nobody),
        TEST(a_gate_that_hangs_is_followed_by_another),
        TEST(a_gate_that_was_stopped_with_the_daemon_goes_on_with_it),
        TEST(nobody_else_can_open_what_the_gate_brings_them_in_by),
        TEST(the_gate_of_a_daemon_that_is_killed_makes_way_for_the_next),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
