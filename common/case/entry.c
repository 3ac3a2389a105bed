/* SPDX-License-Identifier: BSD-3-Clause */
/* What the schema says about an entry, paths to it, and complaints about it in words. */
#include "common/case/value.h"
#include "common/case/words.h"
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

const CaseSchema *case_schema_of(MessageType *type)
{
    for (size_t k = 0; k < case_schemas_n; k++)
        if (!strcmp(case_schemas[k].message, type->name)) return &case_schemas[k];
    return NULL;
}

const CaseEntry *case_entry_of(MessageType *type, Field *field)
{
    return &case_schema_of(type)->entries[field - type->fields];
}

Field *case_field_named(MessageType *type, const char *name, size_t n)
{
    for (unsigned k = 0; k < type->n_fields; k++)
        if (strlen(type->fields[k].name) == n && !memcmp(type->fields[k].name, name, n)) return &type->fields[k];
    return NULL;
}

void case_names_for(MessageType *type, const char *wrong, char *text, size_t size)
{
    const char *names[64];
    for (unsigned k = 0; k < type->n_fields; k++) names[k] = type->fields[k].name;
    words_suggest(names, type->n_fields, wrong, NULL, text, size);
}

static void allowed_number(const CaseEntry *entry, const char *kind, char *text, size_t size)
{
    snprintf(text, size, "%s%s%s%s%s", *entry->range ? "" : kind,
             *entry->range && *kind == 'w' ? "whole number in " : "", entry->range, *entry->unit ? " " : "",
             entry->unit);
}

static void allowed_word(const ProtobufCEnumDescriptor *type, char *text, size_t size)
{
    size_t n = 0;
    *text = 0;
    for (unsigned k = 0; k < type->n_values && n < size; k++) {
        char word[64];
        n += (size_t)snprintf(text + n, size - n, "%s%s", k ? ", " : "", words_from_enum(type->values[k].name, word));
    }
}

void case_allowed(MessageType *type, Field *field, char *text, size_t size)
{
    const CaseEntry *entry = case_entry_of(type, field);
    switch (field->type) {
    case PROTOBUF_C_TYPE_DOUBLE: allowed_number(entry, "any finite number", text, size); break;
    case PROTOBUF_C_TYPE_UINT32: allowed_number(entry, "whole numbers from 0", text, size); break;
    case PROTOBUF_C_TYPE_BOOL: snprintf(text, size, "true, false"); break;
    case PROTOBUF_C_TYPE_ENUM: allowed_word(field->descriptor, text, size); break;
    case PROTOBUF_C_TYPE_MESSAGE: snprintf(text, size, "a mapping"); break;
    default:
        if (entry->formula)
            snprintf(text, size, "a number or a formula%s%s", *entry->formula ? " of " : "", entry->formula);
        else snprintf(text, size, "a text");
    }
}

static size_t grow(CasePath *path, int length)
{
    const size_t before = path->n;
    path->n += (size_t)length;
    if (path->n >= sizeof path->text) path->n = sizeof path->text - 1;
    return before;
}

size_t case_path_name(CasePath *path, const char *name, size_t n)
{
    return grow(
        path, snprintf(path->text + path->n, sizeof path->text - path->n, "%s%.*s", path->n ? "." : "", (int)n, name));
}

size_t case_path_index(CasePath *path, size_t k)
{
    return grow(path, snprintf(path->text + path->n, sizeof path->text - path->n, "[%zu]", k));
}

void case_path_cut(CasePath *path, size_t n)
{
    path->text[path->n = n] = 0;
}

MnsStatus case_fail(MnsError *error, MnsStatus status, const char *path, const char *format, ...)
{
    char sentence[sizeof error->text];
    va_list list;
    va_start(list, format);
    vsnprintf(sentence, sizeof sentence, format, list);
    va_end(list);
    const int room = sizeof error->path - 1; /* so that the text begins with what error->path can hold */
    return mns_fail_at(error, status, path, "%.*s%s%s", room, path, *path ? ": " : "", sentence);
}

MnsStatus case_no_memory(MnsError *error)
{
    return mns_fail(error, MNS_E_MEMORY, "no memory left for the case");
}

const char *case_shown(const char *text, char shown[static 48])
{
    size_t n = 0;
    for (; n < 40 && text[n]; n++) shown[n] = (unsigned char)text[n] < ' ' || text[n] == 127 ? '?' : text[n];
    if (text[n]) {
        while (n && (text[n] & 0xC0) == 0x80) n--; /* not in the middle of a character */
        memcpy(shown + n, "...", 3);
        n += 3;
    }
    shown[n] = 0;
    return shown;
}
