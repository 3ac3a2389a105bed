/* SPDX-License-Identifier: BSD-3-Clause */
/* What daemons share with their clients: sockets, the daemon itself, its files, keys. */
#include "client/cli/doctor.h"
#include "client/cli/listener.h"
#include "common/host/places.h"
#include "common/wire/frame.h"
#include "common/wire/keys.h"
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <sys/un.h>
#include <unistd.h>

/* The directory itself, or the nearest above it that is there. */
static void nearest(const char *path, char *ret, size_t size)
{
    struct stat info;
    snprintf(ret, size, "%s", path);
    while (stat(ret, &info)) {
        char *slash = strrchr(ret, '/');
        if (!slash || slash == ret) {
            snprintf(ret, size, "%s", slash ? "/" : ".");
            return;
        }
        *slash = 0;
    }
}

/* --- sockets -------------------------------------------------------------------------------------------------------------- */

/* One that is there must be ours alone, as whoever may write in it could put a socket in the place of a daemon's. */
static bool is_private(Doctor *doctor, const char *path)
{
    char remedy[400];
    const Place place = places_look(path);
    if (place == PLACE_MISSING || place == PLACE_PRIVATE) return true;
    if (place != PLACE_STRANGE) snprintf(remedy, sizeof remedy, "chmod 700 %.300s", path);
    else snprintf(remedy, sizeof remedy, "remove it, or set XDG_RUNTIME_DIR to a directory of your own");
    if (place == PLACE_STRANGE)
        doctor_say(doctor, PROBLEM, "sockets", remedy, "%.300s is no directory of this user", path);
    else
        doctor_say(doctor, PROBLEM, "sockets", remedy, "others can %s %.300s",
                   place == PLACE_OPEN ? "write in" : "look into", path);
    return false;
}

/* As the XDG specification has it, so that something may well be elsewhere than its user believes. */
static void warn_of_relative(Doctor *doctor)
{
    static const char *const names[] = {"XDG_RUNTIME_DIR", "XDG_STATE_HOME", "XDG_CONFIG_HOME"};
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        const char *value = getenv(names[k]);
        if (value && *value && !places_variable(names[k]))
            doctor_say(doctor, WARNING, "places", "set it to an absolute path, or unset it",
                       "%s is %.200s, which is no absolute path and does not count", names[k], value);
    }
}

void doctor_check_sockets(Doctor *doctor)
{
    warn_of_relative(doctor);
    const size_t longest = sizeof((struct sockaddr_un *)NULL)->sun_path - 1;
    char base[1024], path[1200], above[1024];
    places_sockets(base, sizeof base);
    snprintf(path, sizeof path, "%s/%s", base, doctor->name);
    if (!is_private(doctor, base) || !is_private(doctor, path)) return;
    nearest(base, above, sizeof above);
    const bool there = strcmp(above, base) == 0;
    if (strlen(path) + strlen("/telemetry.ipc") > longest)
        doctor_say(doctor, PROBLEM, "sockets", "set XDG_RUNTIME_DIR to a shorter one, or take a shorter --name",
                   "%.300s is too long for a socket's path, which has %zu bytes at most", path, longest);
    else if (!there && strlen(above) < (size_t)(strrchr(base, '/') - base)) /* daemons make the last directory alone */
        doctor_say(
            doctor, PROBLEM, "sockets", "unset XDG_RUNTIME_DIR, or set it to a directory of your own that is there",
            "daemons have their sockets in %.300s, and there is no %.*s", base, (int)(strrchr(base, '/') - base), base);
    else if (access(above, W_OK | X_OK))
        doctor_say(doctor, PROBLEM, "sockets", "set XDG_RUNTIME_DIR to a directory of your own, or unset it",
                   "daemons have their sockets in %.300s, and %.300s cannot be written: %s", base, above,
                   strerror(errno));
    else
        doctor_say(doctor, WELL, "sockets", NULL, "%.300s%s", base,
                   there ? ", for this user alone" : ", which the first daemon makes");
}

/* --- the daemon ----------------------------------------------------------------------------------------------------------- */

