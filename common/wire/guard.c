/* SPDX-License-Identifier: BSD-3-Clause */
/* Whose browser is let in. */
#include "common/wire/guard.h"
#include "common/wire/address.h"
#include <arpa/inet.h>
#include <string.h>
#include <strings.h>

/* The port is not compared: behind a tunnel or a proxy it is another one. */
static bool take_name(const char *host, char ret[GUARD_TEXT])
{
    const bool brackets = host[0] == '[';
    const char *end = brackets ? strchr(host, ']') : strchr(host, ':');
    const size_t size = brackets ? (end ? (size_t)(end - host) - 1 : 0) : end ? (size_t)(end - host) : strlen(host);
    const char *rest = brackets && end ? end + 1 : end;
    if (!size || size >= GUARD_TEXT) return false;
    if (rest && *rest && (*rest != ':' || !rest[1] || strspn(rest + 1, "0123456789") != strlen(rest + 1))) return false;
    memcpy(ret, host + brackets, size);
    ret[size] = 0;
    struct in6_addr v6;
    return !brackets || inet_pton(AF_INET6, ret, &v6) == 1;
}

bool guard_host(const Guard *guard, const char *host)
{
    char name[GUARD_TEXT];
    struct in_addr v4;
    if (!take_name(host, name)) return false;
    if (host[0] == '[' || inet_pton(AF_INET, name, &v4) == 1 || address_of_localhost(name)) return true;
    for (size_t k = 0; k < guard->n; k++)
        if (!strcasecmp(name, guard->names[k])) return true;
    return false;
}

bool guard_origin(const char *origin, const char *host)
{
    static const char *const schemes[] = {"http://", "https://"};
    for (size_t k = 0; k < 2; k++) {
        const size_t n = strlen(schemes[k]);
        if (!strncasecmp(origin, schemes[k], n) && !strcasecmp(origin + n, host)) return true;
    }
    return false;
}
