/* SPDX-License-Identifier: BSD-3-Clause */
/* Whatever happens to the text of a case, reading it ends with a case or with a complaint that has a place. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "cases/translate.h"
#include "common/case/file.h"
#include "tests/support/draw.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ROUNDS = 4000, ROOM = 16384 };

static const char *const files[] = {"dambreak2d",   "dambreak3d", "sloshing2d",
                                    "hydrostatic4", "cavity2d",   "drop-periodic2d"};

static size_t load(const char *name, char *text)
{
    char path[200];
    snprintf(path, sizeof path, "server/cases/%s.yaml", name);
    FILE *in = fopen(path, "r");
    assert_non_null(in);
    const size_t size = fread(text, 1, ROOM / 2, in);
    fclose(in);
    return size;
}

/* Put `more` in the place of n bytes. */
static size_t splice(char *text, size_t size, size_t at, size_t n, const char *more, size_t length)
{
    if (n > size - at) n = size - at;
    if (size - n + length > ROOM) return size;
    memmove(text + at + length, text + at + n, size - at - n);
    memcpy(text + at, more, length);
    return size - n + length;
}

/* One change: a byte, a piece of the format's own words, or a piece of the text itself, lost, doubled or moved. */
static size_t mutate(char *text, size_t size, uint64_t *seed)
{
    static const char *const words[] = {"-1", "nan", "1e400",   "{}",     "[",     "]",        "}",        "\n",  "  ",
                                        ": ", "&a ", "*a",      "!!str ", "---\n", "'",        "\"",       "|\n", "? ",
                                        "#",  "box", "fluids:", "null",   "\xff",  "[[[[[[[[", "%YAML 9\n"};
    char piece[64];
    const size_t at = draw_below(seed, size), n = draw_below(seed, 24);
    switch (draw_below(seed, 4)) {
    case 0: text[at] = (char)draw(seed); return size;
    case 1: return size > 100 ? splice(text, size, at, n, "", 0) : size;
    case 2: {
        const char *word = words[draw_below(seed, sizeof words / sizeof *words)];
        return splice(text, size, at, draw_below(seed, 3), word, strlen(word));
    }
    default: {
        const size_t from = draw_below(seed, size), length = n < size - from ? n : size - from;
        memcpy(piece, text + from, length);
        return splice(text, size, at, 0, piece, length);
    }
    }
}

static bool has_a_place(const char *text)
{
    unsigned line, column;
    return sscanf(text, "a.yaml:%u:%u: ", &line, &column) == 2 && line > 0 && column > 0;
}

/* Returns whether it was a case. */
static bool read_whole(const char *text, size_t size)
{
    CaseFile *file = NULL;
    MnsCase *c = NULL;
    MnsError error = {0};
    if (case_file_parse("a.yaml", text, size, &file, &error)) {
        if (!has_a_place(error.text)) fail_msg("no place: %s", error.text);
        return false;
    }
    const MnsStatus status = case_translate(case_file_message(file), &c, &error);
    case_file_locate(file, &error);
    if (status && !has_a_place(error.text)) fail_msg("no place: %s", error.text);
    mns_case_free(c);
    case_file_free(file);
    return !status;
}

static void any_text_is_a_case_or_a_complaint_with_a_place(void **state)
{
    (void)state;
    uint64_t seed = 20200301;
    size_t good = 0, bad = 0;
    char *original = malloc(ROOM), *text = malloc(ROOM);
    assert_true(original && text);
    for (size_t f = 0; f < sizeof files / sizeof *files; f++) {
        const size_t length = load(files[f], original);
        for (int round = 0; round < ROUNDS; round++) {
            size_t size = length;
            memcpy(text, original, size);
            for (size_t k = 1 + draw_below(&seed, 3); k; k--) size = mutate(text, size, &seed);
            *(read_whole(text, size) ? &good : &bad) += 1;
        }
    }
    free(original);
    free(text);
    assert_true(good > ROUNDS / 10 && bad > ROUNDS / 10); /* the mutations reach both ends */
}

/* A message from a socket, damaged: it does not unpack, or is refused, or is a good case. */
static void any_damaged_message_is_refused_or_good(void **state)
{
    (void)state;
    uint64_t seed = 7;
    CaseFile *file = NULL;
    assert_int_equal(case_file_read("server/cases/sloshing2d.yaml", &file, NULL), MNS_OK);
    const size_t size = meniscus__case__get_packed_size(case_file_message(file));
    uint8_t *packed = malloc(size), *damaged = malloc(size);
    assert_true(packed && damaged);
    meniscus__case__pack(case_file_message(file), packed);
    size_t refused = 0;
    for (int round = 0; round < ROUNDS; round++) {
        memcpy(damaged, packed, size);
        for (size_t k = 1 + draw_below(&seed, 4); k; k--) damaged[draw_below(&seed, size)] = (uint8_t)draw(&seed);
        Meniscus__Case *m = meniscus__case__unpack(NULL, size, damaged);
        MnsCase *c = NULL;
        MnsError error = {0};
        if (!m) continue;
        MnsStatus status = case_message_check(m, &error);
        if (!status) status = case_translate(m, &c, &error);
        if (status) assert_true(*error.path && *error.text);
        refused += status != MNS_OK;
        mns_case_free(c);
        meniscus__case__free_unpacked(m, NULL);
    }
    assert_true(refused > ROUNDS / 10);
    free(packed);
    free(damaged);
    case_file_free(file);
}

/* Paths and values that nobody would write leave the case whole. */
static void any_assignment_is_taken_or_refused_with_a_sentence(void **state)
{
    (void)state;
    static const char *const seeds[] = {"fluids[1].density=2", "gravity=[0, -1]", "probes[16]={name: a, coverage: {}}",
                                        "scheme.riemann.guard=0.1", "walls[0].shape[0].box.min[1]=3"};
    uint64_t seed = 11;
    CaseFile *file = NULL;
    assert_int_equal(case_file_read("server/cases/dambreak2d.yaml", &file, NULL), MNS_OK);
    for (int round = 0; round < ROUNDS; round++) {
        char text[ROOM];
        const char *from = seeds[draw_below(&seed, sizeof seeds / sizeof *seeds)];
        size_t size = strlen(from);
        memcpy(text, from, size);
        size = mutate(text, size, &seed);
        text[size < ROOM ? size : ROOM - 1] = 0;
        MnsError error = {0};
        if (case_file_set(file, text, &error)) assert_memory_equal(error.text, "--set ", 6);
    }
    assert_int_equal(case_message_check(case_file_message(file), NULL), MNS_OK);
    case_file_free(file);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(any_text_is_a_case_or_a_complaint_with_a_place),
        cmocka_unit_test(any_damaged_message_is_refused_or_good),
        cmocka_unit_test(any_assignment_is_taken_or_refused_with_a_sentence),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
