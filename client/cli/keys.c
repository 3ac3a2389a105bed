/* SPDX-License-Identifier: BSD-3-Clause */
/* meniscus keys: who is let in from afar. It changes files, which daemons look at by themselves. */
#include "common/wire/keys.h"
#include "client/cli/command.h"
#include "client/cli/output.h"
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

_Static_assert((int)MNS_KEY_SIZE == (int)KEY_TEXT, "keys are as long here as there");

/* A directory of keys, nobody else's while we are at it. */
typedef struct Ring {
    char directory[KEYS_PATH];
    int lock;
    Keys keys;
} Ring;

/* To look, no lock is needed, as files are replaced whole. */
static MnsStatus ring_open(Invocation *in, bool to_change, Ring *ring, MnsError *error)
{
    const char *given = options_get(&in->options, OPT_KEYS);
    MnsStatus status = MNS_OK;
    *ring = (Ring){.lock = -1};
    if (!given) status = command_usage(in, keys_directory(ring->directory, error));
    else if (!*given || strlen(given) >= KEYS_PATH - KEY_NAME_SIZE - 16)
        status =
            command_usage(in, mns_fail(error, MNS_E_INVALID, "--keys must name a directory; found \"%.80s\"", given));
    else memcpy(ring->directory, given, strlen(given) + 1);
    if (!status && to_change) status = keys_lock(ring->directory, &ring->lock, error);
    return status ? status : keys_read(ring->directory, &ring->keys, error);
}

static void ring_close(Ring *ring)
{
    keys_done(&ring->keys);
    if (ring->lock >= 0) keys_unlock(ring->lock);
}

/* The daemon's own pair, made when it is first asked for. */
static MnsStatus server_key(const Ring *ring, char ret[KEY_TEXT], MnsError *error)
{
    char path[KEYS_PATH];
    KeyPair own;
    key_path(ring->directory, KEYS_DAEMON, path);
    MnsStatus status = key_file_read(path, &own, error);
    if (status == MNS_E_NOT_FOUND) {
        own = (KeyPair){.server_key = ""};
        status = mns_key_pair(own.public_key, own.secret_key, error);
        if (!status) status = key_file_write(path, &own, error);
    }
    if (!status) memcpy(ret, own.public_key, KEY_TEXT);
    explicit_bzero(&own, sizeof own);
    return status;
}

/* The secret first: a key of which nobody has the secret lets nobody in. */
static MnsStatus add(Ring *ring, const char *name, Role role, KeyPair *pair, char path[KEYS_PATH], MnsError *error)
{
    Key *keys = reallocarray(ring->keys.keys, ring->keys.n + 1, sizeof *keys);
    if (!keys) return mns_fail(error, MNS_E_MEMORY, "no memory for one more key");
    ring->keys.keys = keys;
    MnsStatus status = mns_key_pair(pair->public_key, pair->secret_key, error);
    if (!status) status = server_key(ring, pair->server_key, error);
    key_path(ring->directory, name, path);
    if (!status) status = key_file_write(path, pair, error);
    if (status) return status;
    Key *key = &keys[ring->keys.n++];
    *key = (Key){.role = role};
    memcpy(key->name, name, strlen(name));
    memcpy(key->public_key, pair->public_key, KEY_TEXT);
    status = keys_write(ring->directory, &ring->keys, error);
    if (status) unlink(path);
    return status;
}

static MnsStatus check_new(Invocation *in, const char *name, Role *ret, MnsError *error)
{
    const char *role = options_get(&in->options, OPT_ROLE);
    *ret = role ? role_find(role) : ROLE_NONE;
    if (*ret == ROLE_NONE)
        return command_usage(in, mns_fail(error, MNS_E_INVALID, "--role must be %s: viewer, operator or admin%s%.40s%s",
                                          role ? "one of these" : "given", role ? "; found \"" : "", role ? role : "",
                                          role ? "\"" : ""));
    return command_usage(in, key_name_check(name, error));
}

