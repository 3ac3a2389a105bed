/* SPDX-License-Identifier: BSD-3-Clause */
/* Is the daemon well? /healthz and /readyz, as JSON. */
#ifndef HTTP_HEALTH_H
#define HTTP_HEALTH_H

#include "http/view.h"

/* All return text from malloc; NULL if there is no memory. */

/* The process answers. */
char *health_alive(const View *view);

/* The daemon takes commands, and the disk can be written to; with loaded, a run is there too, and not in FAULT. Else *ret_ready is false, and the text has the
 * reason; it also has that of a FAULT, in which commands are taken. */
char *health_ready(const View *view, bool loaded, bool *ret_ready);

#endif
