/* SPDX-License-Identifier: BSD-3-Clause */
/* Probes: fluids, walls and fields are found by name, coordinates put where they belong. */
#include "cases/translation.h"
#include <meniscus/sim.h>
#include <stdlib.h>

/* A fluid by name; all of them without one. */
static MnsStatus take_fluid(Translation *t, const char *name, MnsProbe *probe)
{
    Names fluids;
    names_of_fluids(t->c, &fluids);
    return name ? take_reference(t, "fluid", name, &fluids, &probe->fluid) : MNS_OK;
}

/* The wall it moves with; none without a name. */
static MnsStatus take_wall(Translation *t, const char *name, MnsProbe *probe)
{
    Names walls;
    names_of_walls(t->c, &walls);
    return name ? take_reference(t, "wall", name, &walls, &probe->wall) : MNS_OK;
}

static MnsStatus take_within(Translation *t, const Meniscus__Box *box, MnsProbe *probe)
{
    if (!box) return MNS_OK;
    const size_t before = translation_enter(t, "within");
    const MnsStatus status = take_box(t, box, probe->min, probe->max);
    probe->within = true;
    case_path_cut(&t->path, before);
    return status;
}

static MnsStatus take_pressure(Translation *t, const Meniscus__PointProbe *m, MnsProbe *probe)
{
    probe->kind = MNS_PROBE_PRESSURE;
    probe->radius = m->has_radius ? m->radius : 0;
    const MnsStatus status = take_wall(t, m->wall, probe);
    return status ? status : take_vector(t, "at", m->n_at, m->at, probe->at);
}

/* The line's coordinates are those across the vertical axis, in their order. */
static MnsStatus take_line(Translation *t, size_t n, const double *at, const Meniscus__Axis *vertical, MnsProbe *probe)
{
    MnsStatus status = MNS_OK;
    probe->axis = t->c->dim - 1;
    if (vertical) status = take_axis(t, "vertical", *vertical, &probe->axis);
    if (!status && n != (size_t)t->c->dim - 1)
        status = translation_fail(t, MNS_E_INVALID, "at",
                                  "found a list of %zu, allowed: a list of %d, the coordinates across "
                                  "the vertical axis",
                                  n, t->c->dim - 1);
    for (int d = 0, k = 0; d < t->c->dim && !status; d++)
        if (d != probe->axis) probe->at[d] = at[k++];
    return status;
}

static MnsStatus take_height(Translation *t, const Meniscus__HeightProbe *m, MnsProbe *probe)
{
    probe->kind = MNS_PROBE_HEIGHT;
    MnsStatus status = take_fluid(t, m->fluid, probe);
    if (!status) status = take_line(t, m->n_at, m->at, m->has_vertical ? &m->vertical : NULL, probe);
    return status ? status : take_wall(t, m->wall, probe);
}

/* A bit for each fluid that is named; none without names, which means all. */
static MnsStatus take_fluids(Translation *t, size_t n, char *const *names, MnsProbe *probe)
{
    Names fluids;
    MnsStatus status = MNS_OK;
    names_of_fluids(t->c, &fluids);
    for (size_t k = 0; k < n && !status; k++) {
        int fluid = 0;
        const size_t before = translation_enter_item(t, "fluids", k);
        status = take_reference(t, NULL, names[k], &fluids, &fluid);
        if (!status && probe->fluids >> fluid & 1)
            status = translation_fail(t, MNS_E_INVALID, NULL, "\"%s\" is there twice", names[k]);
        probe->fluids |= 1u << fluid;
        case_path_cut(&t->path, before);
    }
    return status;
}

static MnsStatus take_elevation(Translation *t, const Meniscus__ElevationProbe *m, MnsProbe *probe)
{
    probe->kind = MNS_PROBE_ELEVATION;
    probe->least = m->which == MENISCUS__EXTREMUM__MIN;
    MnsStatus status = take_fluids(t, m->n_fluids, m->fluids, probe);
    if (!status) status = take_line(t, m->n_at, m->at, m->has_vertical ? &m->vertical : NULL, probe);
    return status ? status : take_wall(t, m->wall, probe);
}

static MnsStatus take_extent(Translation *t, const Meniscus__ExtentProbe *m, MnsProbe *probe)
{
    probe->kind = MNS_PROBE_EXTENT;
    probe->least = m->which == MENISCUS__EXTREMUM__MIN;
    MnsStatus status = take_fluid(t, m->fluid, probe);
    if (!status) status = take_axis(t, "axis", m->axis, &probe->axis);
    return status ? status : take_within(t, m->within, probe);
}

