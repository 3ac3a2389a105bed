/* SPDX-License-Identifier: BSD-3-Clause */
/* A daemon that listens to those from afar, with keys of each role, for black-box tests. */
#ifndef TESTS_CASTLE_H
#define TESTS_CASTLE_H

#include "common/wire/keys.h"
#include "tests/support/dialogue.h"

/* Three keys that it lets in, of vera, otto and ada, and one that it does not know. */
typedef struct Castle {
    Dialogue dialogue; /* local */
    char keys[64];
    int port, http;
    KeyPair viewer, operator, admin, stranger;
} Castle;

/* For cmocka: one of its own for each test, which must end well. */
int castle_begin(void **state);
int castle_end(void **state);

typedef struct Guest {
    const char *name;
    Role role;
    const KeyPair *pair;
} Guest;

/* Let in these, and nobody else, from now on. */
void castle_let_in(const Castle *castle, size_t n, const Guest *guests);

/* The process that those from afar go through, within ten seconds; 0: there is none, or another than this one (0: any). */
pid_t castle_gate(const Castle *castle, pid_t but);

/* Its page of metrics has this line. */
void castle_shows(const Castle *castle, const char *line);

/* A DEALER at the control socket, or a SUB at the telemetry one; pair: NULL for plain text. Closed by castle_end(). */
void *castle_connect(Castle *castle, int type, const KeyPair *pair);

/* Ask as clients do, again under the same id until there is a reply, as one is lost where connections are cut. NULL if there was none
 * within twenty seconds; free with meniscus__reply__free_unpacked(). */
Meniscus__Reply *castle_ask(void *socket, Meniscus__Request request);

#endif
