/* SPDX-License-Identifier: BSD-3-Clause */
/* The daemon's promises to people who steer, seen from outside. */
#include "tests/support/check.h"
#include "tests/support/steer.h"
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zmq.h>

/* --- tests ------------------------------------------------------------------------------------------------------------- */

static void sockets_are_for_their_user_alone(void **state)
{
    const Dialogue *dialogue = *state;
    struct stat info;
    assert_int_equal(stat(dialogue->endpoint + strlen("ipc://"), &info), 0);
    assert_int_equal(info.st_mode & 0777, 0600);
}

static void an_empty_daemon_says_so_and_refuses_to_start(void **state)
{
    Dialogue *dialogue = *state;
    Meniscus__Request request = dialogue_start();
    Meniscus__Reply *reply = dialogue_ask(dialogue, &request);
    assert_int_equal(reply->code, MENISCUS__CODE__FAILED_PRECONDITION);
    assert_int_equal(reply->state, MENISCUS__STATE__EMPTY);
    assert_int_equal(reply->n_allowed, 1);
    assert_int_equal(reply->allowed[0], MENISCUS__STATE__READY);
    meniscus__reply__free_unpacked(reply, NULL);
}

static void pause_is_answered_when_the_solver_stands(void **state)
{
    Dialogue *dialogue = *state;
    dialogue_load(dialogue, NULL);
    assert_int_equal(steer_code(dialogue, dialogue_start()), MENISCUS__CODE__OK);
    steer_accepted(steer_wait_step(dialogue, 1));
    Meniscus__Request request = dialogue_pause();
    Meniscus__Reply *reply = dialogue_ask(dialogue, &request);
    assert_int_equal(reply->code, MENISCUS__CODE__OK);
    assert_int_equal(reply->state, MENISCUS__STATE__PAUSED);
    assert_true(reply->effect_step > 0);
    steer_sleep(50);
    steer_stands_at(dialogue, MENISCUS__STATE__PAUSED, reply->effect_step);
    meniscus__reply__free_unpacked(reply, NULL);
}

static void pause_overtakes_a_thousand_queued_commands(void **state)
{
    Dialogue *dialogue = *state;
    uint8_t ids[1000][16], pause_id[16];
    dialogue_load(dialogue, NULL);
    assert_int_equal(steer_code(dialogue, dialogue_start()), MENISCUS__CODE__OK);
    for (int k = 0; k < 1000; k++) {
        Meniscus__Request request = dialogue_resume();
        dialogue_say(dialogue->control, &request, ids[k]);
    }
    Meniscus__Request pause = dialogue_pause();
    dialogue_say(dialogue->control, &pause, pause_id);
    for (int k = 0; k < 1001; k++) {
        Meniscus__Reply *reply = dialogue_receive(dialogue->control, NULL);
        assert_non_null(reply);
        meniscus__reply__free_unpacked(reply, NULL);
    }
    Meniscus__Reply *reply = steer_status(dialogue);
    assert_int_equal(reply->status->state, MENISCUS__STATE__PAUSED);
    meniscus__reply__free_unpacked(reply, NULL);
}

static void steps_are_counted_exactly(void **state)
{
    Dialogue *dialogue = *state;
    dialogue_load(dialogue, NULL);
    Meniscus__Reply *reply = steer_step(dialogue, 7);
    assert_int_equal(reply->code, MENISCUS__CODE__OK);
    assert_int_equal(reply->state, MENISCUS__STATE__PAUSED);
    assert_int_equal(reply->effect_step, 7);
    meniscus__reply__free_unpacked(reply, NULL);
    reply = steer_step(dialogue, 0);
    assert_int_equal(reply->code, MENISCUS__CODE__INVALID_ARGUMENT);
    meniscus__reply__free_unpacked(reply, NULL);
    steer_stands_at(dialogue, MENISCUS__STATE__PAUSED, 7);
}

static void run_until_is_exact_and_survives_other_commands(void **state)
{
    Dialogue *dialogue = *state;
    uint8_t id[16];
    const char *const settings[] = {"resolution=20", NULL};
    dialogue_load(dialogue, settings);
    steer_say_until(dialogue->control, 0.12345, id);
    void *other = dialogue_connect(dialogue);
    Meniscus__Request requests[2] = {dialogue_start(), dialogue_status()};
    for (int k = 0; k < 20; k++) {
        uint8_t other_id[16];
        dialogue_say(other, &requests[k % 2], other_id);
        Meniscus__Reply *reply = dialogue_receive(other, NULL);
        assert_non_null(reply);
        meniscus__reply__free_unpacked(reply, NULL);
    }
    Meniscus__Reply *reply = dialogue_receive(dialogue->control, NULL);
    assert_non_null(reply);
    assert_memory_equal(reply->id.data, id, 16);
    assert_int_equal(reply->code, MENISCUS__CODE__OK);
    assert_true(reply->time == 0.12345);
    meniscus__reply__free_unpacked(reply, NULL);
}

