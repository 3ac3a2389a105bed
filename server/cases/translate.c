/* SPDX-License-Identifier: BSD-3-Clause */
/* Case message to MnsCase: names resolved, counts checked against the dimensions, defaults filled in. */
#include "cases/translate.h"
#include "cases/translation.h"
#include <assert.h>
#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_CONSTANTS = 256 };

static MnsStatus translate_domain(Translation *t, const Meniscus__Domain *m)
{
    MnsCase *c = t->c;
    const Meniscus__Box box = {.n_min = m->n_min, .min = m->min, .n_max = m->n_max, .max = m->max};
    const size_t outer = translation_enter(t, "domain");
    MnsStatus status = take_box(t, &box, c->min, c->max);
    for (size_t k = 0; k < m->n_periodic && !status; k++) {
        int axis = 0;
        const size_t before = translation_enter_item(t, "periodic", k);
        status = take_axis(t, NULL, m->periodic[k], &axis);
        if (!status && c->periodic[axis])
            status = translation_fail(t, MNS_E_INVALID, NULL, "\"%c\" is there twice", "xyz"[axis]);
        c->periodic[axis] = true;
        case_path_cut(&t->path, before);
    }
    if (!status) status = take_formulas(t, "displacement", m->n_displacement, m->displacement, c->displacement);
    case_path_cut(&t->path, outer);
    c->disorder = m->disorder;
    c->seed = m->seed;
    return status;
}

static bool is_identifier(const char *name)
{
    if (!isalpha((unsigned char)*name) && *name != '_') return false;
    while (isalnum((unsigned char)*name) || *name == '_') name++;
    return !*name;
}

static MnsStatus translate_constant(Translation *t, const Meniscus__Constant *m, size_t k)
{
    char shown[48];
    case_shown(m->name, shown);
    if (!is_identifier(m->name))
        return translation_fail(
            t, MNS_E_INVALID, "name",
            "found \"%s\", allowed: letters, digits and underscores, a letter or an underscore first", shown);
    for (size_t other = 0; other < k; other++)
        if (!strcmp(m->name, t->c->constants[other].name))
            return translation_fail(t, MNS_E_INVALID, "name",
                                    "found \"%s\", which constant %zu has too: names must differ", shown, other);
    const MnsStatus status = take_text(t, m->name, &t->c->constants[k].name);
    return status ? status : take_text(t, m->value, &t->c->constants[k].value);
}

static MnsStatus translate_constants(Translation *t, const Meniscus__Case *m)
{
    MnsStatus status = check_limit(t, "constants", m->n_constants, MAX_CONSTANTS);
    if (status || !m->n_constants) return status;
    t->c->constants = calloc(m->n_constants, sizeof *t->c->constants);
    if (!t->c->constants) return case_no_memory(t->error);
    t->c->n_constants = m->n_constants;
    for (size_t k = 0; k < m->n_constants && !status; k++) {
        const size_t before = translation_enter_item(t, "constants", k);
        status = translate_constant(t, m->constants[k], k);
        case_path_cut(&t->path, before);
    }
    return status;
}

/* What suits each scheme where the case is silent: its paper's, or what was found to be needed where the paper is silent too. */
typedef struct Method {
    const char *scheme;
    MnsKernel kernel;
    double smoothing;
    bool sound; /* are its fluids compressed? */
} Method;

static const Method *method_of(const MnsSchemeOptions *scheme)
{
    static const Method methods[] = {
        {"riemann", MNS_WENDLAND_C2, 1.3, true},         {"dissipation", MNS_TRUNCATED_GAUSSIAN, 1.1, true},
        {"interfacial", MNS_WENDLAND_C2, 1.6, true},     {"incompressible", MNS_QUINTIC_SPLINE, 1, false},
        {"differences", MNS_QUINTIC_SPLINE, 0.9, false},
    };
    size_t k = 0;
    for (; strcmp(methods[k].scheme, scheme->name) != 0; k++) assert(k + 1 < sizeof methods / sizeof *methods);
    return &methods[k];
}

