/* SPDX-License-Identifier: BSD-3-Clause */
/* Is the daemon well? /healthz and /readyz, as JSON. */
#ifndef HTTP_HEALTH_H
#define HTTP_HEALTH_H

#include "http/view.h"

/* All return text from malloc; NULL if there is no memory. */

/* The process answers. */
char *health_alive(const View *view);

/* A run is loaded and not in FAULT, and the disk can be written to; else *ret_ready is false and the text has the reason. */
char *health_ready(const View *view, bool *ret_ready);

#endif