static void say_cancel(void *socket, uint8_t *id, uint8_t *cancel_id)
{
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    Meniscus__Cancel cancel = MENISCUS__CANCEL__INIT;
    cancel.has_id = 1;
    cancel.id = (ProtobufCBinaryData){.len = 16, .data = id};
    request.command_case = MENISCUS__REQUEST__COMMAND_CANCEL;
    request.cancel = &cancel;
    dialogue_say(socket, &request, cancel_id);
}

static void check_cancelled(void *socket, const uint8_t *id)
{
    Meniscus__Reply *first = dialogue_receive(socket, NULL);
    Meniscus__Reply *second = dialogue_receive(socket, NULL);
    assert_non_null(first);
    assert_non_null(second);
    assert_memory_equal(first->id.data, id, 16);
    assert_int_equal(first->code, MENISCUS__CODE__ABORTED);
    assert_int_equal(second->code, MENISCUS__CODE__OK);
    assert_true(second->state != MENISCUS__STATE__RUNNING);
    meniscus__reply__free_unpacked(first, NULL);
    meniscus__reply__free_unpacked(second, NULL);
}

static void cancel_ends_run_until_with_aborted(void **state)
{
    Dialogue *dialogue = *state;
    uint8_t id[16], cancel_id[16];
    dialogue_load(dialogue, NULL);
    steer_say_until(dialogue->control, 900, id);
    say_cancel(dialogue->control, id, cancel_id);
    check_cancelled(dialogue->control, id);
}

static void a_cancel_is_answered_after_what_it_ends(void **state)
{
    Dialogue *dialogue = *state;
    uint8_t id[16], cancel_id[16];
    void *watcher = dialogue_connect(dialogue);
    dialogue_load(dialogue, NULL);
    steer_say_until(dialogue->control, 900, id);
    steer_say_wait_for(watcher, MENISCUS__STATE__RUNNING, cancel_id);
    steer_accepted(dialogue_receive(watcher, NULL)); /* it is under way, and no longer in the queue */
    say_cancel(dialogue->control, id, cancel_id);
    check_cancelled(dialogue->control, id);
}

static void a_deadline_ends_what_takes_too_long(void **state)
{
    Dialogue *dialogue = *state;
    dialogue_load(dialogue, NULL);
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    Meniscus__Wait wait = MENISCUS__WAIT__INIT;
    wait.has_time = 1;
    wait.time = 1;
    request.command_case = MENISCUS__REQUEST__COMMAND_WAIT;
    request.wait = &wait;
    request.has_deadline_ms = 1;
    request.deadline_ms = 50;
    assert_int_equal(dialogue_code(dialogue, &request), MENISCUS__CODE__DEADLINE_EXCEEDED);
}

/* A single step, under an id that it had before. */
static void check_step_again(Dialogue *dialogue, const Meniscus__Request *request)
{
    dialogue_send(dialogue->control, request);
    Meniscus__Reply *reply = dialogue_receive(dialogue->control, NULL);
    assert_non_null(reply);
    assert_int_equal(reply->effect_step, 1);
    meniscus__reply__free_unpacked(reply, NULL);
}

/* A case, and the request for a step of it under an id. */
static void prepare_step(Dialogue *dialogue, Meniscus__Request *ret, Meniscus__Step *command, uint8_t id[static 16])
{
    dialogue_load(dialogue, NULL);
    meniscus__request__init(ret);
    meniscus__step__init(command);
    ret->command_case = MENISCUS__REQUEST__COMMAND_STEP;
    ret->step = command;
    dialogue_seal(ret, id);
}

static void the_same_request_again_changes_nothing(void **state)
{
    Dialogue *dialogue = *state;
    uint8_t id[16];
    Meniscus__Request request;
    Meniscus__Step command;
    prepare_step(dialogue, &request, &command, id);
    for (int k = 0; k < 3; k++) check_step_again(dialogue, &request);
    steer_stands_at(dialogue, MENISCUS__STATE__PAUSED, 1);
}

