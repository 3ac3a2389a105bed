/* SPDX-License-Identifier: BSD-3-Clause */
/* Names of cases, daemons, fluids, walls and probes. They become names of files, of data sets and parts of paths, so one
 * small alphabet serves all; closer limits of length and of the first letter are up to who uses them. */
#ifndef COMMON_CASE_NAME_H
#define COMMON_CASE_NAME_H

#include <stdbool.h>

enum { CASE_NAME_SIZE = 101 };

/* Of a case that is loaded without one, also when a journal tells of that load. */
#define CASE_NAMELESS "case"

/* One to 100 letters, digits, dots, dashes and underscores, the first of them neither a dot, which would be hidden or a way up, nor a dash, which
 * would be an option. */
bool is_name(const char *text);

/* "cases/tank.yaml" gives "tank": the file's name without folder and ending, cut to 100 letters, with underscores for what
 * a name of a case may not have. */
void case_name_from_path(const char *path, char ret[static CASE_NAME_SIZE]);

#endif
