/* SPDX-License-Identifier: BSD-3-Clause */
/* The table that schema.py makes, and the manual beside it. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "cases/translate.h"
#include "common/case/value.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static size_t walk(const ProtobufCMessageDescriptor *type, void (*visit)(const ProtobufCMessageDescriptor *, unsigned))
{
    size_t n = 0;
    for (unsigned k = 0; k < type->n_fields; k++) {
        visit(type, k);
        n++;
        if (type->fields[k].type == PROTOBUF_C_TYPE_MESSAGE) n += walk(type->fields[k].descriptor, visit);
    }
    return n;
}

static void has_a_row_with_a_meaning(const ProtobufCMessageDescriptor *type, unsigned k)
{
    const CaseSchema *schema = case_schema_of(type);
    assert_non_null(schema);
    assert_int_equal(schema->n, type->n_fields);
    assert_string_equal(schema->entries[k].name, type->fields[k].name);
    assert_true(strlen(schema->entries[k].meaning) > 3);
}

/* walk() ends only if the schema is not recursive, which is what bounds the nesting of every message. */
static void every_entry_has_a_row_with_a_meaning(void **state)
{
    (void)state;
    assert_true(walk(&meniscus__case__descriptor, has_a_row_with_a_meaning) > 100);
}

static void default_is_within_bounds(const ProtobufCMessageDescriptor *type, unsigned k)
{
    const CaseEntry *entry = &case_schema_of(type)->entries[k];
    const ProtobufCFieldDescriptor *field = &type->fields[k];
    if (!*entry->range) return;
    assert_true(entry->min < entry->max);
    if (field->type != PROTOBUF_C_TYPE_DOUBLE || !field->default_value) return;
    const double value = *(const double *)field->default_value;
    assert_true(entry->min_open ? value > entry->min : value >= entry->min);
    assert_true(entry->max_open ? value < entry->max : value <= entry->max);
}

static void every_default_is_within_its_bounds(void **state)
{
    (void)state;
    walk(&meniscus__case__descriptor, default_is_within_bounds);
}

static void comments_become_units_bounds_and_counts(void **state)
{
    (void)state;
    const ProtobufCMessageDescriptor *fluid = &meniscus__fluid__descriptor, *box = &meniscus__box__descriptor;
    const CaseEntry *density = case_entry_of(fluid, case_field_named(fluid, "density", 7));
    assert_string_equal(density->unit, "kg/m^3");
    assert_string_equal(density->range, "[1e-9, 1e9]");
    assert_true(density->min == 1e-9 && !density->min_open && density->required && !density->steerable);
    const CaseEntry *sound_speed = case_entry_of(fluid, case_field_named(fluid, "sound_speed", 11));
    assert_string_equal(sound_speed->range, "(0, inf)");
    assert_true(sound_speed->min == 0 && sound_speed->min_open);
    const CaseEntry *corner = case_entry_of(box, case_field_named(box, "min", 3));
    assert_int_equal(corner->count_min, 2);
    assert_int_equal(corner->count_max, 3);
}

static void steerable_parameters_can_be_got_by_their_path(void **state)
{
    (void)state;
    Meniscus__Case message = MENISCUS__CASE__INIT;
    size_t n;
    const CaseParameter *parameters = case_parameters(&n);
    assert_true(n >= 8);
    for (size_t k = 0; k < n; k++) {
        char *text;
        const char *unit;
        assert_int_equal(case_message_get(&message, parameters[k].path, &text, &unit, NULL), MNS_OK);
        assert_string_equal(unit, parameters[k].unit);
        free(text);
    }
}

static char *read_file(const char *path, size_t *ret_size)
{
    FILE *in = fopen(path, "r");
    assert_non_null(in);
    char *text = malloc(1 << 20);
    assert_non_null(text);
    *ret_size = fread(text, 1, (1 << 20) - 1, in);
    text[*ret_size] = 0;
    fclose(in);
    return text;
}

static void the_example_of_the_manual_is_a_case(void **state)
{
    (void)state;
    MnsError error = {0};
    CaseFile *file;
    MnsCase *c;
    size_t size;
    char *manual = read_file("server/cases/REFERENCE.md", &size);
    char *begin = strstr(manual, "```yaml\n");
    assert_non_null(begin);
    begin += strlen("```yaml\n");
    const char *end = strstr(begin, "```");
    assert_non_null(end);
    if (case_file_parse("REFERENCE.md", begin, (size_t)(end - begin), &file, &error)) fail_msg("%s", error.text);
    if (case_translate(case_file_message(file), &c, &error)) fail_msg("%s", error.text);
    assert_int_equal(mns_case_check(c, &error), MNS_OK);
    mns_case_free(c);
    case_file_free(file);
    free(manual);
}

static void the_manual_names_every_steerable_entry(void **state)
{
    (void)state;
    size_t size, n;
    char *manual = read_file("server/cases/REFERENCE.md", &size);
    const CaseParameter *parameters = case_parameters(&n);
    for (size_t k = 0; k < n; k++) {
        char row[128];
        snprintf(row, sizeof row, "| `%s` |", parameters[k].path);
        assert_non_null(strstr(manual, row));
    }
    free(manual);
}

/* | entry | type | unit | bounds | default | steerable | meaning |; a bar within a cell is escaped. */
static void the_manual_says_what_the_absence_of_each_entry_means(void **state)
{
    (void)state;
    size_t size, rows = 0;
    char *manual = read_file("server/cases/REFERENCE.md", &size);
    char *save = NULL;
    for (char *line = strtok_r(manual, "\n", &save); line; line = strtok_r(NULL, "\n", &save)) {
        char *cell[16];
        int n = 0;
        if (strncmp(line, "| `", 3) != 0) continue;
        for (char *bar = strchr(line, '|'); bar && n < 16; bar = strchr(bar + 1, '|'))
            if (bar == line || bar[-1] != '\\') cell[n++] = bar;
        if (n != 8) continue; /* of the table of steerable entries */
        if (cell[5] - cell[4] < 4) fail_msg("no default: %s", line);
        rows++;
    }
    assert_true(rows > 90);
    free(manual);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_entry_has_a_row_with_a_meaning),
        cmocka_unit_test(every_default_is_within_its_bounds),
        cmocka_unit_test(comments_become_units_bounds_and_counts),
        cmocka_unit_test(steerable_parameters_can_be_got_by_their_path),
        cmocka_unit_test(the_example_of_the_manual_is_a_case),
        cmocka_unit_test(the_manual_names_every_steerable_entry),
        cmocka_unit_test(the_manual_says_what_the_absence_of_each_entry_means),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
