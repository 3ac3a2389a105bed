/* SPDX-License-Identifier: BSD-3-Clause */
/* What somebody may do with a daemon. Each role may do all that the ones before it may. */
#ifndef COMMON_WIRE_ROLE_H
#define COMMON_WIRE_ROLE_H

typedef enum Role {
    ROLE_NONE,     /* nothing                                                    */
    ROLE_VIEWER,   /* ask and listen                                             */
    ROLE_OPERATOR, /* steer: start, pause, set, checkpoint, stop ...             */
    ROLE_ADMIN     /* load cases, and end the daemon                             */
} Role;

/* "operator". */
const char *role_name(Role role);

/* ROLE_NONE if it is the name of no other role. */
Role role_find(const char *name);

#endif
