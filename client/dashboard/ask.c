/* SPDX-License-Identifier: BSD-3-Clause */
/* What a browser may say. */
#include "client/dashboard/ask.h"
#include "client/cli/options.h"
#include "common/case/find.h"
#include <math.h>
#include <string.h>

/* --- the entries ------------------------------------------------------------------------------------------------------- */

typedef enum EntryType { A_WHOLE, A_NUMBER, A_SWITCH, A_TEXT, A_TEXTS } EntryType;

/* Rows of the table. */
enum {
    ENTRY_ID,
    ENTRY_LEASE,
    ENTRY_COUNT,
    ENTRY_LIMIT,
    ENTRY_VERSION,
    ENTRY_TIME,
    ENTRY_SECONDS,
    ENTRY_WALLS,
    ENTRY_CHECKPOINT,
    ENTRY_START,
    ENTRY_FIELD,
    ENTRY_HOLDER,
    ENTRY_TOKEN,
    ENTRY_NAME,
    ENTRY_SETTINGS,
    ENTRY_AT_STEP,
    ENTRY_AT_TIME,
    ENTRY_REQUEST,
    ENTRIES
};

/* A set of entries has a bit for each. */
#define E(entry)  (1u << ENTRY_##entry)
#define E_COMMAND (E(ID) | E(LEASE))
#define E_LATER   (E(AT_STEP) | E(AT_TIME))
_Static_assert(ENTRIES <= 32, "a set of entries is an unsigned");

static const struct {
    const char *name;
    EntryType type;
    size_t offset;
} entries[ENTRIES] = {
    [ENTRY_ID] = {"id", A_WHOLE, offsetof(Ask, id)},
    [ENTRY_LEASE] = {"lease", A_WHOLE, offsetof(Ask, lease)},
    [ENTRY_COUNT] = {"count", A_WHOLE, offsetof(Ask, count)},
    [ENTRY_LIMIT] = {"limit", A_WHOLE, offsetof(Ask, limit)},
    [ENTRY_VERSION] = {"version", A_WHOLE, offsetof(Ask, version)},
    [ENTRY_TIME] = {"time", A_NUMBER, offsetof(Ask, time)},
    [ENTRY_SECONDS] = {"seconds", A_NUMBER, offsetof(Ask, seconds)},
    [ENTRY_WALLS] = {"walls", A_SWITCH, offsetof(Ask, walls)},
    [ENTRY_CHECKPOINT] = {"checkpoint", A_SWITCH, offsetof(Ask, checkpoint)},
    [ENTRY_START] = {"start", A_SWITCH, offsetof(Ask, start)},
    [ENTRY_FIELD] = {"field", A_TEXT, offsetof(Ask, field)},
    [ENTRY_HOLDER] = {"holder", A_TEXT, offsetof(Ask, holder)},
    [ENTRY_TOKEN] = {"token", A_TEXT, offsetof(Ask, token)},
    [ENTRY_NAME] = {"name", A_TEXT, offsetof(Ask, name)},
    [ENTRY_SETTINGS] = {"settings", A_TEXTS, offsetof(Ask, settings)},
    [ENTRY_AT_STEP] = {"at_step", A_WHOLE, offsetof(Ask, at_step)},
    [ENTRY_AT_TIME] = {"at_time", A_NUMBER, offsetof(Ask, at_time)},
    [ENTRY_REQUEST] = {"request", A_TEXT, offsetof(Ask, request)},
};

/* --- what is asked ----------------------------------------------------------------------------------------------------- */

static MnsStatus call_step(const Ask *ask, MnsClient *client, MnsReply **ret, MnsError *error)
{
    return mns_client_step(client, ask->count, ret, error);
}

static MnsStatus call_run_until(const Ask *ask, MnsClient *client, MnsReply **ret, MnsError *error)
{
    return mns_client_run_until(client, ask->time, true, ret, error);
}

static MnsStatus call_stop(const Ask *ask, MnsClient *client, MnsReply **ret, MnsError *error)
{
    return mns_client_stop(client, ask->checkpoint, ret, error);
}

static MnsStatus call_restore(const Ask *ask, MnsClient *client, MnsReply **ret, MnsError *error)
{
    return mns_client_restore(client, ask->name, ret, error);
}

static MnsStatus call_snapshot(const Ask *ask, MnsClient *client, MnsReply **ret, MnsError *error)
{
    (void)ask;
    return mns_client_snapshot(client, 0, NULL, ret, error);
}

