/* SPDX-License-Identifier: BSD-3-Clause */
/* Case messages become plain values: names resolved, dimensions checked, defaults filled in. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "cases/translate.h"
#include "common/case/file.h"
#include "common/case/find.h"
#include "sim/probes/probes.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define HEAD                                                                                                           \
    "dimensions: 2\nresolution: 10\ndomain: {min: [0, 0], max: [2, 1]}\nend_time: 1\n"                                 \
    "fluids: [{name: water, density: 1000, sound_speed: 10}, {name: air, density: 1, sound_speed: 20}]\n"              \
    "walls: [{name: tank, shape: [{outside: true, box: {min: [0, 0], max: [2, 1]}}]}]\n"

static MnsStatus translate(const char *text, MnsCase **ret, MnsError *error)
{
    CaseFile *file = NULL;
    if (case_file_parse("a.yaml", text, strlen(text), &file, error)) fail_msg("%s", error->text);
    const MnsStatus status = case_translate(case_file_message(file), ret, error);
    case_file_free(file); /* the case must not lean on the message */
    return status;
}

static MnsCase *translated(const char *text)
{
    MnsCase *c = NULL;
    MnsError error = {0};
    if (translate(text, &c, &error)) fail_msg("%s", error.text);
    return c;
}

static void refuses(const char *text, const char *path, const char *expected)
{
    MnsCase *c = NULL;
    MnsError error = {0};
    assert_int_equal(translate(text, &c, &error), MNS_E_INVALID);
    assert_null(c);
    assert_string_equal(error.path, path);
    assert_string_equal(error.text + strlen(path), expected);
}

static void what_is_absent_has_its_default(void **state)
{
    (void)state;
    MnsCase *c = translated(HEAD);
    assert_string_equal(c->title, "");
    assert_true(c->reference_length == 1 && c->threads == 0);
    for (int d = 0; d < 3; d++) {
        assert_string_equal(c->gravity[d], "0");
        assert_string_equal(c->displacement[d], "0");
        assert_string_equal(c->fluids[1].velocity[d], "0");
        assert_string_equal(c->walls[0].surface_velocity[d], "0");
    }
    assert_string_equal(c->fluids[0].pressure, "0");
    assert_int_equal(c->fluids[0].density_method, MNS_DENSITY_AUTOMATIC);
    assert_string_equal(c->scheme.name, "riemann");
    assert_int_equal(c->scheme.kernel, MNS_WENDLAND_C2);
    assert_true(c->scheme.smoothing == 1.3 && c->scheme.cfl == 0.25 && c->scheme.skin == 0.3);
    assert_true(c->scheme.riemann.limiter == 3 && c->scheme.riemann.guard == 0.25);
    assert_true(c->scheme.riemann.background_pressure == 4);
    assert_true(c->output.probe_interval == 0.01 && c->output.checkpoints_kept == 3 && c->output.walls);
    assert_true(c->limits.density_min == 0.1 && c->limits.density_max == 10 && c->limits.time_step_floor == 1e-4);
    assert_int_equal(c->walls[0].motion.kind, MNS_STILL);
    mns_case_free(c);
}

