/* SPDX-License-Identifier: BSD-3-Clause */
#include "tests/support/shipped.h"
#include "tests/support/check.h"
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void visit_at(const char *path, void (*visit)(CaseFile *file))
{
    CaseFile *file = NULL;
    MnsError error = {0};
    if (case_file_read(path, &file, &error)) fail_msg("%s", error.text);
    visit(file);
    case_file_free(file);
}

size_t shipped_each(void (*visit)(CaseFile *file))
{
    struct dirent **entries;
    size_t seen = 0;
    const int n = scandir("server/cases", &entries, NULL, alphasort);
    for (int k = 0; k < n; k++) {
        char path[300];
        const char *end = strrchr(entries[k]->d_name, '.');
        snprintf(path, sizeof path, "server/cases/%.256s", entries[k]->d_name);
        const bool is_case = end && !strcmp(end, ".yaml");
        free(entries[k]);
        if (!is_case) continue;
        visit_at(path, visit);
        seen++;
    }
    if (n >= 0) free(entries);
    return seen;
}
