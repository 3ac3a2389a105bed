/* SPDX-License-Identifier: BSD-3-Clause */
/* The table of quotas, as they are unless the command line says otherwise. proto/README.md has the same numbers, and a test compares them. */
#include "run/quota.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

typedef struct Share {
    size_t each, all;
} Share;

static const size_t NO_BOUND = SIZE_MAX; /* here: descriptors bound connections of this machine */

/* clang-format off */
static struct {
    const char *name, *what, *advice;
    Share of[POOLS];
} quotas[QUOTAS] = {
    /*                                                                                                     viewers        operators, admins  local                  */
    [QUOTA_CONTROL]   = {"control", "connections for commands",      "close one",                                   {{  64,  375 },  {  64,  500 },  { NO_BOUND, NO_BOUND }}},
    [QUOTA_TELEMETRY] = {"telemetry", "connections for telemetry",     "close one",                                   {{ 256, 1024 },  { 256, 1024 },  { NO_BOUND, NO_BOUND }}},
    [QUOTA_DATA]      = {"data", "connections for streams",       "close one",                                   {{  32,  192 },  {  32,  256 },  { NO_BOUND, NO_BOUND }}},
    [QUOTA_STREAMS]   = {"streams", "streams",                       "end one, or ask again later",                 {{ 256, 1024 },  { 512, 1024 },  {     4096,     4096 }}},
    [QUOTA_WAITS]     = {"waits", "waits",                         "ask again later",                             {{ 128,  512 },  { 256,  512 },  {     1024,     1024 }}},
    [QUOTA_COMMANDS]  = {"commands", "commands waiting",              "wait for an answer, then send it again",      {{  64,  256 },  { 256, 1024 },  {     2048,     2048 }}},
    [QUOTA_QUESTIONS] = {"questions", "questions waiting",             "wait for an answer, then send it again",      {{  64,  256 },  { 128,  256 },  {     1024,     1024 }}},
    [QUOTA_UNREAD]    = {"unread", "MiB of replies that are not read", "read them, or wait",                     {{  32,   64 },  {  32,   64 },  {      128,      128 }}},
    [QUOTA_SCHEDULED] = {"scheduled", "commands scheduled",            "cancel one, or wait until one is done",       {{   0,    0 },  {  32,   48 },  {       64,       64 }}},
};
/* clang-format on */

static Quota find(const char *name, size_t size)
{
    Quota quota = 0;
    while (quota < QUOTAS && (strlen(quotas[quota].name) != size || strncmp(quotas[quota].name, name, size) != 0))
        quota++;
    return quota;
}

static MnsStatus fail_unknown(const char *text, MnsError *error)
{
    char names[160] = "";
    for (Quota quota = 0; quota < QUOTAS; quota++) {
        strcat(names, quota ? ", " : "");
        strcat(names, quotas[quota].name);
    }
    return mns_fail(
        error, MNS_E_INVALID,
        "a quota is NAME=VIEWER or NAME=VIEWER,OPERATOR, as in streams=64,128; found \"%.80s\"; the names are "
        "%s",
        text, names);
}

/* True if there is a number, which *at is behind then. */
static bool read_number(const char **at, size_t *ret)
{
    char *end;
    if (**at < '0' || **at > '9') return false;
    *ret = strtoul(*at, &end, 10);
    *at = end;
    return true;
}

MnsStatus quota_set(const char *text, MnsError *error)
{
    const char *at = strchr(text, '=');
    const Quota quota = at ? find(text, (size_t)(at - text)) : QUOTAS;
    if (quota == QUOTAS) return fail_unknown(text, error);
    size_t each[POOL_LOCAL] = {[POOL_STEERERS] = quotas[quota].of[POOL_STEERERS].each};
    at++;
    bool good = read_number(&at, &each[POOL_VIEWERS]);
    if (good && *at == ',') {
        at++;
        good = read_number(&at, &each[POOL_STEERERS]);
    }
    if (!good || *at) return fail_unknown(text, error);
    for (QuotaPool pool = 0; pool < POOL_LOCAL; pool++)
        if (each[pool] > quotas[quota].of[pool].all)
            return mns_fail(error, MNS_E_INVALID, "%s have %zu %s together, so each key has 0 to %zu; found \"%.80s\"",
                            pool == POOL_VIEWERS ? "viewers" : "operators and admins", quotas[quota].of[pool].all,
                            quotas[quota].what, quotas[quota].of[pool].all, text);
    for (QuotaPool pool = 0; pool < POOL_LOCAL; pool++) quotas[quota].of[pool].each = each[pool];
    return MNS_OK;
}

static bool is_local(const Who *who)
{
    return !who->name[0] || !strcmp(who->name, WHO_LOCAL) || !strcmp(who->name, WHO_DAEMON) ||
           !strcmp(who->name, WHO_BATCH);
}

QuotaPool quota_pool(const Who *who)
{
    if (is_local(who)) return POOL_LOCAL;
    return who->role > ROLE_VIEWER ? POOL_STEERERS : POOL_VIEWERS;
}

bool quota_same(const Who *a, const Who *b)
{
    return (is_local(a) && is_local(b)) || !strcmp(a->name, b->name);
}

size_t quota_each(Quota quota, QuotaPool pool)
{
    return quotas[quota].of[pool].each;
}

size_t quota_all(Quota quota, QuotaPool pool)
{
    return quotas[quota].of[pool].all;
}

void quota_count(QuotaUse *use, const Who *who, const Who *holder)
{
    use->own += quota_same(who, holder);
    use->pool += quota_pool(who) == quota_pool(holder);
}

static const char *const pools[POOLS] = {"viewers have", "operators and admins have",
                                         "the clients on this machine have"};

MnsStatus quota_check(Quota quota, const Who *who, const QuotaUse *use, MnsError *error)
{
    const QuotaPool pool = quota_pool(who);
    const Share *share = &quotas[quota].of[pool];
    if (use->own < share->each && use->pool < share->all) return MNS_OK;
    if (pool != POOL_LOCAL && use->own >= share->each)
        return mns_fail(error, MNS_E_LIMIT, "the key \"%s\" has %zu %s, and one key has no more; %s", who->name,
                        use->own, quotas[quota].what, quotas[quota].advice);
    return mns_fail(error, MNS_E_LIMIT, "%s %zu %s, and together no more; %s", pools[pool], use->pool,
                    quotas[quota].what, quotas[quota].advice);
}
