/* SPDX-License-Identifier: BSD-3-Clause */
/* Names of roles. */
#include "common/wire/role.h"

#include <string.h>

static const char *const names[] = {
    [ROLE_NONE] = "none", [ROLE_VIEWER] = "viewer", [ROLE_OPERATOR] = "operator", [ROLE_ADMIN] = "admin"};

const char *role_name(Role role)
{
    return names[role];
}

Role role_find(const char *name)
{
    for (Role role = ROLE_VIEWER; role <= ROLE_ADMIN; role++)
        if (!strcmp(names[role], name)) return role;
    return ROLE_NONE;
}
