/* SPDX-License-Identifier: BSD-3-Clause */
/* YAML events to a case message, led by the message's descriptor. Nesting is bounded by the schema, not by the text. */
#include "common/case/reader.h"
#include "common/case/scalar.h"
#include <stdio.h>
#include <string.h>
#include <yaml.h>

typedef struct Reader {
    yaml_parser_t parser;
    yaml_event_t event; /* the one being looked at */
    const char *name;   /* of the file; NULL if there is none */
    const char *text;
    Marks *marks; /* NULL if nobody asks */
    CasePath path;
    MnsError *error;
} Reader;

/* Complain about the entry at reader->path, which stands at line and column (from 0). */
static MnsStatus fail_at(Reader *reader, yaml_mark_t mark, const char *sentence)
{
    char place[300] = "";
    if (reader->name) snprintf(place, sizeof place, "%.250s:%zu:%zu: ", reader->name, mark.line + 1, mark.column + 1);
    return mns_fail_at(reader->error, MNS_E_INVALID, reader->path.text, "%s%s%s%s", place, reader->path.text,
                       reader->path.n ? ": " : "", sentence);
}

static MnsStatus fail(Reader *reader, const char *sentence)
{
    return fail_at(reader, reader->event.start_mark, sentence);
}

/* libyaml gives a byte offset, but no line, for bytes that are no text at all. */
static yaml_mark_t mark_of_offset(const char *text, size_t offset)
{
    yaml_mark_t mark = {.index = offset};
    for (size_t k = 0; k < offset; k++) {
        mark.column++;
        if (text[k] == '\n') {
            mark.line++;
            mark.column = 0;
        }
    }
    return mark;
}

static MnsStatus fail_syntax(Reader *reader)
{
    const yaml_parser_t *parser = &reader->parser;
    char sentence[256];
    yaml_mark_t mark = parser->problem_mark;
    if (parser->error == YAML_MEMORY_ERROR) return case_no_memory(reader->error);
    if (parser->error == YAML_READER_ERROR) mark = mark_of_offset(reader->text, parser->problem_offset);
    if (parser->error == YAML_SCANNER_ERROR && *parser->buffer.pointer == '\t')
        return fail_at(reader, mark, "there is a tab, and YAML allows none for indentation: write spaces");
    snprintf(sentence, sizeof sentence, "this is not YAML: %s%s%s", parser->context ? parser->context : "",
             parser->context ? ", " : "", parser->problem ? parser->problem : "unknown problem");
    return fail_at(reader, mark, sentence);
}

static bool is_decorated(const yaml_event_t *event)
{
    switch (event->type) {
    case YAML_SCALAR_EVENT: return event->data.scalar.anchor || event->data.scalar.tag;
    case YAML_SEQUENCE_START_EVENT: return event->data.sequence_start.anchor || event->data.sequence_start.tag;
    case YAML_MAPPING_START_EVENT: return event->data.mapping_start.anchor || event->data.mapping_start.tag;
    default: return event->type == YAML_ALIAS_EVENT;
    }
}

static MnsStatus next(Reader *reader)
{
    yaml_event_delete(&reader->event);
    if (!yaml_parser_parse(&reader->parser, &reader->event)) return fail_syntax(reader);
    if (is_decorated(&reader->event))
        return fail(reader, "anchors (&), aliases (*) and tags (!) are not used in case files: write the value itself");
    return MNS_OK;
}

static uint32_t add_mark(Reader *reader, uint32_t parent, const char *name, size_t index)
{
    if (!reader->marks) return 0;
    const yaml_mark_t at = reader->event.start_mark;
    return marks_add(reader->marks, (Mark){.name = name,
                                           .index = (uint32_t)index,
                                           .parent = parent,
                                           .line = (uint32_t)at.line + 1,
                                           .column = (uint32_t)at.column + 1});
}

static const char *found(const yaml_event_t *event, char text[static 64])
{
    char shown[48];
    switch (event->type) {
    case YAML_SEQUENCE_START_EVENT: return "a list";
    case YAML_MAPPING_START_EVENT: return "a mapping";
    default: break;
    }
    const char *value = (const char *)event->data.scalar.value;
    if (!*value && event->data.scalar.style == YAML_PLAIN_SCALAR_STYLE) return "nothing";
    snprintf(text, 64, "\"%s\"", case_shown(value, shown));
    return text;
}

static MnsStatus fail_kind(Reader *reader, const char *allowed)
{
    char text[64], sentence[400];
    snprintf(sentence, sizeof sentence, "found %s, allowed: %s", found(&reader->event, text), allowed);
    return fail(reader, sentence);
}