/* Nor is it another request's: that is refused, and takes nothing from the first. */
static void the_id_of_another_request_is_refused(void **state)
{
    Dialogue *dialogue = *state;
    uint8_t id[16];
    Meniscus__Request request;
    Meniscus__Step command;
    prepare_step(dialogue, &request, &command, id);
    check_step_again(dialogue, &request);
    command.has_count = 1;
    command.count = 5;
    dialogue_send(dialogue->control, &request);
    steer_refused(dialogue_receive(dialogue->control, NULL), MENISCUS__CODE__INVALID_ARGUMENT, "another request");
    command.has_count = 0;
    request.has_if_step = 1; /* which is asking for something else, too */
    dialogue_send(dialogue->control, &request);
    steer_refused(dialogue_receive(dialogue->control, NULL), MENISCUS__CODE__INVALID_ARGUMENT, "another request");
    request.has_if_step = 0;
    Meniscus__Request start = dialogue_start();
    start.has_major = start.has_id = 1;
    start.major = request.major;
    start.id = request.id;
    dialogue_send(dialogue->control, &start);
    steer_refused(dialogue_receive(dialogue->control, NULL), MENISCUS__CODE__INVALID_ARGUMENT, "another request");
    command.has_count = 0;
    check_step_again(dialogue, &request);
    steer_stands_at(dialogue, MENISCUS__STATE__PAUSED, 1);
}

static void nobody_who_is_refused_has_a_reply_forgotten(void **state)
{
    enum { REFUSED = 5000 }; /* more than are remembered of these */
    Dialogue *dialogue = *state;
    uint8_t id[16];
    Meniscus__Request request;
    Meniscus__Step command;
    prepare_step(dialogue, &request, &command, id);
    check_step_again(dialogue, &request);
    for (int k = 0; k < REFUSED; k++) {
        Meniscus__Request start = dialogue_start(); /* it stands at its first step, and is to be resumed */
        assert_int_equal(dialogue_code(dialogue, &start), MENISCUS__CODE__FAILED_PRECONDITION);
    }
    check_step_again(dialogue, &request);
    steer_stands_at(dialogue, MENISCUS__STATE__PAUSED, 1);
}

/* A wait for the state that it is in, and questions that are refused. */
static void ask_in_vain(Dialogue *dialogue, int k)
{
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    Meniscus__Wait wait = MENISCUS__WAIT__INIT;
    Meniscus__State ready = MENISCUS__STATE__READY;
    wait.n_states = k % 2 ? 1 : 0;
    wait.states = &ready;
    request.command_case = MENISCUS__REQUEST__COMMAND_WAIT;
    request.wait = &wait;
    if (k % 3 == 0) request = dialogue_status();
    assert_int_equal(dialogue_code(dialogue, &request),
                     k % 3 == 0 || k % 2 ? MENISCUS__CODE__OK : MENISCUS__CODE__INVALID_ARGUMENT);
}

/* A command that was refused is not done when it comes again, whatever has been asked since and could be done by then. */
static void nobody_who_asks_has_a_refusal_forgotten(void **state)
{
    enum { QUESTIONS = 13000 }; /* twice as many, of each kind, as are remembered of any */
    Dialogue *dialogue = *state;
    uint8_t id[16];
    Meniscus__Request start = dialogue_start();
    dialogue_seal(&start, id);
    dialogue_send(dialogue->control, &start);
    steer_refused(dialogue_receive(dialogue->control, NULL), MENISCUS__CODE__FAILED_PRECONDITION, "EMPTY");
    dialogue_load(dialogue, NULL);
    for (int k = 0; k < QUESTIONS; k++) ask_in_vain(dialogue, k);
    dialogue_send(dialogue->control, &start);
    steer_refused(dialogue_receive(dialogue->control, NULL), MENISCUS__CODE__FAILED_PRECONDITION, "EMPTY");
    steer_stands_at(dialogue, MENISCUS__STATE__READY, 0);
}

/* The daemon has read all that was said on this connection before. */
static void assert_heard(void *socket)
{
    uint8_t id[16];
    Meniscus__Request status = dialogue_status();
    dialogue_say(socket, &status, id);
    Meniscus__Reply *reply = dialogue_receive(socket, NULL);
    assert_non_null(reply);
    assert_memory_equal(reply->id.data, id, sizeof id);
    meniscus__reply__free_unpacked(reply, NULL);
}

