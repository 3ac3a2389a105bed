/* SPDX-License-Identifier: BSD-3-Clause */
/* Cases and their entries as YAML text. */
#ifndef COMMON_CASE_PRINT_H
#define COMMON_CASE_PRINT_H

#include "common/case/value.h"
#include <stdint.h>

#define CASE_ALL SIZE_MAX

/* Value k of a field, or all of it, as one line; the default where nothing is there, null if there is none. Yours;
 * NULL if there is no memory. */
char *case_print_value(const ProtobufCMessage *message, Field *field, size_t k);

/* A whole message as one line. Yours; NULL if there is no memory. */
char *case_print_line(const ProtobufCMessage *message);

#endif
