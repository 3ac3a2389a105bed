/* SPDX-License-Identifier: BSD-3-Clause */
/* Files of keys. They are lines of words with blanks between them, which letters of a key never are; '#' begins a comment only at
 * the beginning of a line, as keys may have it. */
#include "common/wire/keys.h"
#include "common/host/disk.h"
#include "common/host/places.h"

#include "common/case/name.h"
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

/* --- names and places ----------------------------------------------------------------------------------------------------- */

MnsStatus keys_directory(char ret[static KEYS_PATH], MnsError *error)
{
    const char *given = getenv("MENISCUS_KEYS"), *config = places_variable("XDG_CONFIG_HOME"),
               *home = places_variable("HOME");
    int n = 0;
    if (given && *given) n = snprintf(ret, KEYS_PATH, "%s", given);
    else if (config) n = snprintf(ret, KEYS_PATH, "%s/meniscus/keys", config);
    else if (home) n = snprintf(ret, KEYS_PATH, "%s/.config/meniscus/keys", home);
    if (n > 0 && n < KEYS_PATH - KEY_NAME_SIZE - 16) return MNS_OK;
    if (n)
        return mns_fail_at(error, MNS_E_INVALID, "keys",
                           "the path of the directory of keys is longer than %d bytes; set MENISCUS_KEYS to another "
                           "one",
                           KEYS_PATH - KEY_NAME_SIZE - 17);
    return mns_fail_at(error, MNS_E_INVALID, "keys",
                       "there is no place for keys, as %s; set MENISCUS_KEYS to their directory, or HOME to an "
                       "absolute path",
                       places_homeless());
}

bool key_is_valid(const char *text)
{
    static const char z85[] = "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ.-:+=^!/*?&<>()[]{}@%$#";
    return strlen(text) == KEY_TEXT - 1 && strspn(text, z85) == KEY_TEXT - 1;
}

MnsStatus key_name_check(const char *name, MnsError *error)
{
    static const char *const taken[] = {WHO_LOCAL, WHO_DAEMON, WHO_BATCH};
    if (!is_name(name) || strlen(name) >= KEY_NAME_SIZE)
        return mns_fail_at(error, MNS_E_INVALID, "name",
                           "the name of a key has 1 to %d letters, digits, dots, dashes and underscores and does not "
                           "begin with a dot or a dash; found \"%.80s\"",
                           KEY_NAME_SIZE - 1, name);
    for (size_t k = 0; k < sizeof taken / sizeof *taken; k++)
        if (!strcmp(name, taken[k]))
            return mns_fail_at(error, MNS_E_INVALID, "name", "the name \"%s\" is taken; choose another", name);
    return MNS_OK;
}

void key_path(const char *directory, const char *name, char ret[static KEYS_PATH])
{
    snprintf(ret, KEYS_PATH, "%s/%s.key", directory, name);
}

/* --- reading -------------------------------------------------------------------------------------------------------------- */

static MnsStatus check_owner(int fd, const char *path, MnsError *error)
{
    struct stat info;
    if (fstat(fd, &info))
        return mns_fail(error, MNS_E_IO, "cannot look at %s: %s; %s", path, strerror(errno), mns_refusal_hint(errno));
    if (!S_ISREG(info.st_mode)) return mns_fail(error, MNS_E_STATE, "%s is no file; keys are not read from it", path);
    if (info.st_uid != geteuid())
        return mns_fail(error, MNS_E_STATE,
                        "%s belongs to user %u and not to user %u, who reads it: give it to them with chown", path,
                        (unsigned)info.st_uid, (unsigned)geteuid());
    if (info.st_mode & 077)
        return mns_fail(error, MNS_E_STATE,
                        "others have access to %s (mode %04o): take it from them with `chmod 600 %s`", path,
                        (unsigned)info.st_mode & 07777, path);
    return MNS_OK;
}

/* *ret: NULL if there is no such file. A link is followed: what counts is whose the file is. */
static MnsStatus open_private(const char *path, FILE **ret, MnsError *error)
{
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    *ret = NULL;
    if (fd < 0 && errno == ENOENT) return MNS_OK;
    if (fd < 0)
        return mns_fail(error, MNS_E_IO, "cannot open %s: %s; %s", path, strerror(errno), mns_refusal_hint(errno));
    const MnsStatus status = check_owner(fd, path, error);
    if (!status && (*ret = fdopen(fd, "r"))) return MNS_OK;
    close(fd);
    return status ? status : mns_fail(error, MNS_E_MEMORY, "no memory to read %s", path);
}

/* Whoever can rename in the directory could bring back a list of yesterday. */
static MnsStatus check_directory(const char *directory, MnsError *error)
{
    struct stat info;
    if (stat(directory, &info) || (info.st_uid == geteuid() && !(info.st_mode & 022))) return MNS_OK;
    return mns_fail(error, MNS_E_STATE,
                    "others can change what is in %s (mode %04o, of user %u): it must belong to user %u, and `chmod "
                    "700 %s`",
                    directory, (unsigned)info.st_mode & 07777, (unsigned)info.st_uid, (unsigned)geteuid(), directory);
}