/* The second one does not take the reply away from the first, nor does a fifth leave anybody without one. */
static void each_who_asks_under_the_same_id_is_answered(void **state)
{
    enum { CLIENTS = 6, HEARD = 4 };
    Dialogue *dialogue = *state;
    uint8_t id[16];
    void *clients[CLIENTS];
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    Meniscus__Wait wait = MENISCUS__WAIT__INIT;
    dialogue_load(dialogue, NULL);
    wait.has_step = 1;
    wait.step = 3;
    request.command_case = MENISCUS__REQUEST__COMMAND_WAIT;
    request.wait = &wait;
    dialogue_seal(&request, id);
    for (int k = 0; k < CLIENTS; k++) {
        clients[k] = dialogue_connect(dialogue);
        dialogue_send(clients[k], &request);
        assert_heard(clients[k]); /* so that they come in this order */
    }
    steer_go(dialogue, 3);
    for (int k = 0; k < CLIENTS; k++) {
        Meniscus__Reply *reply = dialogue_receive(clients[k], NULL);
        assert_non_null(reply);
        assert_memory_equal(reply->id.data, id, sizeof id);
        const bool heard = k >= CLIENTS - HEARD;
        assert_int_equal(reply->code, heard ? MENISCUS__CODE__OK : MENISCUS__CODE__RESOURCE_EXHAUSTED);
        if (heard) assert_int_equal(reply->effect_step, 3);
        meniscus__reply__free_unpacked(reply, NULL);
    }
}

static void a_set_of_several_is_all_or_nothing(void **state)
{
    Dialogue *dialogue = *state;
    static const char *const bad[2][2] = {{"end_time", "3"}, {"scheme.cfl", "-1"}};
    static const char *const fixed[1][2] = {{"resolution", "20"}};
    static const char *const twice[3][2] = {{"end_time", "-3"}, {"scheme.cfl", "0.2"}, {"end_time", "3"}};
    static const char *const good[2][2] = {{"end_time", "3"}, {"scheme.cfl", "0.2"}};
    dialogue_load(dialogue, NULL);
    assert_int_equal(steer_set_all(dialogue, 3, twice), MENISCUS__CODE__INVALID_ARGUMENT);
    assert_int_equal(steer_set_all(dialogue, 2, bad), MENISCUS__CODE__INVALID_ARGUMENT);
    assert_true(steer_get(dialogue, "end_time") == 1000);
    assert_int_equal(steer_set_all(dialogue, 1, fixed), MENISCUS__CODE__INVALID_ARGUMENT);
    assert_int_equal(steer_set_all(dialogue, 2, good), MENISCUS__CODE__OK);
    assert_true(steer_get(dialogue, "end_time") == 3);
    assert_true(steer_get(dialogue, "scheme.cfl") == 0.2);
}

static Meniscus__Request particles(Meniscus__Query *query, Meniscus__ParticleQuery *which)
{
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    meniscus__query__init(query);
    query->what_case = MENISCUS__QUERY__WHAT_PARTICLES;
    query->particles = which;
    request.command_case = MENISCUS__REQUEST__COMMAND_QUERY;
    request.query = query;
    return request;
}

static void particles_of_a_box_come_as_raw_frames_within_a_limit(void **state)
{
    Dialogue *dialogue = *state;
    Meniscus__Query query;
    Meniscus__ParticleQuery which = MENISCUS__PARTICLE_QUERY__INIT;
    uint8_t id[16];
    size_t frames = 0;
    dialogue_load(dialogue, NULL);
    Meniscus__Request request = particles(&query, &which);
    dialogue_say(dialogue->control, &request, id);
    Meniscus__Reply *reply = dialogue_receive(dialogue->control, &frames);
    assert_non_null(reply);
    assert_int_equal(reply->code, MENISCUS__CODE__OK);
    assert_int_equal(frames, 3);
    assert_int_equal(reply->n_arrays, 3);
    assert_string_equal(reply->arrays[0]->name, "position");
    assert_int_equal(reply->arrays[0]->shape[0], 200);
    assert_int_equal(reply->arrays[0]->shape[1], 2);
    meniscus__reply__free_unpacked(reply, NULL);
    which.has_limit = 1;
    which.limit = 199;
    assert_int_equal(dialogue_code(dialogue, &request), MENISCUS__CODE__RESOURCE_EXHAUSTED);
}

