/* SPDX-License-Identifier: BSD-3-Clause */
/* The command line of `meniscus render`: what it means, what it refuses, what scripts get back. */
#include "client/cli/command.h"
#include "client/cli/render_options.h"
#include "io/snapshot.h"
#include "tests/support/io_fixture.h"
#include <math.h>
#include <meniscus/exit.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

enum { MOST_WORDS = 24 };

/* Words of a command line, which getopt may reorder. */
typedef struct Line {
    char text[1024], *words[MOST_WORDS + 1];
    int n;
} Line;

static Line split(const char *text)
{
    Line line = {.n = 0};
    snprintf(line.text, sizeof line.text, "%s", text);
    return line;
}

static char **words_of(Line *line)
{
    for (char *word = strtok(line->text, " "); word && line->n < MOST_WORDS; word = strtok(NULL, " "))
        line->words[line->n++] = word;
    return line->words;
}

static MnsStatus parse(Line *line, RenderOptions *o, MnsError *error)
{
    static Options options;
    const Command *render;
    char **words = words_of(line);
    int used;
    options.n_given = options.n_words = 0;
    assert_int_equal(command_find("render", &render, NULL), MNS_OK);
    const MnsStatus status = options_parse(&options, line->n, words, command_options(render), false, &used, error);
    return status ? status : render_options_read(&options, o, error);
}

static void every_option_arrives(void **state)
{
    (void)state;
    RenderOptions o;
    Line line =
        split("render a.hdf -f pressure --range -10,2e3 --size 800x450 --cut y=0.5,0.02 --walls --colours magma "
              "--title T --box 0,-1,2.5,3 --fluid water,air --out b.png");
    assert_int_equal(parse(&line, &o, NULL), MNS_OK);
    assert_string_equal(o.snapshot, "a.hdf");
    assert_string_equal(o.field, "pressure");
    assert_true(o.has_range && o.range[0] == -10 && o.range[1] == 2000);
    assert_true(o.width == 800 && o.height == 450);
    assert_true(o.view.kind == VIEW_CUT && o.view.axis == 1 && o.view.at == 0.5 && o.view.thickness == 0.02);
    assert_true(o.view.walls && o.map == colour_map_find("magma"));
    assert_string_equal(o.title, "T");
    assert_true(o.view.has_box && o.view.box[1] == -1 && o.view.box[2] == 2.5);
    assert_string_equal(o.view.fluids, "water,air");
    assert_string_equal(o.out, "b.png");
}

static void little_needs_to_be_said(void **state)
{
    (void)state;
    RenderOptions o;
    Line line = split("render --out b.png");
    assert_int_equal(parse(&line, &o, NULL), MNS_OK);
    assert_null(o.snapshot);
    assert_string_equal(o.field, "phase");
    assert_true(o.width == 1600 && o.height == 0 && o.view.kind == VIEW_AUTOMATIC && isnan(o.view.at));
}

static void wrong_options_are_refused_by_name(void **state)
{
    (void)state;
    static const struct {
        const char *text, *path;
        MnsStatus status;
    } wrong[] = {
        {"render a.hdf --out b.png --range 3,1", "--range", MNS_E_INVALID},
        {"render a.hdf --out b.png --range 1,nan", "--range", MNS_E_INVALID},
        {"render a.hdf --out b.png --range 1,2x", "--range", MNS_E_INVALID},
        {"render a.hdf --out b.png --size 800x", "--size", MNS_E_INVALID},
        {"render a.hdf --out b.png --size -800x600", "--size", MNS_E_INVALID},
        {"render a.hdf --out b.png --size 20x20", "--size", MNS_E_LIMIT},
        {"render a.hdf --out b.png --size 8000x8000", "--size", MNS_E_LIMIT},
        {"render a.hdf --out b.png --size 5000", "--size", MNS_E_LIMIT},
        {"render a.hdf --out b.png --size 99999999999999999999", "--size", MNS_E_LIMIT},
        {"render a.hdf --out b.png --size 99999999999999999999x900", "--size", MNS_E_LIMIT},
        {"render a.hdf --out b.png --cut w=1", "--cut", MNS_E_INVALID},
        {"render a.hdf --out b.png --cut z=", "--cut", MNS_E_INVALID},
        {"render a.hdf --out b.png --cut z=1,-1", "--cut", MNS_E_INVALID},
        {"render a.hdf --out b.png --project zz", "--project", MNS_E_INVALID},
        {"render a.hdf --out b.png --project z --cut z", "--cut", MNS_E_INVALID},
        {"render a.hdf --out b.png --box 0,0,1", "--box", MNS_E_INVALID},
        {"render a.hdf --out b.png --box 0,0,0,1", "--box", MNS_E_INVALID},
        {"render a.hdf --out b.png --colours rainbow", "--colours", MNS_E_INVALID},
        {"render a.hdf --out b.jpg", "--out", MNS_E_INVALID},
        {"render a.hdf", "--out", MNS_E_INVALID},
        {"render a.hdf --out b.png --wals", "", MNS_E_INVALID},
        {"render a.hdf --out b.png --range", "", MNS_E_INVALID},
        {"render a.hdf --daemon lab --out b.png", "", MNS_E_INVALID},
    };
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
        RenderOptions o;
        MnsError error = {0};
        Line line = split(wrong[k].text);
        assert_int_equal(parse(&line, &o, &error), wrong[k].status);
        assert_string_equal(error.path, wrong[k].path);
        assert_true(strlen(error.text) > 10);
    }
}

static int run(const char *text)
{
    Line line = split(text);
    char **words = words_of(&line);
    return command_main(line.n, words);
}

static void exit_codes_are_those_of_the_manual(void **state)
{
    (void)state;
    char text[512], *dir = scratch_new(), *snapshot = path_in(dir, "a.hdf");
    MnsCapture *c = noise_capture(2, 50, 40, 3);
    const FileMeta meta = noise_meta();
    double *x = c->data[mns_field_find("position")][0], *y = c->data[mns_field_find("position")][1];
    uint8_t *phase = c->data[mns_field_find("phase")][0];
    for (int i = 0; i < 50; i++) x[i] = 0.1 * (i % 10), y[i] = 0.1 * (i / 10), phase[i] = (uint8_t)(i < 40 ? i % 2 : 2);
    assert_int_equal(snapshot_write(snapshot, c, &meta, NULL), MNS_OK);
    snprintf(text, sizeof text, "meniscus render %s --out %s/a.png", snapshot, dir);
    assert_int_equal(run(text), MNS_EXIT_DONE);
    assert_true(holds(dir, "a.png"));
    snprintf(text, sizeof text, "meniscus render %s -f temperature --out %s/b.png", snapshot, dir);
    assert_int_equal(run(text), MNS_EXIT_FAILED);
    assert_false(holds(dir, "b.png"));
    snprintf(text, sizeof text, "meniscus render %s --out %s/no/a.png", snapshot, dir);
    assert_int_equal(run(text), MNS_EXIT_IO);
    assert_int_equal(run("meniscus render --size none"), MNS_EXIT_USAGE);
    assert_int_equal(run("meniscus render a.hdf c.hdf --out b.png"), MNS_EXIT_USAGE);
    assert_int_equal(run("meniscus render --daemon ipc:///nonexistent/socket --out b.png"), MNS_EXIT_UNREACHABLE);
    mns_capture_free(c);
    free(snapshot);
    scratch_free(dir);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_option_arrives),
        cmocka_unit_test(little_needs_to_be_said),
        cmocka_unit_test(wrong_options_are_refused_by_name),
        cmocka_unit_test(exit_codes_are_those_of_the_manual),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