static MnsStatus read_scalar(Reader *reader, MessageType *type, Field *field, void *item)
{
    char allowed[256], sentence[400];
    const yaml_event_t *event = &reader->event;
    case_allowed(type, field, allowed, sizeof allowed);
    if (event->type != YAML_SCALAR_EVENT) return fail_kind(reader, allowed);
    const char *text = (const char *)event->data.scalar.value;
    const bool plain = event->data.scalar.style == YAML_PLAIN_SCALAR_STYLE;
    if (plain && !*text) return fail_kind(reader, allowed);
    if (strlen(text) != event->data.scalar.length) return fail(reader, "the text has a zero byte in it: remove it");
    const MnsStatus status = case_scalar_parse(type, field, text, plain, item, sentence, sizeof sentence);
    if (status == MNS_E_MEMORY) return case_no_memory(reader->error);
    return status ? fail(reader, sentence) : MNS_OK;
}

static MnsStatus read_mapping(Reader *reader, ProtobufCMessage *message, uint32_t mark);

/* The one of several entries that exclude each other that is named, where entries were expected; NULL for none. */
static Field *choice_named(const Reader *reader, MessageType *type)
{
    if (reader->event.type != YAML_SCALAR_EVENT) return NULL;
    Field *field =
        case_field_named(type, (const char *)reader->event.data.scalar.value, reader->event.data.scalar.length);
    const bool is_choice =
        field && field->flags & PROTOBUF_C_FIELD_FLAG_ONEOF && field->type == PROTOBUF_C_TYPE_MESSAGE;
    return is_choice ? field : NULL;
}

/* "scheme: riemann" is "scheme: {riemann: {}}". */
static MnsStatus read_choice(Reader *reader, MessageType *type, Field *choice, void *item, uint32_t mark)
{
    ProtobufCMessage *parent = case_message_new(type);
    if (!parent) return case_no_memory(reader->error);
    *(ProtobufCMessage **)item = parent;
    ProtobufCMessage **child = case_add(parent, choice);
    if (child) *child = case_message_new(choice->descriptor);
    return child && *child && add_mark(reader, mark, choice->name, 0) != MARK_NONE ? MNS_OK
                                                                                   : case_no_memory(reader->error);
}

static MnsStatus read_item(Reader *reader, MessageType *type, Field *field, void *item, uint32_t mark)
{
    char allowed[300];
    if (field->type != PROTOBUF_C_TYPE_MESSAGE) return read_scalar(reader, type, field, item);
    Field *choice = choice_named(reader, field->descriptor);
    if (choice) return read_choice(reader, field->descriptor, choice, item, mark);
    if (reader->event.type != YAML_MAPPING_START_EVENT) {
        case_names_for(field->descriptor, "", allowed, sizeof allowed);
        char sentence[400];
        snprintf(sentence, sizeof sentence, "a mapping ({} for an empty one) of entries %s",
                 allowed + strlen("allowed: "));
        return fail_kind(reader, sentence);
    }
    ProtobufCMessage *child = case_message_new(field->descriptor);
    if (!child) return case_no_memory(reader->error);
    *(ProtobufCMessage **)item = child; /* owned by the parent from here on, whatever happens */
    return read_mapping(reader, child, mark);
}

static MnsStatus read_list(Reader *reader, ProtobufCMessage *message, Field *field, uint32_t mark)
{
    char allowed[256], sentence[360];
    MnsStatus status;
    if (reader->event.type != YAML_SEQUENCE_START_EVENT) {
        case_allowed(message->descriptor, field, allowed, sizeof allowed);
        snprintf(sentence, sizeof sentence, "a list, as in [a, b] or lines that begin with \"- \", of %s", allowed);
        return fail_kind(reader, sentence);
    }
    for (size_t k = 0; !(status = next(reader)) && reader->event.type != YAML_SEQUENCE_END_EVENT; k++) {
        const size_t before = case_path_index(&reader->path, k);
        const uint32_t item_mark = add_mark(reader, mark, NULL, k);
        void *item = case_add(message, field);
        if (!item || item_mark == MARK_NONE) return case_no_memory(reader->error);
        status = read_item(reader, message->descriptor, field, item, item_mark);
        if (status) return status;
        case_path_cut(&reader->path, before);
    }
    return status;
}

/* The value of a field, its first event being looked at. */
static MnsStatus read_field(Reader *reader, ProtobufCMessage *message, Field *field, uint32_t mark)
{
    if (field->label == PROTOBUF_C_LABEL_REPEATED) return read_list(reader, message, field, mark);
    void *item = case_add(message, field);
    if (!item) return case_no_memory(reader->error);
    return read_item(reader, message->descriptor, field, item, mark);
}

static MnsStatus fail_unknown(Reader *reader, MessageType *type)
{
    const char *key = (const char *)reader->event.data.scalar.value;
    char shown[48], names[400], sentence[480];
    case_names_for(type, key, names, sizeof names);
    case_shown(key, shown);
    snprintf(sentence, sizeof sentence, "unknown entry \"%s\", %s", shown, names);
    return fail(reader, sentence);
}

