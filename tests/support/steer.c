/* SPDX-License-Identifier: BSD-3-Clause */
/* What tests say to a daemon, in one call each. */
#include "tests/support/steer.h"

#include "tests/support/check.h"
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <zmq.h>

/* --- a daemon for each test ---------------------------------------------------------------------------------------------- */

int steer_begin(void **state)
{
    Dialogue *dialogue = calloc(1, sizeof *dialogue);
    dialogue_begin(dialogue, NULL);
    *state = dialogue;
    return 0;
}

int steer_end(void **state)
{
    const int code = dialogue_end(*state);
    free(*state);
    return code;
}

int steer_end_somehow(void **state)
{
    steer_end(state);
    return 0;
}

double steer_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

void steer_sleep(long milliseconds)
{
    nanosleep(&(struct timespec){.tv_sec = milliseconds / 1000, .tv_nsec = milliseconds % 1000 * 1000000}, NULL);
}

void steer_path(const Dialogue *dialogue, const char *name, char ret[static 256])
{
    snprintf(ret, 256, "%s/state/%s", dialogue->home, name);
}

void steer_load_here(Dialogue *dialogue, const char *const *settings, char ret_here[static 256])
{
    steer_path(dialogue, "dam", ret_here);
    dialogue_load(dialogue, settings);
}

static void rename_run(const Dialogue *dialogue, const char *from, const char *to)
{
    char old[256], new[256];
    steer_path(dialogue, from, old);
    steer_path(dialogue, to, new);
    assert_int_equal(rename(old, new), 0);
}

void steer_take_away(const Dialogue *dialogue)
{
    rename_run(dialogue, "dam", "away");
}

void steer_bring_back(const Dialogue *dialogue)
{
    rename_run(dialogue, "away", "dam");
}

int steer_count(const char *directory, const char *like)
{
    DIR *stream = opendir(directory);
    int n = 0;
    assert_non_null(stream);
    for (const struct dirent *entry; (entry = readdir(stream));)
        n += !strncmp(entry->d_name, like, strlen(like)) && !strstr(entry->d_name, ".tmp");
    closedir(stream);
    return n;
}

/* --- requests ------------------------------------------------------------------------------------------------------------ */

Meniscus__Code steer_code(Dialogue *dialogue, Meniscus__Request request)
{
    return dialogue_code(dialogue, &request);
}

static Meniscus__Request plain(Meniscus__Request__CommandCase which)
{
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    request.command_case = which;
    return request;
}

Meniscus__Reply *steer_status(Dialogue *dialogue)
{
    Meniscus__Request request = dialogue_status();
    Meniscus__Reply *reply = dialogue_ask(dialogue, &request);
    assert_int_equal(reply->result_case, MENISCUS__REPLY__RESULT_STATUS);
    return reply;
}

Meniscus__Reply *steer_step(Dialogue *dialogue, uint64_t n)
{
    Meniscus__Request request = plain(MENISCUS__REQUEST__COMMAND_STEP);
    Meniscus__Step command = MENISCUS__STEP__INIT;
    command.has_count = 1;
    command.count = n;
    request.step = &command;
    return dialogue_ask(dialogue, &request);
}

static Meniscus__Request until_request(Meniscus__RunUntil *until, double t)
{
    Meniscus__Request request = plain(MENISCUS__REQUEST__COMMAND_RUN_UNTIL);
    meniscus__run_until__init(until);
    until->has_time = 1;
    until->time = t;
    request.run_until = until;
    return request;
}

Meniscus__Reply *steer_until(Dialogue *dialogue, double t)
{
    Meniscus__RunUntil until;
    Meniscus__Request request = until_request(&until, t);
    return dialogue_ask(dialogue, &request);
}

void steer_say_until(void *socket, double t, uint8_t *id)
{
    Meniscus__RunUntil until;
    Meniscus__Request request = until_request(&until, t);
    dialogue_say(socket, &request, id);
}

enum { ENTRIES = 4 };

/* A change of n entries, and where its parts are. */
typedef struct Change {
    Meniscus__Set set;
    Meniscus__Assignment assignments[ENTRIES], *list[ENTRIES];
} Change;

