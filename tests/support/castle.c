/* SPDX-License-Identifier: BSD-3-Clause */
/* A daemon with keys. */
#include "tests/support/castle.h"

#include "tests/support/check.h"
#include <arpa/inet.h>
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>
#include <zmq.h>

static int bind_port(int port, int *ret_fd)
{
    struct sockaddr_in address = {
        .sin_family = AF_INET, .sin_port = htons((uint16_t)port), .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    socklen_t size = sizeof address;
    *ret_fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (bind(*ret_fd, (struct sockaddr *)&address, size) || getsockname(*ret_fd, (struct sockaddr *)&address, &size))
        return 0;
    return ntohs(address.sin_port);
}

/* Four ports in a row that nobody has, three for the daemon's sockets and one for HTTP: not of those that the system gives to
 * others, and other ones for programs side by side. */
static int free_ports(void)
{
    static int calls;
    for (int k = 0; k < 100; k++) {
        const int port = 10000 + (getpid() % 250 * 20 + calls++ % 20) * 4;
        int fds[4], n = 0;
        while (n < 4 && bind_port(port + n, &fds[n])) n++;
        for (int i = 0; i <= n && i < 4; i++) close(fds[i]);
        if (n == 4) return port;
    }
    fail_msg("there are no free ports");
    return 0;
}

static void make_pair(KeyPair *pair, const char *server)
{
    assert_int_equal(zmq_curve_keypair(pair->public_key, pair->secret_key), 0);
    memcpy(pair->server_key, server, strlen(server) + 1);
}

void castle_let_in(const Castle *castle, size_t n, const Guest *guests)
{
    Key list[8] = {{.role = ROLE_NONE}};
    MnsError error;
    assert_true(n < sizeof list / sizeof *list);
    for (size_t k = 0; k < n; k++) {
        list[k].role = guests[k].role;
        snprintf(list[k].name, sizeof list[k].name, "%s", guests[k].name);
        memcpy(list[k].public_key, guests[k].pair->public_key, KEY_TEXT);
    }
    if (keys_write(castle->keys, &(Keys){n, list}, &error)) fail_msg("%s", error.text);
}

int castle_begin(void **state)
{
    Castle *castle = calloc(1, sizeof *castle);
    KeyPair own = {.server_key = ""};
    char path[KEYS_PATH], listen[64], keys[96], http[32];
    strcpy(castle->keys, "/tmp/mns-keys-XXXXXX");
    assert_non_null(mkdtemp(castle->keys));
    make_pair(&own, "");
    key_path(castle->keys, KEYS_DAEMON, path);
    assert_int_equal(key_file_write(path, &own, NULL), MNS_OK);
    KeyPair *const pairs[] = {&castle->viewer, &castle->operator, & castle->admin, &castle->stranger};
    for (size_t k = 0; k < 4; k++) make_pair(pairs[k], own.public_key);
    const Guest guests[] = {{"vera", ROLE_VIEWER, &castle->viewer},
                            {"otto", ROLE_OPERATOR, &castle->operator}, {"ada", ROLE_ADMIN, &castle->admin}};
    castle_let_in(castle, 3, guests);
    castle->port = free_ports();
    snprintf(listen, sizeof listen, "--listen=tcp://127.0.0.1:%d", castle->port);
    snprintf(keys, sizeof keys, "--keys=%s", castle->keys);
    castle->http = castle->port + 3;
    snprintf(http, sizeof http, "--http=%d", castle->http);
    dialogue_begin(&castle->dialogue, (const char *const[]){listen, keys, http, NULL});
    *state = castle;
    return 0;
}

int castle_end(void **state)
{
    Castle *castle = *state;
    char command[96];
    const int code = dialogue_end(&castle->dialogue);
    snprintf(command, sizeof command, "rm -rf %s", castle->keys);
    assert_int_equal(system(command), 0);
    free(castle);
    return code;
}

void castle_shows(const Castle *castle, const char *line)
{
    static const char request[] = "GET /metrics HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
    static char text[1 << 17];
    const struct sockaddr_in at = {
        .sin_family = AF_INET, .sin_port = htons((uint16_t)castle->http), .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    size_t size = 0;
    const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_int_equal(connect(fd, (const struct sockaddr *)&at, sizeof at), 0);
    assert_int_equal(send(fd, request, strlen(request), MSG_NOSIGNAL), strlen(request));
    for (ssize_t n; (n = recv(fd, text + size, sizeof text - 1 - size, 0)) > 0;) size += (size_t)n;
    close(fd);
    text[size] = 0;
    const char *found = strstr(text, line);
    if (!found || found[strlen(line)] != '\n') fail_msg("no line \"%s\" in: %s", line, text);
}

static pid_t parent_of(const char *process)
{
    char path[64], text[256] = "";
    int parent = 0;
    snprintf(path, sizeof path, "/proc/%.16s/stat", process);
    FILE *file = fopen(path, "r");
    if (!file) return 0;
    if (!fgets(text, sizeof text, file)) text[0] = 0;
    fclose(file);
    const char *end = strrchr(text, ')');
    return end && sscanf(end, ") %*c %d", &parent) == 1 ? parent : 0;
}

static pid_t find_child(pid_t parent)
{
    pid_t child = 0;
    DIR *processes = opendir("/proc");
    assert_non_null(processes);
    for (const struct dirent *entry; !child && (entry = readdir(processes));)
        if (*entry->d_name >= '1' && *entry->d_name <= '9' && parent_of(entry->d_name) == parent)
            child = atoi(entry->d_name);
    closedir(processes);
    return child;
}

pid_t castle_gate(const Castle *castle, pid_t but)
{
    for (int k = 0; k < 1000; k++) {
        const pid_t gate = find_child(castle->dialogue.daemon);
        if (gate && gate != but) return gate;
        nanosleep(&(struct timespec){.tv_nsec = 10000000}, NULL);
    }
    return 0;
}

void *castle_connect(Castle *castle, int type, const KeyPair *pair)
{
    const int patience = 20000;
    char address[64];
    void *socket = dialogue_socket(&castle->dialogue, type);
    zmq_setsockopt(socket, ZMQ_RCVTIMEO, &patience, sizeof patience);
    if (pair) {
        assert_int_equal(zmq_setsockopt(socket, ZMQ_CURVE_SERVERKEY, pair->server_key, KEY_TEXT), 0);
        assert_int_equal(zmq_setsockopt(socket, ZMQ_CURVE_PUBLICKEY, pair->public_key, KEY_TEXT), 0);
        assert_int_equal(zmq_setsockopt(socket, ZMQ_CURVE_SECRETKEY, pair->secret_key, KEY_TEXT), 0);
    }
    if (type == ZMQ_SUB) zmq_setsockopt(socket, ZMQ_SUBSCRIBE, "", 0);
    snprintf(address, sizeof address, "tcp://127.0.0.1:%d", castle->port + (type == ZMQ_SUB));
    assert_int_equal(zmq_connect(socket, address), 0);
    return socket;
}

static bool answers(const Meniscus__Reply *reply, const uint8_t *id)
{
    return reply && reply->id.len == 16 && !memcmp(reply->id.data, id, 16);
}

Meniscus__Reply *castle_ask(void *socket, Meniscus__Request request)
{
    uint8_t id[16];
    zmq_pollitem_t item = {.socket = socket, .events = ZMQ_POLLIN};
    dialogue_seal(&request, id);
    for (int k = 0; k < 20; k++) {
        dialogue_send(socket, &request);
        while (zmq_poll(&item, 1, 1000) > 0) {
            Meniscus__Reply *reply = dialogue_receive(socket, NULL);
            if (answers(reply, id)) return reply;
            if (reply) meniscus__reply__free_unpacked(reply, NULL);
        }
    }
    return NULL;
}
