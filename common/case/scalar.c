/* SPDX-License-Identifier: BSD-3-Clause */
/* Single values of a case: from text, strictly; to text, exactly; and whether they are within their bounds. */
#include "common/case/scalar.h"
#include "common/case/words.h"
#include "common/host/text.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

static bool parse_enum(const ProtobufCEnumDescriptor *type, const char *text, int *ret)
{
    char word[64];
    for (unsigned k = 0; k < type->n_values; k++)
        if (!strcmp(words_from_enum(type->values[k].name, word), text)) {
            *ret = type->values[k].value;
            return true;
        }
    return false;
}

/* Decimal digits only: what fits no uint32 is refused, not wrapped. */
static bool parse_whole(const char *text, uint32_t *ret)
{
    uint64_t value = 0;
    for (const char *p = text; *p; p++) {
        if (*p < '0' || *p > '9') return false;
        value = 10 * value + (uint64_t)(*p - '0');
        if (value > UINT32_MAX) return false;
    }
    *ret = (uint32_t)value;
    return *text;
}

static bool parse_truth(const char *text, protobuf_c_boolean *ret)
{
    *ret = !strcmp(text, "true");
    return *ret || !strcmp(text, "false");
}

static void explain_enum(const ProtobufCEnumDescriptor *type, const char *text, char *sentence, size_t size)
{
    enum { MOST = 32 };
    char words[MOST][64], shown[48];
    const char *names[MOST];
    const unsigned n = type->n_values < MOST ? type->n_values : MOST;
    for (unsigned k = 0; k < n; k++) names[k] = words_from_enum(type->values[k].name, words[k]);
    const int used = snprintf(sentence, size, "found \"%s\", ", case_shown(text, shown));
    words_suggest(names, n, text, NULL, sentence + used, size - (size_t)used);
}

static void explain(MessageType *type, Field *field, const char *text, bool plain, char *sentence, size_t size)
{
    char allowed[256], shown[48];
    if (field->type == PROTOBUF_C_TYPE_ENUM) {
        explain_enum(field->descriptor, text, sentence, size);
        return;
    }
    case_allowed(type, field, allowed, sizeof allowed);
    const char *kind = field->type == PROTOBUF_C_TYPE_DOUBLE   ? "a number"
                       : field->type == PROTOBUF_C_TYPE_UINT32 ? "a whole number"
                                                               : "a truth value";
    snprintf(sentence, size, "found \"%s\"%s, which is not %s, allowed: %s", case_shown(text, shown),
             plain ? "" : " in quotes", kind, allowed);
}

MnsStatus case_scalar_parse(MessageType *type, Field *field, const char *text, bool plain, void *item, char *sentence,
                            size_t size)
{
    bool good;
    switch (field->type) {
    case PROTOBUF_C_TYPE_DOUBLE: good = plain && words_to_number(text, item); break;
    case PROTOBUF_C_TYPE_UINT32: good = plain && parse_whole(text, item); break;
    case PROTOBUF_C_TYPE_BOOL: good = plain && parse_truth(text, item); break;
    case PROTOBUF_C_TYPE_ENUM: good = parse_enum(field->descriptor, text, item); break;
    default: return (*(char **)item = strdup(text)) ? MNS_OK : MNS_E_MEMORY;
    }
    if (!good) explain(type, field, text, plain, sentence, size);
    return good ? MNS_OK : MNS_E_INVALID;
}

static bool within(const CaseEntry *entry, double value)
{
    if (isnan(value)) return false;
    const bool above = entry->min_open ? value > entry->min : value >= entry->min;
    const bool below = entry->max_open ? value < entry->max : value <= entry->max;
    return above && below;
}

static bool is_good(const CaseEntry *entry, Field *field, const void *item)
{
    switch (field->type) {
    case PROTOBUF_C_TYPE_DOUBLE: return within(entry, *(const double *)item);
    case PROTOBUF_C_TYPE_UINT32: return within(entry, *(const uint32_t *)item);
    case PROTOBUF_C_TYPE_ENUM: return protobuf_c_enum_descriptor_get_value(field->descriptor, *(const int *)item);
    case PROTOBUF_C_TYPE_STRING: return *(const char *const *)item && text_is_clean(*(const char *const *)item, true);
    default: return true;
    }
}

bool case_scalar_check(MessageType *type, Field *field, const void *item, char *sentence, size_t size)
{
    char allowed[256], buffer[64], shown[48];
    if (is_good(case_entry_of(type, field), field, item)) return true;
    if (field->type == PROTOBUF_C_TYPE_STRING) {
        snprintf(sentence, size, "found a text that is not UTF-8 or has control characters in it: remove them");
        return false;
    }
    case_allowed(type, field, allowed, sizeof allowed);
    snprintf(sentence, size, "found \"%s\", allowed: %s", case_shown(case_scalar_text(field, item, buffer), shown),
             allowed);
    return false;
}

const char *case_scalar_text(Field *field, const void *item, char buffer[static 64])
{
    const ProtobufCEnumValue *value;
    switch (field->type) {
    case PROTOBUF_C_TYPE_DOUBLE: return words_from_number(*(const double *)item, buffer);
    case PROTOBUF_C_TYPE_UINT32: snprintf(buffer, 64, "%u", *(const uint32_t *)item); return buffer;
    case PROTOBUF_C_TYPE_BOOL: return *(const protobuf_c_boolean *)item ? "true" : "false";
    case PROTOBUF_C_TYPE_ENUM:
        value = protobuf_c_enum_descriptor_get_value(field->descriptor, *(const int *)item);
        if (value) return words_from_enum(value->name, buffer);
        snprintf(buffer, 64, "%d", *(const int *)item);
        return buffer;
    default: return *(const char *const *)item;
    }
}

bool case_scalar_equal(Field *field, const void *a, const void *b)
{
    char text_a[64], text_b[64];
    if (field->type == PROTOBUF_C_TYPE_DOUBLE) return *(const double *)a == *(const double *)b;
    return !strcmp(case_scalar_text(field, a, text_a), case_scalar_text(field, b, text_b));
}
