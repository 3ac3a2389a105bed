/* SPDX-License-Identifier: BSD-3-Clause */
/* Requests as they come off the wire. A few bytes can ask for much memory, so it is counted while they are unpacked. */
#include "proto/frame.h"

#include <stdlib.h>

typedef struct Budget {
    size_t left;
    int exceeded;
} Budget;

static void *take(void *arg, size_t size)
{
    Budget *budget = arg;
    if (size > budget->left) budget->exceeded = 1;
    if (budget->exceeded) return NULL;
    budget->left -= size;
    return malloc(size);
}

static void give_back(void *arg, void *memory)
{
    (void)arg;
    free(memory);
}

/* Is it one we can answer? */
static MnsStatus check(const Meniscus__Request *request, MnsError *error)
{
    if (!request->has_major || request->major != FRAME_MAJOR)
        return mns_fail_at(error, MNS_E_VERSION, "major",
                           "this daemon speaks version %d of the protocol, the request says %u%s", FRAME_MAJOR,
                           request->major, request->has_major ? "" : " (nothing)");
    if (!request->has_id || request->id.len != FRAME_ID)
        return mns_fail_at(error, MNS_E_INVALID, "id", "a request needs an id of %d bytes; this one has %zu", FRAME_ID,
                           request->has_id ? request->id.len : 0);
    if (request->command_case == MENISCUS__REQUEST__COMMAND__NOT_SET)
        return mns_fail_at(error, MNS_E_VERSION, "command", "the request has no command that this daemon knows");
    return MNS_OK;
}

MnsStatus request_read(const void *data, size_t size, Meniscus__Request **ret, MnsError *error)
{
    Budget budget = {.left = FRAME_MEMORY};
    ProtobufCAllocator allocator = {.alloc = take, .free = give_back, .allocator_data = &budget};
    *ret = NULL;
    if (size > FRAME_MAX)
        return mns_fail(error, MNS_E_LIMIT, "a request may have %d bytes, this one has %zu", FRAME_MAX, size);
    *ret = meniscus__request__unpack(&allocator, size, data);
    if (*ret) return check(*ret, error);
    if (budget.exceeded)
        return mns_fail(error, MNS_E_LIMIT, "the request takes more than %d bytes of memory", FRAME_MEMORY);
    return mns_fail(error, MNS_E_INVALID, "these %zu bytes are no request of this protocol", size);
}

void request_free(Meniscus__Request *request)
{
    if (request) meniscus__request__free_unpacked(request, NULL);
}

Meniscus__Code code_of(MnsStatus status)
{
    static const Meniscus__Code codes[] = {
        [MNS_OK] = MENISCUS__CODE__OK,
        [MNS_E_INVALID] = MENISCUS__CODE__INVALID_ARGUMENT,
        [MNS_E_NOT_FOUND] = MENISCUS__CODE__NOT_FOUND,
        [MNS_E_STATE] = MENISCUS__CODE__FAILED_PRECONDITION,
        [MNS_E_LIMIT] = MENISCUS__CODE__RESOURCE_EXHAUSTED,
        [MNS_E_MEMORY] = MENISCUS__CODE__RESOURCE_EXHAUSTED,
        [MNS_E_DIVERGED] = MENISCUS__CODE__ABORTED,
        [MNS_E_IO] = MENISCUS__CODE__INTERNAL,
        [MNS_E_NO_SPACE] = MENISCUS__CODE__RESOURCE_EXHAUSTED,
        [MNS_E_CORRUPT] = MENISCUS__CODE__DATA_LOSS,
        [MNS_E_VERSION] = MENISCUS__CODE__UNIMPLEMENTED,
        [MNS_E_UNAVAILABLE] = MENISCUS__CODE__UNAVAILABLE,
        [MNS_E_TIMEOUT] = MENISCUS__CODE__DEADLINE_EXCEEDED,
        [MNS_E_INTERRUPTED] = MENISCUS__CODE__ABORTED,
        [MNS_E_INTERNAL] = MENISCUS__CODE__INTERNAL,
    };
    const unsigned k = (unsigned)status;
    return k < sizeof codes / sizeof *codes ? codes[k] : MENISCUS__CODE__INTERNAL;
}
