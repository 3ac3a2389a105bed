/* SPDX-License-Identifier: BSD-3-Clause */
/* A case file as a `load`, as clients and the daemon's own command line send it. */
#ifndef COMMON_CASE_LOAD_H
#define COMMON_CASE_LOAD_H

#include "common/case/file.h"
#include "meniscus.pb-c.h"

/* A command with the case and what was set of it, both borrowed from the file. MNS_E_MEMORY. */
MnsStatus load_init(Meniscus__Load *load, const CaseFile *file, MnsError *error);
void load_done(Meniscus__Load *load);

#endif
