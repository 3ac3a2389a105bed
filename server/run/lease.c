/* SPDX-License-Identifier: BSD-3-Clause */
#include "run/lease.h"
#include "common/host/text.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

bool lease_live(const Lease *lease, double now)
{
    return lease->epoch && now < lease->until;
}

static MnsStatus held(const Lease *lease, double now, MnsError *error)
{
    return mns_fail_at(error, MNS_E_HELD, "lease_epoch", "%s holds the lease for another %.1f s; nothing was done",
                       lease->holder, lease->until - now);
}

MnsStatus lease_admits(const Lease *lease, uint64_t epoch, double now, MnsError *error)
{
    const bool live = lease_live(lease, now);
    if (live && !epoch) return held(lease, now, error);
    if (!epoch || (live && epoch == lease->epoch)) return MNS_OK;
    return mns_fail_at(error, MNS_E_EXPIRED, "lease_epoch",
                       "the lease of epoch %" PRIu64 " is over%s%s; nothing was done. Take a new one", epoch,
                       live ? ", and the present one is held by " : "", live ? lease->holder : "");
}

static MnsStatus check_wish(const LeaseWish *wish, MnsError *error)
{
    const size_t length = wish->holder ? strlen(wish->holder) : 0;
    if (wish->release) return MNS_OK;
    if (wish->ttl_ms < LEASE_MS_MIN || wish->ttl_ms > LEASE_MS_MAX)
        return mns_fail_at(error, MNS_E_INVALID, "ttl_ms",
                           "a lease lives from %d to %d ms, and can be renewed; found %" PRIu64, LEASE_MS_MIN,
                           LEASE_MS_MAX, wish->ttl_ms);
    if (!wish->epoch && (!length || length >= LEASE_HOLDER))
        return mns_fail_at(error, MNS_E_INVALID, "holder",
                           "a lease needs a name that others are told, of 1 to %d bytes; found %zu", LEASE_HOLDER - 1,
                           length);
    return wish->epoch ? MNS_OK : text_name_check(wish->holder, "holder", error);
}

MnsStatus lease_take(Lease *lease, const LeaseWish *wish, uint64_t least, double now, MnsError *error)
{
    MnsStatus status = check_wish(wish, error);
    if (!status) status = lease_admits(lease, wish->epoch, now, error);
    if (status) return status;
    if (wish->release) {
        if (!wish->epoch)
            return mns_fail_at(error, MNS_E_INVALID, "lease_epoch", "which lease is to end? Give its epoch");
        lease->until = now;
        return MNS_OK;
    }
    if (!wish->epoch) {
        lease->epoch = lease->epoch + 1 > least ? lease->epoch + 1 : least;
        snprintf(lease->holder, sizeof lease->holder, "%s", wish->holder);
    }
    lease->ttl_ms = (uint32_t)wish->ttl_ms;
    lease->until = now + 1e-3 * (double)wish->ttl_ms;
    return MNS_OK;
}
