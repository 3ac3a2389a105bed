/* SPDX-License-Identifier: BSD-3-Clause */
/* The cases that ship, one after the other. */
#ifndef SUPPORT_SHIPPED_H
#define SUPPORT_SHIPPED_H

#include "common/case/file.h"
#include <stddef.h>

/* Call visit with every shipped case, and return how many there are. The file is closed afterwards; the test fails where one cannot be read. */
size_t shipped_each(void (*visit)(CaseFile *file));

#endif
