/* SPDX-License-Identifier: BSD-3-Clause */
/* The texts of requests, by the descriptors of their messages: what one client names, another one prints. */
#include "common/wire/texts.h"

#include "common/case/value.h"
#include "common/host/text.h"
#include "meniscus.pb-c.h"
#include <string.h>

static MnsStatus check_message(const ProtobufCMessage *message, CasePath *path, MnsError *error);

/* A value that is set is written as in a case file, where it may have several lines. */
static MnsStatus check_item(const ProtobufCMessage *message, Field *field, size_t k, CasePath *path, MnsError *error)
{
    if (field->type == PROTOBUF_C_TYPE_MESSAGE) return check_message(case_child(message, field, k), path, error);
    const bool lines = message->descriptor == &meniscus__assignment__descriptor && !strcmp(field->name, "value");
    const char *text = *(const char *const *)case_item(message, field, k);
    if (text && text_is_clean(text, lines)) return MNS_OK;
    return mns_fail_at(
        error, MNS_E_INVALID, path->text,
        "found a text that is not UTF-8, or has control characters or hidden ones in it, such as marks of "
        "direction or of no width: remove them");
}

static MnsStatus check_field(const ProtobufCMessage *message, Field *field, CasePath *path, MnsError *error)
{
    MnsStatus status = MNS_OK;
    const bool is_list = field->label == PROTOBUF_C_LABEL_REPEATED;
    const size_t n = case_count(message, field), before = case_path_name(path, field->name, strlen(field->name));
    for (size_t k = 0; k < n && !status; k++) {
        const size_t name = is_list ? case_path_index(path, k) : path->n;
        status = check_item(message, field, k, path, error);
        case_path_cut(path, name);
    }
    case_path_cut(path, before);
    return status;
}

static MnsStatus check_message(const ProtobufCMessage *message, CasePath *path, MnsError *error)
{
    MnsStatus status = MNS_OK;
    const ProtobufCMessageDescriptor *type = message->descriptor;
    for (unsigned k = 0; k < type->n_fields && !status && type != &meniscus__case__descriptor; k++) {
        Field *field = &type->fields[k];
        if (field->type == PROTOBUF_C_TYPE_STRING || field->type == PROTOBUF_C_TYPE_MESSAGE)
            status = check_field(message, field, path, error);
    }
    return status;
}

MnsStatus texts_check(const ProtobufCMessage *request, MnsError *error)
{
    MnsStatus status = MNS_OK;
    const ProtobufCMessageDescriptor *type = request->descriptor;
    for (unsigned k = 0; k < type->n_fields && !status; k++) {
        CasePath path = {0};
        Field *field = &type->fields[k];
        if (field->type == PROTOBUF_C_TYPE_MESSAGE && case_count(request, field))
            status = check_message(case_child(request, field, 0), &path, error);
    }
    return status;
}
