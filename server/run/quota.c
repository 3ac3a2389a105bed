/* SPDX-License-Identifier: BSD-3-Clause */
/* The table of quotas. proto/README.md has the same numbers, and a test compares them. */
#include "run/quota.h"

#include <stdint.h>
#include <string.h>

typedef struct Share {
    size_t each, all;
} Share;

static const size_t NO_BOUND = SIZE_MAX; /* here: descriptors bound connections of this machine */

/* clang-format off */
static const struct {
    const char *what, *advice;
    Share of[POOLS];
} quotas[QUOTAS] = {
    /*                                                                                                     viewers        operators, admins  local                  */
    [QUOTA_CONTROL]   = {"connections for commands",      "close one",                                   {{  64,  375 },  {  64,  500 },  { NO_BOUND, NO_BOUND }}},
    [QUOTA_TELEMETRY] = {"connections for telemetry",     "close one",                                   {{ 256, 1024 },  { 256, 1024 },  { NO_BOUND, NO_BOUND }}},
    [QUOTA_DATA]      = {"connections for streams",       "close one",                                   {{  32,  192 },  {  32,  256 },  { NO_BOUND, NO_BOUND }}},
    [QUOTA_STREAMS]   = {"streams",                       "end one, or ask again later",                 {{ 256, 1024 },  { 512, 1024 },  {     4096,     4096 }}},
    [QUOTA_WAITS]     = {"waits",                         "ask again later",                             {{ 128,  512 },  { 256,  512 },  {     1024,     1024 }}},
    [QUOTA_COMMANDS]  = {"commands waiting",              "wait for an answer, then send it again",      {{  64,  256 },  { 256, 1024 },  {     2048,     2048 }}},
    [QUOTA_QUESTIONS] = {"questions waiting",             "wait for an answer, then send it again",      {{  64,  256 },  { 128,  256 },  {     1024,     1024 }}},
    [QUOTA_SCHEDULED] = {"commands scheduled",            "cancel one, or wait until one is done",       {{   0,    0 },  {  32,   48 },  {       64,       64 }}},
};
/* clang-format on */

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
