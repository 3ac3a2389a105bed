/* SPDX-License-Identifier: BSD-3-Clause */
#include "run/unknown.h"

#include "common/case/words.h"
#include <meniscus/sim.h>

enum { SUGGESTION = 400 }; /* what the sentence around it leaves of an error */

MnsStatus unknown_field(const char *path, const char *name, uint64_t fields, MnsError *error)
{
    const char *names[MNS_MAX_FIELDS], *asked = name ? name : "";
    char text[SUGGESTION];
    size_t n = 0;
    for (int f = 0; mns_fields()[f].name; f++)
        if (fields >> f & 1) names[n++] = mns_fields()[f].name;
    words_suggest(names, n, asked, "`meniscus capabilities`", text, sizeof text);
    return mns_fail_at(error, MNS_E_NOT_FOUND, path, "there is no field \"%.60s\" in this simulation; %s", asked, text);
}

MnsStatus unknown_probe(const char *path, const char *name, const MnsCase *c, MnsError *error)
{
    const char *names[MNS_MAX_PROBES], *asked = name ? name : "";
    char text[SUGGESTION];
    if (!c->n_probes)
        return mns_fail_at(error, MNS_E_NOT_FOUND, path, "the case has no probe \"%.60s\", as it has none at all",
                           asked);
    for (size_t k = 0; k < c->n_probes; k++) names[k] = c->probes[k].name;
    words_suggest(names, c->n_probes, asked, "`meniscus capabilities`", text, sizeof text);
    return mns_fail_at(error, MNS_E_NOT_FOUND, path, "the case has no probe \"%.60s\"; %s", asked, text);
}