static MnsStatus take_jump(Translation *t, const Meniscus__JumpProbe *m, MnsProbe *probe)
{
    probe->kind = MNS_PROBE_PRESSURE_JUMP;
    probe->radius = m->has_margin ? m->margin : 0;
    Names fluids;
    names_of_fluids(t->c, &fluids);
    return take_reference(t, "inside", m->inside, &fluids, &probe->fluid);
}

static MnsStatus take_front(Translation *t, const Meniscus__FrontProbe *m, MnsProbe *probe)
{
    probe->kind = MNS_PROBE_FRONT;
    probe->least = m->backwards;
    MnsStatus status = take_fluid(t, m->fluid, probe);
    if (!status) status = take_axis(t, "axis", m->axis, &probe->axis);
    return status ? status : take_within(t, m->within, probe);
}

static MnsStatus take_whole(Translation *t, MnsProbeKind kind, const Meniscus__FluidProbe *m, MnsProbe *probe)
{
    probe->kind = kind;
    return take_fluid(t, m->fluid, probe);
}

static MnsStatus take_solver(const Meniscus__SolverProbe *m, MnsProbe *probe)
{
    static const MnsSolverQuantity quantities[] = {
        [MENISCUS__SOLVER_QUANTITY__ITERATIONS] = MNS_SOLVER_ITERATIONS,
        [MENISCUS__SOLVER_QUANTITY__RESIDUAL] = MNS_SOLVER_RESIDUAL,
        [MENISCUS__SOLVER_QUANTITY__CORRECTIONS] = MNS_SOLVER_CORRECTIONS,
        [MENISCUS__SOLVER_QUANTITY__CORRECTION_ITERATIONS] = MNS_SOLVER_CORRECTION_ITERATIONS,
        [MENISCUS__SOLVER_QUANTITY__DENSITY_ERROR] = MNS_SOLVER_DENSITY_ERROR,
    };
    probe->kind = MNS_PROBE_SOLVER;
    probe->quantity = quantities[m->of];
    return MNS_OK;
}

static MnsStatus take_component(Translation *t, MnsProbeKind kind, const Meniscus__AxisProbe *m, MnsProbe *probe)
{
    probe->kind = kind;
    MnsStatus status = take_fluid(t, m->fluid, probe);
    if (!status) status = take_axis(t, "axis", m->axis, &probe->axis);
    return status ? status : take_within(t, m->within, probe);
}

static MnsStatus take_extremum(Translation *t, const Meniscus__ExtremumProbe *m, MnsProbe *probe)
{
    Names fields = {.what = "field"};
    int field;
    probe->kind = MNS_PROBE_EXTREMUM;
    probe->least = m->which == MENISCUS__EXTREMUM__MIN;
    names_of_fields(&fields);
    MnsStatus status = take_reference(t, "field", m->field, &fields, &field);
    if (!status) status = take_text(t, m->field, &probe->field);
    return status ? status : take_fluid(t, m->fluid, probe);
}

static MnsStatus take_coverage(Translation *t, const Meniscus__CoverageProbe *m, MnsProbe *probe)
{
    probe->kind = MNS_PROBE_COVERAGE;
    const MnsStatus status = take_wall(t, m->wall, probe);
    return status ? status : take_within(t, m->within, probe);
}

static MnsStatus take_escaped(Translation *t, const Meniscus__EscapedProbe *m, MnsProbe *probe)
{
    probe->kind = MNS_PROBE_ESCAPED;
    const MnsStatus status = take_fluid(t, m->fluid, probe);
    return status ? status : take_wall(t, m->wall, probe);
}

static MnsStatus take_deviation(Translation *t, const Meniscus__DeviationProbe *m, MnsProbe *probe)
{
    probe->kind = MNS_PROBE_PRESSURE_DEVIATION;
    const MnsStatus status = take_fluid(t, m->fluid, probe);
    return status ? status : take_text(t, m->from, &probe->formula);
}

/* The field of the message that is there names the entry complaints are about. */
static const char *kind_name(const Meniscus__Probe *m)
{
    const ProtobufCFieldDescriptor *field =
        protobuf_c_message_descriptor_get_field(m->base.descriptor, (unsigned)m->kind_case);
    return field ? field->name : "";
}