enum { LINE = 256, WORDS = 4 };

/* What of a line did not fit, so that it is not taken for the next one. */
static void skip_rest(FILE *file, const char *line)
{
    if (strchr(line, '\n')) return;
    for (int c = getc(file); c != EOF && c != '\n'; c = getc(file)) {}
}

/* The next line that is not empty, in words; WORDS of them if there are as many or more. -1 at the end. */
static int read_words(FILE *file, char line[static LINE], char *words[static WORDS], size_t *number)
{
    while (fgets(line, LINE, file)) {
        int n = 0;
        char *rest;
        ++*number;
        skip_rest(file, line);
        if (line[0] == '#') continue;
        for (char *word = strtok_r(line, " \t\n", &rest); word && n < WORDS; word = strtok_r(NULL, " \t\n", &rest))
            words[n++] = word;
        if (n) return n;
    }
    return -1;
}

static MnsStatus wrong(MnsError *error, const char *path, size_t number, const char *what)
{
    return mns_fail(error, MNS_E_INVALID, "%s:%zu: %s", path, number, what);
}

static MnsStatus add(Keys *keys, int n, char *const words[static WORDS], const char *path, size_t number,
                     MnsError *error)
{
    MnsError name;
    if (n != 3) return wrong(error, path, number, "a line has a name, a role and a public key");
    const Role role = role_find(words[1]);
    if (key_name_check(words[0], &name)) return wrong(error, path, number, name.text);
    if (role == ROLE_NONE) return wrong(error, path, number, "a role is viewer, operator or admin");
    if (!key_is_valid(words[2])) return wrong(error, path, number, "a public key has 40 letters of Z85");
    if (keys_named(keys, words[0]) || keys_find(keys, words[2]))
        return wrong(error, path, number, "the name, or the key, is there already");
    if (keys->n == KEYS_MAX) return wrong(error, path, number, "more than 4096 keys");
    if (!(keys->n & (keys->n - 1))) { /* room for twice as many */
        Key *more = reallocarray(keys->keys, keys->n ? 2 * keys->n : 1, sizeof *more);
        if (!more) return mns_fail(error, MNS_E_MEMORY, "no memory for the keys of %s", path);
        keys->keys = more;
    }
    Key *key = &keys->keys[keys->n++];
    *key = (Key){.role = role};
    memcpy(key->name, words[0], strlen(words[0]));
    memcpy(key->public_key, words[2], KEY_TEXT);
    return MNS_OK;
}

MnsStatus keys_read(const char *directory, Keys *ret, MnsError *error)
{
    char path[KEYS_PATH + 16], line[LINE], *words[WORDS];
    FILE *file;
    Keys keys = {0};
    size_t number = 0;
    snprintf(path, sizeof path, "%s/" KEYS_AUTHORIZED, directory);
    MnsStatus status = check_directory(directory, error);
    if (status) return status;
    status = open_private(path, &file, error);
    for (int n; !status && file && (n = read_words(file, line, words, &number)) >= 0;)
        status = add(&keys, n, words, path, number, error);
    if (!status && file && ferror(file))
        status = mns_fail(error, MNS_E_IO, "cannot read %s: %s; %s", path, strerror(errno), mns_refusal_hint(errno));
    if (file) fclose(file);
    if (status) keys_done(&keys);
    else *ret = keys;
    return status;
}

void keys_done(Keys *keys)
{
    free(keys->keys);
    *keys = (Keys){0};
}

const Key *keys_find(const Keys *keys, const char *public_key)
{
    for (size_t k = 0; k < keys->n; k++)
        if (!strcmp(keys->keys[k].public_key, public_key)) return &keys->keys[k];
    return NULL;
}

const Key *keys_named(const Keys *keys, const char *name)
{
    for (size_t k = 0; k < keys->n; k++)
        if (!strcmp(keys->keys[k].name, name)) return &keys->keys[k];
    return NULL;
}

static char *place_of(KeyPair *pair, const char *word)
{
    if (!strcmp(word, "public-key")) return pair->public_key;
    if (!strcmp(word, "secret-key")) return pair->secret_key;
    return !strcmp(word, "server-key") ? pair->server_key : NULL;
}

MnsStatus key_file_read(const char *path, KeyPair *ret, MnsError *error)
{
    char line[LINE], *words[WORDS];
    FILE *file;
    KeyPair pair = {.public_key = ""};
    size_t number = 0;
    MnsStatus status = open_private(path, &file, error);
    if (!status && !file) return mns_fail(error, MNS_E_NOT_FOUND, "there is no file of a key %s", path);
    for (int n; !status && (n = read_words(file, line, words, &number)) >= 0;) {
        char *to = place_of(&pair, words[0]);
        if (to && n == 2 && key_is_valid(words[1])) memcpy(to, words[1], KEY_TEXT);
        else
            status =
                wrong(error, path, number, "a line is public-key, secret-key or server-key, and 40 letters of Z85");
    }
    if (file) fclose(file);
    explicit_bzero(line, sizeof line);
    if (!status && !(*pair.public_key && *pair.secret_key))
        status = mns_fail(error, MNS_E_INVALID, "%s lacks its public-key or its secret-key", path);
    if (!status) *ret = pair;
    explicit_bzero(&pair, sizeof pair);
    return status;
}

