/* SPDX-License-Identifier: BSD-3-Clause */
/* What must be known of a case to show it. */
#ifndef DASHBOARD_ABOUT_H
#define DASHBOARD_ABOUT_H

#include <jansson.h>
#include <meniscus/client.h>

/* Ask what the daemon can do and, if there is a case, how it is laid out: README.md lists the keys. `status`: a fresh one. */
MnsStatus about_ask(MnsClient *client, const MnsReply *status, json_t **ret, MnsError *error);

#endif
