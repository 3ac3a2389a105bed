/* SPDX-License-Identifier: BSD-3-Clause */
/* What a shell can offer for a word, read from how the tables of commands and options write it. */
#ifndef CLI_COMPLETION_H
#define CLI_COMPLETION_H

#include <stddef.h>

/* What may stand for `text`, an OptionInfo.value or Command.arguments, with blanks between: words that are meant as they are, and
 * @files, @directories, @cases, @daemons, @parameters, @assignments, @commands. Empty if it is anybody's guess. */
void completion_kinds(const char *text, char *ret, size_t size);

#endif
