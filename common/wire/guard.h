/* SPDX-License-Identifier: BSD-3-Clause */
/* Whose browser is let in: pages of other sites are not, though the browser that shows them can reach us. */
#ifndef COMMON_WIRE_GUARD_H
#define COMMON_WIRE_GUARD_H

#include <stdbool.h>
#include <stddef.h>

enum { GUARD_NAMES = 16, GUARD_TEXT = 300 };

/* Names by which browsers may call this machine, besides localhost and addresses in digits. */
typedef struct Guard {
    size_t n;
    const char *names[GUARD_NAMES];
} Guard;

/* May a request have this Host header? A name that somebody else can point at this machine may not (DNS rebinding). */
bool guard_host(const Guard *guard, const char *host);

/* Does a page of this Origin come from that Host, which is us? Other sites' pages may not open a WebSocket here. Browsers always say an
 * origin; who says none is refused. */
bool guard_origin(const char *origin, const char *host);

#endif
