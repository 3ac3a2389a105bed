/* SPDX-License-Identifier: BSD-3-Clause */
/* What the files of the translation share: the place in the message, and how texts, vectors and names are taken
 * over. */
#ifndef CASES_TRANSLATION_H
#define CASES_TRANSLATION_H

#include "case.pb-c.h"
#include "common/case/value.h"
#include <meniscus/case.h>

typedef struct Translation {
    MnsCase *c; /* filled as the walk goes on; fluids and walls before probes */
    CasePath path;
    MnsError *error;
} Translation;

/* Name and number of the things a name may stand for. */
typedef struct Names {
    const char *what; /* "fluid" */
    const char *all;  /* the command that lists them, where they may be too many for a sentence; or NULL */
    size_t n;
    const char *list[MNS_MAX_PROBES];
} Names;

/* Step into an entry, or into an item of its list; leave with case_path_cut(). Both return the length before. */
size_t translation_enter(Translation *t, const char *name);
size_t translation_enter_item(Translation *t, const char *name, size_t k);

/* Complain about an entry within the present place; name may be NULL for the place itself. */
MnsStatus translation_fail(Translation *t, MnsStatus status, const char *name, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

/* Complain about the present place, a oneof of which the member that is there is not known here. The switches over such members
 * have no default but name all values, of which one only gives the type its size: so the compiler tells of a new member. */
MnsStatus translation_unknown(Translation *t);

MnsStatus take_text(Translation *t, const char *text, char **ret);

/* One number for each dimension. */
MnsStatus take_vector(Translation *t, const char *name, size_t n, const double *values, double ret[3]);

/* One formula for each dimension; none at all means 0. */
MnsStatus take_formulas(Translation *t, const char *name, size_t n, char *const *formulas, char *ret[3]);

/* A name of letters, digits, dot, dash and underscore that none of the names before it is like. */
MnsStatus take_name(Translation *t, const char *name, const Names *before, char **ret);

/* Index of a name. */
MnsStatus take_reference(Translation *t, const char *entry, const char *name, const Names *names, int *ret);

/* An axis that the case has. */
MnsStatus take_axis(Translation *t, const char *name, Meniscus__Axis axis, int *ret);

MnsStatus take_box(Translation *t, const Meniscus__Box *box, double min[3], double max[3]);

/* At most `limit` items. */
MnsStatus check_limit(Translation *t, const char *name, size_t n, size_t limit);

void names_of_fluids(const MnsCase *c, Names *ret);
void names_of_walls(const MnsCase *c, Names *ret);
void names_of_fields(Names *ret);

MnsStatus translate_shape(Translation *t, size_t n, Meniscus__Part *const *parts, bool formulas, MnsShape *ret);
MnsStatus translate_motion(Translation *t, const Meniscus__Motion *message, MnsMotion *ret);
MnsStatus translate_probes(Translation *t, const Meniscus__Case *message);

#endif