static void shapes_keep_their_numbers(void **state)
{
    (void)state;
    MnsCase *c = translated(
        "dimensions: 3\nresolution: 10\ndomain: {min: [0, 0, 0], max: [1, 1, 1], periodic: [z, x]}\nend_time: 1\n"
        "fluids:\n  - name: a\n    density: 1\n    sound_speed: 1\n    velocity: [x, y, 3]\n    shape:\n"
        "      - ball: {centre: [1, 2, 3], radius: 4}\n"
        "      - {operation: subtract, cylinder: {from: [1, 2, 3], to: [4, 5, 6], radius: 7}}\n"
        "      - {operation: intersect, plate: {centre: [1, 2, 3], along: [4, 5, 6], normal: [7, 8, 9], length: 10, "
        "width: 11, "
        "thickness: 12}}\n"
        "      - {outside: true, half_space: {point: [1, 2, 3], normal: [4, 5, 6]}}\n"
        "      - formula: z < 1\n");
    const MnsPart *p = c->fluids[0].shape.parts;
    assert_int_equal(c->fluids[0].shape.n, 5);
    assert_true(p[0].primitive == MNS_BALL && p[0].operation == MNS_ADD && p[0].a[2] == 3 && p[0].radius == 4);
    assert_true(p[1].primitive == MNS_CYLINDER && p[1].operation == MNS_SUBTRACT && p[1].b[0] == 4 && p[1].radius == 7);
    assert_true(p[2].primitive == MNS_PLATE && p[2].operation == MNS_INTERSECT && p[2].b[1] == 5 && p[2].c[2] == 9);
    assert_true(p[2].length == 10 && p[2].width == 11 && p[2].thickness == 12);
    assert_true(p[3].primitive == MNS_HALF_SPACE && p[3].outside && p[3].a[1] == 2 && p[3].b[0] == 4);
    assert_int_equal(p[4].primitive, MNS_FORMULA);
    assert_string_equal(p[4].formula, "z < 1");
    assert_string_equal(c->fluids[0].velocity[1], "y");
    assert_true(c->periodic[0] && !c->periodic[1] && c->periodic[2]);
    mns_case_free(c);
}

/* The tables of the translation hold what the schema had when they were written: a new choice must come here too. */
static void every_choice_of_the_schema_is_translated(void **state)
{
    (void)state;
    static const struct {
        const char *kernel, *method;
        MnsKernel k;
        MnsDensityMethod m;
    } choices[] = {{"wendland-c2", "automatic", MNS_WENDLAND_C2, MNS_DENSITY_AUTOMATIC},
                   {"truncated-gaussian", "continuity", MNS_TRUNCATED_GAUSSIAN, MNS_DENSITY_CONTINUITY},
                   {"quintic-spline", "summation", MNS_QUINTIC_SPLINE, MNS_DENSITY_SUMMATION}};
    assert_int_equal(meniscus__kernel__descriptor.n_values, 3);
    assert_int_equal(meniscus__density_method__descriptor.n_values, 3);
    assert_int_equal(meniscus__operation__descriptor.n_values, 3); /* all in the shapes above */
    for (size_t j = 0; j < 3; j++) {
        char text[400];
        snprintf(text, sizeof text,
                 "dimensions: 2\nresolution: 10\ndomain: {min: [0, 0], max: [2, 1]}\nend_time: 1\n"
                 "fluids: [{name: water, density: 1000, sound_speed: 10, density_method: %s}]\nscheme: {kernel: %s}\n",
                 choices[j].method, choices[j].kernel);
        MnsCase *c = translated(text);
        assert_int_equal(c->scheme.kernel, choices[j].k);
        assert_int_equal(c->fluids[0].density_method, choices[j].m);
        mns_case_free(c);
    }
}

/* Of a fluid that cannot be compressed nobody need say how fast sound is in it, of others everybody. */
static void only_what_can_be_compressed_needs_a_speed_of_sound(void **state)
{
    (void)state;
    static const char text[] = "dimensions: 2\nresolution: 10\ndomain: {min: [0, 0], max: [2, 1]}\nend_time: 1\n"
                               "fluids: [{name: water, density: 1000}]\nscheme: {%s: {}}\n";
    char one[300];
    snprintf(one, sizeof one, text, "incompressible");
    MnsCase *c = translated(one);
    assert_true(isinf(c->fluids[0].sound_speed));
    assert_string_equal(c->scheme.name, "incompressible");
    assert_true(c->scheme.kernel == MNS_QUINTIC_SPLINE && c->scheme.smoothing == 1);
    assert_true(c->scheme.incompressible.reference_speed < 0); /* not given */
    assert_true(c->scheme.incompressible.iterations == 5000);
    mns_case_free(c);
    snprintf(one, sizeof one, text, "riemann");
    refuses(one, "fluids[0].sound_speed", ": missing, required: (0, inf) m/s");
}

