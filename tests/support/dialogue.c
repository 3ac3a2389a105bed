/* SPDX-License-Identifier: BSD-3-Clause */
/* A meniscusd and connections to it. */
#include "tests/support/dialogue.h"

#include "common/case/load.h"
#include "tests/support/check.h"
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/random.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>
#include <zmq.h>

const char dialogue_case[] = "dimensions: 2\n"
                             "resolution: 10\n"
                             "domain: {min: [0, 0], max: [2, 1]}\n"
                             "gravity: [0, -1]\n"
                             "fluids:\n"
                             "  - {name: water, density: 1000, sound_speed: 20,\n"
                             "     shape: [{box: {min: [0, 0], max: [1, 0.5]}}]}\n"
                             "  - {name: air, density: 1, sound_speed: 20}\n"
                             "walls:\n"
                             "  - {name: tank, shape: [{outside: true, box: {min: [0, 0], max: [2, 1]}}]}\n"
                             "end_time: 1000\n"
                             "threads: 1\n"
                             "probes:\n"
                             "  - {name: front, front: {fluid: water}}\n"
                             "  - {name: energy, kinetic_energy: {}}\n";

static void run_daemon(const Dialogue *dialogue, const char *const *options)
{
    const char *build = getenv("BUILD");
    const char *words[32] = {NULL, "--name", "t", "--state-dir", NULL};
    char program[4096], state[80];
    size_t n = 5;
    snprintf(program, sizeof program, "%s/meniscusd", build ? build : "build");
    snprintf(state, sizeof state, "%s/state", dialogue->home);
    words[0] = program;
    words[4] = state;
    for (; options && *options && n < 31; options++) words[n++] = *options;
    setenv("XDG_RUNTIME_DIR", dialogue->home, 1);
    prctl(PR_SET_PDEATHSIG, SIGKILL); /* a test that fails or is killed leaves no daemon behind */
    if (!getenv("MENISCUS_TEST_LOG")) words[n < 29 ? n++ : n] = "--log-level=error";
    execv(program, (char *const *)words);
    _exit(127);
}

/* However slow the machine is: what ends the wait is the socket, or the end of the daemon. */
static void await_socket(const char *path, pid_t daemon)
{
    enum { PATIENCE = 6000 }; /* hundredths of a second */
    for (int k = 0; access(path, F_OK); k++) {
        if (waitpid(daemon, NULL, WNOHANG) != 0) fail_msg("the daemon ended before it made the socket %s", path);
        if (k == PATIENCE) fail_msg("the daemon has made no socket %s", path);
        nanosleep(&(struct timespec){.tv_nsec = 10000000}, NULL);
    }
}

static void start(Dialogue *dialogue, const char *const *options)
{
    dialogue->daemon = fork();
    if (dialogue->daemon == 0) run_daemon(dialogue, options);
    await_socket(dialogue->endpoint + strlen("ipc://"), dialogue->daemon);
    dialogue->control = dialogue_connect(dialogue);
}

void dialogue_begin(Dialogue *dialogue, const char *const *options)
{
    *dialogue = (Dialogue){.home = "/tmp/mns-dialogue-XXXXXX"};
    assert_non_null(mkdtemp(dialogue->home));
    snprintf(dialogue->endpoint, sizeof dialogue->endpoint, "ipc://%s/meniscus/t/control.ipc", dialogue->home);
    dialogue->context = zmq_ctx_new();
    start(dialogue, options);
}

/* One of several; the last takes its place. */
static void leave(Dialogue *dialogue, void *socket)
{
    for (size_t k = 0; k < dialogue->n_sockets; k++) {
        if (dialogue->sockets[k] != socket) continue;
        zmq_close(socket);
        dialogue->sockets[k] = dialogue->sockets[--dialogue->n_sockets];
        return;
    }
}

int dialogue_join(Dialogue *dialogue)
{
    int how = 0;
    if (dialogue->daemon <= 0 || waitpid(dialogue->daemon, &how, 0) != dialogue->daemon) return -1;
    dialogue->daemon = 0;
    return WIFEXITED(how) ? WEXITSTATUS(how) : -1;
}

void dialogue_again(Dialogue *dialogue, const char *const *options)
{
    unlink(dialogue->endpoint + strlen("ipc://")); /* which start() waits for */
    leave(dialogue, dialogue->control);
    start(dialogue, options);
}

void dialogue_crash(Dialogue *dialogue)
{
    kill(dialogue->daemon, SIGKILL);
    assert_int_equal(dialogue_join(dialogue), -1);
    dialogue_again(dialogue, NULL);
}

