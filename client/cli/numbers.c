/* SPDX-License-Identifier: BSD-3-Clause */
/* Numbers on the command line: the whole word counts, in every locale. */
#include "client/cli/options.h"
#include "common/case/words.h"
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

MnsStatus parse_number(const char *name, const char *text, double *ret, MnsError *error)
{
    double value;
    if (!words_to_number(text, &value) || !isfinite(value))
        return mns_fail(error, MNS_E_INVALID, "%s: \"%s\" is not a number", name, text);
    *ret = value;
    return MNS_OK;
}

MnsStatus parse_count(const char *name, const char *text, uint64_t *ret, MnsError *error)
{
    char *end;
    errno = 0;
    const unsigned long long value = strtoull(text, &end, 10);
    if (*text < '0' || *text > '9' || *end || errno)
        return mns_fail(error, MNS_E_INVALID, "%s: \"%s\" is not a whole number from 0 on", name, text);
    *ret = value;
    return MNS_OK;
}

MnsStatus parse_numbers(const char *name, const char *text, size_t most, double *ret, size_t *ret_n, MnsError *error)
{
    size_t n = 0;
    for (const char *word = text; word; n++) {
        const char *comma = strchr(word, ',');
        char one[64];
        snprintf(one, sizeof one, "%.*s", comma ? (int)(comma - word) : (int)sizeof one - 1, word);
        if (n == most) return mns_fail(error, MNS_E_INVALID, "%s: \"%s\" has more than %zu numbers", name, text, most);
        const MnsStatus status = parse_number(name, one, &ret[n], error);
        if (status != MNS_OK) return status;
        word = comma ? comma + 1 : NULL;
    }
    *ret_n = n;
    return MNS_OK;
}

MnsStatus parse_id(const char *name, const char *text, uint8_t id[MNS_REQUEST_ID_SIZE], MnsError *error)
{
    bool good =
        strlen(text) == 2 * (size_t)MNS_REQUEST_ID_SIZE && strspn(text, "0123456789abcdefABCDEF") == strlen(text);
    for (size_t k = 0; good && k < MNS_REQUEST_ID_SIZE; k++) good = sscanf(text + 2 * k, "%2hhx", &id[k]) == 1;
    if (good) return MNS_OK;
    return mns_fail(error, MNS_E_INVALID, "%s: \"%.60s\" is not 32 hex digits", name, text);
}