static MnsStatus translate_fluid(Translation *t, const Meniscus__Fluid *m, const Names *before, MnsFluid *fluid)
{
    static const MnsDensityMethod methods[] = {
        [MENISCUS__DENSITY_METHOD__AUTOMATIC] = MNS_DENSITY_AUTOMATIC,
        [MENISCUS__DENSITY_METHOD__CONTINUITY] = MNS_DENSITY_CONTINUITY,
        [MENISCUS__DENSITY_METHOD__SUMMATION] = MNS_DENSITY_SUMMATION,
    };
    fluid->density = m->density;
    fluid->viscosity = m->viscosity;
    const bool sound = method_of(&t->c->scheme)->sound;
    fluid->sound_speed = sound && m->has_sound_speed ? m->sound_speed : INFINITY;
    fluid->density_method = methods[m->density_method];
    fluid->exponent = m->has_exponent ? m->exponent : 0;
    if (sound && !m->has_sound_speed)
        return translation_fail(t, MNS_E_INVALID, "sound_speed", "missing, required: (0, inf) m/s");
    MnsStatus status = take_name(t, m->name, before, &fluid->name);
    if (!status) status = translate_shape(t, m->n_shape, m->shape, true, &fluid->shape);
    if (!status) status = take_formulas(t, "velocity", m->n_velocity, m->velocity, fluid->velocity);
    return status ? status : take_text(t, m->pressure, &fluid->pressure);
}

static MnsStatus translate_fluids(Translation *t, const Meniscus__Case *m)
{
    Names before = {.what = "fluid"};
    MnsStatus status = check_limit(t, "fluids", m->n_fluids, MNS_MAX_FLUIDS);
    if (status) return status;
    t->c->fluids = calloc(m->n_fluids, sizeof *t->c->fluids);
    if (!t->c->fluids) return case_no_memory(t->error);
    t->c->n_fluids = m->n_fluids;
    for (size_t k = 0; k < m->n_fluids && !status; k++) {
        const size_t outer = translation_enter_item(t, "fluids", k);
        status = translate_fluid(t, m->fluids[k], &before, &t->c->fluids[k]);
        case_path_cut(&t->path, outer);
        before.list[before.n++] = t->c->fluids[k].name;
    }
    return status;
}

static MnsStatus translate_interface(Translation *t, const Meniscus__Interface *m, const Names *fluids)
{
    int side[2] = {0, 0};
    MnsStatus status = MNS_OK;
    for (size_t k = 0; k < 2 && !status; k++) {
        const size_t before = translation_enter_item(t, "between", k);
        status = take_reference(t, NULL, m->between[k], fluids, &side[k]);
        case_path_cut(&t->path, before);
    }
    if (status) return status;
    if (side[0] == side[1])
        return translation_fail(t, MNS_E_INVALID, "between", "\"%s\" is there twice: name two fluids", m->between[0]);
    double(*tension)[MNS_MAX_FLUIDS] = t->c->tension;
    if (tension[side[0]][side[1]] > 0)
        return translation_fail(t, MNS_E_INVALID, "between", "the interface between \"%s\" and \"%s\" is there twice",
                                m->between[0], m->between[1]);
    tension[side[0]][side[1]] = tension[side[1]][side[0]] = m->tension;
    return MNS_OK;
}

static MnsStatus translate_interfaces(Translation *t, const Meniscus__Case *m)
{
    Names fluids;
    MnsStatus status = MNS_OK;
    names_of_fluids(t->c, &fluids);
    for (size_t k = 0; k < m->n_interfaces && !status; k++) {
        const size_t outer = translation_enter_item(t, "interfaces", k);
        status = translate_interface(t, m->interfaces[k], &fluids);
        case_path_cut(&t->path, outer);
    }
    return status;
}

static MnsStatus translate_wall(Translation *t, const Meniscus__Wall *m, const Names *before, MnsWall *wall)
{
    wall->no_slip = m->slip == MENISCUS__SLIP__NONE;
    MnsStatus status = take_name(t, m->name, before, &wall->name);
    if (!status) status = translate_shape(t, m->n_shape, m->shape, false, &wall->shape);
    if (!status && m->motion) status = translate_motion(t, m->motion, &wall->motion);
    if (status) return status;
    return take_formulas(t, "surface_velocity", m->n_surface_velocity, m->surface_velocity, wall->surface_velocity);
}

static MnsStatus translate_walls(Translation *t, const Meniscus__Case *m)
{
    Names before = {.what = "wall"};
    MnsStatus status = check_limit(t, "walls", m->n_walls, MNS_MAX_WALLS);
    if (status || !m->n_walls) return status;
    t->c->walls = calloc(m->n_walls, sizeof *t->c->walls);
    if (!t->c->walls) return case_no_memory(t->error);
    t->c->n_walls = m->n_walls;
    for (size_t k = 0; k < m->n_walls && !status; k++) {
        const size_t outer = translation_enter_item(t, "walls", k);
        status = translate_wall(t, m->walls[k], &before, &t->c->walls[k]);
        case_path_cut(&t->path, outer);
        before.list[before.n++] = t->c->walls[k].name;
    }
    return status;
}

