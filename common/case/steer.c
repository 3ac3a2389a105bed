/* SPDX-License-Identifier: BSD-3-Clause */
/* What may change while a simulation runs, and whether two cases differ in nothing else. */
#include "common/case/scalar.h"
#include "common/case/words.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static MnsStatus compare(MessageType *type, const ProtobufCMessage *a, const ProtobufCMessage *b, CasePath *path,
                         MnsError *error);

static MnsStatus fail_fixed(const CasePath *path, MnsError *error)
{
    enum { MOST = 256 };
    const char *paths[MOST];
    char names[150]; /* short, so that nobody's sentence around it loses its end */
    size_t n = 0;
    for (; n < case_steerables_n && n < MOST; n++) paths[n] = case_steerables[n].path;
    words_suggest(paths, n, path->text, "`meniscus get`", names, sizeof names);
    return case_fail(error, MNS_E_INVALID, path->text, "cannot change while the simulation runs; %s", names);
}

/* The value in force: what is there, or the default; NULL if there is neither. */
static const void *effective(const ProtobufCMessage *message, Field *field, const void *const *ret_default)
{
    if (case_count(message, field)) return case_item(message, field, 0);
    if (!field->default_value) return NULL;
    return field->type == PROTOBUF_C_TYPE_STRING ? (const void *)ret_default : field->default_value;
}

static bool scalars_equal(const ProtobufCMessage *a, const ProtobufCMessage *b, Field *field)
{
    const void *text = field->default_value;
    const void *in_a = effective(a, field, &text), *in_b = effective(b, field, &text);
    return in_a && in_b ? case_scalar_equal(field, in_a, in_b) : in_a == in_b;
}

static MnsStatus compare_list(const ProtobufCMessage *a, const ProtobufCMessage *b, Field *field, CasePath *path,
                              MnsError *error)
{
    const size_t n = case_count(a, field);
    MnsStatus status = n == case_count(b, field) ? MNS_OK : fail_fixed(path, error);
    for (size_t k = 0; k < n && !status; k++) {
        const size_t before = case_path_index(path, k);
        if (field->type == PROTOBUF_C_TYPE_MESSAGE)
            status = compare(field->descriptor, case_child(a, field, k), case_child(b, field, k), path, error);
        else if (!case_scalar_equal(field, case_item(a, field, k), case_item(b, field, k)))
            status = fail_fixed(path, error);
        case_path_cut(path, before);
    }
    return status;
}

static bool is_chosen(MessageType *type, const ProtobufCMessage *message, Field *field)
{
    return case_chosen_member(type, message, field) == field;
}

static MnsStatus compare_field(MessageType *type, const ProtobufCMessage *a, const ProtobufCMessage *b, Field *field,
                               CasePath *path, MnsError *error)
{
    if (field->label == PROTOBUF_C_LABEL_REPEATED) return compare_list(a, b, field, path, error);
    const bool is_member = field->flags & PROTOBUF_C_FIELD_FLAG_ONEOF;
    if (is_member && is_chosen(type, a, field) != is_chosen(type, b, field)) return fail_fixed(path, error);
    if (field->type == PROTOBUF_C_TYPE_MESSAGE)
        return compare(field->descriptor, case_child(a, field, 0), case_child(b, field, 0), path, error);
    return scalars_equal(a, b, field) ? MNS_OK : fail_fixed(path, error);
}

static MnsStatus compare(MessageType *type, const ProtobufCMessage *a, const ProtobufCMessage *b, CasePath *path,
                         MnsError *error)
{
    MnsStatus status = MNS_OK;
    if (!a && !b) return MNS_OK;
    for (unsigned k = 0; k < type->n_fields && !status; k++) {
        Field *field = &type->fields[k];
        if (case_entry_of(type, field)->steerable) continue;
        const size_t before = case_path_name(path, field->name, strlen(field->name));
        status = compare_field(type, a, b, field, path, error);
        case_path_cut(path, before);
    }
    return status;
}

MnsStatus case_message_steerable(const Meniscus__Case *a, const Meniscus__Case *b, MnsError *error)
{
    CasePath path = {0};
    return compare(a->base.descriptor, &a->base, &b->base, &path, error);
}

MnsStatus case_message_steers(const Meniscus__Case *c, const char *path, MnsError *error)
{
    MessageType *type = c->base.descriptor;
    const ProtobufCMessage *message = &c->base;
    for (const char *name = path; type && message;) {
        const size_t n = strcspn(name, ".[");
        Field *field = case_field_named(type, name, n);
        if (!field) return MNS_OK; /* who sets it will say so */
        const bool is_member = field->flags & PROTOBUF_C_FIELD_FLAG_ONEOF;
        Field *chosen = is_member ? case_chosen_member(type, message, field) : NULL;
        if (chosen && chosen != field)
            return case_fail(error, MNS_E_INVALID, path,
                             "the run has \"%s\" instead of \"%s\", and keeps it: load a case that has \"%s\"",
                             chosen->name, field->name, field->name);
        if (name[n] != '.' || field->type != PROTOBUF_C_TYPE_MESSAGE) return MNS_OK;
        message = case_child(message, field, 0);
        type = field->descriptor;
        name += n + 1;
    }
    return MNS_OK;
}

static void tell_difference(const Meniscus__Case *a, const Meniscus__Case *b, const char *path,
                            void (*tell)(void *arg, const char *path, const char *in_a, const char *in_b), void *arg)
{
    char *in_a = NULL, *in_b = NULL;
    const char *unit;
    const bool both = !case_message_get(a, path, &in_a, &unit, NULL) && !case_message_get(b, path, &in_b, &unit, NULL);
    if (both && strcmp(in_a, in_b) != 0) tell(arg, path, in_a, in_b);
    free(in_a);
    free(in_b);
}

void case_message_differences(const Meniscus__Case *a, const Meniscus__Case *b,
                              void (*tell)(void *arg, const char *path, const char *in_a, const char *in_b), void *arg)
{
    for (size_t k = 0; k < case_steerables_n; k++) tell_difference(a, b, case_steerables[k].path, tell, arg);
}

const CaseParameter *case_parameters(size_t *ret_n)
{
    *ret_n = case_steerables_n;
    return case_steerables;
}
