/* SPDX-License-Identifier: BSD-3-Clause */
/* Requests as they come, and when each is heard. Of one thread. */
#ifndef NET_HEARING_H
#define NET_HEARING_H

#include "net/answers.h"

/* Begins as zeros but for the answers, which are borrowed. */
typedef struct Hearing {
    Pace pace;
    Answers *answers;
} Hearing;

/* A request has come, of so many frames, of which this is the first: hear it, or let it wait for its turn. The frame stays yours, empty or not. */
void hearing_take(Hearing *hearing, const Sender *sender, zmq_msg_t *frame, uint64_t parts);

/* Those that wait, whose turn has come. */
void hearing_go_on(Hearing *hearing);

#endif