/* Its absence means the same as its defaults. */
static void translate_riemann(const Meniscus__Riemann *given, MnsSchemeOptions *ret)
{
    const Meniscus__Riemann defaults = MENISCUS__RIEMANN__INIT;
    const Meniscus__Riemann *r = given ? given : &defaults;
    static const MnsReconstruction reconstructions[] = {
        [MENISCUS__RIEMANN__RECONSTRUCTION__NONE] = MNS_RECONSTRUCTION_NONE,
        [MENISCUS__RIEMANN__RECONSTRUCTION__VELOCITY] = MNS_RECONSTRUCTION_VELOCITY,
        [MENISCUS__RIEMANN__RECONSTRUCTION__BOTH] = MNS_RECONSTRUCTION_BOTH,
    };
    ret->name = "riemann";
    ret->riemann = (MnsRiemann){.limiter = r->limiter,
                                .background_pressure = r->background_pressure,
                                .heavy_background_pressure = r->heavy_background_pressure,
                                .guard = r->guard,
                                .transport_stress = r->transport_stress,
                                .reconstruction = reconstructions[r->reconstruction]};
}

static const MnsPairAverage PAIR_AVERAGES[] = {
    [MENISCUS__PAIR_AVERAGE__ARITHMETIC] = MNS_AVERAGE_ARITHMETIC,
    [MENISCUS__PAIR_AVERAGE__DENSITY] = MNS_AVERAGE_DENSITY,
};

static void translate_dissipation(const Meniscus__Dissipation *m, MnsSchemeOptions *ret)
{
    static const MnsDissipationForm forms[] = {
        [MENISCUS__DISSIPATION_FORM__GENERALIZED] = MNS_DISSIPATION_GENERALIZED,
        [MENISCUS__DISSIPATION_FORM__NO_VOLUME_FACTOR] = MNS_DISSIPATION_NO_VOLUME_FACTOR,
        [MENISCUS__DISSIPATION_FORM__PLAIN] = MNS_DISSIPATION_PLAIN,
    };
    ret->name = "dissipation";
    ret->dissipation = (MnsDissipation){.delta = m->delta,
                                        .form = forms[m->form],
                                        .gradient_correction = m->gradient_correction,
                                        .repulsion = m->repulsion,
                                        .pair_average = PAIR_AVERAGES[m->pair_average],
                                        .background_pressure = m->background_pressure,
                                        .guard = m->guard};
}

static void translate_interfacial(const Meniscus__Interfacial *m, MnsSchemeOptions *ret)
{
    static const MnsShifting shiftings[] = {
        [MENISCUS__SHIFTING__OFF] = MNS_SHIFTING_OFF,
        [MENISCUS__SHIFTING__INTERFACE] = MNS_SHIFTING_INTERFACE,
        [MENISCUS__SHIFTING__ORIGINAL] = MNS_SHIFTING_ORIGINAL,
    };
    ret->name = "interfacial";
    ret->interfacial = (MnsInterfacial){.delta = m->delta,
                                        .shifting = shiftings[m->shifting],
                                        .shifting_strength = m->shifting_strength,
                                        .gradient_correction = m->gradient_correction,
                                        .repulsion = m->repulsion,
                                        .pair_average = PAIR_AVERAGES[m->pair_average],
                                        .background_pressure = m->background_pressure,
                                        .guard = m->guard};
}

static MnsSolver solver_of(Meniscus__Solver solver)
{
    static const MnsSolver solvers[] = {
        [MENISCUS__SOLVER__BY_SIZE] = MNS_SOLVER_BY_SIZE,
        [MENISCUS__SOLVER__CG] = MNS_SOLVER_CG,
        [MENISCUS__SOLVER__BICGSTAB] = MNS_SOLVER_BICGSTAB,
        [MENISCUS__SOLVER__AMG] = MNS_SOLVER_AMG,
    };
    return solvers[solver];
}