/* The cases that are installed, by name: a browser has no business with other files of this machine. */
static MnsStatus call_load(const Ask *ask, MnsClient *client, MnsReply **ret, MnsError *error)
{
    char path[4096];
    if (strspn(ask->name, "abcdefghijklmnopqrstuvwxyz0123456789-_") != strlen(ask->name))
        return mns_fail_at(
            error, MNS_E_INVALID, "name",
            "a case is named by small letters, digits and hyphens here, as in dambreak2d; for a file of your "
            "own use `meniscus load FILE`");
    MnsStatus status = case_find(ask->name, path, error);
    const MnsLoad load = {
        .file = path, .name = ask->name, .n_sets = ask->n_settings, .sets = ask->settings, .resume = false};
    if (!status) status = mns_client_load(client, &load, ret, error);
    if (!status && ask->start) {
        mns_reply_free(*ret);
        *ret = NULL; /* nothing is written there if it is refused */
        status = mns_client_start(client, ret, error);
    }
    return status;
}

static MnsStatus call_set(const Ask *ask, MnsClient *client, MnsReply **ret, MnsError *error)
{
    return mns_client_set(client, ask->n_settings, ask->settings, ret, error);
}

static MnsStatus call_rollback(const Ask *ask, MnsClient *client, MnsReply **ret, MnsError *error)
{
    return mns_client_rollback(client, ask->version, ret, error);
}

static MnsStatus call_lease(const Ask *ask, MnsClient *client, MnsReply **ret, MnsError *error)
{
    return mns_client_lease(client, ask->seconds, ask->holder, ret, error);
}

static MnsStatus call_cancel(const Ask *ask, MnsClient *client, MnsReply **ret, MnsError *error)
{
    uint8_t id[MNS_REQUEST_ID_SIZE];
    const MnsStatus status = parse_id("request", ask->request, id, error);
    return status ? status : mns_client_cancel(client, id, ret, error);
}

/* plain: of commands that say nothing but their name; call: of the others. */
static const struct {
    const char *name;
    unsigned must, may;
    MnsStatus (*plain)(MnsClient *client, MnsReply **ret_reply, MnsError *error);
    MnsStatus (*call)(const Ask *ask, MnsClient *client, MnsReply **ret_reply, MnsError *error);
} asks[ASK_COUNT] = {
    [ASK_HELLO] = {"hello", 0, E(TOKEN), NULL, NULL},
    [ASK_SHOW] = {"show", E(FIELD) | E(LIMIT), E(WALLS), NULL, NULL},
    [ASK_DRAWN] = {"drawn", E(COUNT), 0, NULL, NULL},
    [ASK_HISTORY] = {"history", 0, 0, NULL, NULL},
    [ASK_JOURNAL] = {"journal", E(ID), 0, NULL, NULL},
    [ASK_START] = {"start", E(ID), E_COMMAND, mns_client_start, NULL},
    [ASK_PAUSE] = {"pause", E(ID), E_COMMAND | E_LATER, mns_client_pause, NULL},
    [ASK_RESUME] = {"resume", E(ID), E_COMMAND, mns_client_resume, NULL},
    [ASK_STEP] = {"step", E(ID) | E(COUNT), E_COMMAND, NULL, call_step},
    [ASK_RUN_UNTIL] = {"run_until", E(ID) | E(TIME), E_COMMAND, NULL, call_run_until},
    [ASK_STOP] = {"stop", E(ID), E_COMMAND | E(CHECKPOINT), NULL, call_stop},
    [ASK_RESET] = {"reset", E(ID), E_COMMAND, mns_client_reset, NULL},
    [ASK_RESTORE] = {"restore", E(ID), E_COMMAND | E(NAME), NULL, call_restore},
    [ASK_CHECKPOINT] = {"checkpoint", E(ID), E_COMMAND | E_LATER, mns_client_checkpoint, NULL},
    [ASK_SNAPSHOT] = {"snapshot", E(ID), E_COMMAND | E_LATER, NULL, call_snapshot},
    [ASK_LOAD] = {"load", E(ID) | E(NAME), E_COMMAND | E(SETTINGS) | E(START), NULL, call_load},
    [ASK_SET] = {"set", E(ID) | E(SETTINGS), E_COMMAND | E_LATER, NULL, call_set},
    [ASK_ROLLBACK] = {"rollback", E(ID) | E(VERSION), E_COMMAND, NULL, call_rollback},
    [ASK_LEASE] = {"lease", E(ID) | E(SECONDS) | E(HOLDER), E_COMMAND, NULL, call_lease},
    [ASK_RELEASE] = {"release", E(ID) | E(LEASE), E_COMMAND, mns_client_release, NULL},
    [ASK_CANCEL] = {"cancel", E(ID) | E(REQUEST), E_COMMAND, NULL, call_cancel},
};

