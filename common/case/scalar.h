/* SPDX-License-Identifier: BSD-3-Clause */
/* Single values of a case: from text, strictly; to text, exactly; and whether they are within their bounds. */
#ifndef COMMON_CASE_SCALAR_H
#define COMMON_CASE_SCALAR_H

#include "common/case/value.h"

/* text as the value of a field. plain: it stands without quotes, as numbers and truth values must.
 * MNS_OK; MNS_E_INVALID with a sentence; MNS_E_MEMORY. */
MnsStatus case_scalar_parse(MessageType *type, Field *field, const char *text, bool plain, void *item, char *sentence,
                            size_t size);

/* Whether a value is within its bounds, an enum value exists, a text is UTF-8. Otherwise false and a sentence. */
bool case_scalar_check(MessageType *type, Field *field, const void *item, char *sentence, size_t size);

/* A value as text; of a string, the string. buffer may be used for it. */
const char *case_scalar_text(Field *field, const void *item, char buffer[static 64]);

bool case_scalar_equal(Field *field, const void *a, const void *b);

#endif
