/* SPDX-License-Identifier: BSD-3-Clause */
/* The word that whoever asks over HTTP must know. */
#ifndef COMMON_WIRE_TOKEN_H
#define COMMON_WIRE_TOKEN_H

#include <meniscus/status.h>
#include <stdbool.h>

enum { TOKEN_SHORTEST = 16, TOKEN_LONGEST = 256 };

typedef struct Token {
    char text[TOKEN_LONGEST + 1]; /* "": nobody is asked for one */
} Token;

/* Read the one line of a file that only its owner can read. MNS_E_IO; MNS_E_INVALID if others can, or it is no such word. */
MnsStatus token_read(const char *path, Token *ret, MnsError *error);

/* Make one that nobody can guess. MNS_E_IO: the system has nothing to make it of. */
MnsStatus token_make(Token *ret, MnsError *error);

/* Is this the token? Takes as long for any wrong word of a length. */
bool token_is(const Token *token, const char *word);

/* Does the value of an Authorization header, NULL if there was none, show the token? All do where none is asked for. */
bool token_shown(const Token *token, const char *authorization);

#endif
