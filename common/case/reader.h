/* SPDX-License-Identifier: BSD-3-Clause */
/* YAML events to a case message, led by the message's descriptor: every wrong key, type and word is found here.
 * Bounds and missing entries are not: case_message_check() finds them, wherever a message comes from. */
#ifndef COMMON_CASE_READER_H
#define COMMON_CASE_READER_H

#include "common/case/mark.h"
#include "common/case/value.h"

enum { CASE_FILE_LIMIT = 16 << 20 }; /* bytes of a case file */

/* Read one YAML document into a message that is new.
 * name: of the file, for complaints that begin "NAME:LINE:COLUMN: ". marks: filled, root first. */
MnsStatus case_read_document(const char *name, const char *text, size_t size, ProtobufCMessage *message, Marks *marks,
                             MnsError *error);

/* Read one YAML document as the value of a field: of all of it, or of an item made by case_add() or
 * case_reset_item() if there is one. path: of the value, for complaints that begin "PATH: ". */
MnsStatus case_read_value(const char *path, const char *text, ProtobufCMessage *message, Field *field, void *item,
                          MnsError *error);

#endif