int dialogue_end(Dialogue *dialogue)
{
    char command[128];
    dialogue_hang_up(dialogue); /* first, or the daemon would wait for us to read its latest reply */
    if (dialogue->daemon > 0) kill(dialogue->daemon, SIGTERM);
    const int code = dialogue_join(dialogue);
    zmq_ctx_term(dialogue->context);
    snprintf(command, sizeof command, "rm -rf %s", dialogue->home);
    assert_int_equal(system(command), 0);
    return code;
}

void *dialogue_socket(Dialogue *dialogue, int type)
{
    const int none = 0;
    assert_true(dialogue->n_sockets < sizeof dialogue->sockets / sizeof *dialogue->sockets);
    void *socket = zmq_socket(dialogue->context, type);
    assert_non_null(socket);
    dialogue->sockets[dialogue->n_sockets++] = socket;
    zmq_setsockopt(socket, ZMQ_LINGER, &none, sizeof none);
    return socket;
}

void dialogue_hang_up(Dialogue *dialogue)
{
    while (dialogue->n_sockets) zmq_close(dialogue->sockets[--dialogue->n_sockets]);
    dialogue->control = NULL;
}

void *dialogue_connect(Dialogue *dialogue)
{
    const int patience = 90000;
    void *socket = dialogue_socket(dialogue, ZMQ_DEALER);
    zmq_setsockopt(socket, ZMQ_RCVTIMEO, &patience, sizeof patience);
    assert_int_equal(zmq_connect(socket, dialogue->endpoint), 0);
    return socket;
}

/* Messages may follow only when the other side has said READY too: a daemon asks its door first who that is. */
static void await_ready(int fd)
{
    uint8_t head[2], body[256];
    assert_int_equal(recv(fd, head, sizeof head, MSG_WAITALL), sizeof head);
    assert_int_equal(head[0], 4); /* a short command */
    assert_int_equal(recv(fd, body, head[1], MSG_WAITALL), head[1]);
    assert_memory_equal(body, "\5READY", 6);
}

int dialogue_by_hand(const char *endpoint, const char *kind, const void *properties, size_t size)
{
    static const uint8_t greeting[64] = "\xff\0\0\0\0\0\0\0\1\x7f\3\0NULL";
    static const char type[] = "\4\0\5READY\x0bSocket-Type\0\0\0";
    const struct timeval patience = {.tv_sec = 10};
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    uint8_t ready[256], answer[64];
    const size_t n = strlen(kind), head = sizeof type + n, whole = head + size;
    assert_true(whole < sizeof ready);
    memcpy(ready, type, sizeof type - 1);
    ready[sizeof type - 1] = (uint8_t)n;
    memcpy(ready + sizeof type, kind, n);
    if (size) memcpy(ready + head, properties, size);
    ready[1] = (uint8_t)(whole - 2);
    const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    snprintf(address.sun_path, sizeof address.sun_path, "%s", endpoint + strlen("ipc://"));
    int refused = connect(fd, (const struct sockaddr *)&address, sizeof address);
    for (int k = 0; refused && k < 100; k++) { /* the file is there a moment before anybody listens */
        nanosleep(&(struct timespec){.tv_nsec = 10000000}, NULL);
        refused = connect(fd, (const struct sockaddr *)&address, sizeof address);
    }
    assert_int_equal(refused, 0);
    assert_int_equal(send(fd, greeting, sizeof greeting, MSG_NOSIGNAL), sizeof greeting);
    assert_int_equal(recv(fd, answer, sizeof answer, MSG_WAITALL), sizeof answer);
    assert_int_equal(send(fd, ready, whole, MSG_NOSIGNAL), whole);
    await_ready(fd);
    return fd;
}

void dialogue_seal(Meniscus__Request *request, uint8_t *id)
{
    assert_int_equal(getrandom(id, 16, 0), 16);
    request->has_major = request->has_id = 1;
    request->major = MENISCUS__PROTOCOL_VERSION__PROTOCOL_MAJOR;
    request->id = (ProtobufCBinaryData){.len = 16, .data = id};
}

void dialogue_send(void *socket, const Meniscus__Request *request)
{
    const size_t size = meniscus__request__get_packed_size(request);
    uint8_t *packed = malloc(size + 1);
    meniscus__request__pack(request, packed);
    assert_int_equal(zmq_send(socket, packed, size, 0), size);
    free(packed);
}