/* A field may be given once, and of a oneof only one member; `given` are the fields that were. */
static MnsStatus check_given(Reader *reader, MessageType *type, Field *field, uint64_t given)
{
    char sentence[200];
    for (unsigned k = 0; k < type->n_fields; k++) {
        Field *other = &type->fields[k];
        if (!(given >> k & 1)) continue;
        if (other == field) {
            snprintf(sentence, sizeof sentence, "the entry \"%s\" is there twice: remove one", field->name);
            return fail(reader, sentence);
        }
        if (field->flags & other->flags & PROTOBUF_C_FIELD_FLAG_ONEOF &&
            field->quantifier_offset == other->quantifier_offset) {
            snprintf(sentence, sizeof sentence, "\"%s\" and \"%s\" exclude each other: remove one", other->name,
                     field->name);
            return fail(reader, sentence);
        }
    }
    return MNS_OK;
}

static MnsStatus read_entry(Reader *reader, ProtobufCMessage *message, uint32_t mark, uint64_t *given)
{
    MessageType *type = message->descriptor;
    if (reader->event.type != YAML_SCALAR_EVENT) return fail_kind(reader, "the name of an entry");
    const yaml_char_t *key = reader->event.data.scalar.value;
    Field *field = case_field_named(type, (const char *)key, reader->event.data.scalar.length);
    if (!field) return fail_unknown(reader, type);
    MnsStatus status = check_given(reader, type, field, *given);
    if (status) return status;
    *given |= UINT64_C(1) << (field - type->fields);
    const size_t before = case_path_name(&reader->path, field->name, strlen(field->name));
    status = next(reader);
    if (status) return status;
    const uint32_t field_mark = add_mark(reader, mark, field->name, 0);
    if (field_mark == MARK_NONE) return case_no_memory(reader->error);
    status = read_field(reader, message, field, field_mark);
    if (!status) case_path_cut(&reader->path, before);
    return status;
}

static MnsStatus read_mapping(Reader *reader, ProtobufCMessage *message, uint32_t mark)
{
    uint64_t given = 0;
    MnsStatus status;
    while (!(status = next(reader)) && reader->event.type != YAML_MAPPING_END_EVENT) {
        status = read_entry(reader, message, mark, &given);
        if (status) return status;
    }
    return status;
}

/* From the start of the text to the first event of its first document. */
static MnsStatus open_document(Reader *reader)
{
    MnsStatus status = next(reader); /* the start of the stream */
    if (!status) status = next(reader);
    if (!status && reader->event.type == YAML_STREAM_END_EVENT) return fail(reader, "there is nothing here");
    return status ? status : next(reader);
}

static MnsStatus close_document(Reader *reader)
{
    MnsStatus status = next(reader); /* the end of the document */
    if (!status) status = next(reader);
    if (!status && reader->event.type != YAML_STREAM_END_EVENT)
        return fail(reader, "a second document begins here: a case is one document");
    return status;
}

static MnsStatus reader_init(Reader *reader, const char *text, size_t size)
{
    if (size > CASE_FILE_LIMIT) {
        char sentence[100];
        snprintf(sentence, sizeof sentence, "the text is %zu bytes long, allowed: %d", size, CASE_FILE_LIMIT);
        return fail(reader, sentence);
    }
    if (!yaml_parser_initialize(&reader->parser)) return case_no_memory(reader->error);
    yaml_parser_set_input_string(&reader->parser, (const unsigned char *)text, size);
    return MNS_OK;
}

static void reader_done(Reader *reader)
{
    yaml_event_delete(&reader->event);
    yaml_parser_delete(&reader->parser);
}

static MnsStatus read_root(Reader *reader, ProtobufCMessage *message)
{
    char allowed[200];
    if (reader->event.type != YAML_MAPPING_START_EVENT) {
        snprintf(allowed, sizeof allowed, "a mapping, with lines such as \"dimensions: 2\"");
        return fail_kind(reader, allowed);
    }
    const uint32_t root = add_mark(reader, MARK_NONE, NULL, 0);
    return root == MARK_NONE ? case_no_memory(reader->error) : read_mapping(reader, message, root);
}

MnsStatus case_read_document(const char *name, const char *text, size_t size, ProtobufCMessage *message, Marks *marks,
                             MnsError *error)
{
    Reader reader = {.name = name, .text = text, .marks = marks, .error = error};
    MnsStatus status = reader_init(&reader, text, size);
    if (status) return status;
    status = open_document(&reader);
    if (!status) status = read_root(&reader, message);
    if (!status) status = close_document(&reader);
    reader_done(&reader);
    return status;
}

MnsStatus case_read_value(const char *path, const char *text, ProtobufCMessage *message, Field *field, void *item,
                          MnsError *error)
{
    Reader reader = {.text = text, .error = error};
    case_path_name(&reader.path, path, strlen(path));
    MnsStatus status = reader_init(&reader, text, strlen(text));
    if (status) return status;
    status = open_document(&reader);
    if (!status)
        status =
            item ? read_item(&reader, message->descriptor, field, item, 0) : read_field(&reader, message, field, 0);
    if (!status) status = close_document(&reader);
    reader_done(&reader);
    return status;
}
