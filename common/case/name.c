/* SPDX-License-Identifier: BSD-3-Clause */
/* What a name may be made of. */
#include "common/case/name.h"
#include <stddef.h>
#include <stdio.h>
#include <string.h>

static const char ALPHABET[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._-";

bool is_name(const char *text)
{
    const size_t n = strspn(text, ALPHABET);
    return n > 0 && n < CASE_NAME_SIZE && !text[n] && *text != '.' && *text != '-';
}

void case_name_from_path(const char *path, char ret[static CASE_NAME_SIZE])
{
    const char *slash = strrchr(path, '/'), *base = slash ? slash + 1 : path, *dot = strrchr(base, '.');
    const size_t length = dot && dot > base ? (size_t)(dot - base) : strlen(base);
    snprintf(ret, CASE_NAME_SIZE, "%.*s", (int)(length < CASE_NAME_SIZE ? length : CASE_NAME_SIZE - 1), base);
    for (char *c = ret; *c; c++)
        if (!strchr(ALPHABET, *c)) *c = '_';
    if (!*ret) strcpy(ret, "_");
    if (*ret == '.' || *ret == '-') *ret = '_'; /* it would be hidden, climb out, or be taken for an option */
}
