/* SPDX-License-Identifier: BSD-3-Clause */
/* Texts of requests that would be an order to a terminal, or break a message of ours. */
#ifndef COMMON_WIRE_TEXTS_H
#define COMMON_WIRE_TEXTS_H

#include <meniscus/status.h>
#include <protobuf-c/protobuf-c.h>

/* All texts of a request's command but those of a case, which is checked by its schema. MNS_OK; MNS_E_INVALID, at the field of the
 * command that is to blame. */
MnsStatus texts_check(const ProtobufCMessage *request, MnsError *error);

#endif