static void motions_keep_their_numbers(void **state)
{
    (void)state;
    MnsCase *c =
        translated("dimensions: 2\nresolution: 10\ndomain: {min: [0, 0], max: [2, 1]}\nend_time: 1\n"
                   "fluids: [{name: water, density: 1000, sound_speed: 10}]\nwalls:\n"
                   "  - name: a\n    shape: [{ball: {centre: [0, 0], radius: 1}}]\n"
                   "    motion: {sine: {amplitude: [1, 2], frequency: 3, phase: 4}}\n"
                   "  - name: b\n    slip: none\n    shape: [{ball: {centre: [0, 0], radius: 1}}]\n"
                   "    motion: {table: {points: [{t: 0, x: [0, 0], v: [1, 2]}, {t: 2, x: [3, 4], v: [5, 6]}]}}\n");
    const MnsMotion *sine = &c->walls[0].motion, *table = &c->walls[1].motion;
    assert_true(sine->kind == MNS_SINE && sine->amplitude[1] == 2 && sine->frequency == 3 && sine->phase == 4);
    assert_true(table->kind == MNS_TABLE && table->n == 2 && table->points[1].t == 2);
    assert_true(table->points[0].v[1] == 2 && table->points[1].x[0] == 3 && table->points[1].v[1] == 6);
    assert_true(!c->walls[0].no_slip && c->walls[1].no_slip);
    mns_case_free(c);
}

static void probes_find_what_they_name(void **state)
{
    (void)state;
    MnsCase *c = translated(
        HEAD "probes:\n"
             "  - {name: p, pressure: {wall: tank, at: [2, 0.5], radius: 0.1}}\n"
             "  - {name: h, height: {fluid: air, at: [0.7]}}\n"
             "  - {name: s, height: {fluid: air, at: [0.7], vertical: x}}\n"
             "  - {name: f, front: {fluid: air, axis: y, backwards: true, within: {min: [0, 1], max: [2, 3]}}}\n"
             "  - {name: e, extremum: {field: velocity, which: min}}\n"
             "  - {name: d, pressure_deviation: {fluid: air, from: 2*y}}\n");
    const MnsProbe *p = c->probes;
    assert_true(p[0].kind == MNS_PROBE_PRESSURE && p[0].wall == 0 && p[0].at[1] == 0.5 && p[0].radius == 0.1);
    assert_true(p[1].kind == MNS_PROBE_HEIGHT && p[1].fluid == 1 && p[1].axis == 1 && p[1].at[0] == 0.7);
    assert_true(p[2].axis == 0 && p[2].at[1] == 0.7 && p[2].at[0] == 0 && p[2].wall == -1);
    assert_true(p[3].kind == MNS_PROBE_FRONT && p[3].least && p[3].axis == 1 && p[3].within && p[3].max[1] == 3);
    assert_true(p[4].kind == MNS_PROBE_EXTREMUM && p[4].least && p[4].fluid == -1);
    assert_string_equal(p[4].field, "velocity");
    assert_string_equal(p[5].formula, "2*y");
    assert_string_equal(p[0].field, "");
    mns_case_free(c);
}

