/* SPDX-License-Identifier: BSD-3-Clause */
/* Cases and their entries as YAML text, written by libyaml so that every text is quoted as it must be. */
#include "common/case/print.h"
#include "common/case/scalar.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <yaml.h>

typedef struct Printer {
    yaml_emitter_t emitter;
    FILE *out;
    bool one_line;
    bool failed; /* sticky: nothing is written after the first failure */
} Printer;

static int write_out(void *arg, unsigned char *bytes, size_t size)
{
    FILE *out = arg;
    return fwrite(bytes, 1, size, out) == size;
}

/* good: whether the event could be made; the emitter owns it from here on. */
static void emit(Printer *printer, int good, yaml_event_t *event)
{
    if (good && printer->failed) yaml_event_delete(event);
    if (!printer->failed) printer->failed = !good || !yaml_emitter_emit(&printer->emitter, event);
}

/* Quotes where a plain text would read as nothing, or spread over lines. */
static yaml_scalar_style_t style_of(const char *text)
{
    return !*text || strpbrk(text, "\n\t") ? YAML_DOUBLE_QUOTED_SCALAR_STYLE : YAML_ANY_SCALAR_STYLE;
}

static void print_text(Printer *printer, const char *text)
{
    yaml_event_t event;
    emit(printer,
         yaml_scalar_event_initialize(&event, NULL, NULL, (const yaml_char_t *)text, (int)strlen(text), 1, 1,
                                      style_of(text)),
         &event);
}

static void begin_mapping(Printer *printer)
{
    yaml_event_t event;
    const yaml_mapping_style_t style = printer->one_line ? YAML_FLOW_MAPPING_STYLE : YAML_BLOCK_MAPPING_STYLE;
    emit(printer, yaml_mapping_start_event_initialize(&event, NULL, NULL, 1, style), &event);
}

static void begin_list(Printer *printer, bool flow)
{
    yaml_event_t event;
    const yaml_sequence_style_t style = flow ? YAML_FLOW_SEQUENCE_STYLE : YAML_BLOCK_SEQUENCE_STYLE;
    emit(printer, yaml_sequence_start_event_initialize(&event, NULL, NULL, 1, style), &event);
}

static void end_mapping(Printer *printer)
{
    yaml_event_t event;
    emit(printer, yaml_mapping_end_event_initialize(&event), &event);
}

static void end_list(Printer *printer)
{
    yaml_event_t event;
    emit(printer, yaml_sequence_end_event_initialize(&event), &event);
}

static void print_message(Printer *printer, const ProtobufCMessage *message);

static void print_item(Printer *printer, const ProtobufCMessage *message, Field *field, size_t k)
{
    char buffer[64];
    if (field->type == PROTOBUF_C_TYPE_MESSAGE) print_message(printer, case_child(message, field, k));
    else print_text(printer, case_scalar_text(field, case_item(message, field, k), buffer));
}

static void print_field(Printer *printer, const ProtobufCMessage *message, Field *field)
{
    if (field->label != PROTOBUF_C_LABEL_REPEATED) {
        print_item(printer, message, field, 0);
        return;
    }
    begin_list(printer, printer->one_line || field->type != PROTOBUF_C_TYPE_MESSAGE);
    for (size_t k = 0; k < case_count(message, field); k++) print_item(printer, message, field, k);
    end_list(printer);
}

static void print_message(Printer *printer, const ProtobufCMessage *message)
{
    begin_mapping(printer);
    for (unsigned k = 0; k < message->descriptor->n_fields; k++) {
        Field *field = &message->descriptor->fields[k];
        if (!case_count(message, field)) continue;
        print_text(printer, field->name);
        print_field(printer, message, field);
    }
    end_mapping(printer);
}

static void print_absent(Printer *printer, Field *field)
{
    char buffer[64];
    if (field->type == PROTOBUF_C_TYPE_MESSAGE) {
        begin_mapping(printer);
        end_mapping(printer);
    } else if (!field->default_value) {
        print_text(printer, "null");
    } else if (field->type == PROTOBUF_C_TYPE_STRING) {
        print_text(printer, field->default_value);
    } else {
        print_text(printer, case_scalar_text(field, field->default_value, buffer));
    }
}

static bool printer_open(Printer *printer, char **ret_text, size_t *ret_size, bool one_line)
{
    yaml_event_t event;
    *printer = (Printer){.out = open_memstream(ret_text, ret_size), .one_line = one_line};
    if (!printer->out) return false;
    if (!yaml_emitter_initialize(&printer->emitter)) {
        fclose(printer->out);
        free(*ret_text);
        return false;
    }
    yaml_emitter_set_output(&printer->emitter, write_out, printer->out);
    yaml_emitter_set_width(&printer->emitter, -1);
    yaml_emitter_set_unicode(&printer->emitter, 1);
    emit(printer, yaml_stream_start_event_initialize(&event, YAML_UTF8_ENCODING), &event);
    emit(printer, yaml_document_start_event_initialize(&event, NULL, NULL, NULL, 1), &event);
    return true;
}

/* The text, which the stream has owned so far; NULL if anything went wrong. */
static char *printer_close(Printer *printer, char **text)
{
    yaml_event_t event;
    emit(printer, yaml_document_end_event_initialize(&event, 1), &event);
    emit(printer, yaml_stream_end_event_initialize(&event), &event);
    yaml_emitter_delete(&printer->emitter);
    if (!fclose(printer->out) && !printer->failed) return *text;
    free(*text);
    return NULL;
}

/* A value alone would get an end-of-document mark from libyaml, so it is printed as the only item of a list. */
static char *unwrap(char *text)
{
    if (!text) return NULL;
    char *end = strrchr(text, ']');
    *end = 0;
    memmove(text, text + 1, (size_t)(end - text));
    return text;
}

char *case_print_value(const ProtobufCMessage *message, Field *field, size_t k)
{
    Printer printer;
    char *text;
    size_t size;
    if (!printer_open(&printer, &text, &size, true)) return NULL;
    begin_list(&printer, true);
    if (k != CASE_ALL) print_item(&printer, message, field, k);
    else if (case_count(message, field)) print_field(&printer, message, field);
    else if (field->label == PROTOBUF_C_LABEL_REPEATED) {
        begin_list(&printer, true);
        end_list(&printer);
    } else print_absent(&printer, field);
    end_list(&printer);
    return unwrap(printer_close(&printer, &text));
}

static char *print_whole(const ProtobufCMessage *message, bool one_line)
{
    Printer printer;
    char *text;
    size_t size;
    if (!printer_open(&printer, &text, &size, one_line)) return NULL;
    print_message(&printer, message);
    return printer_close(&printer, &text);
}

char *case_print_line(const ProtobufCMessage *message)
{
    char *text = print_whole(message, true);
    if (text) text[strcspn(text, "\n")] = 0;
    return text;
}

char *case_message_print(const Meniscus__Case *message)
{
    return print_whole(&message->base, false);
}
