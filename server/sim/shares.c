/* SPDX-License-Identifier: BSD-3-Clause */
/* Both ends of a part in one word, so that they are taken from without a lock. */
#include "sim/shares.h"

#include <assert.h>
#include <stdatomic.h>

static uint64_t pack(size_t front, size_t back)
{
    return (uint64_t)front | (uint64_t)back << 32;
}

static uint64_t front_of(uint64_t left)
{
    return left & UINT32_MAX;
}

static uint64_t count(uint64_t left)
{
    return (left >> 32) - front_of(left);
}

void shares_init(Shares *shares, size_t n, int threads)
{
    assert(n <= UINT32_MAX);
    shares->n = threads < SHARES_MAX ? threads : SHARES_MAX;
    for (int k = 0; k < shares->n; k++) {
        const size_t parts = (size_t)shares->n, part = (size_t)k;
        atomic_init(&shares->of[k].left, pack(n * part / parts, n * (part + 1) / parts));
    }
}

static bool take_front(Share *share, size_t *ret)
{
    uint64_t left = atomic_load_explicit(&share->left, memory_order_relaxed);
    while (count(left)) {
        if (!atomic_compare_exchange_weak_explicit(&share->left, &left, left + 1, memory_order_relaxed,
                                                   memory_order_relaxed))
            continue;
        *ret = front_of(left);
        return true;
    }
    return false;
}

static bool take_back(Share *share, size_t *ret)
{
    uint64_t left = atomic_load_explicit(&share->left, memory_order_relaxed);
    while (count(left)) {
        const size_t back = (size_t)(left >> 32) - 1;
        if (!atomic_compare_exchange_weak_explicit(&share->left, &left, pack(front_of(left), back),
                                                   memory_order_relaxed, memory_order_relaxed))
            continue;
        *ret = back;
        return true;
    }
    return false;
}

static Share *fullest(Shares *shares)
{
    Share *found = NULL;
    uint64_t most = 0;
    for (int k = 0; k < shares->n; k++) {
        const uint64_t n = count(atomic_load_explicit(&shares->of[k].left, memory_order_relaxed));
        if (n <= most) continue;
        most = n;
        found = &shares->of[k];
    }
    return found;
}

bool shares_take(Shares *shares, int thread, size_t *ret)
{
    if (take_front(&shares->of[thread % shares->n], ret)) return true;
    for (Share *other; (other = fullest(shares));)
        if (take_back(other, ret)) return true;
    return false;
}