static void probes_of_surfaces_find_what_they_name(void **state)
{
    (void)state;
    MnsCase *c = translated(
        HEAD "probes:\n"
             "  - {name: e, elevation: {at: [0.7]}}\n"
             "  - {name: i, elevation: {fluids: [air, water], at: [0.7], vertical: x, wall: tank, which: max}}\n"
             "  - {name: o, elevation: {fluids: [air], at: [0.7]}}\n"
             "  - {name: x, extent: {fluid: air}}\n"
             "  - {name: y, extent: {fluid: air, axis: y, which: min, within: {min: [0, 1], max: [2, 3]}}}\n"
             "  - {name: j, pressure_jump: {inside: air, margin: 0.1}}\n"
             "  - {name: v, velocity: {fluid: air, axis: y}}\n"
             "  - {name: r, roundness: {fluid: air}}\n"
             "  - {name: s, surface_area: {}}\n"
             "  - {name: m, volume: {fluid: water}}\n"
             "  - {name: q, mass_centre: {fluid: air, axis: y, within: {min: [0, 1], max: [2, 3]}}}\n"
             "  - {name: z, solver: {of: correction-iterations}}\n");
    const MnsProbe *p = c->probes;
    assert_true(p[0].kind == MNS_PROBE_ELEVATION && p[0].fluids == 0 && p[0].least && p[0].axis == 1);
    assert_true(p[0].at[0] == 0.7 && p[0].wall == -1);
    assert_true(p[1].fluids == 3 && !p[1].least && p[1].axis == 0 && p[1].at[1] == 0.7 && p[1].wall == 0);
    assert_true(p[2].fluids == 2);
    assert_true(p[3].kind == MNS_PROBE_EXTENT && p[3].fluid == 1 && !p[3].least && p[3].axis == 0 && !p[3].within);
    assert_true(p[4].axis == 1 && p[4].least && p[4].within && p[4].max[1] == 3);
    assert_true(p[5].kind == MNS_PROBE_PRESSURE_JUMP && p[5].fluid == 1 && p[5].radius == 0.1);
    assert_true(p[6].kind == MNS_PROBE_VELOCITY && p[6].fluid == 1 && p[6].axis == 1);
    assert_true(p[7].kind == MNS_PROBE_ROUNDNESS && p[7].fluid == 1);
    assert_true(p[10].kind == MNS_PROBE_MASS_CENTRE && p[10].within && p[10].max[1] == 3 && p[10].axis == 1);
    assert_true(p[11].kind == MNS_PROBE_SOLVER && p[11].quantity == MNS_SOLVER_CORRECTION_ITERATIONS);
    assert_true(p[8].kind == MNS_PROBE_SURFACE_AREA && p[8].fluid == -1);
    assert_true(p[9].kind == MNS_PROBE_VOLUME && p[9].fluid == 0);
    mns_case_free(c);
    refuses(HEAD "probes: [{name: e, elevation: {fluids: [air, oil], at: [0]}}]\n", "probes[0].elevation.fluids[1]",
            ": there is no fluid \"oil\", allowed: water, air");
    refuses(HEAD "probes: [{name: e, elevation: {fluids: [air, air], at: [0]}}]\n", "probes[0].elevation.fluids[1]",
            ": \"air\" is there twice");
    refuses(HEAD "probes: [{name: e, elevation: {at: [0, 1]}}]\n", "probes[0].elevation.at",
            ": found a list of 2, allowed: a list of 1, the coordinates across the vertical axis");
    refuses(HEAD "probes: [{name: j, pressure_jump: {inside: oil}}]\n", "probes[0].pressure_jump.inside",
            ": there is no fluid \"oil\", allowed: water, air");
}

/* All members of the message but the first, which is the name. */
static void every_kind_of_probe_has_the_same_name_for_the_solver(void **state)
{
    (void)state;
    const ProtobufCMessageDescriptor *d = &meniscus__probe__descriptor;
    for (unsigned k = 1; k < d->n_fields; k++) {
        const MnsProbe probe = {.kind = (MnsProbeKind)(k - 1)};
        assert_non_null(probe_kind(&probe));
        assert_string_equal(probe_kind(&probe)->name, d->fields[k].name);
    }
    assert_null(probe_kind(&(MnsProbe){.kind = (MnsProbeKind)(d->n_fields - 1)}));
}

static void names_of_nothing_get_a_suggestion(void **state)
{
    (void)state;
    refuses(HEAD "probes: [{name: p, pressure: {wall: tnak, at: [0, 0]}}]\n", "probes[0].pressure.wall",
            ": there is no wall \"tnak\", did you mean \"tank\"? Allowed: tank");
    refuses(HEAD "probes: [{name: p, mass: {}}, {name: q, mass: {fluid: oil}}]\n", "probes[1].mass.fluid",
            ": there is no fluid \"oil\", allowed: water, air");
    MnsCase *c = NULL;
    MnsError error = {0};
    assert_int_equal(translate(HEAD "output: {fields: [velocity, presure]}\n", &c, &error), MNS_E_INVALID);
    assert_string_equal(error.path, "output.fields[1]");
    assert_non_null(strstr(error.text, "there is no field \"presure\", did you mean \"pressure\"?"));
}