static MnsStatus new_key(Invocation *in, Ring *ring, const char *name, MnsError *error)
{
    Role role;
    KeyPair pair = {.public_key = ""};
    char path[KEYS_PATH];
    MnsStatus status = check_new(in, name, &role, error);
    if (!status && keys_named(&ring->keys, name))
        status =
            mns_fail(error, MNS_E_STATE, "there is a key \"%s\" already; take another name, or remove it first", name);
    if (!status && ring->keys.n == KEYS_MAX)
        status = mns_fail(error, MNS_E_LIMIT, "there are %d keys, and no room for more", KEYS_MAX);
    if (!status) status = add(ring, name, role, &pair, path, error);
    explicit_bzero(pair.secret_key, sizeof pair.secret_key);
    if (status) return status;
    if (in->json)
        return output_json(json_pack("{ss ss ss ss so}", "name", name, "role", role_name(role), "public_key",
                                     pair.public_key, "server_key", pair.server_key, "file", output_text(path)),
                           error);
    printf("%s is %s. Its secret is in\n    %s\nGive that file to %s and nobody else; there: meniscus --key %s.key "
           "--daemon "
           "tcp://HOST:PORT status\n",
           name, role_name(role), path, name, name);
    return MNS_OK;
}

static MnsStatus list_keys(const Invocation *in, const Ring *ring, MnsError *error)
{
    char path[KEYS_PATH];
    KeyPair own = {.public_key = ""};
    key_path(ring->directory, KEYS_DAEMON, path);
    const MnsStatus status = key_file_read(path, &own, error);
    explicit_bzero(own.secret_key, sizeof own.secret_key);
    if (status && status != MNS_E_NOT_FOUND) return status;
    json_t *list = json_array();
    for (size_t k = 0; k < ring->keys.n; k++) {
        const Key *key = &ring->keys.keys[k];
        if (!in->json) printf("%-20s %-9s %s\n", key->name, role_name(key->role), key->public_key);
        json_array_append_new(list, json_pack("{ss ss ss}", "name", key->name, "role", role_name(key->role),
                                              "public_key", key->public_key));
    }
    if (in->json)
        return output_json(json_pack("{so ss? so}", "directory", output_text(ring->directory), "server_key",
                                     *own.public_key ? own.public_key : NULL, "keys", list),
                           error);
    if (*own.public_key) printf("%-20s %-9s %s\n", KEYS_DAEMON, "", own.public_key);
    else printf("no keys in %s\n", ring->directory);
    json_decref(list);
    return MNS_OK;
}

static MnsStatus remove_key(const Invocation *in, Ring *ring, const char *name, MnsError *error)
{
    char path[KEYS_PATH];
    const Key *found = keys_named(&ring->keys, name);
    if (!found) return mns_fail(error, MNS_E_NOT_FOUND, "there is no key \"%.80s\" in %s", name, ring->directory);
    const size_t k = (size_t)(found - ring->keys.keys), n = --ring->keys.n;
    memmove(ring->keys.keys + k, ring->keys.keys + k + 1, (n - k) * sizeof *found);
    const MnsStatus status = keys_write(ring->directory, &ring->keys, error);
    if (status) return status;
    key_path(ring->directory, name, path);
    if (unlink(path) && errno != ENOENT)
        return mns_fail(error, MNS_E_IO, "cannot remove %s: %s; %s", path, strerror(errno), mns_refusal_hint(errno));
    if (in->json) return output_json(json_pack("{ss}", "name", name), error);
    printf("%s is let in no more\n", name);
    return MNS_OK;
}

MnsStatus command_keys(Invocation *in, MnsError *error)
{
    const char *const *words = in->options.words;
    const bool is_list = strcmp(words[0], "list") == 0, is_new = strcmp(words[0], "new") == 0;
    if (!is_list && !is_new && strcmp(words[0], "remove") != 0)
        return command_usage(in, mns_fail(error, MNS_E_INVALID,
                                          "keys new NAME, keys list or keys remove NAME; found \"%.80s\"", words[0]));
    if ((in->options.n_words == 1) != is_list)
        return command_usage(
            in, mns_fail(error, MNS_E_INVALID, "keys %s %s", words[0], is_list ? "takes no name" : "needs a name"));
    Ring ring;
    MnsStatus status = ring_open(in, !is_list, &ring, error);
    if (!status && is_list) status = list_keys(in, &ring, error);
    else if (!status) status = is_new ? new_key(in, &ring, words[1], error) : remove_key(in, &ring, words[1], error);
    ring_close(&ring);
    return status;
}
