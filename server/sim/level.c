/* SPDX-License-Identifier: BSD-3-Clause */
#include "sim/level.h"
#include <string.h>

static const char *const NAMES[] = {
#if HAS_LEVELS
    [LEVEL_BASE] = "x86-64",
    [LEVEL_V3] = "x86-64-v3",
    [LEVEL_V4] = "x86-64-v4",
#elif defined __aarch64__
    [LEVEL_BASE] = "aarch64",
#else
    [LEVEL_BASE] = "base", /* for one machine */
#endif
};

static _Atomic int forced = -1; /* set where runs are made, and asked by whoever tells of them */

static Level best(void)
{
#if HAS_LEVELS
    /* Of v3 those that machines came with, and that clang 14 knows the names of; the others came with them. */
    if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma") || !__builtin_cpu_supports("bmi") ||
        !__builtin_cpu_supports("bmi2"))
        return LEVEL_BASE;
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512cd") &&
        __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
        return LEVEL_V4;
    return LEVEL_V3;
#else
    return LEVEL_BASE;
#endif
}

Level level_in_use(void)
{
    const int level = forced;
    return level < 0 ? best() : (Level)level;
}

const char *level_name(Level level)
{
    return NAMES[level];
}

const char *level_arithmetic(Level level)
{
    return level > LEVEL_BASE || BASE_FUSES ? "fused" : "separate";
}

const char *mns_level(void)
{
    return level_name(level_in_use());
}

const char *mns_arithmetic(void)
{
    return level_arithmetic(level_in_use());
}

MnsStatus mns_level_force(const char *name, MnsError *error)
{
    for (int k = 0; k < LEVELS; k++) {
        if (strcmp(name, NAMES[k]) != 0) continue;
        if (k > (int)best())
            return mns_fail(error, MNS_E_INVALID, "this machine has not the instructions of %s: %s is its best", name,
                            NAMES[best()]);
        forced = k;
        return MNS_OK;
    }
    return mns_fail(error, MNS_E_INVALID, "there is no level \"%s\"; this machine's best is %s", name, NAMES[best()]);
}
