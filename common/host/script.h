/* SPDX-License-Identifier: BSD-3-Clause */
/* What all programs promise to scripts alike. */
#ifndef COMMON_HOST_SCRIPT_H
#define COMMON_HOST_SCRIPT_H

#include <stdbool.h>

/* Whether a command line asks for JSON, wherever it does and whatever else is wrong with it: whoever asks is to get one
 * object even if the rest cannot be understood. */
bool script_wants_json(int argc, char *const *argv);

#endif
