/* SPDX-License-Identifier: BSD-3-Clause */
/* Words of case files: names of enum values, numbers as text in any locale, and guesses at what a wrong word meant. */
#ifndef COMMON_CASE_WORDS_H
#define COMMON_CASE_WORDS_H

#include <stdbool.h>
#include <stddef.h>

/* TRUNCATED_GAUSSIAN as truncated-gaussian. */
const char *words_from_enum(const char *name, char word[static 64]);

/* `did you mean "density"? Allowed: name, density`; without the question if no name is like the wrong word. What does not
 * fit is counted: `name, density, and 7 more (\`meniscus capabilities\` lists all)`.
 *  all  the command that lists them, in its quotes; NULL: there is none */
void words_suggest(const char *const *names, size_t n, const char *wrong, const char *all, char *text, size_t size);

/* A decimal number, the whole text, with a point in every locale; .inf and -.inf as YAML has them, inf and -inf too. */
bool words_to_number(const char *text, double *ret);

/* The shortest text that words_to_number() reads back as the same number. */
const char *words_from_number(double value, char text[static 32]);

#endif
