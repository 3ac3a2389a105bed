/* SPDX-License-Identifier: BSD-3-Clause */
/* What all commands end with. */
#ifndef CLIENT_COMMANDS_H
#define CLIENT_COMMANDS_H

#include "client/lib/reply.h"

/* Send the request; the reply as a plain struct in *ret_reply, unless that is NULL. */
MnsStatus command_call(MnsClient *client, Meniscus__Request *request, MnsReply **ret_reply, MnsError *error);

#endif
