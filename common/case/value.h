/* SPDX-License-Identifier: BSD-3-Clause */
/* Fields of a case message by descriptor: whether they are there, their values, and the paths that name them. */
#ifndef COMMON_CASE_VALUE_H
#define COMMON_CASE_VALUE_H

#include "common/case/schema.h"

typedef const ProtobufCFieldDescriptor Field;
typedef const ProtobufCMessageDescriptor MessageType;

/* --- what the schema says ----------------------------------------------------------------------------------------- */

const CaseSchema *case_schema_of(MessageType *type);
const CaseEntry *case_entry_of(MessageType *type, Field *field);

/* Field of a name given by its first n bytes, or NULL. */
Field *case_field_named(MessageType *type, const char *name, size_t n);

/* All names of a message, as in "name, density", for complaints; preceded by the likeliest one if `wrong` is like
 * it. */
void case_names_for(MessageType *type, const char *wrong, char *text, size_t size);

/* What may stand in an entry, as in "(0, inf) kg/m^3" or "add, subtract, intersect". */
void case_allowed(MessageType *type, Field *field, char *text, size_t size);

/* --- values; a NULL message is one in which nothing is there ------------------------------------------------------ */

/* How many values are there: 0 or 1, or the length of a list. */
size_t case_count(const ProtobufCMessage *message, Field *field);

/* Value k < case_count(): points to a double, uint32_t, int (enum), protobuf_c_boolean, char * or ProtobufCMessage
 * *. */
const void *case_item(const ProtobufCMessage *message, Field *field, size_t k);

/* Message k of a field, or NULL if it is not there. */
const ProtobufCMessage *case_child(const ProtobufCMessage *message, Field *field, size_t k);

/* Of the members of a oneof, of which `field` is one, the one in force: it is there, or it is what the absence of all means. NULL if
 * neither. */
Field *case_chosen_member(MessageType *type, const ProtobufCMessage *message, Field *field);

/* Room for one more value, all bits zero (a NULL pointer); a single value and the other members of a oneof go first.
 * NULL if there is no memory. */
void *case_add(ProtobufCMessage *message, Field *field);

/* Free what a field holds; afterwards case_count() is 0. */
void case_clear(ProtobufCMessage *message, Field *field);

/* Free one value of a list and make its bits zero. */
void *case_reset_item(ProtobufCMessage *message, Field *field, size_t k);

/* An empty message, or NULL if there is no memory; free with protobuf_c_message_free_unpacked(). */
ProtobufCMessage *case_message_new(MessageType *type);

/* --- paths -------------------------------------------------------------------------------------------------------- */

/* "fluids[1].density", grown and cut as a tree is walked; cut short if a path is longer than the room. */
typedef struct CasePath {
    size_t n;
    char text[sizeof((MnsError *)0)->path];
} CasePath;

/* Both return the length before, for case_path_cut(). */
size_t case_path_name(CasePath *path, const char *name, size_t n);
size_t case_path_index(CasePath *path, size_t k);
void case_path_cut(CasePath *path, size_t n);

/* --- complaints --------------------------------------------------------------------------------------------------- */

/* mns_fail_at() with "PATH: " before the sentence. */
MnsStatus case_fail(MnsError *error, MnsStatus status, const char *path, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

/* No memory left. */
MnsStatus case_no_memory(MnsError *error);

/* The first 40 bytes of a text from outside with everything that could upset a terminal replaced. */
const char *case_shown(const char *text, char shown[static 48]);

#endif
