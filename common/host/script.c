/* SPDX-License-Identifier: BSD-3-Clause */
/* What all programs promise to scripts alike. */
#include "common/host/script.h"
#include <string.h>

bool script_wants_json(int argc, char *const *argv)
{
    for (int k = 1; k < argc; k++) {
        const char *word = argv[k], *next = k + 1 < argc ? argv[k + 1] : "";
        if (strcmp(word, "-ojson") == 0 || strcmp(word, "--output=json") == 0) return true;
        if ((strcmp(word, "-o") == 0 || strcmp(word, "--output") == 0) && strcmp(next, "json") == 0) return true;
    }
    return false;
}
