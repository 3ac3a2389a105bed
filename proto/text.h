/* SPDX-License-Identifier: BSD-3-Clause */
/* Texts that come from outside and are shown to people, or stored, later: on terminals, in JSON, in files. */
#ifndef PROTO_TEXT_H
#define PROTO_TEXT_H

#include "proto/case_value.h"
#include <stdbool.h>

/* UTF-8 without control characters. lines: newlines, tabs and characters that cannot be seen may be in it, as in a case file. */
bool text_is_clean(const char *text, bool lines);

/* The same text as UTF-8, which JSON must be: U+FFFD stands for each byte that is none, as in the name of a file. From malloc; NULL if there is
 * no memory. */
char *text_valid(const char *text);

/* The same with \\n, \\t and \\uXXXX for what a terminal would obey, or would not show: also right for JSON in one line. From malloc; NULL if there is no
 * memory. */
char *text_escaped(const char *text);

enum { TEXT_SHOWN = 8 };

/* The same, to be printed at once: it holds until the thread has asked for TEXT_SHOWN more. Empty for NULL. */
const char *text_shown(const char *text);

/* All texts of a request's command but those of a case, which is checked by its schema. MNS_OK; MNS_E_INVALID, at the field of the
 * command that is to blame. */
MnsStatus text_check(const ProtobufCMessage *request, MnsError *error);

#endif
