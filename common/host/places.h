/* SPDX-License-Identifier: BSD-3-Clause */
/* Where daemons of this user are and keep their files if nobody says otherwise: for the daemon, and for who looks after it. */
#ifndef COMMON_HOST_PLACES_H
#define COMMON_HOST_PLACES_H

#include <meniscus/status.h>
#include <stdbool.h>
#include <stddef.h>

/* Where systemd's daemons have theirs. */
#define PLACES_SYSTEM "/run/meniscus"

/* Whose a directory is: who may write in it can put a socket in the place of a daemon's. */
typedef enum Place {
    PLACE_MISSING, /* there is nothing */
    PLACE_PRIVATE, /* ours alone */
    PLACE_SEEN,    /* ours, and others may look in */
    PLACE_OPEN,    /* ours, and others may write */
    PLACE_STRANGE, /* somebody else's, or no directory, or a link, which leads anywhere */
} Place;
Place places_look(const char *path);

/* May a client believe what is in BASE/NAME? Both must be ours, and not for others to write; in systemd's it is up to root whose they are. */
bool places_is_safe(const char *base, const char *name);

/* Can an account besides this user and root put files into a directory, or take them away? Then it can keep runs from starting, or spoil them: `ret` is
 * a sentence that says so, and what to do. Groups do not count, as administrators make them, and group-writable is what umask 002 gives. */
bool places_is_exposed(const char *path, char *ret, size_t size);

/* The absolute path that a variable of the environment has. NULL: it is not set, or is relative, and then it does not count, as the XDG Base Directory
 * Specification has it: a place of all of the user's programs is not where one of them was started. */
const char *places_variable(const char *name);

/* Why there is nothing below the user's home directory: the end of a sentence. */
const char *places_homeless(void);

/* The directory that holds one directory of sockets per daemon: $XDG_RUNTIME_DIR/meniscus or /tmp/meniscus-UID. */
void places_sockets(char *ret, size_t size);

/* Where a daemon's runs keep their files: $STATE_DIRECTORY, $XDG_STATE_HOME/meniscus/NAME or $HOME/.local/state/meniscus/NAME. MNS_E_INVALID: none
 * of these is set, or the path is too long. */
MnsStatus places_state(const char *name, char *ret, size_t size, MnsError *error);

enum { PLACES_FOUND = 512 };

/* What is there in place of what was to be: the end of a sentence that begins with the path and "is", as "a file", "a pipe" or "a link to 'x', which is not
 * there". */
void places_found(const char *path, char ret[static PLACES_FOUND]);

#endif
