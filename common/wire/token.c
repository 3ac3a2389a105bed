/* SPDX-License-Identifier: BSD-3-Clause */
/* The word that whoever asks over HTTP must know, as RFC 6750 has it. */
#include "common/wire/token.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <strings.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

static MnsStatus check_file(const char *path, int fd, MnsError *error)
{
    struct stat info;
    if (fstat(fd, &info))
        return mns_fail_at(error, MNS_E_IO, "http-token", "cannot look at '%.300s': %s; %s", path, strerror(errno),
                           mns_refusal_hint(errno));
    if (!S_ISREG(info.st_mode))
        return mns_fail_at(error, MNS_E_INVALID, "http-token", "--http-token takes a file, which '%.300s' is not",
                           path);
    if (info.st_mode & 077)
        return mns_fail_at(error, MNS_E_INVALID, "http-token",
                           "others than its owner can read or write '%.300s', so its token is no secret: chmod 600 it",
                           path);
    return MNS_OK;
}

static MnsStatus check_text(const char *path, const char *text, MnsError *error)
{
    static const char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._~+/=";
    const size_t n = strlen(text);
    if (n >= TOKEN_SHORTEST && n <= TOKEN_LONGEST && strspn(text, letters) == n) return MNS_OK;
    return mns_fail_at(error, MNS_E_INVALID, "http-token",
                       "a token is one line of %d to %d letters, digits and \"-._~+/=\", which '%.200s' does not hold; "
                       "make one with: openssl rand -hex 32 >FILE",
                       TOKEN_SHORTEST, TOKEN_LONGEST, path);
}

MnsStatus token_read(const char *path, Token *ret, MnsError *error)
{
    char text[TOKEN_LONGEST + 3]; /* one more than may be there, with the end of its line */
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0)
        return mns_fail_at(error, MNS_E_IO, "http-token", "cannot read the token in '%.300s': %s; %s", path,
                           strerror(errno), mns_refusal_hint(errno));
    MnsStatus status = check_file(path, fd, error);
    const ssize_t n = status ? 0 : read(fd, text, sizeof text - 1);
    if (n < 0)
        status = mns_fail_at(error, MNS_E_IO, "http-token", "cannot read the token in '%.300s': %s; %s", path,
                             strerror(errno), mns_refusal_hint(errno));
    close(fd);
    if (status) return status;
    size_t size = n > 0 ? (size_t)n : 0;
    if (size && text[size - 1] == '\n') size--;
    text[size] = 0;
    status = check_text(path, text, error);
    if (!status) memcpy(ret->text, text, size + 1);
    return status;
}

MnsStatus token_make(Token *ret, MnsError *error)
{
    static const char digits[] = "0123456789abcdef";
    unsigned char bytes[16];
    if (getrandom(bytes, sizeof bytes, 0) != (ssize_t)sizeof bytes)
        return mns_fail(error, MNS_E_IO, "cannot make a token: %s", strerror(errno));
    for (size_t k = 0; k < sizeof bytes; k++) {
        ret->text[2 * k] = digits[bytes[k] >> 4];
        ret->text[2 * k + 1] = digits[bytes[k] & 15];
    }
    ret->text[2 * sizeof bytes] = 0;
    return MNS_OK;
}

bool token_is(const Token *token, const char *word)
{
    const size_t n = strlen(token->text);
    if (strlen(word) != n) return false;
    unsigned different = 0;
    for (size_t k = 0; k < n; k++) different |= (unsigned)(word[k] ^ token->text[k]);
    return !different;
}

bool token_shown(const Token *token, const char *authorization)
{
    static const char scheme[] = "Bearer ";
    if (!token->text[0]) return true;
    if (!authorization || strncasecmp(authorization, scheme, strlen(scheme)) != 0) return false;
    return token_is(token, authorization + strlen(scheme));
}
