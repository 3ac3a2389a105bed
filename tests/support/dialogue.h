/* SPDX-License-Identifier: BSD-3-Clause */
/* A meniscusd in a directory of its own, and connections that speak its protocol byte by byte, for black-box tests. */
#ifndef TESTS_DIALOGUE_H
#define TESTS_DIALOGUE_H

#include "common/case/file.h"
#include "meniscus.pb-c.h"
#include <stdbool.h>
#include <stddef.h>
#include <sys/types.h>

typedef struct Dialogue {
    char home[64]; /* everything the daemon writes is below */
    pid_t daemon;
    void *context, *control;
    void *sockets[32]; /* closed in the end, also of a test that fails */
    size_t n_sockets;
    char endpoint[128];
} Dialogue;

/* Start $BUILD/meniscusd (build/meniscusd) with these further options, NULL-terminated, and connect. Fails the test. */
void dialogue_begin(Dialogue *dialogue, const char *const *options);

/* Kill the daemon as a crash would, start it again without further options, and connect. */
void dialogue_crash(Dialogue *dialogue);

/* Start it once more, after it has ended somehow, with these further options, and connect. */
void dialogue_again(Dialogue *dialogue, const char *const *options);

/* End the daemon with SIGTERM if it runs; its exit code, or -1 if a signal ended it. Removes the directory. */
int dialogue_end(Dialogue *dialogue);

/* Wait for the daemon to end by itself; as above, but nothing is removed. */
int dialogue_join(Dialogue *dialogue);

/* Another connection. */
void *dialogue_connect(Dialogue *dialogue);

/* A socket that is not connected yet, and does not linger. */
void *dialogue_socket(Dialogue *dialogue, int type);

/* Close all of them, as a client that leaves; dialogue_end() does so. */
void dialogue_hang_up(Dialogue *dialogue);

/* A connection without libzmq, at ipc://: past the handshake, in which the client says what it is, "DEALER" or "SUB", and these properties
 * of itself after that. A file descriptor whose reads wait ten seconds at most. */
int dialogue_by_hand(const char *endpoint, const char *kind, const void *properties, size_t size);

/* A request of this protocol's version with a new id; id: [16], room for it. */
void dialogue_seal(Meniscus__Request *request, uint8_t *id);

void dialogue_send(void *socket, const Meniscus__Request *request);

/* Seal and send; the reply is waited for elsewhere. */
void dialogue_say(void *socket, Meniscus__Request *request, uint8_t *id);

/* The next reply within 90 seconds, or NULL; raw frames behind it are counted. Free with meniscus__reply__free_unpacked(). */
Meniscus__Reply *dialogue_receive(void *socket, size_t *ret_frames);

/* Seal, send, receive. */
Meniscus__Reply *dialogue_ask(Dialogue *dialogue, Meniscus__Request *request);

/* The same where only the code matters. */
Meniscus__Code dialogue_code(Dialogue *dialogue, Meniscus__Request *request);

/* Commands without entries. */
Meniscus__Request dialogue_status(void), dialogue_start(void), dialogue_pause(void), dialogue_resume(void);
Meniscus__Request dialogue_reset(void), dialogue_checkpoint(void), dialogue_stop(void), dialogue_shutdown(void);

/* A request to load a case, from its text and with these changes, NULL-terminated; it stays where it is until it is done. */
typedef struct LoadRequest {
    CaseFile *file;
    Meniscus__Load load;
    Meniscus__Request request;
} LoadRequest;
void dialogue_load_init(LoadRequest *load, const char *name, const char *text, const char *const *settings);
void dialogue_load_done(LoadRequest *load);

/* Load a small dam break with these changes, NULL-terminated: "end_time=2". Fails the test unless it is loaded. */
void dialogue_load(Dialogue *dialogue, const char *const *settings);

/* The text of that case. */
extern const char dialogue_case[];

#endif