static void describe(Doctor *doctor, const char *endpoint, const MnsRunInfo *info)
{
    const bool empty = info->state == MNS_STATE_EMPTY;
    char *slash;
    if (*info->run_directory) {
        snprintf(doctor->state_dir, sizeof doctor->state_dir, "%s", info->run_directory);
        if ((slash = strrchr(doctor->state_dir, '/')) && slash > doctor->state_dir) *slash = 0;
    }
    if (strcmp(info->version, MENISCUS_VERSION) != 0)
        doctor_say(doctor, WARNING, "daemon", "shut it down and start it again to have the newer one",
                   "the one at %s is meniscusd %s, and this is meniscus " MENISCUS_VERSION, endpoint, info->version);
    else if (info->state == MNS_STATE_FAULT)
        doctor_say(doctor, WARNING, "daemon", "see `meniscus status`, then resume, restore or load",
                   "the one at %s stopped in FAULT: %.300s", endpoint, info->fault);
    else if (*info->fault)
        doctor_say(doctor, WARNING, "daemon", "mend that and start the daemon again, or load a case",
                   "the one at %s is %s: %.300s", endpoint, mns_state_name(info->state), info->fault);
    else
        doctor_say(doctor, WELL, "daemon", NULL, "the one at %s is %s%s%s, %s, protocol %d", endpoint,
                   mns_state_name(info->state), empty ? "" : ", case ", empty ? "" : info->case_name, info->version,
                   (int)FRAME_MAJOR);
}

/* Which key file is ours, and whether it is good; one line says what is wrong with it. */
static const char *own_key(const Doctor *doctor, MnsError *error)
{
    const char *given = options_get(&doctor->in->options, OPT_KEY), *path = given ? given : getenv("MENISCUS_KEY");
    KeyPair pair = {.public_key = ""};
    *error = (MnsError){0};
    if (!path || !*path) return NULL;
    key_file_read(path, &pair, error);
    explicit_bzero(pair.secret_key, sizeof pair.secret_key);
    return path;
}

static void ask_daemon(Doctor *doctor, const char *endpoint)
{
    MnsError key;
    const Options *o = &doctor->in->options;
    const MnsClientOptions options = {
        .daemon = endpoint, .key_file = options_get(o, OPT_KEY), .server_key = options_get(o, OPT_SERVER_KEY)};
    MnsClient *client = NULL;
    MnsReply *reply = NULL;
    MnsError error = {0};
    MnsStatus status = mns_client_open_with(&options, &client, &error);
    if (!status) {
        mns_client_set_timeout(client, 5);
        status = mns_client_status(client, &reply, &error);
    }
    if (status && own_key(doctor, &key) && key.status && strcmp(key.text, error.text) == 0)
        doctor_say(doctor, WARNING, "daemon", "see to the key first: own key, below", "the one at %s was not asked",
                   endpoint);
    else if (status) doctor_say(doctor, PROBLEM, "daemon", mns_status_hint(status), "%s", error.text);
    else if (reply->info) describe(doctor, endpoint, reply->info);
    else doctor_say(doctor, PROBLEM, "daemon", mns_status_hint(MNS_E_VERSION), "its status is empty");
    mns_reply_free(reply);
    mns_client_close(client);
}

/* That none runs is nothing bad, but whoever names one expects it. */
void doctor_check_daemon(Doctor *doctor)
{
    const char *given = options_get(&doctor->in->options, OPT_DAEMON), *variable = getenv("MENISCUS_DAEMON");
    const bool expected = given || (variable && *variable);
    char endpoint[MNS_ENDPOINT_SIZE], remedy[300];
    MnsError error = {0};
    const MnsStatus status = mns_daemon_endpoint(given, endpoint, &error);
    snprintf(remedy, sizeof remedy, "`meniscusd --name %s &` starts one", doctor->name);
    if (status == MNS_E_UNAVAILABLE)
        doctor_say(doctor, expected ? WARNING : WELL, "daemon", remedy, "none named %s is running", doctor->name);
    else if (status) doctor_say(doctor, PROBLEM, "daemon", mns_status_hint(status), "%s", error.text);
    else if (listener_is_gone(endpoint))
        doctor_say(doctor, WARNING, "daemon",
                   "start it again by the same command line as before: with its --state-dir it goes on with its run",
                   "the one at %s has ended without a word", endpoint);
    else ask_daemon(doctor, endpoint);
}

/* --- files ---------------------------------------------------------------------------------------------------------------- */

static void check_room(Doctor *doctor, const char *path, bool there)
{
    static const double GIB = 1 << 30, little = 1, none = 0.0625;
    struct statvfs disk;
    if (statvfs(path, &disk)) {
        doctor_say(doctor, PROBLEM, "state", "give meniscusd another --state-dir", "cannot look at %.300s: %s", path,
                   strerror(errno));
        return;
    }
    const double room = (double)disk.f_bavail * (double)disk.f_frsize / GIB;
    const Verdict verdict = room < none ? PROBLEM : room < little ? WARNING : WELL;
    doctor_say(doctor, verdict, "state", verdict ? "make room, or give meniscusd another --state-dir" : NULL,
               "%.300s%s, %.2f GiB free", doctor->state_dir, there ? "" : ", which the daemon makes", room);
}