void dialogue_say(void *socket, Meniscus__Request *request, uint8_t *id)
{
    dialogue_seal(request, id);
    dialogue_send(socket, request);
}

Meniscus__Reply *dialogue_receive(void *socket, size_t *ret_frames)
{
    Meniscus__Reply *reply = NULL;
    int more = 1;
    for (size_t k = 0; more; k++) {
        zmq_msg_t frame;
        zmq_msg_init(&frame);
        if (zmq_msg_recv(&frame, socket, 0) < 0) break;
        if (k == 0) reply = meniscus__reply__unpack(NULL, zmq_msg_size(&frame), zmq_msg_data(&frame));
        more = zmq_msg_more(&frame);
        zmq_msg_close(&frame);
        if (ret_frames) *ret_frames = k;
    }
    return reply;
}

Meniscus__Reply *dialogue_ask(Dialogue *dialogue, Meniscus__Request *request)
{
    uint8_t id[16];
    dialogue_say(dialogue->control, request, id);
    Meniscus__Reply *reply = dialogue_receive(dialogue->control, NULL);
    assert_non_null(reply);
    assert_memory_equal(reply->id.data, id, sizeof id);
    request->id = (ProtobufCBinaryData){0}; /* it was ours */
    return reply;
}

Meniscus__Code dialogue_code(Dialogue *dialogue, Meniscus__Request *request)
{
    Meniscus__Reply *reply = dialogue_ask(dialogue, request);
    const Meniscus__Code code = reply->code;
    meniscus__reply__free_unpacked(reply, NULL);
    return code;
}

/* Messages without entries are all alike and never change, so they are shared. */
#define PLAIN(name, KIND, member, Type, INIT)                                                                          \
    Meniscus__Request name(void)                                                                                       \
    {                                                                                                                  \
        static const Type command = INIT;                                                                              \
        Meniscus__Request request = MENISCUS__REQUEST__INIT;                                                           \
        request.command_case = MENISCUS__REQUEST__COMMAND_##KIND;                                                      \
        request.member = (Type *)&command;                                                                             \
        return request;                                                                                                \
    }

PLAIN(dialogue_status, STATUS, status, Meniscus__GetStatus, MENISCUS__GET_STATUS__INIT)
PLAIN(dialogue_start, START, start, Meniscus__Start, MENISCUS__START__INIT)
PLAIN(dialogue_pause, PAUSE, pause, Meniscus__Pause, MENISCUS__PAUSE__INIT)
PLAIN(dialogue_resume, RESUME, resume, Meniscus__Resume, MENISCUS__RESUME__INIT)
PLAIN(dialogue_reset, RESET, reset, Meniscus__Reset, MENISCUS__RESET__INIT)
PLAIN(dialogue_checkpoint, CHECKPOINT, checkpoint, Meniscus__CheckpointNow, MENISCUS__CHECKPOINT_NOW__INIT)
PLAIN(dialogue_stop, STOP, stop, Meniscus__Stop, MENISCUS__STOP__INIT)
PLAIN(dialogue_shutdown, SHUTDOWN, shutdown, Meniscus__Shutdown, MENISCUS__SHUTDOWN__INIT)

void dialogue_load_init(LoadRequest *load, const char *name, const char *text, const char *const *settings)
{
    MnsError error = {.text = ""};
    *load = (LoadRequest){.load = MENISCUS__LOAD__INIT, .request = MENISCUS__REQUEST__INIT};
    if (case_file_parse(name, text, strlen(text), &load->file, &error)) fail_msg("%s", error.text);
    for (; settings && *settings; settings++)
        if (case_file_set(load->file, *settings, &error)) fail_msg("%s", error.text);
    if (load_init(&load->load, load->file, &error)) fail_msg("%s", error.text);
    load->load.name = (char *)name;
    load->request.command_case = MENISCUS__REQUEST__COMMAND_LOAD;
    load->request.load = &load->load;
}

void dialogue_load_done(LoadRequest *load)
{
    load_done(&load->load);
    case_file_free(load->file);
}

void dialogue_load(Dialogue *dialogue, const char *const *settings)
{
    LoadRequest load;
    dialogue_load_init(&load, "dam", dialogue_case, settings);
    Meniscus__Reply *reply = dialogue_ask(dialogue, &load.request);
    if (reply->code != MENISCUS__CODE__OK) fail_msg("the case is not loaded: %s", reply->message);
    assert_int_equal(reply->state, MENISCUS__STATE__READY);
    meniscus__reply__free_unpacked(reply, NULL);
    dialogue_load_done(&load);
}
