/* SPDX-License-Identifier: BSD-3-Clause */
/* A case file as a `load`, as clients and the daemon's own command line send it. */
#ifndef PROTO_LOAD_H
#define PROTO_LOAD_H

#include "meniscus.pb-c.h"
#include "proto/case_file.h"

/* A command with the case and what was set of it, both borrowed from the file. MNS_E_MEMORY. */
MnsStatus load_init(Meniscus__Load *load, const CaseFile *file, MnsError *error);
void load_done(Meniscus__Load *load);

#endif