void doctor_check_state(Doctor *doctor)
{
    const char *given = options_get(&doctor->in->options, OPT_STATE_DIR);
    char above[4096], exposed[512];
    struct stat info;
    MnsError error;
    if (given) snprintf(doctor->state_dir, sizeof doctor->state_dir, "%s", given);
    if (!*doctor->state_dir && places_state(doctor->name, doctor->state_dir, sizeof doctor->state_dir, &error)) {
        *doctor->state_dir = 0;
        doctor_say(doctor, PROBLEM, "state", "set HOME, or give meniscusd --state-dir DIR", "%s", error.text);
        return;
    }
    if (places_is_exposed(doctor->state_dir, exposed, sizeof exposed))
        doctor_say(doctor, WARNING, "state", NULL, "%s", exposed);
    nearest(doctor->state_dir, above, sizeof above);
    if (stat(above, &info) || !S_ISDIR(info.st_mode))
        doctor_say(doctor, PROBLEM, "state", "give meniscusd another --state-dir", "%.300s is no directory", above);
    else if (access(above, W_OK | X_OK))
        doctor_say(doctor, PROBLEM, "state", "make it writable for this user, or give meniscusd another --state-dir",
                   "runs keep their files in %.300s, and %.300s cannot be written: %s", doctor->state_dir, above,
                   strerror(errno));
    else check_room(doctor, above, strcmp(above, doctor->state_dir) == 0);
}

/* --- keys ----------------------------------------------------------------------------------------------------------------- */

/* The secret file of a name, if it is there: it may have been given away. */
static bool check_pair(Doctor *doctor, const char *path)
{
    KeyPair pair = {.public_key = ""};
    MnsError error = {0};
    const MnsStatus status = key_file_read(path, &pair, &error);
    explicit_bzero(pair.secret_key, sizeof pair.secret_key);
    if (!status || status == MNS_E_NOT_FOUND) return true;
    doctor_say(doctor, PROBLEM, "keys", "mend it, or make the key anew with `meniscus keys`", "%s", error.text);
    return false;
}

static void check_ring(Doctor *doctor, const char *directory)
{
    char path[KEYS_PATH];
    Keys keys = {0};
    MnsError error = {0};
    struct stat info;
    if (stat(directory, &info)) {
        doctor_say(doctor, WELL, "keys", NULL, "none in %.300s: only this machine reaches its daemons", directory);
        return;
    }
    if (keys_read(directory, &keys, &error)) {
        doctor_say(doctor, PROBLEM, "keys", "until then daemons with --listen let nobody in", "%s", error.text);
        return;
    }
    key_path(directory, KEYS_DAEMON, path);
    bool good = check_pair(doctor, path);
    for (size_t k = 0; k < keys.n && good; k++) {
        key_path(directory, keys.keys[k].name, path);
        good = check_pair(doctor, path);
    }
    if (good) doctor_say(doctor, WELL, "keys", NULL, "%zu let in by %.300s", keys.n, directory);
    keys_done(&keys);
}

/* Our own, for daemons elsewhere. */
static void check_own(Doctor *doctor)
{
    MnsError error;
    const char *path = own_key(doctor, &error);
    if (!path) return;
    if (error.status)
        doctor_say(doctor, PROBLEM, "own key", "name a file that `meniscus keys new` wrote, of mode 0600", "%s",
                   error.text);
    else doctor_say(doctor, WELL, "own key", NULL, "%.300s", path);
}

void doctor_check_keys(Doctor *doctor)
{
    const char *given = options_get(&doctor->in->options, OPT_KEYS);
    char directory[KEYS_PATH];
    MnsError error = {0};
    if (given && *given && strlen(given) < KEYS_PATH - KEY_NAME_SIZE - 16) check_ring(doctor, given);
    else if (given) doctor_say(doctor, PROBLEM, "keys", "name a directory", "--keys \"%.80s\" is none", given);
    else if (keys_directory(directory, &error)) doctor_say(doctor, WARNING, "keys", NULL, "%s", error.text);
    else check_ring(doctor, directory);
    check_own(doctor);
}