static void translate_incompressible(const Meniscus__Incompressible *m, MnsSchemeOptions *ret)
{
    static const MnsMobility mobilities[] = {
        [MENISCUS__MOBILITY__BY_RATIO] = MNS_MOBILITY_BY_RATIO,
        [MENISCUS__MOBILITY__TRUE_DENSITY] = MNS_MOBILITY_DENSITY,
        [MENISCUS__MOBILITY__UNIT] = MNS_MOBILITY_UNIT,
    };
    ret->name = "incompressible";
    ret->incompressible =
        (MnsIncompressible){.density_tolerance = m->density_tolerance,
                            .density_corrections = m->density_corrections,
                            .density_patience = m->density_patience,
                            .density_offset = m->density_offset,
                            .mobility = mobilities[m->mobility],
                            .reference_speed = m->has_reference_speed ? m->reference_speed : -1,
                            .gauge = m->gauge == MENISCUS__GAUGE__MEAN ? MNS_GAUGE_MEAN : MNS_GAUGE_MINIMUM,
                            .solver = solver_of(m->solver),
                            .tolerance = m->tolerance,
                            .density_solver_tolerance = m->density_solver_tolerance,
                            .iterations = m->iterations,
                            .guard = m->guard};
}

static MnsStatus translate_differences(Translation *t, const Meniscus__Differences *m, MnsSchemeOptions *ret)
{
    static const MnsDiffusion diffusions[] = {
        [MENISCUS__DIFFUSION__DIVTAU] = MNS_DIFFUSION_DIVTAU,
        [MENISCUS__DIFFUSION__HARMONIC] = MNS_DIFFUSION_HARMONIC,
        [MENISCUS__DIFFUSION__CONSERVATIVE] = MNS_DIFFUSION_CONSERVATIVE,
        [MENISCUS__DIFFUSION__SPH] = MNS_DIFFUSION_SPH,
    };
    ret->name = "differences";
    ret->differences = (MnsDifferences){.diffusion = diffusions[m->diffusion],
                                        .interface_threshold = m->interface_threshold,
                                        .shifting_strength = m->shifting_strength,
                                        .shift_across_interfaces = m->shift_across_interfaces,
                                        .buoyant_in = -1,
                                        .holds_pressure = m->n_zero_pressure > 0,
                                        .reference_speed = m->has_reference_speed ? m->reference_speed : -1,
                                        .tolerance = m->tolerance,
                                        .iterations = m->iterations,
                                        .solver = solver_of(m->solver),
                                        .guard = m->guard};
    if (!m->n_zero_pressure) return MNS_OK;
    const size_t before = translation_enter(t, "differences");
    const MnsStatus status =
        take_vector(t, "zero_pressure", m->n_zero_pressure, m->zero_pressure, ret->differences.zero_pressure);
    case_path_cut(&t->path, before);
    return status;
}

/* The fluid is known by name only when fluids are. */
static MnsStatus translate_buoyancy(Translation *t, const Meniscus__Scheme *m)
{
    Names fluids;
    if (!m || m->method_case != MENISCUS__SCHEME__METHOD_DIFFERENCES || !m->differences->buoyant_in) return MNS_OK;
    names_of_fluids(t->c, &fluids);
    const size_t before = translation_enter(t, "scheme");
    translation_enter(t, "differences");
    const MnsStatus status =
        take_reference(t, "buoyant_in", m->differences->buoyant_in, &fluids, &t->c->scheme.differences.buoyant_in);
    case_path_cut(&t->path, before);
    return status;
}

static MnsStatus translate_method(Translation *t, const Meniscus__Scheme *m, MnsSchemeOptions *ret)
{
    switch (m->method_case) {
    case MENISCUS__SCHEME__METHOD_RIEMANN: translate_riemann(m->riemann, ret); return MNS_OK;
    case MENISCUS__SCHEME__METHOD_DISSIPATION: translate_dissipation(m->dissipation, ret); return MNS_OK;
    case MENISCUS__SCHEME__METHOD_INTERFACIAL: translate_interfacial(m->interfacial, ret); return MNS_OK;
    case MENISCUS__SCHEME__METHOD_INCOMPRESSIBLE: translate_incompressible(m->incompressible, ret); return MNS_OK;
    case MENISCUS__SCHEME__METHOD_DIFFERENCES: return translate_differences(t, m->differences, ret);
    case MENISCUS__SCHEME__METHOD__NOT_SET: translate_riemann(NULL, ret); return MNS_OK;
    case _MENISCUS__SCHEME__METHOD__CASE_IS_INT_SIZE: break;
    }
    return translation_unknown(t);
}

