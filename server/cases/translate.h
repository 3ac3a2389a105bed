/* SPDX-License-Identifier: BSD-3-Clause */
/* Case message to MnsCase: the one file that knows both. */
#ifndef CASES_TRANSLATE_H
#define CASES_TRANSLATE_H

#include "case.pb-c.h"
#include <meniscus/case.h>

/* message has passed case_message_check(). Names (fluids, walls, fields) are resolved, counts checked against the
 * number of dimensions. MNS_OK; MNS_E_INVALID, MNS_E_LIMIT with error->path. Free *ret with mns_case_free(). */
MnsStatus case_translate(const Meniscus__Case *message, MnsCase **ret, MnsError *error);

#endif