MnsStatus ask_call(const Ask *ask, MnsClient *client, MnsReply **ret_reply, MnsError *error)
{
    /* What is scheduled may be hours away: the browser is answered when it is accepted. */
    if (ask->at_a_step) mns_client_set_at_step(client, ask->at_step);
    if (ask->at_a_time) mns_client_set_at_time(client, ask->at_time);
    if (ask->at_a_step || ask->at_a_time) mns_client_set_no_wait(client);
    if (asks[ask->kind].plain) return asks[ask->kind].plain(client, ret_reply, error);
    return asks[ask->kind].call(ask, client, ret_reply, error);
}

/* --- reading ----------------------------------------------------------------------------------------------------------- */

static MnsStatus wrong(const char *entry, const char *wanted, MnsError *error)
{
    return mns_fail_at(error, MNS_E_INVALID, entry, "\"%.60s\" takes %s", entry, wanted);
}

static MnsStatus take_texts(const json_t *value, Ask *ret, MnsError *error)
{
    const size_t n = json_array_size(value);
    if (!json_is_array(value) || !n || n > ASK_WORDS) return wrong("settings", "a list of 1 to 64 texts", error);
    for (size_t k = 0; k < n; k++) {
        ret->settings[k] = json_string_value(json_array_get(value, k));
        if (!ret->settings[k]) return wrong("settings", "a list of texts", error);
    }
    ret->n_settings = n;
    return MNS_OK;
}

static MnsStatus take(size_t k, const json_t *value, Ask *ret, MnsError *error)
{
    void *to = (char *)ret + entries[k].offset;
    switch (entries[k].type) {
    case A_WHOLE:
        if (!json_is_integer(value) || json_integer_value(value) < 0)
            return wrong(entries[k].name, "a whole number from 0 on", error);
        *(uint64_t *)to = (uint64_t)json_integer_value(value);
        return MNS_OK;
    case A_NUMBER:
        if (!json_is_number(value)) return wrong(entries[k].name, "a number", error);
        *(double *)to = json_number_value(value);
        return MNS_OK;
    case A_SWITCH:
        if (!json_is_boolean(value)) return wrong(entries[k].name, "true or false", error);
        *(bool *)to = json_is_true(value);
        return MNS_OK;
    case A_TEXT:
        if (!json_is_string(value)) return wrong(entries[k].name, "a text", error);
        *(const char **)to = json_string_value(value);
        return MNS_OK;
    default: return take_texts(value, ret, error);
    }
}

static MnsStatus take_all(json_t *object, Ask *ret, MnsError *error)
{
    const unsigned allowed = asks[ret->kind].must | asks[ret->kind].may;
    unsigned given = 0;
    const char *key;
    json_t *value;
    json_object_foreach(object, key, value)
    {
        size_t k = 0;
        while (k < ENTRIES && strcmp(entries[k].name, key) != 0) k++;
        if (!strcmp(key, "do")) continue;
        if (k == ENTRIES || !(allowed & 1u << k))
            return mns_fail_at(error, MNS_E_INVALID, key, "%s has no use for \"%.60s\"", asks[ret->kind].name, key);
        const MnsStatus status = take(k, value, ret, error);
        if (status) return status;
        given |= 1u << k;
    }
    ret->at_a_step = given & E(AT_STEP);
    ret->at_a_time = given & E(AT_TIME);
    for (size_t k = 0; k < ENTRIES; k++)
        if (asks[ret->kind].must & ~given & 1u << k)
            return mns_fail_at(error, MNS_E_INVALID, entries[k].name, "%s needs \"%s\"", asks[ret->kind].name,
                               entries[k].name);
    return MNS_OK;
}

MnsStatus ask_parse(const char *text, size_t size, Ask *ret, MnsError *error)
{
    json_error_t why;
    json_t *object = size <= ASK_BYTES ? json_loadb(text, size, JSON_REJECT_DUPLICATES, &why) : NULL;
    *ret = (Ask){0};
    if (!object) return mns_fail(error, MNS_E_INVALID, "a message is one JSON object of at most %d bytes", ASK_BYTES);
    const char *what = json_string_value(json_object_get(object, "do"));
    Ask ask = {.json = object, .kind = ASK_HELLO};
    while (what && ask.kind < ASK_COUNT && strcmp(asks[ask.kind].name, what) != 0) ask.kind++;
    /* An id comes back in the refusal too. */
    ask.id = (uint64_t)json_integer_value(json_object_get(object, "id"));
    MnsStatus status = MNS_OK;
    if (!what || ask.kind == ASK_COUNT)
        status =
            mns_fail_at(error, MNS_E_INVALID, "do", "\"%.60s\" is nothing that can be done here", what ? what : "");
    else status = take_all(object, &ask, error);
    *ret = ask;
    if (status) {
        ask_done(ret);
        ret->id = ask.id;
    }
    return status;
}

void ask_done(Ask *ask)
{
    json_decref(ask->json);
    *ask = (Ask){0};
}
