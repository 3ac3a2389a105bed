/* SPDX-License-Identifier: BSD-3-Clause */
/* Where daemons are and keep their files. */
#include "proto/places.h"
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

void places_sockets(char *ret, size_t size)
{
    const char *user = getenv("XDG_RUNTIME_DIR");
    if (user && *user) snprintf(ret, size, "%s/meniscus", user);
    else snprintf(ret, size, "/tmp/meniscus-%u", (unsigned)getuid());
}

void places_state(const char *name, char *ret, size_t size)
{
    const char *systemd = getenv("STATE_DIRECTORY"), *state = getenv("XDG_STATE_HOME"), *home = getenv("HOME");
    if (systemd && *systemd) snprintf(ret, size, "%s", systemd);
    else if (state && *state) snprintf(ret, size, "%s/meniscus/%s", state, name);
    else if (home && *home) snprintf(ret, size, "%s/.local/state/meniscus/%s", home, name);
    else snprintf(ret, size, "meniscus-%s", name);
}
