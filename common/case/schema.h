/* SPDX-License-Identifier: BSD-3-Clause */
/* What the comments of case.proto say about each entry, as a table: made by proto/schema.py, read by every reader. */
#ifndef COMMON_CASE_SCHEMA_H
#define COMMON_CASE_SCHEMA_H

#include "common/case/file.h"
#include <protobuf-c/protobuf-c.h>
#include <stdbool.h>
#include <stddef.h>

typedef struct CaseEntry {
    const char *name;              /* as in case.proto and in files                                         */
    const char *unit;              /* "kg/m^3"; empty if there is none                                      */
    const char *range;             /* "(0, inf)"; empty if every finite number is allowed                   */
    double min, max;               /* the same as numbers                                                   */
    bool min_open, max_open;       /* whether the bound itself is refused                                   */
    unsigned count_min, count_max; /* items a list must have; 0, 0 if any number will do                    */
    const char *formula;           /* variables of a formula, "x y z"; NULL if it is not one                */
    bool required, steerable;
    bool of_required_choice; /* member of a oneof of which one must be there                          */
    bool is_default;         /* member of a oneof: what the absence of all members means              */
    const char *note;        /* what its words alone do not say, for who left it out; empty if there is nothing */
    const char *meaning;
} CaseEntry;

/* Entries of one message, in the order of its descriptor's fields. */
typedef struct CaseSchema {
    const char *message; /* "meniscus.Fluid" */
    size_t n;
    const CaseEntry *entries; /* [n] */
} CaseSchema;

extern const CaseSchema case_schemas[]; /* [case_schemas_n] */
extern const size_t case_schemas_n;

extern const CaseParameter case_steerables[]; /* [case_steerables_n] */
extern const size_t case_steerables_n;

#endif