/* The ids of about one in `every` particles, into ret; how many there are. */
static size_t sampled(Dialogue *dialogue, uint64_t every, uint32_t ret[200])
{
    Meniscus__Query query;
    Meniscus__ParticleQuery which = MENISCUS__PARTICLE_QUERY__INIT;
    char *fields[] = {(char *)"id"};
    Meniscus__Request request = particles(&query, &which);
    uint8_t id[16];
    which.has_every = 1;
    which.every = every;
    which.n_fields = 1;
    which.fields = fields;
    dialogue_say(dialogue->control, &request, id);
    zmq_msg_t frame;
    zmq_msg_init(&frame);
    assert_true(zmq_msg_recv(&frame, dialogue->control, 0) > 0);
    assert_true(zmq_msg_more(&frame));
    assert_true(zmq_msg_recv(&frame, dialogue->control, 0) >= 0);
    const size_t n = zmq_msg_size(&frame) / sizeof *ret;
    assert_true(n <= 200);
    memcpy(ret, zmq_msg_data(&frame), n * sizeof *ret);
    zmq_msg_close(&frame);
    return n;
}

static void one_particle_in_so_many_is_always_the_same(void **state)
{
    Dialogue *dialogue = *state;
    uint32_t all[200], some[200], again[200];
    dialogue_load(dialogue, NULL);
    assert_int_equal(sampled(dialogue, 1, all), 200);
    assert_int_equal(sampled(dialogue, 0, all), 200);
    const size_t n = sampled(dialogue, 5, some);
    assert_in_range(n, 25, 60);
    steer_accepted(steer_step(dialogue, 3));
    assert_int_equal(sampled(dialogue, 5, again), n);
    assert_memory_equal(some, again, n * sizeof *some);
    assert_int_equal(sampled(dialogue, UINT64_MAX, some), 0);
}

static void a_box_has_corners_that_are_numbers(void **state)
{
    Dialogue *dialogue = *state;
    Meniscus__Query query;
    Meniscus__ParticleQuery which = MENISCUS__PARTICLE_QUERY__INIT;
    double corner[2] = {0, NAN}, open[2] = {-INFINITY, 0};
    dialogue_load(dialogue, NULL);
    Meniscus__Request request = particles(&query, &which);
    which.n_min = which.n_max = 2;
    which.min = open;
    which.max = corner;
    steer_refused(dialogue_ask(dialogue, &request), MENISCUS__CODE__INVALID_ARGUMENT, "no number along y");
    corner[1] = INFINITY;
    steer_accepted(dialogue_ask(dialogue, &request));
}

/* However many names are sent, none is looked for then. */
static void names_of_probes_are_counted_before_they_are_looked_for(void **state)
{
    enum { MOST = 256 };
    Dialogue *dialogue = *state;
    char *names[MOST + 1];
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    Meniscus__Query query = MENISCUS__QUERY__INIT;
    Meniscus__ProbeQuery which = MENISCUS__PROBE_QUERY__INIT;
    dialogue_load(dialogue, NULL);
    for (int k = 0; k <= MOST; k++) names[k] = (char *)"nowhere";
    query.what_case = MENISCUS__QUERY__WHAT_PROBES;
    query.probes = &which;
    request.command_case = MENISCUS__REQUEST__COMMAND_QUERY;
    request.query = &query;
    which.names = names;
    which.n_names = MOST + 1;
    steer_refused(dialogue_ask(dialogue, &request), MENISCUS__CODE__RESOURCE_EXHAUSTED,
                  "at most 256 probes at a time, found 257");
    which.n_names = MOST;
    steer_refused(dialogue_ask(dialogue, &request), MENISCUS__CODE__NOT_FOUND, "no probe \"nowhere\"");
}

static void a_breakpoint_pauses_at_its_step(void **state)
{
    Dialogue *dialogue = *state;
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    Meniscus__SetBreakpoint point = MENISCUS__SET_BREAKPOINT__INIT;
    dialogue_load(dialogue, NULL);
    point.name = (char *)"b";
    point.has_step = 1;
    point.step = 5;
    request.command_case = MENISCUS__REQUEST__COMMAND_BREAKPOINT;
    request.breakpoint = &point;
    assert_int_equal(dialogue_code(dialogue, &request), MENISCUS__CODE__OK);
    assert_int_equal(steer_code(dialogue, dialogue_start()), MENISCUS__CODE__OK);
    steer_wait_for(dialogue, MENISCUS__STATE__PAUSED);
    steer_stands_at(dialogue, MENISCUS__STATE__PAUSED, 5);
}