static void names_must_differ_and_be_plain(void **state)
{
    (void)state;
    refuses(HEAD "probes: [{name: p, mass: {}}, {name: p, mass: {}}]\n", "probes[1].name",
            ": found \"p\", which probe 0 has too: names must differ");
    refuses(HEAD "probes: [{name: a b, mass: {}}]\n", "probes[0].name",
            ": found \"a b\", allowed: up to 100 letters, digits, dots, dashes and underscores, the first of them "
            "neither a dot nor a dash");
    refuses(HEAD "probes: [{name: \"\", mass: {}}]\n", "probes[0].name",
            ": found \"\", allowed: up to 100 letters, digits, dots, dashes and underscores, the first of them neither "
            "a dot nor a dash");
    refuses(HEAD "constants: [{name: a, value: 1}, {name: a, value: 2}]\n", "constants[1].name",
            ": found \"a\", which constant 0 has too: names must differ");
    refuses(HEAD "constants: [{name: 1a, value: 1}]\n", "constants[0].name",
            ": found \"1a\", allowed: letters, digits and underscores, a letter or an underscore first");
    refuses(HEAD "output: {fields: [velocity, velocity]}\n", "output.fields[1]", ": \"velocity\" is there twice");
}

static void lists_have_an_item_for_each_dimension(void **state)
{
    (void)state;
    refuses(HEAD "gravity: [0, 0, 1]\n", "gravity",
            ": found a list of 3, allowed: a list of 2, one formula for each dimension");
    refuses(HEAD "probes: [{name: p, pressure: {at: [0, 0, 1]}}]\n", "probes[0].pressure.at",
            ": found a list of 3, allowed: a list of 2, one number for each dimension");
    refuses(HEAD "probes: [{name: h, height: {fluid: air, at: [0, 1]}}]\n", "probes[0].height.at",
            ": found a list of 2, allowed: a list of 1, the coordinates across the vertical axis");
    refuses("dimensions: 3\nresolution: 10\ndomain: {min: [0, 0], max: [2, 1]}\nend_time: 1\n"
            "fluids: [{name: water, density: 1000, sound_speed: 10}]\n",
            "domain.min", ": found a list of 2, allowed: a list of 3, one number for each dimension");
}

static void two_dimensions_have_no_z(void **state)
{
    (void)state;
    refuses(HEAD "probes: [{name: m, momentum: {axis: z}}]\n", "probes[0].momentum.axis",
            ": found \"z\", allowed in two dimensions: x, y");
    refuses("dimensions: 2\nresolution: 10\ndomain: {min: [0, 0], max: [2, 1], periodic: [x, z]}\nend_time: 1\n"
            "fluids: [{name: water, density: 1000, sound_speed: 10}]\n",
            "domain.periodic[1]", ": found \"z\", allowed in two dimensions: x, y");
}

static void what_makes_no_sense_is_refused(void **state)
{
    (void)state;
    refuses("dimensions: 2\nresolution: 10\ndomain: {min: [0, 0], max: [0, 1]}\nend_time: 1\n"
            "fluids: [{name: water, density: 1000, sound_speed: 10}]\n",
            "domain.max", ": found 0 in direction x, allowed: above 0, the lower corner");
    static const char walls[] = "dimensions: 2\nresolution: 10\ndomain: {min: [0, 0], max: [2, 1]}\nend_time: 1\n"
                                "fluids: [{name: water, density: 1000, sound_speed: 10}]\n"
                                "walls: [{name: w, shape: [{%s}]%s}]\n";
    char text[600];
    snprintf(text, sizeof text, walls, "formula: x < 1", "");
    refuses(text, "walls[0].shape[0].formula",
            ": only a fluid's shape can be a formula: use box, ball, cylinder, plate or half_space");
    snprintf(text, sizeof text, walls, "plate: {centre: [0, 0], along: [1, 0], length: 1, width: 1, thickness: 1}", "");
    refuses(text, "walls[0].shape[0].plate.width", ": in two dimensions a plate has none: remove it");
    snprintf(text, sizeof text, walls, "ball: {centre: [0, 0], radius: 1}",
             ", motion: {one_minus_cosine: {amplitude: [1, 0], frequency: 1, phase: 1}}");
    refuses(text, "walls[0].motion.one_minus_cosine.phase", ": only a sine has a phase: remove it");
    snprintf(text, sizeof text, walls, "ball: {centre: [0, 0], radius: 1}",
             ", motion: {table: {points: [{t: 1, x: [0, 0], v: [0, 0]}, {t: 1, x: [0, 0], v: [0, 0]}]}}");
    refuses(text, "walls[0].motion.table.points[1].t", ": found 1, allowed: above 1, the time of the point before");
}

