/* SPDX-License-Identifier: BSD-3-Clause */
/* Where daemons are and keep their files. */
#include "common/host/places.h"
#include "common/host/text.h"
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

Place places_look(const char *path)
{
    struct stat info;
    if (lstat(path, &info)) return errno == ENOENT ? PLACE_MISSING : PLACE_STRANGE;
    if (!S_ISDIR(info.st_mode) || info.st_uid != geteuid()) return PLACE_STRANGE;
    if (info.st_mode & 022) return PLACE_OPEN;
    return info.st_mode & 077 ? PLACE_SEEN : PLACE_PRIVATE;
}

/* Only root makes directories in /run, and gives them to whom it wants. */
static bool is_given_by_root(const char *path)
{
    struct stat info;
    return !lstat(path, &info) && S_ISDIR(info.st_mode) && !(info.st_mode & 022);
}

static bool is_ours(const char *path)
{
    const Place place = places_look(path);
    return place == PLACE_PRIVATE || place == PLACE_SEEN;
}

bool places_is_safe(const char *base, const char *name)
{
    char path[4096];
    const int n = snprintf(path, sizeof path, "%s/%s", base, name);
    if (n < 0 || (size_t)n >= sizeof path) return false;
    if (!strcmp(base, PLACES_SYSTEM)) return is_given_by_root(base) && is_given_by_root(path);
    return is_ours(base) && is_ours(path);
}

/* A sticky directory, as /tmp is, keeps others from taking files away, but not from being the first to make one. */
bool places_is_exposed(const char *path, char *ret, size_t size)
{
    struct stat info;
    if (stat(path, &info)) return false;
    const bool ours = info.st_uid == geteuid(), sticky = info.st_mode & S_ISVTX;
    const unsigned mode = (unsigned)info.st_mode & 07777;
    if (!ours && info.st_uid)
        snprintf(ret, size,
                 "'%.300s' belongs to user %u, who can take away or replace what is in it; choose a directory of your "
                 "own, such as one in it",
                 path, (unsigned)info.st_uid);
    else if (info.st_mode & S_IWOTH && ours)
        snprintf(ret, size, "every account can %s '%.300s' (mode %04o); `chmod o-w` it",
                 sticky ? "put files into" : "take away or replace what is in", path, mode);
    else if (info.st_mode & S_IWOTH)
        snprintf(ret, size,
                 "every account can %s '%.300s' (mode %04o); choose a directory of your own, such as one in it",
                 sticky ? "put files into" : "take away or replace what is in", path, mode);
    else return false;
    return true;
}

const char *places_variable(const char *name)
{
    const char *path = getenv(name);
    return path && *path == '/' ? path : NULL;
}

const char *places_homeless(void)
{
    const char *home = getenv("HOME");
    return home && *home ? "HOME is no absolute path" : "HOME is not set";
}

void places_sockets(char *ret, size_t size)
{
    const char *user = places_variable("XDG_RUNTIME_DIR");
    if (user) snprintf(ret, size, "%s/meniscus", user);
    else snprintf(ret, size, "/tmp/meniscus-%u", (unsigned)getuid());
}

MnsStatus places_state(const char *name, char *ret, size_t size, MnsError *error)
{
    const char *systemd = places_variable("STATE_DIRECTORY"), *state = places_variable("XDG_STATE_HOME"),
               *home = places_variable("HOME");
    int n = 0;
    if (systemd) n = snprintf(ret, size, "%s", systemd);
    else if (state) n = snprintf(ret, size, "%s/meniscus/%s", state, name);
    else if (home) n = snprintf(ret, size, "%s/.local/state/meniscus/%s", home, name);
    if (n > 0 && (size_t)n < size) return MNS_OK;
    if (n)
        return mns_fail_at(error, MNS_E_INVALID, "state-dir",
                           "the path of the state directory is longer than %zu bytes; give meniscusd --state-dir DIR",
                           size - 1);
    return mns_fail_at(error, MNS_E_INVALID, "state-dir",
                       "there is no place for the files of runs, as %s; give meniscusd --state-dir DIR, or set HOME to "
                       "an absolute path",
                       places_homeless());
}

static const char *kind_of(mode_t mode)
{
    if (S_ISREG(mode)) return "a file";
    if (S_ISDIR(mode)) return "a directory";
    return S_ISFIFO(mode) ? "a pipe" : S_ISSOCK(mode) ? "a socket" : "a device";
}

void places_found(const char *path, char ret[static PLACES_FOUND])
{
    struct stat own, there;
    char leads[64] = "";
    if (lstat(path, &own)) snprintf(ret, PLACES_FOUND, "not to be seen: %s", strerror(errno));
    else if (!S_ISLNK(own.st_mode)) snprintf(ret, PLACES_FOUND, "%s", kind_of(own.st_mode));
    else {
        if (readlink(path, leads, sizeof leads - 1) < 0) leads[0] = 0;
        snprintf(ret, PLACES_FOUND, "a link to '%s', which is %s", text_shown(leads),
                 stat(path, &there) ? "not there" : kind_of(there.st_mode));
    }
}
