/* SPDX-License-Identifier: BSD-3-Clause */
/* Shapes and motions: vectors get their dimensions checked, a oneof becomes a kind. */
#include "cases/translation.h"
#include <stdlib.h>

static MnsStatus take_ball(Translation *t, const Meniscus__Ball *m, MnsPart *part)
{
    part->primitive = MNS_BALL;
    part->radius = m->radius;
    return take_vector(t, "centre", m->n_centre, m->centre, part->a);
}

static MnsStatus take_cylinder(Translation *t, const Meniscus__Cylinder *m, MnsPart *part)
{
    part->primitive = MNS_CYLINDER;
    part->radius = m->radius;
    const MnsStatus status = take_vector(t, "from", m->n_from, m->from, part->a);
    return status ? status : take_vector(t, "to", m->n_to, m->to, part->b);
}

/* In two dimensions a plate has neither normal nor width, in three it needs both. */
static MnsStatus check_plate(Translation *t, const Meniscus__Plate *m)
{
    const bool needed = t->c->dim == 3;
    if ((m->n_normal > 0) != needed)
        return translation_fail(t, MNS_E_INVALID, "normal",
                                needed ? "missing, required in three dimensions: a list of 3"
                                       : "in two dimensions a plate has none: remove it");
    if (m->has_width != needed)
        return translation_fail(t, MNS_E_INVALID, "width",
                                needed ? "missing, required in three dimensions: (0, inf) m"
                                       : "in two dimensions a plate has none: remove it");
    return MNS_OK;
}

static MnsStatus take_plate(Translation *t, const Meniscus__Plate *m, MnsPart *part)
{
    part->primitive = MNS_PLATE;
    part->length = m->length;
    part->width = m->width;
    part->thickness = m->thickness;
    MnsStatus status = take_vector(t, "centre", m->n_centre, m->centre, part->a);
    if (!status) status = take_vector(t, "along", m->n_along, m->along, part->b);
    if (!status) status = check_plate(t, m);
    if (!status && t->c->dim == 3) status = take_vector(t, "normal", m->n_normal, m->normal, part->c);
    return status;
}

static MnsStatus take_half_space(Translation *t, const Meniscus__HalfSpace *m, MnsPart *part)
{
    part->primitive = MNS_HALF_SPACE;
    const MnsStatus status = take_vector(t, "point", m->n_point, m->point, part->a);
    return status ? status : take_vector(t, "normal", m->n_normal, m->normal, part->b);
}

static MnsStatus take_formula(Translation *t, const Meniscus__Part *m, bool formulas, MnsPart *part)
{
    part->primitive = MNS_FORMULA;
    if (!formulas)
        return translation_fail(t, MNS_E_INVALID, "formula",
                                "only a fluid's shape can be a formula: use box, ball, "
                                "cylinder, plate or half_space");
    return take_text(t, m->formula, &part->formula);
}

static MnsStatus take_primitive(Translation *t, const Meniscus__Part *m, bool formulas, MnsPart *part)
{
    size_t before = t->path.n;
    MnsStatus status = MNS_E_INTERNAL;
    switch (m->primitive_case) {
    case MENISCUS__PART__PRIMITIVE_BOX:
        part->primitive = MNS_BOX;
        before = translation_enter(t, "box");
        status = take_box(t, m->box, part->a, part->b);
        break;
    case MENISCUS__PART__PRIMITIVE_BALL:
        before = translation_enter(t, "ball");
        status = take_ball(t, m->ball, part);
        break;
    case MENISCUS__PART__PRIMITIVE_CYLINDER:
        before = translation_enter(t, "cylinder");
        status = take_cylinder(t, m->cylinder, part);
        break;
    case MENISCUS__PART__PRIMITIVE_PLATE:
        before = translation_enter(t, "plate");
        status = take_plate(t, m->plate, part);
        break;
    case MENISCUS__PART__PRIMITIVE_HALF_SPACE:
        before = translation_enter(t, "half_space");
        status = take_half_space(t, m->half_space, part);
        break;
    case MENISCUS__PART__PRIMITIVE_FORMULA: status = take_formula(t, m, formulas, part); break;
    case MENISCUS__PART__PRIMITIVE__NOT_SET:
    case _MENISCUS__PART__PRIMITIVE__CASE_IS_INT_SIZE: status = translation_unknown(t); break;
    }
    case_path_cut(&t->path, before);
    return status;
}