static Meniscus__Request set_request(Change *change, size_t n, const char *const (*pairs)[2])
{
    Meniscus__Request request = plain(MENISCUS__REQUEST__COMMAND_SET);
    assert_true(n <= ENTRIES);
    meniscus__set__init(&change->set);
    for (size_t k = 0; k < n; k++) {
        meniscus__assignment__init(&change->assignments[k]);
        change->assignments[k].path = (char *)pairs[k][0];
        change->assignments[k].value = (char *)pairs[k][1];
        change->list[k] = &change->assignments[k];
    }
    change->set.n_assignments = n;
    change->set.assignments = change->list;
    request.set = &change->set;
    return request;
}

Meniscus__Reply *steer_set(Dialogue *dialogue, const char *path, const char *value)
{
    Change change;
    const char *const pair[1][2] = {{path, value}};
    Meniscus__Request request = set_request(&change, 1, pair);
    return dialogue_ask(dialogue, &request);
}

Meniscus__Reply *steer_set_under(Dialogue *dialogue, const Meniscus__Request *under, const char *path,
                                 const char *value)
{
    Change change;
    const char *const pair[1][2] = {{path, value}};
    const Meniscus__Request set = set_request(&change, 1, pair);
    Meniscus__Request request = *under;
    request.command_case = set.command_case;
    request.set = set.set;
    return dialogue_ask(dialogue, &request);
}

Meniscus__Code steer_set_all(Dialogue *dialogue, size_t n, const char *const (*pairs)[2])
{
    Change change;
    Meniscus__Request request = set_request(&change, n, pairs);
    return dialogue_code(dialogue, &request);
}

void steer_say_set(void *socket, size_t n, const char *const (*pairs)[2], uint8_t *id)
{
    Change change;
    Meniscus__Request request = set_request(&change, n, pairs);
    dialogue_say(socket, &request, id);
}

Meniscus__Reply *steer_restore(Dialogue *dialogue, const char *checkpoint)
{
    Meniscus__Request request = plain(MENISCUS__REQUEST__COMMAND_RESTORE);
    Meniscus__Restore restore = MENISCUS__RESTORE__INIT;
    restore.checkpoint = (char *)checkpoint;
    request.restore = &restore;
    return dialogue_ask(dialogue, &request);
}

/* For a state, unless it is NULL, or else a step. */
static Meniscus__Request wait_request(Meniscus__Wait *wait, Meniscus__State *state, uint64_t step)
{
    Meniscus__Request request = plain(MENISCUS__REQUEST__COMMAND_WAIT);
    meniscus__wait__init(wait);
    wait->n_states = state ? 1 : 0;
    wait->states = state;
    wait->has_step = !state;
    wait->step = step;
    request.wait = wait;
    return request;
}

static Meniscus__Reply *wait_patiently(Dialogue *dialogue, Meniscus__Request request, long patience_ms)
{
    request.has_deadline_ms = 1;
    request.deadline_ms = (uint64_t)patience_ms;
    return dialogue_ask(dialogue, &request);
}

Meniscus__Reply *steer_wait(Dialogue *dialogue, Meniscus__State state, long patience_ms)
{
    Meniscus__Wait wait;
    return wait_patiently(dialogue, wait_request(&wait, &state, 0), patience_ms);
}

Meniscus__Reply *steer_wait_step(Dialogue *dialogue, uint64_t step)
{
    Meniscus__Wait wait;
    return wait_patiently(dialogue, wait_request(&wait, NULL, step), 15000);
}

void steer_say_wait(void *socket, uint64_t step, uint8_t *id)
{
    Meniscus__Wait wait;
    Meniscus__Request request = wait_request(&wait, NULL, step);
    dialogue_say(socket, &request, id);
}

void steer_say_wait_for(void *socket, Meniscus__State state, uint8_t *id)
{
    Meniscus__Wait wait;
    Meniscus__Request request = wait_request(&wait, &state, 0);
    dialogue_say(socket, &request, id);
}

/* --- what came of it ----------------------------------------------------------------------------------------------------- */

void steer_accepted(Meniscus__Reply *reply)
{
    if (reply->code != MENISCUS__CODE__OK) fail_msg("refused: %s", reply->message);
    meniscus__reply__free_unpacked(reply, NULL);
}

void steer_refused(Meniscus__Reply *reply, Meniscus__Code code, const char *part)
{
    assert_int_equal(reply->code, code);
    if (!strstr(reply->message, part)) fail_msg("\"%s\" does not say \"%s\"", reply->message, part);
    meniscus__reply__free_unpacked(reply, NULL);
}

