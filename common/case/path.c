/* SPDX-License-Identifier: BSD-3-Clause */
/* Reach an entry of a case by its path, to read or to change it. */
#include "common/case/mark.h"
#include "common/case/print.h"
#include "common/case/reader.h"
#include <stdlib.h>
#include <string.h>

/* A field of a message, or one item of its list; the message is NULL where nothing is there. */
typedef struct Place {
    MessageType *type;
    ProtobufCMessage *message;
    Field *field; /* NULL: the whole message */
    bool is_item;
    size_t index;
    bool create; /* make the messages on the way, and one item beyond the end of a list */
} Place;

static MnsStatus fail_path(const char *path, const char *rest, MnsError *error)
{
    char shown[48];
    return case_fail(error, MNS_E_NOT_FOUND, path,
                     "\"%s\" is not a path: write names joined by dots and indices in "
                     "brackets, as in fluids[1].density",
                     case_shown(rest, shown));
}

/* The one entry that can be set and is called like this at the end of its path: scheme.cfl for cfl. */
static const char *only_one_called(const char *name)
{
    const char *found = NULL;
    for (size_t k = 0; k < case_steerables_n; k++) {
        const char *dot = strrchr(case_steerables[k].path, '.');
        if (!dot || strcmp(dot + 1, name) != 0) continue;
        if (found) return NULL;
        found = case_steerables[k].path;
    }
    return found;
}

static MnsStatus fail_name(const char *path, MessageType *type, const char *name, size_t length, MnsError *error)
{
    char wrong[48], shown[48], names[400];
    const size_t n = length < sizeof wrong ? length : sizeof wrong - 1;
    memcpy(wrong, name, n);
    wrong[n] = 0;
    const char *meant = only_one_called(path);
    if (meant)
        return case_fail(error, MNS_E_NOT_FOUND, path, "unknown entry \"%s\", did you mean \"%s\"?", wrong, meant);
    case_names_for(type, wrong, names, sizeof names);
    return case_fail(error, MNS_E_NOT_FOUND, path, "unknown entry \"%s\", %s", case_shown(wrong, shown), names);
}

static MnsStatus fail_index(const char *path, size_t n, bool may_append, MnsError *error)
{
    if (may_append)
        return case_fail(error, MNS_E_NOT_FOUND, path, "no such item, allowed: 0 to %zu, where %zu appends one", n, n);
    if (!n) return case_fail(error, MNS_E_NOT_FOUND, path, "no such item, the list is empty");
    return case_fail(error, MNS_E_NOT_FOUND, path, "no such item, allowed: 0 to %zu", n - 1);
}

static MnsStatus fail_list(const char *path, Field *field, MnsError *error)
{
    return case_fail(error, MNS_E_NOT_FOUND, path, "\"%s\" is a list, name one of its items: %s[0]", field->name,
                     field->name);
}

static MnsStatus fail_not_list(const char *path, Field *field, MnsError *error)
{
    return case_fail(error, MNS_E_NOT_FOUND, path, "\"%s\" is not a list, leave out the index", field->name);
}

static MnsStatus fail_leaf(const char *path, Field *field, MnsError *error)
{
    return case_fail(error, MNS_E_NOT_FOUND, path, "\"%s\" is a single value, there are no entries in it", field->name);
}

static MnsStatus fail_member(const Place *place, const char *path, Field *chosen, MnsError *error)
{
    return case_fail(error, MNS_E_INVALID, path,
                     "the case has \"%s\", which excludes \"%s\": set \"%s\" as a whole to have it instead",
                     chosen->name, place->field->name, place->field->name);
}

/* The message that a place names, made if it is missing and that is wanted. */
static MnsStatus child_of(const Place *place, const char *path, ProtobufCMessage **ret, MnsError *error)
{
    *ret = NULL;
    if (place->index < case_count(place->message, place->field)) {
        *ret = *(ProtobufCMessage *const *)case_item(place->message, place->field, place->index);
        return MNS_OK;
    }
    if (!place->create) return MNS_OK;
    const bool is_member = place->field->flags & PROTOBUF_C_FIELD_FLAG_ONEOF;
    Field *chosen = is_member ? case_chosen_member(place->type, place->message, place->field) : NULL;
    if (chosen && chosen != place->field) return fail_member(place, path, chosen, error);
    ProtobufCMessage **slot = case_add(place->message, place->field);
    if (!slot || !(*slot = case_message_new(place->field->descriptor))) return case_no_memory(error);
    *ret = *slot;
    return MNS_OK;
}

/* Step into what place names so far; a name follows. */
static MnsStatus enter(Place *place, const char *path, MnsError *error)
{
    ProtobufCMessage *child;
    if (!place->field) return MNS_OK;
    if (place->field->label == PROTOBUF_C_LABEL_REPEATED && !place->is_item)
        return fail_list(path, place->field, error);
    if (place->field->type != PROTOBUF_C_TYPE_MESSAGE) return fail_leaf(path, place->field, error);
    const MnsStatus status = child_of(place, path, &child, error);
    if (!status) *place = (Place){.type = place->field->descriptor, .message = child, .create = place->create};
    return status;
}