static MnsStatus take_kind(Translation *t, const Meniscus__Probe *m, MnsProbe *probe)
{
    switch (m->kind_case) {
    case MENISCUS__PROBE__KIND_PRESSURE: return take_pressure(t, m->pressure, probe);
    case MENISCUS__PROBE__KIND_HEIGHT: return take_height(t, m->height, probe);
    case MENISCUS__PROBE__KIND_FRONT: return take_front(t, m->front, probe);
    case MENISCUS__PROBE__KIND_KINETIC_ENERGY: return take_whole(t, MNS_PROBE_KINETIC_ENERGY, m->kinetic_energy, probe);
    case MENISCUS__PROBE__KIND_POTENTIAL_ENERGY:
        return take_whole(t, MNS_PROBE_POTENTIAL_ENERGY, m->potential_energy, probe);
    case MENISCUS__PROBE__KIND_MASS_CENTRE: return take_component(t, MNS_PROBE_MASS_CENTRE, m->mass_centre, probe);
    case MENISCUS__PROBE__KIND_MOMENTUM: return take_component(t, MNS_PROBE_MOMENTUM, m->momentum, probe);
    case MENISCUS__PROBE__KIND_MASS: return take_whole(t, MNS_PROBE_MASS, m->mass, probe);
    case MENISCUS__PROBE__KIND_EXTREMUM: return take_extremum(t, m->extremum, probe);
    case MENISCUS__PROBE__KIND_COVERAGE: return take_coverage(t, m->coverage, probe);
    case MENISCUS__PROBE__KIND_ESCAPED: return take_escaped(t, m->escaped, probe);
    case MENISCUS__PROBE__KIND_PRESSURE_DEVIATION: return take_deviation(t, m->pressure_deviation, probe);
    case MENISCUS__PROBE__KIND_VELOCITY: return take_component(t, MNS_PROBE_VELOCITY, m->velocity, probe);
    case MENISCUS__PROBE__KIND_VOLUME: return take_whole(t, MNS_PROBE_VOLUME, m->volume, probe);
    case MENISCUS__PROBE__KIND_ELEVATION: return take_elevation(t, m->elevation, probe);
    case MENISCUS__PROBE__KIND_EXTENT: return take_extent(t, m->extent, probe);
    case MENISCUS__PROBE__KIND_ROUNDNESS: return take_whole(t, MNS_PROBE_ROUNDNESS, m->roundness, probe);
    case MENISCUS__PROBE__KIND_SURFACE_AREA: return take_whole(t, MNS_PROBE_SURFACE_AREA, m->surface_area, probe);
    case MENISCUS__PROBE__KIND_PRESSURE_JUMP: return take_jump(t, m->pressure_jump, probe);
    case MENISCUS__PROBE__KIND_SOLVER: return take_solver(m->solver, probe);
    case MENISCUS__PROBE__KIND__NOT_SET:
    case _MENISCUS__PROBE__KIND__CASE_IS_INT_SIZE: break;
    }
    return translation_unknown(t);
}

/* Every text of a probe must be there, even where its kind has no use for it. */
static MnsStatus fill_texts(Translation *t, MnsProbe *probe)
{
    MnsStatus status = probe->field ? MNS_OK : take_text(t, "", &probe->field);
    if (!status && !probe->formula) status = take_text(t, "", &probe->formula);
    return status;
}

static MnsStatus take_probe(Translation *t, const Meniscus__Probe *m, const Names *before, MnsProbe *probe)
{
    *probe = (MnsProbe){.fluid = -1, .wall = -1};
    MnsStatus status = take_name(t, m->name, before, &probe->name);
    if (status) return status;
    const size_t outer = translation_enter(t, kind_name(m));
    status = take_kind(t, m, probe);
    case_path_cut(&t->path, outer);
    return status ? status : fill_texts(t, probe);
}

MnsStatus translate_probes(Translation *t, const Meniscus__Case *message)
{
    Names before = {.what = "probe"};
    MnsStatus status = check_limit(t, "probes", message->n_probes, MNS_MAX_PROBES);
    if (status || !message->n_probes) return status;
    t->c->probes = calloc(message->n_probes, sizeof *t->c->probes);
    if (!t->c->probes) return case_no_memory(t->error);
    t->c->n_probes = message->n_probes;
    for (size_t k = 0; k < message->n_probes && !status; k++) {
        const size_t outer = translation_enter_item(t, "probes", k);
        status = take_probe(t, message->probes[k], &before, &t->c->probes[k]);
        case_path_cut(&t->path, outer);
        before.list[before.n++] = t->c->probes[k].name;
    }
    return status;
}
