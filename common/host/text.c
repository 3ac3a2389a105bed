/* SPDX-License-Identifier: BSD-3-Clause */
/* What one client names, another one prints: nothing in it may be an order to a terminal, or break a message of ours. */
#include "common/host/text.h"
#include <pthread.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char replacement[] = "\xef\xbf\xbd";

/* The character at the beginning of a text that ends with a zero, in its shortest form, and how many bytes it has; 0 bytes: it is no character of UTF-8. */
static size_t decode(const unsigned char *at, uint32_t *ret)
{
    static const uint32_t least[] = {0, 0, 0x80, 0x800, 0x10000};
    const size_t n = *at < 0x80 ? 1 : *at >= 0xf8 ? 0 : *at >= 0xf0 ? 4 : *at >= 0xe0 ? 3 : *at >= 0xc0 ? 2 : 0;
    uint32_t c = n > 1 ? *at & (0x7fu >> n) : *at;
    for (size_t k = 1; k < n; k++) {
        if ((at[k] & 0xc0) != 0x80) return 0; /* also where the text ends */
        c = c << 6 | (at[k] & 0x3fu);
    }
    const bool is_half = c >= 0xd800 && c <= 0xdfff; /* of a pair of UTF-16 */
    *ret = c;
    return n && c >= least[n] && c <= 0x10ffff && !is_half ? n : 0;
}

/* From U+0080 to U+009F there are more of them, which terminals obey too. */
static bool is_control(uint32_t c, bool lines)
{
    if (c == '\n' || c == '\t') return !lines;
    return c < ' ' || (c >= 0x7f && c <= 0x9f);
}

/* What cannot be seen, or turns around what is beside it, so that a text is not what it seems to be: Unicode's Default_Ignorable_Code_Point (soft
 * hyphens, zero-width characters, marks and orders of writing direction, fillers, variation selectors, tags), separators of lines and paragraphs, and
 * marks of annotations. */
static bool is_hidden(uint32_t c)
{
    static const uint32_t ranges[][2] = {
        {0xad, 0xad},     {0x34f, 0x34f},   {0x61c, 0x61c},     {0x115f, 0x1160},   {0x17b4, 0x17b5},  {0x180b, 0x180f},
        {0x200b, 0x200f}, {0x2028, 0x202e}, {0x2060, 0x206f},   {0x3164, 0x3164},   {0xfe00, 0xfe0f},  {0xfeff, 0xfeff},
        {0xffa0, 0xffa0}, {0xfff0, 0xfffb}, {0x1bca0, 0x1bca3}, {0x1d173, 0x1d17a}, {0xe0000, 0xe0fff}};
    for (size_t k = 0; k < sizeof ranges / sizeof *ranges; k++)
        if (c >= ranges[k][0] && c <= ranges[k][1]) return true;
    return false;
}

bool text_is_clean(const char *text, bool lines)
{
    uint32_t c = 0;
    for (const unsigned char *at = (const unsigned char *)text; *at;) {
        const size_t n = decode(at, &c);
        if (!n || is_control(c, lines) || (!lines && is_hidden(c))) return false;
        at += n;
    }
    return true;
}

/* As in JSON, which has no more than four digits: of other characters both halves of the surrogate pair. */
static char *write_escape(char *to, uint32_t c)
{
    if (c == '\n' || c == '\t') return to + sprintf(to, "\\%c", c == '\n' ? 'n' : 't');
    if (c < 0x10000) return to + sprintf(to, "\\u%04x", (unsigned)c);
    return to + sprintf(to, "\\u%04x\\u%04x", (unsigned)(0xd7c0 + (c >> 10)), (unsigned)(0xdc00 + (c & 0x3ff)));
}

/* Whether a picture or a sign is meant: no terminal obeys that, and it belongs to many an emoji. In a name it would tell apart what looks alike. */
static bool is_presentation(uint32_t c)
{
    return c == 0xfe0e || c == 0xfe0f;
}

size_t text_escape(const char *text, size_t size, bool lines, char *ret)
{
    const unsigned char *at = (const unsigned char *)text, *const end = at + size;
    char *to = ret;
    while (at < end) {
        uint32_t c;
        const size_t n = decode(at, &c), m = n ? n : strlen(replacement);
        if (n && (is_control(c, lines) || (is_hidden(c) && !is_presentation(c)))) to = write_escape(to, c);
        else to = (char *)memcpy(to, n ? (const char *)at : replacement, m) + m;
        at += n ? n : 1;
    }
    return (size_t)(to - ret);
}

size_t text_cut(const char *text, size_t size)
{
    for (size_t n = 1; n < TEXT_CHARACTER && n <= size; n++) {
        const unsigned char c = (unsigned char)text[size - n];
        if (c >= 0xc0) return n < (c >= 0xf0 ? 4u : c >= 0xe0 ? 3u : 2u) ? n : 0;
        if (c < 0x80) return 0;
    }
    return 0;
}

char *text_escaped(const char *text)
{
    if (text_is_clean(text, false)) return strdup(text);
    const size_t n = strlen(text);
    char *ret = malloc(TEXT_ESCAPE * n + 1);
    if (ret) ret[text_escape(text, n, false, ret)] = 0;
    return ret;
}

static pthread_key_t of_thread; /* what a thread was shown, which is freed when it ends */
static bool is_freed;

static void free_shown(void *data)
{
    char **shown = data;
    for (int k = 0; k < TEXT_SHOWN; k++) {
        free(shown[k]);
        shown[k] = NULL; /* another destructor may still show something */
    }
}

static void make_key(void)
{
    is_freed = !pthread_key_create(&of_thread, free_shown);
}

const char *text_shown(const char *text)
{
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    static _Thread_local char *shown[TEXT_SHOWN];
    static _Thread_local unsigned next;
    pthread_once(&once, make_key);
    if (is_freed) pthread_setspecific(of_thread, shown);
    char **place = &shown[next++ % TEXT_SHOWN];
    free(*place);
    *place = text ? text_escaped(text) : NULL;
    return *place ? *place : "";
}

char *text_valid(const char *text)
{
    const size_t longest = sizeof replacement - 1;
    uint32_t c;
    char *ret = malloc(longest * strlen(text) + 1), *to = ret;
    for (const unsigned char *at = (const unsigned char *)text; ret && *at;) {
        const size_t n = decode(at, &c), m = n ? n : longest;
        memcpy(to, n ? (const char *)at : replacement, m);
        at += n ? n : 1;
        to += m;
    }
    if (ret) *to = 0;
    return ret;
}

MnsStatus text_name_check(const char *name, const char *path, MnsError *error)
{
    if (*name != '-') return MNS_OK;
    return mns_fail_at(error, MNS_E_INVALID, path,
                       "a name does not begin with a dash, as options do; found \"%.60s\": choose another", name);
}
