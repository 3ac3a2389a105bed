/* SPDX-License-Identifier: BSD-3-Clause */
/* Keys on the disk: who may talk to the daemons of a user from afar, as what. They are in one directory:
 *   authorized    a line for each key: name, role, public key; no secrets
 *   daemon.key    the daemon's own pair
 *   NAME.key      the pair of NAME with the daemon's public key, to be given to NAME: see key_file_read()
 * Each file belongs to the user alone, mode 0600, and the directory can be changed by nobody else, or is refused. All are written
 * anew and renamed, under a lock of the directory. */
#ifndef COMMON_WIRE_KEYS_H
#define COMMON_WIRE_KEYS_H

#include "common/wire/role.h"
#include <meniscus/status.h>
#include <stdbool.h>
#include <stddef.h>

enum { KEY_TEXT = 41, KEY_NAME_SIZE = 64, KEYS_PATH = 1024, KEYS_MAX = 4096 };

#define KEYS_AUTHORIZED "authorized"
#define KEYS_DAEMON     "daemon" /* of daemon.key */

/* Who is at work without a key: names that no key has. */
#define WHO_LOCAL  "local"  /* whoever can open the sockets of this machine */
#define WHO_DAEMON "daemon" /* its command line, signals, and what it comes back to */
#define WHO_BATCH  "batch"  /* the same without a daemon */

/* A key that is let in. Keys are 40 letters of Z85, as ZeroMQ writes them. */
typedef struct Key {
    char name[KEY_NAME_SIZE];
    Role role;
    char public_key[KEY_TEXT];
} Key;

typedef struct Keys {
    size_t n;
    Key *keys; /* [n] */
} Keys;

/* What a secret file holds. */
typedef struct KeyPair {
    char public_key[KEY_TEXT], secret_key[KEY_TEXT];
    char server_key[KEY_TEXT]; /* public, of the daemon; empty in daemon.key */
} KeyPair;

/* Where they are if nobody says: $MENISCUS_KEYS, $XDG_CONFIG_HOME/meniscus/keys or $HOME/.config/meniscus/keys.
 * MNS_E_INVALID: none of them is set, or the path is too long. */
MnsStatus keys_directory(char ret[static KEYS_PATH], MnsError *error);

/* Could it be a key? */
bool key_is_valid(const char *text);

/* Letters, digits, dots, dashes and underscores, at most 63, and no name that stands for somebody else: MNS_E_INVALID. */
MnsStatus key_name_check(const char *name, MnsError *error);

/* --- who is let in ------------------------------------------------------------------------------------------------------ */

/* Read DIRECTORY/authorized; keys_done() later. None if there is no such file. MNS_E_INVALID with file and line; MNS_E_STATE if
 * others than the user could read or change it; MNS_E_IO, MNS_E_MEMORY. */
MnsStatus keys_read(const char *directory, Keys *ret, MnsError *error);
void keys_done(Keys *keys);

/* NULL if there is none. */
const Key *keys_find(const Keys *keys, const char *public_key);
const Key *keys_named(const Keys *keys, const char *name);

/* --- changes -------------------------------------------------------------------------------------------------------------- */

/* Make the directory if need be, for this user alone, and keep others from changing what is in it until keys_unlock(*ret).
 * MNS_E_IO. */
MnsStatus keys_lock(const char *directory, int *ret, MnsError *error);
void keys_unlock(int lock);

/* Write DIRECTORY/authorized. */
MnsStatus keys_write(const char *directory, const Keys *keys, MnsError *error);

/* --- secret files --------------------------------------------------------------------------------------------------------- */

/* DIRECTORY/NAME.key */
void key_path(const char *directory, const char *name, char ret[static KEYS_PATH]);

/* MNS_E_NOT_FOUND, MNS_E_INVALID, MNS_E_STATE if others could read it, MNS_E_IO. */
MnsStatus key_file_read(const char *path, KeyPair *ret, MnsError *error);
/* That nobody else has access to it, where there is one; the same otherwise. */
MnsStatus key_file_check(const char *path, MnsError *error);
MnsStatus key_file_write(const char *path, const KeyPair *pair, MnsError *error);

#endif
