/* SPDX-License-Identifier: BSD-3-Clause */
/* Texts, vectors and names of a case message, taken over one by one. */
#include "cases/translation.h"
#include "common/case/name.h"
#include "common/case/words.h"
#include <meniscus/sim.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

size_t translation_enter(Translation *t, const char *name)
{
    return case_path_name(&t->path, name, strlen(name));
}

size_t translation_enter_item(Translation *t, const char *name, size_t k)
{
    const size_t before = translation_enter(t, name);
    case_path_index(&t->path, k);
    return before;
}

MnsStatus translation_fail(Translation *t, MnsStatus status, const char *name, const char *format, ...)
{
    char sentence[400];
    va_list list;
    va_start(list, format);
    vsnprintf(sentence, sizeof sentence, format, list);
    va_end(list);
    const size_t before = name ? translation_enter(t, name) : t->path.n;
    case_fail(t->error, status, t->path.text, "%s", sentence);
    case_path_cut(&t->path, before);
    return status;
}

MnsStatus translation_unknown(Translation *t)
{
    return translation_fail(t, MNS_E_INVALID, NULL,
                            "found nothing of what is allowed here, or what this program is too old for");
}

MnsStatus take_text(Translation *t, const char *text, char **ret)
{
    *ret = strdup(text);
    return *ret ? MNS_OK : case_no_memory(t->error);
}

static MnsStatus check_dimensions(Translation *t, const char *name, size_t n, const char *what)
{
    if (n == (size_t)t->c->dim) return MNS_OK;
    return translation_fail(t, MNS_E_INVALID, name,
                            "found a list of %zu, allowed: a list of %d, one %s for each dimension", n, t->c->dim,
                            what);
}

MnsStatus take_vector(Translation *t, const char *name, size_t n, const double *values, double ret[3])
{
    const MnsStatus status = check_dimensions(t, name, n, "number");
    for (size_t d = 0; d < n && !status; d++) ret[d] = values[d];
    return status;
}

MnsStatus take_formulas(Translation *t, const char *name, size_t n, char *const *formulas, char *ret[3])
{
    MnsStatus status = n ? check_dimensions(t, name, n, "formula") : MNS_OK;
    for (size_t d = 0; d < 3 && !status; d++) status = take_text(t, d < n ? formulas[d] : "0", &ret[d]);
    return status;
}

MnsStatus take_name(Translation *t, const char *name, const Names *before, char **ret)
{
    char shown[48];
    if (!is_name(name))
        return translation_fail(t, MNS_E_INVALID, "name",
                                "found \"%s\", allowed: up to 100 letters, digits, dots, dashes and underscores, the "
                                "first of them neither a dot nor a dash",
                                case_shown(name, shown));
    for (size_t k = 0; k < before->n; k++)
        if (!strcmp(before->list[k], name))
            return translation_fail(t, MNS_E_INVALID, "name", "found \"%s\", which %s %zu has too: names must differ",
                                    case_shown(name, shown), before->what, k);
    return take_text(t, name, ret);
}

MnsStatus take_reference(Translation *t, const char *entry, const char *name, const Names *names, int *ret)
{
    char allowed[300], shown[48];
    for (size_t k = 0; k < names->n; k++)
        if (!strcmp(names->list[k], name)) {
            *ret = (int)k;
            return MNS_OK;
        }
    words_suggest(names->list, names->n, name, names->all, allowed, sizeof allowed);
    return translation_fail(t, MNS_E_INVALID, entry, "there is no %s \"%s\", %s", names->what, case_shown(name, shown),
                            names->n ? allowed : "there is none at all");
}

MnsStatus take_axis(Translation *t, const char *name, Meniscus__Axis axis, int *ret)
{
    if ((int)axis >= t->c->dim)
        return translation_fail(t, MNS_E_INVALID, name, "found \"z\", allowed in two dimensions: x, y");
    *ret = (int)axis;
    return MNS_OK;
}

MnsStatus take_box(Translation *t, const Meniscus__Box *box, double min[3], double max[3])
{
    MnsStatus status = take_vector(t, "min", box->n_min, box->min, min);
    if (!status) status = take_vector(t, "max", box->n_max, box->max, max);
    for (int d = 0; d < t->c->dim && !status; d++)
        if (min[d] >= max[d])
            status = translation_fail(t, MNS_E_INVALID, "max",
                                      "found %g in direction %c, allowed: above %g, the lower corner", max[d], "xyz"[d],
                                      min[d]);
    return status;
}

MnsStatus check_limit(Translation *t, const char *name, size_t n, size_t limit)
{
    if (n <= limit) return MNS_OK;
    return translation_fail(t, MNS_E_LIMIT, name, "found a list of %zu, allowed: at most %zu", n, limit);
}

void names_of_fluids(const MnsCase *c, Names *ret)
{
    *ret = (Names){.what = "fluid", .n = c->n_fluids};
    for (size_t k = 0; k < c->n_fluids; k++) ret->list[k] = c->fluids[k].name;
}

void names_of_walls(const MnsCase *c, Names *ret)
{
    *ret = (Names){.what = "wall", .n = c->n_walls};
    for (size_t k = 0; k < c->n_walls; k++) ret->list[k] = c->walls[k].name;
}

void names_of_fields(Names *ret)
{
    *ret = (Names){.what = "field", .all = "`meniscus capabilities`"};
    for (const MnsFieldInfo *field = mns_fields(); field->name; field++) ret->list[ret->n++] = field->name;
}
