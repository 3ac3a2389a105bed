/* SPDX-License-Identifier: BSD-3-Clause */
/* Where the other programs of the project are. */
#include "client/cli/beside.h"
#include <stdio.h>
#include <string.h>
#include <unistd.h>

bool beside_find(const char *program, char ret[static PATH_MAX])
{
    char self[PATH_MAX];
    const ssize_t n = readlink("/proc/self/exe", self, sizeof self - 1);
    if (n <= 0) return false;
    self[n] = 0;
    char *slash = strrchr(self, '/');
    if (!slash) return false;
    *slash = 0;
    return snprintf(ret, PATH_MAX, "%s/%s", self, program) < PATH_MAX && access(ret, X_OK) == 0;
}
