/* SPDX-License-Identifier: BSD-3-Clause */
#include "run/versions.h"

#include <inttypes.h>

void versions_done(Versions *versions)
{
    for (size_t k = 0; k < VERSIONS_KEPT; k++) document_leave(versions->kept[k]);
    *versions = (Versions){.number = 0};
}

void versions_begin(Versions *versions, uint64_t number, Document *document)
{
    versions_done(versions);
    versions->number = number - 1;
    versions_add(versions, document);
}

void versions_add(Versions *versions, Document *document)
{
    Document **place = &versions->kept[++versions->number % VERSIONS_KEPT];
    document_leave(*place);
    *place = document_share(document);
    if (versions->n < VERSIONS_KEPT) versions->n++;
}

MnsStatus versions_find(const Versions *versions, uint64_t number, Document **ret, MnsError *error)
{
    const uint64_t last = versions->number;
    if (!number || number > last)
        return mns_fail_at(error, MNS_E_NOT_FOUND, "version",
                           "there is no version %" PRIu64 " of the case: the present one is %" PRIu64, number, last);
    if (last - number >= versions->n)
        return mns_fail_at(error, MNS_E_NOT_FOUND, "version",
                           "version %" PRIu64
                           " of the case is not kept: the last %zu are, and none from before a load, reset or restore; "
                           "the oldest is %" PRIu64,
                           number, (size_t)VERSIONS_KEPT, last - versions->n + 1);
    *ret = versions->kept[number % VERSIONS_KEPT];
    return MNS_OK;
}
