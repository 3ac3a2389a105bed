/* SPDX-License-Identifier: BSD-3-Clause */
/* What a daemon says of itself: status and capabilities as messages, from malloc. */
#ifndef NET_DESCRIBE_H
#define NET_DESCRIBE_H

#include "http/traffic.h"
#include "meniscus.pb-c.h"
#include "run/run.h"

/* Of the sources, "+" behind it if they were changed, or ""; of the compiler, "gcc 12.2.0". */
const char *describe_commit(void);
const char *describe_compiler(void);

/* streams: may be NULL. NULL if there is no memory. */
Meniscus__Status *describe_status(const RunStatus *status, const StreamTraffic *streams);

/* commands: NULL-terminated; document: the present case, or NULL; fields: that its simulation has, 0 without one. NULL if there is no memory. */
Meniscus__Capabilities *describe_capabilities(const char *const *commands, const Document *document, uint64_t fields);

#endif
