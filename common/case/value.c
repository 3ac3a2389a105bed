/* SPDX-License-Identifier: BSD-3-Clause */
/* Fields of a case message by descriptor, laid out and freed the way protobuf-c does it. */
#include "common/case/value.h"
#include <stdlib.h>
#include <string.h>

static size_t item_size(Field *field)
{
    switch (field->type) {
    case PROTOBUF_C_TYPE_DOUBLE: return sizeof(double);
    case PROTOBUF_C_TYPE_UINT32: return sizeof(uint32_t);
    case PROTOBUF_C_TYPE_BOOL: return sizeof(protobuf_c_boolean);
    case PROTOBUF_C_TYPE_ENUM: return sizeof(int);
    default: return sizeof(void *); /* strings and messages; schema.py admits no other type */
    }
}

static const void *at(const ProtobufCMessage *message, size_t offset)
{
    return (const char *)message + offset;
}
static void *at_mutable(ProtobufCMessage *message, size_t offset)
{
    return (char *)message + offset;
}

static bool is_pointer(Field *field)
{
    return field->type == PROTOBUF_C_TYPE_STRING || field->type == PROTOBUF_C_TYPE_MESSAGE;
}

size_t case_count(const ProtobufCMessage *message, Field *field)
{
    if (!message) return 0;
    if (field->label == PROTOBUF_C_LABEL_REPEATED) return *(const size_t *)at(message, field->quantifier_offset);
    const bool is_member = field->flags & PROTOBUF_C_FIELD_FLAG_ONEOF;
    if (is_member && *(const uint32_t *)at(message, field->quantifier_offset) != field->id) return 0;
    if (is_pointer(field)) {
        const void *pointer = *(const void *const *)at(message, field->offset);
        return pointer && pointer != field->default_value;
    }
    return is_member || *(const protobuf_c_boolean *)at(message, field->quantifier_offset);
}

const void *case_item(const ProtobufCMessage *message, Field *field, size_t k)
{
    const void *member = at(message, field->offset);
    if (field->label != PROTOBUF_C_LABEL_REPEATED) return member;
    return *(const char *const *)member + k * item_size(field);
}

const ProtobufCMessage *case_child(const ProtobufCMessage *message, Field *field, size_t k)
{
    if (k >= case_count(message, field)) return NULL;
    return *(const ProtobufCMessage *const *)case_item(message, field, k);
}

static void free_item(Field *field, void *item)
{
    if (field->type == PROTOBUF_C_TYPE_STRING) free(*(char **)item);
    if (field->type == PROTOBUF_C_TYPE_MESSAGE) protobuf_c_message_free_unpacked(*(ProtobufCMessage **)item, NULL);
}

void *case_reset_item(ProtobufCMessage *message, Field *field, size_t k)
{
    void *item = *(char **)at_mutable(message, field->offset) + k * item_size(field);
    free_item(field, item);
    return memset(item, 0, item_size(field));
}

/* A list that was unpacked has room for what is in it and no more, so each new item asks for its own. */
static void *add_to_list(ProtobufCMessage *message, Field *field)
{
    size_t *n = at_mutable(message, field->quantifier_offset);
    char **list = at_mutable(message, field->offset);
    char *grown = reallocarray(*list, *n + 1, item_size(field));
    if (!grown) return NULL;
    *list = grown;
    return memset(*list + (*n)++ * item_size(field), 0, item_size(field));
}

Field *case_chosen_member(MessageType *type, const ProtobufCMessage *message, Field *field)
{
    Field *chosen = NULL;
    /* Members of a oneof share the place that says which of them is there. */
    for (unsigned k = 0; k < type->n_fields; k++) {
        Field *member = &type->fields[k];
        if (!(member->flags & PROTOBUF_C_FIELD_FLAG_ONEOF) || member->quantifier_offset != field->quantifier_offset)
            continue;
        if (case_count(message, member)) return member;
        if (case_entry_of(type, member)->is_default) chosen = member;
    }
    return chosen;
}

void *case_add(ProtobufCMessage *message, Field *field)
{
    if (field->label == PROTOBUF_C_LABEL_REPEATED) return add_to_list(message, field);
    if (field->flags & PROTOBUF_C_FIELD_FLAG_ONEOF) {
        Field *chosen = case_chosen_member(message->descriptor, message, field);
        if (chosen) case_clear(message, chosen);
        *(uint32_t *)at_mutable(message, field->quantifier_offset) = field->id;
    } else {
        case_clear(message, field);
        if (!is_pointer(field)) *(protobuf_c_boolean *)at_mutable(message, field->quantifier_offset) = 1;
    }
    return memset(at_mutable(message, field->offset), 0, item_size(field));
}

static void clear_list(ProtobufCMessage *message, Field *field)
{
    size_t *n = at_mutable(message, field->quantifier_offset);
    void **list = at_mutable(message, field->offset);
    for (size_t k = 0; k < *n; k++) case_reset_item(message, field, k);
    free(*list);
    *list = NULL;
    *n = 0;
}

void case_clear(ProtobufCMessage *message, Field *field)
{
    if (field->label == PROTOBUF_C_LABEL_REPEATED) {
        clear_list(message, field);
        return;
    }
    if (!case_count(message, field)) return;
    void *item = at_mutable(message, field->offset);
    free_item(field, item);
    memset(item, 0, item_size(field));
    if (field->flags & PROTOBUF_C_FIELD_FLAG_ONEOF) *(uint32_t *)at_mutable(message, field->quantifier_offset) = 0;
    else if (!is_pointer(field)) *(protobuf_c_boolean *)at_mutable(message, field->quantifier_offset) = 0;
}

ProtobufCMessage *case_message_new(MessageType *type)
{
    ProtobufCMessage *message = malloc(type->sizeof_message);
    if (message) protobuf_c_message_init(type, message);
    return message;
}
