/* SPDX-License-Identifier: BSD-3-Clause */
/* What goes to standard output: one JSON object with stable keys, or text for people. README.md lists the keys. The dashboard sends its
 * browsers the same objects. */
#ifndef CLI_OUTPUT_H
#define CLI_OUTPUT_H

#include <jansson.h>
#include <meniscus/client.h>

/* Print as one line, and forget it. MNS_E_IO if standard output cannot be written; MNS_E_MEMORY if it is NULL. */
MnsStatus output_json(json_t *object, MnsError *error);

/* A text that comes from outside, as a name of a file, which need not be UTF-8; null for NULL. */
json_t *output_text(const char *text);

/* A number; null if it is not finite. */
json_t *output_number(double value);

/* {name: {"value": number, or text where it is none, "unit": text}, ...} */
json_t *output_values(size_t n, const MnsValue *values);

/* {"unit", "type", "shape", "values": nested lists} */
json_t *output_array(const MnsArray *array);

/* Element k of an array as a number. */
double output_element(const MnsArray *array, size_t k);

/* What every reply has: state, step, time, effect_step, daemon_epoch, message. */
json_t *output_reply(const MnsReply *reply);

/* All of a status. */
json_t *output_info(const MnsRunInfo *info);

/* One message of telemetry: topic, sequence, lost, step, time, and what its topic has. */
json_t *output_telemetry(const MnsTelemetry *message);

/* All that a daemon can do. */
json_t *output_capabilities(const MnsCapabilities *capabilities);

/* {"error": ...}: a failure, what to do about it, and the exit code that goes with it. */
json_t *output_failure(const MnsError *error, const char *hint, int code);

/* Values as lines "name = value unit". */
/* For people: nothing behind a number that has none. */
const char *output_unit(const char *unit);

void output_print_values(size_t n, const MnsValue *values);

/* The id of a request, as options take it. */
void output_id(const uint8_t id[MNS_REQUEST_ID_SIZE], char ret[2 * MNS_REQUEST_ID_SIZE + 1]);

#endif
