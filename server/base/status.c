/* SPDX-License-Identifier: BSD-3-Clause */
/* Codes and sentences of <meniscus/status.h>. */
#include <meniscus/status.h>
#include <stdarg.h>
#include <stdio.h>

const char *mns_status_name(MnsStatus status)
{
    static const char *const names[] = {
        [MNS_OK] = "ok",
        [MNS_E_INVALID] = "invalid",
        [MNS_E_NOT_FOUND] = "not found",
        [MNS_E_STATE] = "wrong state",
        [MNS_E_LIMIT] = "limit reached",
        [MNS_E_MEMORY] = "out of memory",
        [MNS_E_DIVERGED] = "diverged",
        [MNS_E_IO] = "input/output error",
        [MNS_E_NO_SPACE] = "no space",
        [MNS_E_CORRUPT] = "corrupt",
        [MNS_E_VERSION] = "wrong version",
        [MNS_E_UNAVAILABLE] = "unavailable",
        [MNS_E_TIMEOUT] = "timed out",
        [MNS_E_INTERRUPTED] = "interrupted",
        [MNS_E_INTERNAL] = "internal error",
    };
    const unsigned k = (unsigned)status;
    return k < sizeof names / sizeof *names ? names[k] : "unknown";
}

static void fill(MnsError *error, MnsStatus status, const char *path, const char *format, va_list list)
{
    if (!error) return;
    error->status = status;
    snprintf(error->path, sizeof error->path, "%s", path);
    vsnprintf(error->text, sizeof error->text, format, list);
}

MnsStatus mns_fail(MnsError *error, MnsStatus status, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    fill(error, status, "", format, list);
    va_end(list);
    return status;
}

MnsStatus mns_fail_at(MnsError *error, MnsStatus status, const char *path, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    fill(error, status, path, format, list);
    va_end(list);
    return status;
}