static MnsStatus step_name(Place *place, const char *path, const char *name, size_t length, MnsError *error)
{
    const MnsStatus status = enter(place, path, error);
    if (status) return status;
    place->field = case_field_named(place->type, name, length);
    return place->field ? MNS_OK : fail_name(path, place->type, name, length, error);
}

static MnsStatus step_index(Place *place, const char *path, size_t index, MnsError *error)
{
    if (place->is_item || place->field->label != PROTOBUF_C_LABEL_REPEATED)
        return fail_not_list(path, place->field, error);
    const size_t n = case_count(place->message, place->field);
    if (index >= n + place->create) return fail_index(path, n, place->create, error);
    place->is_item = true;
    place->index = index;
    return MNS_OK;
}

/* Walk from the root, which place is, to the end of a path. The first step is a name, the others begin with . or [. */
static MnsStatus find(Place *place, const char *path, MnsError *error)
{
    const char *rest = path, *name;
    size_t length = 0, index = 0;
    while (*rest) {
        const bool is_first = rest == path, is_joined = *rest == '.' || *rest == '[';
        const char *after = is_first == is_joined ? NULL : path_step(rest, &name, &length, &index);
        if (!after) return fail_path(path, rest, error);
        const MnsStatus status =
            name ? step_name(place, path, name, length, error) : step_index(place, path, index, error);
        if (status) return status;
        rest = after;
    }
    return MNS_OK;
}

MnsStatus case_message_get(const Meniscus__Case *message, const char *path, char **ret_text, const char **ret_unit,
                           MnsError *error)
{
    /* Nothing is changed without .create. */
    Place place = {.type = message->base.descriptor, .message = (ProtobufCMessage *)&message->base};
    const MnsStatus status = find(&place, path, error);
    if (status) return status;
    char *text = place.field ? case_print_value(place.message, place.field, place.is_item ? place.index : CASE_ALL)
                             : case_print_line(place.message);
    if (!text) return case_no_memory(error);
    *ret_text = text;
    if (ret_unit) *ret_unit = place.field ? case_entry_of(place.type, place.field)->unit : "";
    return MNS_OK;
}

static ProtobufCMessage *copy(const ProtobufCMessage *message)
{
    const size_t size = protobuf_c_message_get_packed_size(message);
    uint8_t *packed = malloc(size ? size : 1);
    if (!packed) return NULL;
    protobuf_c_message_pack(message, packed);
    ProtobufCMessage *made = protobuf_c_message_unpack(message->descriptor, NULL, size, packed);
    free(packed);
    return made;
}

static MnsStatus change(ProtobufCMessage *message, const char *path, const char *yaml, MnsError *error)
{
    Place place = {.type = message->descriptor, .message = message, .create = true};
    void *item = NULL;
    if (!*path) return fail_path(path, path, error);
    const MnsStatus status = find(&place, path, error);
    if (status) return status;
    if (place.is_item) {
        const bool is_new = place.index == case_count(place.message, place.field);
        item = is_new ? case_add(place.message, place.field) : case_reset_item(place.message, place.field, place.index);
        if (!item) return case_no_memory(error);
    } else {
        case_clear(place.message, place.field);
    }
    return case_read_value(path, yaml, place.message, place.field, item, error);
}

MnsStatus case_message_put(const Meniscus__Case *message, const char *path, const char *yaml, Meniscus__Case **ret,
                           MnsError *error)
{
    ProtobufCMessage *changed = copy(&message->base);
    if (!changed) return case_no_memory(error);
    const MnsStatus status = change(changed, path, yaml, error);
    if (status) protobuf_c_message_free_unpacked(changed, NULL);
    else *ret = (Meniscus__Case *)changed;
    return status;
}

MnsStatus case_message_set(const Meniscus__Case *message, const char *path, const char *yaml, Meniscus__Case **ret,
                           MnsError *error)
{
    Meniscus__Case *changed = NULL;
    MnsStatus status = case_message_put(message, path, yaml, &changed, error);
    if (!status) status = case_message_check(changed, error);
    if (!status) *ret = changed;
    else if (changed) meniscus__case__free_unpacked(changed, NULL);
    return status;
}

static void tell_entries(MessageType *type, CasePath *path, void (*tell)(void *arg, const char *path), void *arg)
{
    for (unsigned k = 0; k < type->n_fields; k++) {
        Field *field = &type->fields[k];
        const bool is_inner = field->type == PROTOBUF_C_TYPE_MESSAGE && field->label != PROTOBUF_C_LABEL_REPEATED;
        const size_t before = case_path_name(path, field->name, strlen(field->name));
        if (is_inner) tell_entries(field->descriptor, path, tell, arg);
        else tell(arg, path->text);
        case_path_cut(path, before);
    }
}

void case_entries(void (*tell)(void *arg, const char *path), void *arg)
{
    CasePath path = {0};
    tell_entries(&meniscus__case__descriptor, &path, tell, arg);
}
