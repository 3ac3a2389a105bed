/* SPDX-License-Identifier: BSD-3-Clause */
/* A daemon that listens to those from afar, with keys of each role, for black-box tests. */
#ifndef TESTS_CASTLE_H
#define TESTS_CASTLE_H

#include "proto/keys.h"
#include "tests/support/dialogue.h"

/* Three keys that it lets in, vera, otto and ada, and one that it does not know. */
typedef struct Castle {
    Dialogue dialogue; /* local */
    char keys[64];
    int port;
    KeyPair viewer, operator, admin, stranger;
    void *sockets[16]; /* closed in the end, also of a test that fails */
    size_t n_sockets;
} Castle;

/* For cmocka: one of its own for each test, which must end well. */
int castle_begin(void **state);
int castle_end(void **state);

/* Let in these from now on, as viewer, operator and admin; a NULL is nobody. */
void castle_let_in(const Castle *castle, const KeyPair *viewer, const KeyPair *operator, const KeyPair * admin);

/* A DEALER at the control socket, or a SUB at the telemetry one; pair: NULL for plain text. Closed by castle_end(). */
void *castle_connect(Castle *castle, int type, const KeyPair *pair);

#endif
