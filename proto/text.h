/* SPDX-License-Identifier: BSD-3-Clause */
/* Texts that come from outside and are shown to people, or stored, later: on terminals, in JSON, in files. */
#ifndef PROTO_TEXT_H
#define PROTO_TEXT_H

#include "proto/case_value.h"
#include <stdbool.h>

/* UTF-8 without control characters, which a case file can hold; lines: newlines and tabs may be in it. */
bool text_is_clean(const char *text, bool lines);

/* The same text as UTF-8, which JSON must be: U+FFFD stands for each byte that is none, as in the name of a file. From malloc; NULL if there is
 * no memory. */
char *text_valid(const char *text);

/* All texts of a request's command but those of a case, which is checked by its schema. MNS_OK; MNS_E_INVALID, at the field of the
 * command that is to blame. */
MnsStatus text_check(const ProtobufCMessage *request, MnsError *error);

#endif
