/* SPDX-License-Identifier: BSD-3-Clause */
/* Texts that come from outside and are shown to people, or stored, later: on terminals, in JSON, in files. */
#ifndef COMMON_HOST_TEXT_H
#define COMMON_HOST_TEXT_H

#include <meniscus/status.h>
#include <stdbool.h>
#include <stddef.h>

/* UTF-8 without control characters. lines: newlines, tabs and characters that cannot be seen may be in it, as in a case file. */
bool text_is_clean(const char *text, bool lines);

/* The same text as UTF-8, which JSON must be: U+FFFD stands for each byte that is none, as in the name of a file. From malloc; NULL if there is
 * no memory. */
char *text_valid(const char *text);

enum {
    TEXT_CHARACTER = 4, /* bytes of the longest character */
    TEXT_ESCAPE = 6     /* bytes that at most become of one */
};

/* What a terminal would obey, or would not show, as \\n, \\t and \\uXXXX, and U+FFFD as above. Returns how many bytes it has.
 *  text   of `size` bytes, and one more, which is 0
 *  lines  newlines and tabs stay
 *  ret    of `size` times TEXT_ESCAPE bytes */
size_t text_escape(const char *text, size_t size, bool lines, char *ret);

/* How many bytes at the end of a text begin a character whose others may follow. */
size_t text_cut(const char *text, size_t size);

/* The same with \\n, \\t and \\uXXXX for what a terminal would obey, or would not show: also right for JSON in one line. From malloc; NULL if there is no
 * memory. */
char *text_escaped(const char *text);

enum { TEXT_SHOWN = 8 };

/* The same, to be printed at once: it holds until the thread has asked for TEXT_SHOWN more. Empty for NULL. */
const char *text_shown(const char *text);

/* A name that a client gives to something. MNS_E_INVALID, at `path`: command lines would take it for an option. */
MnsStatus text_name_check(const char *name, const char *path, MnsError *error);

#endif
