/* SPDX-License-Identifier: BSD-3-Clause */
/* The books of one stream. */
#include "net/subscription.h"

void subscription_begin(Subscription *s, size_t chunk, uint64_t credit, uint64_t taken)
{
    *s = (Subscription){.chunk = chunk, .taken = taken, .counted = taken};
    subscription_grant(s, credit);
}

void subscription_grant(Subscription *s, uint64_t bytes)
{
    const uint64_t room = CREDIT_MOST - s->credit;
    s->credit += bytes < room ? bytes : room;
}

bool subscription_wants(const Subscription *s, uint64_t number)
{
    return !s->under_way && number > s->taken;
}

uint64_t subscription_take(Subscription *s, uint64_t number, uint64_t size)
{
    const uint64_t skipped = number ? number - s->taken - 1 : 0;
    s->before = s->taken;
    if (number) s->taken = number;
    s->sequence += 1 + skipped;
    s->offset = 0;
    s->size = size;
    s->under_way = true;
    s->opened = false;
    return skipped;
}

void subscription_put_back(Subscription *s, uint64_t skipped)
{
    s->taken = s->before;
    s->sequence -= 1 + skipped;
    s->under_way = false;
}

uint64_t subscription_skips(Subscription *s, uint64_t newest, uint64_t due)
{
    const uint64_t known = s->taken > s->counted ? s->taken : s->counted;
    const uint64_t lost = (newest > s->taken ? newest : due) - 1;
    if (!due || lost <= known) return 0;
    s->counted = lost;
    return lost - known;
}

size_t subscription_next(const Subscription *s)
{
    const uint64_t left = s->size - s->offset;
    return left < s->chunk ? (size_t)left : s->chunk;
}

bool subscription_pay(Subscription *s, size_t cost)
{
    if (cost > s->credit) return false;
    s->credit -= cost;
    return true;
}

bool subscription_sent(Subscription *s, size_t n)
{
    s->offset += n;
    s->opened = true;
    s->under_way = s->offset < s->size;
    return !s->under_way;
}

bool subscription_cancel(Subscription *s, uint64_t sequence)
{
    if (!s->under_way || (sequence && sequence != s->sequence)) return false;
    s->under_way = false;
    return true;
}

bool subscription_resume(Subscription *s, uint64_t sequence, uint64_t offset)
{
    if (!s->sequence || sequence != s->sequence || offset > s->offset) return false;
    s->offset = offset;
    s->opened = offset > 0;
    s->under_way = offset < s->size || (!s->size && !offset);
    return true;
}