MnsStatus translate_shape(Translation *t, size_t n, Meniscus__Part *const *parts, bool formulas, MnsShape *ret)
{
    static const MnsOperation operations[] = {
        [MENISCUS__OPERATION__ADD] = MNS_ADD,
        [MENISCUS__OPERATION__SUBTRACT] = MNS_SUBTRACT,
        [MENISCUS__OPERATION__INTERSECT] = MNS_INTERSECT,
    };
    MnsStatus status = MNS_OK;
    if (!n) return MNS_OK;
    ret->parts = calloc(n, sizeof *ret->parts);
    if (!ret->parts) return case_no_memory(t->error);
    ret->n = n;
    for (size_t k = 0; k < n && !status; k++) {
        const size_t before = translation_enter_item(t, "shape", k);
        ret->parts[k].operation = operations[parts[k]->operation];
        ret->parts[k].outside = parts[k]->outside;
        status = take_primitive(t, parts[k], formulas, &ret->parts[k]);
        case_path_cut(&t->path, before);
    }
    return status;
}

static MnsStatus take_oscillation(Translation *t, const char *name, const Meniscus__Oscillation *m, MnsMotion *ret)
{
    const size_t before = translation_enter(t, name);
    ret->frequency = m->frequency;
    ret->phase = m->phase;
    MnsStatus status = take_vector(t, "amplitude", m->n_amplitude, m->amplitude, ret->amplitude);
    if (!status && ret->kind == MNS_ONE_MINUS_COSINE && m->has_phase)
        status = translation_fail(t, MNS_E_INVALID, "phase", "only a sine has a phase: remove it");
    case_path_cut(&t->path, before);
    return status;
}

static MnsStatus take_point(Translation *t, const Meniscus__MotionPoint *m, const MnsMotionPoint *last,
                            MnsMotionPoint *ret)
{
    ret->t = m->t;
    if (last && m->t <= last->t)
        return translation_fail(t, MNS_E_INVALID, "t", "found %g, allowed: above %g, the time of the point before",
                                m->t, last->t);
    const MnsStatus status = take_vector(t, "x", m->n_x, m->x, ret->x);
    return status ? status : take_vector(t, "v", m->n_v, m->v, ret->v);
}

static MnsStatus take_table(Translation *t, const Meniscus__MotionTable *m, MnsMotion *ret)
{
    MnsStatus status = MNS_OK;
    ret->points = calloc(m->n_points, sizeof *ret->points);
    if (!ret->points) return case_no_memory(t->error);
    ret->n = m->n_points;
    const size_t outer = translation_enter(t, "table");
    for (size_t k = 0; k < ret->n && !status; k++) {
        const size_t before = translation_enter_item(t, "points", k);
        status = take_point(t, m->points[k], k ? &ret->points[k - 1] : NULL, &ret->points[k]);
        case_path_cut(&t->path, before);
    }
    case_path_cut(&t->path, outer);
    return status;
}

MnsStatus translate_motion(Translation *t, const Meniscus__Motion *message, MnsMotion *ret)
{
    const size_t before = translation_enter(t, "motion");
    MnsStatus status = MNS_E_INTERNAL;
    switch (message->kind_case) {
    case MENISCUS__MOTION__KIND_SINE:
        ret->kind = MNS_SINE;
        status = take_oscillation(t, "sine", message->sine, ret);
        break;
    case MENISCUS__MOTION__KIND_ONE_MINUS_COSINE:
        ret->kind = MNS_ONE_MINUS_COSINE;
        status = take_oscillation(t, "one_minus_cosine", message->one_minus_cosine, ret);
        break;
    case MENISCUS__MOTION__KIND_TABLE:
        ret->kind = MNS_TABLE;
        status = take_table(t, message->table, ret);
        break;
    case MENISCUS__MOTION__KIND__NOT_SET:
    case _MENISCUS__MOTION__KIND__CASE_IS_INT_SIZE: status = translation_unknown(t); break;
    }
    case_path_cut(&t->path, before);
    return status;
}
