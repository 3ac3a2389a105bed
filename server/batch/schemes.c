/* SPDX-License-Identifier: BSD-3-Clause */
/* The schemes this program has, as text or as one JSON object. */
#include "batch/schemes.h"
#include <jansson.h>
#include <meniscus/exit.h>
#include <meniscus/sim.h>
#include <stdio.h>

enum { TEXT = 32768 };

static json_t *describe_all(void)
{
    static const size_t most = 100;
    json_t *list = json_array();
    char text[TEXT];
    const char *name;
    for (size_t k = 0; k < most && (name = mns_scheme_describe(k, text, sizeof text)); k++)
        json_array_append_new(list, json_pack("{ss ss}", "name", name, "meaning", text));
    return list;
}

static void print_text(const json_t *list)
{
    for (size_t k = 0; k < json_array_size(list); k++)
        printf("%s%s\n", k ? "\n" : "", json_string_value(json_object_get(json_array_get(list, k), "meaning")));
}

int schemes_print(bool json)
{
    json_t *list = describe_all(), *all = json_pack("{sO}", "schemes", list);
    if (json) {
        json_dumpf(all, stdout, JSON_COMPACT);
        putchar('\n');
    } else {
        print_text(list);
    }
    json_decref(all);
    json_decref(list);
    return MNS_EXIT_DONE;
}