static void a_restored_run_goes_on_bit_for_bit(void **state)
{
    Dialogue *dialogue = *state;
    char path[256];
    dialogue_load(dialogue, NULL);
    steer_go(dialogue, 6);
    steer_write_checkpoint(dialogue, path);
    assert_int_equal(access(path, R_OK), 0);
    steer_go(dialogue, 9);
    const uint64_t straight = steer_hash(dialogue);
    steer_accepted(steer_restore(dialogue, NULL));
    steer_stands_at(dialogue, MENISCUS__STATE__READY, 6);
    steer_go(dialogue, 9);
    assert_true(steer_hash(dialogue) == straight);
}

static void a_subscriber_hears_the_last_event_at_once(void **state)
{
    Dialogue *dialogue = *state;
    dialogue_load(dialogue, NULL);
    void *socket = steer_subscribe(dialogue, "event");
    Meniscus__Telemetry *message = steer_hear(socket);
    assert_int_equal(message->item_case, MENISCUS__TELEMETRY__ITEM_EVENT);
    assert_int_equal(message->event->state, MENISCUS__STATE__READY);
    assert_true(message->sequence > 0);
    meniscus__telemetry__free_unpacked(message, NULL);
}

static bool has_text(size_t n, char *const *list, const char *text)
{
    for (size_t k = 0; k < n; k++)
        if (!strcmp(list[k], text)) return true;
    return false;
}

static void a_daemon_says_how_it_was_built_and_what_it_can_do(void **state)
{
    Dialogue *dialogue = *state;
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    Meniscus__GetCapabilities command = MENISCUS__GET_CAPABILITIES__INIT;
    static const char *const commands[] = {"load", "run_until", "breakpoint", "capabilities", "shutdown"};
    static const char *const topics[] = {"event", "log", "progress", "probe"};
    request.command_case = MENISCUS__REQUEST__COMMAND_CAPABILITIES;
    request.capabilities = &command;
    Meniscus__Reply *reply = dialogue_ask(dialogue, &request);
    const Meniscus__Capabilities *can = reply->capabilities;
    for (size_t k = 0; k < 5; k++) assert_true(has_text(can->n_commands, can->commands, commands[k]));
    assert_int_equal(can->n_topics, 4);
    for (size_t k = 0; k < 4; k++) assert_true(has_text(can->n_topics, can->topics, topics[k]));
    assert_true(strstr(can->compiler, "gcc ") || strstr(can->compiler, "clang "));
    assert_memory_equal(can->build, can->compiler, strlen(can->compiler));
    assert_true(can->n_parameters > 5);
    for (size_t k = 0; k < can->n_parameters; k++)
        assert_string_equal(can->parameters[k]->takes_effect, "from the next step");
    meniscus__reply__free_unpacked(reply, NULL);
}

static void a_second_daemon_of_the_name_is_refused(void **state)
{
    const Dialogue *dialogue = *state;
    char command[4400];
    const char *build = getenv("BUILD");
    snprintf(command, sizeof command, "XDG_RUNTIME_DIR=%s %s/meniscusd --name t --state-dir %s/other 2>/dev/null",
             dialogue->home, build ? build : "build", dialogue->home);
    assert_int_equal(WEXITSTATUS(system(command)), 1);
    assert_int_equal(access(dialogue->endpoint + strlen("ipc://"), F_OK), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(sockets_are_for_their_user_alone, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(names_of_probes_are_counted_before_they_are_looked_for, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(an_empty_daemon_says_so_and_refuses_to_start, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(pause_is_answered_when_the_solver_stands, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(pause_overtakes_a_thousand_queued_commands, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(steps_are_counted_exactly, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(run_until_is_exact_and_survives_other_commands, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(cancel_ends_run_until_with_aborted, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(a_cancel_is_answered_after_what_it_ends, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(a_deadline_ends_what_takes_too_long, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(each_who_asks_under_the_same_id_is_answered, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(the_same_request_again_changes_nothing, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(the_id_of_another_request_is_refused, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(nobody_who_is_refused_has_a_reply_forgotten, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(nobody_who_asks_has_a_refusal_forgotten, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(a_set_of_several_is_all_or_nothing, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(particles_of_a_box_come_as_raw_frames_within_a_limit, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(one_particle_in_so_many_is_always_the_same, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(a_box_has_corners_that_are_numbers, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(a_breakpoint_pauses_at_its_step, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(a_restored_run_goes_on_bit_for_bit, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(a_subscriber_hears_the_last_event_at_once, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(a_daemon_says_how_it_was_built_and_what_it_can_do, steer_begin, steer_end),
        cmocka_unit_test_setup_teardown(a_second_daemon_of_the_name_is_refused, steer_begin, steer_end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