static void more_fluids_than_the_solver_knows_are_refused(void **state)
{
    (void)state;
    char text[4000] = "dimensions: 2\nresolution: 10\ndomain: {min: [0, 0], max: [2, 1]}\nend_time: 1\nfluids:\n";
    for (int k = 0; k < MNS_MAX_FLUIDS + 1; k++) {
        const size_t n = strlen(text);
        snprintf(text + n, sizeof text - n, "  - {name: f%d, density: 1, sound_speed: 10}\n", k);
    }
    MnsCase *c = NULL;
    MnsError error = {0};
    assert_int_equal(translate(text, &c, &error), MNS_E_LIMIT);
    assert_string_equal(error.text, "fluids: found a list of 17, allowed: at most 16");
}

static void cases_are_found_by_name_and_by_path(void **state)
{
    (void)state;
    char path[4096];
    MnsError error = {0};
    assert_int_equal(case_find("dambreak2d", path, &error), MNS_OK);
    assert_non_null(strstr(path, "server/cases/dambreak2d.yaml"));
    assert_int_equal(case_find("server/cases/sloshing2d.yaml", path, &error), MNS_OK);
    assert_string_equal(path, "server/cases/sloshing2d.yaml");
    assert_int_equal(case_find("/tmp", path, &error), MNS_E_INVALID);
    assert_non_null(strstr(error.text, "a directory"));
    assert_int_equal(case_find("/dev/null", path, &error), MNS_E_INVALID);
    assert_int_equal(case_find("dambrake", path, &error), MNS_E_NOT_FOUND);
    assert_non_null(strstr(error.text, "there is no case \"dambrake\""));
    assert_non_null(strstr(error.text, "server/cases; "));
    assert_non_null(strstr(error.text, ", cavity2d, "));
    const char *rest = strstr(error.text, " more (`meniscus completion cases` lists all)");
    assert_non_null(rest); /* there are too many to name them all */
    assert_int_equal(rest[strlen(" more (`meniscus completion cases` lists all)")], 0);
    assert_null(strstr(error.text, "did you mean"));
    assert_int_equal(case_find("dambraek2d", path, &error), MNS_E_NOT_FOUND);
    assert_non_null(strstr(error.text, "did you mean \"dambreak2d\"? Allowed: bubble-in-water2d, "));
}

static void the_folder_asked_for_comes_first(void **state)
{
    (void)state;
    char folder[] = "/tmp/meniscus-cases-XXXXXX", file[64], path[4096];
    assert_non_null(mkdtemp(folder));
    snprintf(file, sizeof file, "%s/dambreak2d.yaml", folder);
    FILE *out = fopen(file, "w");
    assert_non_null(out);
    fclose(out);
    setenv("MENISCUS_CASES", folder, 1);
    const MnsStatus status = case_find("dambreak2d", path, NULL);
    unsetenv("MENISCUS_CASES");
    unlink(file);
    rmdir(folder);
    assert_int_equal(status, MNS_OK);
    assert_string_equal(path, file);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_absent_has_its_default),
        cmocka_unit_test(shapes_keep_their_numbers),
        cmocka_unit_test(every_choice_of_the_schema_is_translated),
        cmocka_unit_test(only_what_can_be_compressed_needs_a_speed_of_sound),
        cmocka_unit_test(motions_keep_their_numbers),
        cmocka_unit_test(probes_find_what_they_name),
        cmocka_unit_test(probes_of_surfaces_find_what_they_name),
        cmocka_unit_test(every_kind_of_probe_has_the_same_name_for_the_solver),
        cmocka_unit_test(names_of_nothing_get_a_suggestion),
        cmocka_unit_test(names_must_differ_and_be_plain),
        cmocka_unit_test(lists_have_an_item_for_each_dimension),
        cmocka_unit_test(two_dimensions_have_no_z),
        cmocka_unit_test(what_makes_no_sense_is_refused),
        cmocka_unit_test(more_fluids_than_the_solver_knows_are_refused),
        cmocka_unit_test(cases_are_found_by_name_and_by_path),
        cmocka_unit_test(the_folder_asked_for_comes_first),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
