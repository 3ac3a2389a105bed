/* SPDX-License-Identifier: BSD-3-Clause */
/* What a browser may say: one JSON object, of which nothing is believed. */
#ifndef DASHBOARD_ASK_H
#define DASHBOARD_ASK_H

#include <jansson.h>
#include <meniscus/client.h>

enum { ASK_BYTES = 64 << 10, ASK_WORDS = 64 };

/* What can be asked, as README.md lists it. Those from ASK_START on are commands for the daemon. */
typedef enum AskKind {
    ASK_HELLO,
    ASK_SHOW,
    ASK_DRAWN,
    ASK_HISTORY,
    ASK_JOURNAL,
    ASK_START,
    ASK_PAUSE,
    ASK_RESUME,
    ASK_STEP,
    ASK_RUN_UNTIL,
    ASK_STOP,
    ASK_RESET,
    ASK_RESTORE,
    ASK_CHECKPOINT,
    ASK_SNAPSHOT,
    ASK_LOAD,
    ASK_SET,
    ASK_ROLLBACK,
    ASK_LEASE,
    ASK_RELEASE,
    ASK_CANCEL,
    ASK_COUNT
} AskKind;

/* Texts are borrowed from the JSON object; NULL and 0 stand for what was not said. */
typedef struct Ask {
    json_t *json;
    AskKind kind;
    uint64_t id;    /* comes back in the reply */
    uint64_t lease; /* epoch under which a command goes out */
    uint64_t count, limit, version;
    double time, seconds;
    bool at_a_step, at_a_time; /* scheduled: for at_step or at_time */
    uint64_t at_step;
    double at_time;
    bool walls, checkpoint, start;
    const char *field, *holder, *token, *name, *request;
    size_t n_settings;
    const char *settings[ASK_WORDS];
} Ask;

/* Read a message. MNS_E_INVALID: no such object, with an unknown, missing or wrong entry, which error->path names;
 * then ret has nothing but the id, if there was one, for the refusal. */
MnsStatus ask_parse(const char *text, size_t size, Ask *ret, MnsError *error);

void ask_done(Ask *ask);

/* Make the call that belongs to a command, under whatever lease the client has. As the function of <meniscus/client.h>. */
MnsStatus ask_call(const Ask *ask, MnsClient *client, MnsReply **ret_reply, MnsError *error);

#endif