MnsStatus key_file_check(const char *path, MnsError *error)
{
    FILE *file;
    const MnsStatus status = open_private(path, &file, error);
    if (file) fclose(file);
    return status;
}

/* --- writing -------------------------------------------------------------------------------------------------------------- */

/* The directory and those above it, for this user alone where they are new. */
static MnsStatus make_directory(const char *directory, MnsError *error)
{
    char path[KEYS_PATH];
    snprintf(path, sizeof path, "%s", directory);
    for (char *slash = strchr(path + 1, '/'); slash; slash = strchr(slash + 1, '/')) {
        *slash = 0;
        if (mkdir(path, 0700) && errno != EEXIST) break; /* the last one will fail, and say why */
        *slash = '/';
    }
    if (!mkdir(directory, 0700) || errno == EEXIST) return MNS_OK;
    return mns_fail(error, MNS_E_IO, "cannot make the directory %s: %s; %s", directory, strerror(errno),
                    mns_refusal_hint(errno));
}

MnsStatus keys_lock(const char *directory, int *ret, MnsError *error)
{
    MnsStatus status = make_directory(directory, error);
    if (status) return status;
    const int lock = open(directory, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (lock >= 0 && !flock(lock, LOCK_EX)) {
        *ret = lock;
        return MNS_OK;
    }
    status = mns_fail(error, MNS_E_IO, "cannot lock the directory %s: %s; %s", directory, strerror(errno),
                      mns_refusal_hint(errno));
    if (lock >= 0) close(lock);
    return status;
}

void keys_unlock(int lock)
{
    close(lock);
}

/* On the disk; the errno of what failed, or 0. A disk that fills up takes a part, and says why when it is given the rest. */
static int write_all(int fd, const char *text, size_t size)
{
    for (size_t done = 0; done < size;) {
        const ssize_t got = write(fd, text + done, size - done);
        if (got < 0 && errno != EINTR) return errno;
        if (got > 0) done += (size_t)got;
    }
    return fsync(fd) ? errno : 0;
}

/* Write PATH.tmp and rename it, so that whoever reads it finds all of it or the one before. */
static MnsStatus replace(const char *path, const char *text, size_t size, MnsError *error)
{
    char temporary[KEYS_PATH + 32];
    snprintf(temporary, sizeof temporary, "%s.tmp", path);
    unlink(temporary); /* of a program that was killed */
    const int fd = open(temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    int cause = fd < 0 ? errno : write_all(fd, text, size);
    if (fd >= 0 && close(fd) && !cause) cause = errno;
    if (!cause && rename(temporary, path)) cause = errno;
    if (!cause) cause = disk_sync_above(path);
    if (!cause) return MNS_OK;
    unlink(temporary);
    return mns_fail(error, disk_status(cause), "cannot write %s: %s; %s", path, strerror(cause),
                    mns_refusal_hint(cause));
}

MnsStatus keys_write(const char *directory, const Keys *keys, MnsError *error)
{
    char path[KEYS_PATH + 16], *text;
    size_t size;
    snprintf(path, sizeof path, "%s/" KEYS_AUTHORIZED, directory);
    FILE *file = open_memstream(&text, &size);
    if (!file) return mns_fail(error, MNS_E_MEMORY, "no memory to write %s", path);
    fputs("# Who may talk to daemons from afar: name, role, public key. `meniscus keys` writes this file.\n", file);
    for (size_t k = 0; k < keys->n; k++)
        fprintf(file, "%s %s %s\n", keys->keys[k].name, role_name(keys->keys[k].role), keys->keys[k].public_key);
    const bool whole = !fclose(file);
    const MnsStatus status =
        whole ? replace(path, text, size, error) : mns_fail(error, MNS_E_MEMORY, "no memory to write %s", path);
    free(text);
    return status;
}

MnsStatus key_file_write(const char *path, const KeyPair *pair, MnsError *error)
{
    char text[512];
    int n = snprintf(text, sizeof text,
                     "# Who has this file may do what its key may: keep it to yourself.\n"
                     "public-key %s\nsecret-key %s\n",
                     pair->public_key, pair->secret_key);
    if (*pair->server_key) n += snprintf(text + n, sizeof text - (size_t)n, "server-key %s\n", pair->server_key);
    const MnsStatus status = replace(path, text, (size_t)n, error);
    explicit_bzero(text, sizeof text);
    return status;
}
