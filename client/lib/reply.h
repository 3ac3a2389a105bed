/* SPDX-License-Identifier: BSD-3-Clause */
/* Messages of the protocol as the plain structs of <meniscus/client.h>. */
#ifndef CLIENT_REPLY_H
#define CLIENT_REPLY_H

#include "client/lib/arena.h"
#include "client/lib/call.h"

/* Takes both the message and the frames, also on failure. MNS_OK; MNS_E_MEMORY; MNS_E_CORRUPT if an array's shape does
 * not fit its frame. */
MnsStatus reply_new(Meniscus__Reply *message, Frames *frames, MnsReply **ret, MnsError *error);

/* [n] values that borrow their text from the messages; NULL if there is no memory. */
const MnsValue *reply_values(Arena *arena, size_t n, Meniscus__Value *const *messages);

#endif
