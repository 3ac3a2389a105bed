/* SPDX-License-Identifier: BSD-3-Clause */
/* Codes and sentences of <meniscus/status.h>. */
#include <errno.h>
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
        [MNS_E_HELD] = "held",
        [MNS_E_EXPIRED] = "expired",
        [MNS_E_DENIED] = "denied",
        [MNS_E_INTERNAL] = "internal error",
    };
    const unsigned k = (unsigned)status;
    return k < sizeof names / sizeof *names ? names[k] : "unknown";
}

const char *mns_status_hint(MnsStatus status)
{
    static const char *const hints[] = {
        [MNS_E_INVALID] = "mend what the message names and try again",
        [MNS_E_NOT_FOUND] = "check the name; the message or `meniscus capabilities` says what there is",
        [MNS_E_STATE] = "see the state with `meniscus status`, and wait for another with `meniscus wait`",
        [MNS_E_LIMIT] = "ask for less, or raise the limit if the message names an entry for it",
        [MNS_E_MEMORY] = "compute with fewer particles, or on a machine with more memory",
        [MNS_E_DIVERGED] =
            "look at the last snapshot, then restore a checkpoint, or load the case with what the message advises",
        [MNS_E_IO] = "see to the file or directory that the message names, then try again",
        [MNS_E_NO_SPACE] =
            ("make room, or where a file is too large raise the limit on the size of files (`ulimit -f`); "
             "a run goes on then with `meniscus resume`, or with `meniscus run --resume auto`"),
        [MNS_E_CORRUPT] = "use another file: the newest whole checkpoint is found by itself",
        [MNS_E_VERSION] = "use programs of the same version",
        [MNS_E_UNAVAILABLE] = "see which daemons there are with `meniscus ls`, or start one with `meniscusd`",
        [MNS_E_TIMEOUT] = "allow more time, or see with `meniscus status` how far it is",
        [MNS_E_INTERRUPTED] = "ended on request: see `meniscus status`, and give it again if it is still wanted",
        [MNS_E_HELD] = ("wait, or only watch; pause, stop and shutdown need none; its holder gives `meniscus` --lease "
                        "or $MENISCUS_LEASE"),
        [MNS_E_EXPIRED] =
            "see with `meniscus status` who holds the lease now, and take a new one with `meniscus lease`",
        [MNS_E_DENIED] = "ask whoever keeps the daemon's keys: `meniscus keys` makes one of the role that is needed",
        [MNS_E_INTERNAL] = "please report this with the command and the log",
    };
    const unsigned k = (unsigned)status;
    return k < sizeof hints / sizeof *hints && hints[k] ? hints[k] : "";
}

const char *mns_refusal_hint(int number)
{
    switch (number) {
    case ENOENT:
    case ENOTDIR: return "check the path, each directory of which must be there";
    case EACCES:
    case EPERM: return "see whose it is, and choose a place that you may use";
    case EROFS: return "nothing can be written there; choose another place";
    case ENOSPC:
    case EDQUOT: return "make room and try again";
    case EFBIG: return "raise the limit on the size of files (`ulimit -f`, LimitFSIZE=) and try again";
    case EISDIR: return "name a file in it, or move it away";
    case EEXIST: return "choose another name";
    case EMFILE:
    case ENFILE: return "allow more open files, as with `ulimit -n`";
    case ENOMEM: return "free some memory and try again";
    default: return "choose another place, or see what the disk has";
    }
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