void steer_go(Dialogue *dialogue, uint64_t n)
{
    steer_accepted(steer_step(dialogue, n));
}

uint64_t steer_step_now(Dialogue *dialogue)
{
    Meniscus__Reply *reply = steer_status(dialogue);
    const uint64_t step = reply->step;
    meniscus__reply__free_unpacked(reply, NULL);
    return step;
}

void steer_stands_at(Dialogue *dialogue, Meniscus__State state, uint64_t step)
{
    Meniscus__Reply *reply = steer_status(dialogue);
    assert_int_equal(reply->status->state, state);
    assert_int_equal(reply->status->step, step);
    meniscus__reply__free_unpacked(reply, NULL);
}

void steer_wait_for(Dialogue *dialogue, Meniscus__State state)
{
    steer_accepted(steer_wait(dialogue, state, 60000));
}

uint64_t steer_hash(Dialogue *dialogue)
{
    Meniscus__Reply *reply = steer_status(dialogue);
    const uint64_t hash = reply->status->state_hash;
    meniscus__reply__free_unpacked(reply, NULL);
    assert_true(hash != 0);
    return hash;
}

double steer_get(Dialogue *dialogue, const char *path)
{
    Meniscus__Request request = plain(MENISCUS__REQUEST__COMMAND_GET);
    Meniscus__Get get = MENISCUS__GET__INIT;
    char *paths[1] = {(char *)path};
    get.n_paths = 1;
    get.paths = paths;
    request.get = &get;
    Meniscus__Reply *reply = dialogue_ask(dialogue, &request);
    assert_int_equal(reply->code, MENISCUS__CODE__OK);
    assert_int_equal(reply->values->n_values, 1);
    const double number = reply->values->values[0]->number;
    meniscus__reply__free_unpacked(reply, NULL);
    return number;
}

void steer_write_checkpoint(Dialogue *dialogue, char path[static 256])
{
    Meniscus__Request request = dialogue_checkpoint();
    Meniscus__Reply *reply = dialogue_ask(dialogue, &request);
    assert_int_equal(reply->code, MENISCUS__CODE__OK);
    snprintf(path, 256, "%.255s", reply->output->path);
    meniscus__reply__free_unpacked(reply, NULL);
}

void *steer_subscribe(Dialogue *dialogue, const char *topic)
{
    char endpoint[160];
    const int patience = 60000;
    const bool other = strcmp(topic, "event") != 0;
    void *socket = dialogue_socket(dialogue, ZMQ_SUB);
    zmq_setsockopt(socket, ZMQ_RCVTIMEO, &patience, sizeof patience);
    zmq_setsockopt(socket, ZMQ_SUBSCRIBE, topic, strlen(topic));
    snprintf(endpoint, sizeof endpoint, "ipc://%s/meniscus/t/telemetry.ipc", dialogue->home);
    assert_int_equal(zmq_connect(socket, endpoint), 0);
    if (!other) return socket;
    /* The daemon reads subscriptions in order, and answers one to events with the last event: then the topic has arrived too. */
    bool arrived = false;
    for (zmq_setsockopt(socket, ZMQ_SUBSCRIBE, "event", 5); !arrived;) {
        Meniscus__Telemetry *message = steer_hear(socket);
        arrived = message->item_case == MENISCUS__TELEMETRY__ITEM_EVENT;
        meniscus__telemetry__free_unpacked(message, NULL);
    }
    zmq_setsockopt(socket, ZMQ_UNSUBSCRIBE, "event", 5);
    return socket;
}

Meniscus__Telemetry *steer_hear(void *socket)
{
    char topic[16];
    uint8_t packed[4096];
    assert_true(zmq_recv(socket, topic, sizeof topic, 0) > 0);
    const int size = zmq_recv(socket, packed, sizeof packed, 0);
    assert_true(size > 0 && size <= (int)sizeof packed);
    Meniscus__Telemetry *message = meniscus__telemetry__unpack(NULL, (size_t)size, packed);
    assert_non_null(message);
    return message;
}

void steer_hear_of(void *log, const char *part)
{
    for (bool found = false; !found;) {
        Meniscus__Telemetry *note = steer_hear(log);
        assert_int_equal(note->item_case, MENISCUS__TELEMETRY__ITEM_LOG);
        found = strstr(note->log->text, part) != NULL;
        meniscus__telemetry__free_unpacked(note, NULL);
    }
}
