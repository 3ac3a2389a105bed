/* SPDX-License-Identifier: BSD-3-Clause */
/* Bounds, counts and required entries of a case message, as case.proto's comments say. The schema is not recursive, so
 * neither is a message deeper than it. */
#include "common/case/scalar.h"
#include <stdio.h>
#include <string.h>

static MnsStatus check_message(const ProtobufCMessage *message, CasePath *path, MnsError *error);

static MnsStatus fail_missing(MessageType *type, Field *field, CasePath *path, MnsError *error)
{
    char allowed[256];
    case_allowed(type, field, allowed, sizeof allowed);
    case_path_name(path, field->name, strlen(field->name));
    const char *some = field->label == PROTOBUF_C_LABEL_REPEATED ? "a list of at least one: " : "";
    const CaseEntry *entry = case_entry_of(type, field);
    return case_fail(error, MNS_E_INVALID, path->text, "missing, required: %s%s%s%s%s", some, allowed,
                     *entry->note ? " (" : "", entry->note, *entry->note ? ")" : "");
}

/* Of a oneof that must have a member, complain at its first one; the others need not be looked at. */
static MnsStatus check_choice(const ProtobufCMessage *message, Field *field, const CasePath *path, MnsError *error)
{
    MessageType *type = message->descriptor;
    char names[300] = "";
    size_t n = 0;
    for (unsigned k = 0; k < type->n_fields && n < sizeof names; k++) {
        Field *member = &type->fields[k];
        const bool in_oneof = member->flags & PROTOBUF_C_FIELD_FLAG_ONEOF;
        if (!in_oneof || member->quantifier_offset != field->quantifier_offset) continue;
        if (case_count(message, member)) return MNS_OK;
        n += (size_t)snprintf(names + n, sizeof names - n, "%s%s", n ? ", " : "", member->name);
    }
    return case_fail(error, MNS_E_INVALID, path->text, "one of %s is required and none is there", names);
}

static MnsStatus check_count(const CaseEntry *entry, size_t n, const CasePath *path, MnsError *error)
{
    if (!entry->count_max || (n >= entry->count_min && n <= entry->count_max)) return MNS_OK;
    char allowed[48];
    if (entry->count_min == entry->count_max) snprintf(allowed, sizeof allowed, "%u", entry->count_min);
    else snprintf(allowed, sizeof allowed, "%u to %u", entry->count_min, entry->count_max);
    return case_fail(error, MNS_E_INVALID, path->text, "found a list of %zu, allowed: a list of %s", n, allowed);
}

static MnsStatus check_item(const ProtobufCMessage *message, Field *field, size_t k, CasePath *path, MnsError *error)
{
    char sentence[400];
    if (field->type == PROTOBUF_C_TYPE_MESSAGE) return check_message(case_child(message, field, k), path, error);
    if (case_scalar_check(message->descriptor, field, case_item(message, field, k), sentence, sizeof sentence))
        return MNS_OK;
    return case_fail(error, MNS_E_INVALID, path->text, "%s", sentence);
}

static MnsStatus check_items(const ProtobufCMessage *message, Field *field, size_t n, CasePath *path, MnsError *error)
{
    MnsStatus status = MNS_OK;
    const bool is_list = field->label == PROTOBUF_C_LABEL_REPEATED;
    for (size_t k = 0; k < n && !status; k++) {
        const size_t before = is_list ? case_path_index(path, k) : path->n;
        status = check_item(message, field, k, path, error);
        case_path_cut(path, before);
    }
    return status;
}

static MnsStatus check_field(const ProtobufCMessage *message, Field *field, CasePath *path, MnsError *error)
{
    const CaseEntry *entry = case_entry_of(message->descriptor, field);
    const size_t n = case_count(message, field);
    MnsStatus status = MNS_OK;
    if (!n && entry->required) return fail_missing(message->descriptor, field, path, error);
    if (!n) return entry->of_required_choice ? check_choice(message, field, path, error) : MNS_OK;
    const size_t before = case_path_name(path, field->name, strlen(field->name));
    if (field->label == PROTOBUF_C_LABEL_REPEATED) status = check_count(entry, n, path, error);
    if (!status) status = check_items(message, field, n, path, error);
    case_path_cut(path, before);
    return status;
}

static MnsStatus check_message(const ProtobufCMessage *message, CasePath *path, MnsError *error)
{
    MnsStatus status = MNS_OK;
    for (unsigned k = 0; k < message->descriptor->n_fields && !status; k++)
        status = check_field(message, &message->descriptor->fields[k], path, error);
    return status;
}

MnsStatus case_message_check(const Meniscus__Case *message, MnsError *error)
{
    CasePath path = {0};
    return check_message(&message->base, &path, error);
}