static MnsStatus translate_scheme(Translation *t, const Meniscus__Scheme *given, MnsSchemeOptions *ret)
{
    static const MnsKernel kernels[] = {
        [MENISCUS__KERNEL__WENDLAND_C2] = MNS_WENDLAND_C2,
        [MENISCUS__KERNEL__TRUNCATED_GAUSSIAN] = MNS_TRUNCATED_GAUSSIAN,
        [MENISCUS__KERNEL__QUINTIC_SPLINE] = MNS_QUINTIC_SPLINE,
    };
    const Meniscus__Scheme scheme_defaults = MENISCUS__SCHEME__INIT;
    const Meniscus__Scheme *m = given ? given : &scheme_defaults;
    *ret = (MnsSchemeOptions){.cfl = m->cfl, .skin = m->skin};
    const size_t before = translation_enter(t, "scheme");
    const MnsStatus status = translate_method(t, m, ret);
    case_path_cut(&t->path, before);
    if (status) return status;
    const Method *method = method_of(ret);
    ret->kernel = m->has_kernel ? kernels[m->kernel] : method->kernel;
    ret->smoothing = m->has_smoothing ? m->smoothing : method->smoothing;
    return MNS_OK;
}

static MnsStatus translate_fields(Translation *t, const Meniscus__Output *m, MnsOutput *ret)
{
    Names fields;
    MnsStatus status = MNS_OK;
    names_of_fields(&fields);
    if (!m->n_fields) return MNS_OK;
    ret->fields = calloc(m->n_fields, sizeof *ret->fields);
    if (!ret->fields) return case_no_memory(t->error);
    ret->n_fields = m->n_fields;
    for (size_t k = 0; k < m->n_fields && !status; k++) {
        int index;
        const size_t before = translation_enter_item(t, "fields", k);
        status = take_reference(t, NULL, m->fields[k], &fields, &index);
        for (size_t other = 0; other < k && !status; other++)
            if (!strcmp(m->fields[k], m->fields[other]))
                status = translation_fail(t, MNS_E_INVALID, NULL, "\"%s\" is there twice", m->fields[k]);
        if (!status) status = take_text(t, m->fields[k], &ret->fields[k]);
        case_path_cut(&t->path, before);
    }
    return status;
}

static MnsStatus translate_output(Translation *t, const Meniscus__Output *given)
{
    const Meniscus__Output defaults = MENISCUS__OUTPUT__INIT;
    const Meniscus__Output *m = given ? given : &defaults;
    t->c->output = (MnsOutput){
        .probe_interval = m->probe_interval,
        .snapshot_interval = m->snapshot_interval,
        .checkpoint_interval = m->checkpoint_interval,
        .checkpoint_wall_interval = m->checkpoint_wall_interval,
        .checkpoints_kept = m->checkpoints_kept,
        .walls = m->walls,
    };
    const size_t before = translation_enter(t, "output");
    const MnsStatus status = translate_fields(t, m, &t->c->output);
    case_path_cut(&t->path, before);
    return status;
}

static MnsLimits translate_limits(const Meniscus__Limits *given)
{
    const Meniscus__Limits defaults = MENISCUS__LIMITS__INIT;
    const Meniscus__Limits *m = given ? given : &defaults;
    return (MnsLimits){m->time_step_floor, m->density_min, m->density_max};
}

static MnsStatus translate_all(Translation *t, const Meniscus__Case *m)
{
    MnsCase *c = t->c;
    c->dim = (int)m->dimensions;
    c->reference_length = m->reference_length;
    c->resolution = m->resolution;
    c->end_time = m->end_time;
    c->threads = m->threads;
    c->limits = translate_limits(m->limits);
    MnsStatus status = translate_scheme(t, m->scheme, &c->scheme);
    if (!status) status = take_text(t, m->title ? m->title : "", &c->title);
    if (!status) status = translate_domain(t, m->domain);
    if (!status) status = translate_constants(t, m);
    if (!status) status = take_formulas(t, "gravity", m->n_gravity, m->gravity, c->gravity);
    if (!status) status = translate_fluids(t, m);
    if (!status) status = translate_buoyancy(t, m->scheme);
    if (!status) status = translate_interfaces(t, m);
    if (!status) status = translate_walls(t, m);
    if (!status) status = translate_probes(t, m);
    return status ? status : translate_output(t, m->output);
}

MnsStatus case_translate(const Meniscus__Case *message, MnsCase **ret, MnsError *error)
{
    Translation t = {.c = calloc(1, sizeof *t.c), .error = error};
    if (!t.c) return case_no_memory(error);
    const MnsStatus status = translate_all(&t, message);
    if (status) mns_case_free(t.c);
    else *ret = t.c;
    return status;
}
