/* SPDX-License-Identifier: BSD-3-Clause */
/* Every case that cannot be run is refused with the entry to blame, by mns_case_check() or, where particles must be
 * placed to know, by mns_sim_new(); and what can be run is not. */
#include "tests/support/cases.h"
#include "tests/support/check.h"
#include <stdlib.h>
#include <string.h>

/* A case with something of everything, all of it good. */
static MnsCase *good(int dim)
{
    MnsCase *c = case_dam_break(dim, 10);
    c->max[0] = 5.4;
    c->walls[0].shape.parts[0].b[0] = 5.4;
    case_add_wall(c, "baffle");
    MnsPart *plate = case_add_part(&c->walls[1].shape, MNS_PLATE);
    *plate = (MnsPart){.primitive = MNS_PLATE,
                       .a = {4, 0.5, 0.5},
                       .b = {1, 1, 0},
                       .c = {0, 1, 1},
                       .length = 1,
                       .width = 1,
                       .thickness = 0.3,
                       .formula = plate->formula};
    static const char *const constants[3][2] = {{"H", "3*dx"}, {"U", "2*H"}, {"late", "U"}};
    c->n_constants = 3;
    c->constants = calloc(3, sizeof *c->constants);
    for (size_t k = 0; c->constants && k < 3; k++) {
        case_set_text(&c->constants[k].name, constants[k][0]);
        case_set_text(&c->constants[k].value, constants[k][1]);
    }
    case_add_probe(c, MNS_PROBE_PRESSURE);
    case_set_text(&case_add_probe(c, MNS_PROBE_EXTREMUM)->field, "velocity");
    case_set_text(&case_add_probe(c, MNS_PROBE_PRESSURE_DEVIATION)->formula, "1 - y + 0*t");
    return c;
}

/* What a test spoils, and what is said about it. */
typedef struct Refusal {
    const char *path;
    MnsStatus status;
    void (*spoil)(MnsCase *c);
} Refusal;

static MnsPart *fluid_part(MnsCase *c, MnsPart part)
{
    MnsPart *p = &c->fluids[0].shape.parts[0];
    part.formula = p->formula;
    *p = part;
    return p;
}

static void wrong_dimension(MnsCase *c)
{
    c->dim = 4;
}
static void no_resolution(MnsCase *c)
{
    c->resolution = 0;
}
static void nan_resolution(MnsCase *c)
{
    c->resolution = NAN;
}
static void no_reference_length(MnsCase *c)
{
    c->reference_length = -1;
}
static void negative_end(MnsCase *c)
{
    c->end_time = -1;
}
static void nan_end(MnsCase *c)
{
    c->end_time = NAN;
}
static void no_smoothing(MnsCase *c)
{
    c->scheme.smoothing = 0.79;
}
static void tiny_cfl(MnsCase *c)
{
    c->scheme.cfl = 1e-300;
}
static void wide_skin(MnsCase *c)
{
    c->scheme.skin = NAN;
}
static void steep_limiter(MnsCase *c)
{
    c->scheme.riemann.limiter = 101;
}
static void deep_guard(MnsCase *c)
{
    c->scheme.riemann.guard = 0.51;
}
static void tiny_floor(MnsCase *c)
{
    c->limits.time_step_floor = 1e-7;
}
static void dense_floor(MnsCase *c)
{
    c->limits.density_min = 1;
}
static void light_ceiling(MnsCase *c)
{
    c->limits.density_max = 1;
}
static void negative_interval(MnsCase *c)
{
    c->output.snapshot_interval = -1;
}
static void many_threads(MnsCase *c)
{
    c->threads = 1025;
}
static void unknown_scheme(MnsCase *c)
{
    c->scheme.name = "riemannn";
}
static void no_fluid(MnsCase *c)
{
    c->n_fluids = 0;
}
static void many_fluids(MnsCase *c)
{
    c->n_fluids = MNS_MAX_FLUIDS + 1;
}
static void many_walls(MnsCase *c)
{
    c->n_walls = MNS_MAX_WALLS + 1;
}
static void many_probes(MnsCase *c)
{
    c->n_probes = MNS_MAX_PROBES + 1;
}
static void bad_displacement(MnsCase *c)
{
    case_set_text(&c->displacement[1], "t");
}

static void empty_domain(MnsCase *c)
{
    c->max[1] = c->min[1];
}
static void nan_domain(MnsCase *c)
{
    c->min[0] = NAN;
}
static void far_origin(MnsCase *c)
{
    c->min[0] = 1e13;
    c->max[0] = 1e13 + 5.4;
}
static void far_ball(MnsCase *c)
{
    fluid_part(c, (MnsPart){.primitive = MNS_BALL, .a = {-1e12, 0, 0}, .radius = 1e12 + 1});
}
static void far_plane(MnsCase *c)
{
    fluid_part(c, (MnsPart){.primitive = MNS_HALF_SPACE, .a = {1e12, 1, 0}, .b = {1, 1, 0}});
}
static void far_plate(MnsCase *c)
{
    c->walls[1].shape.parts[0].a[1] = 1e12;
}
static void far_motion(MnsCase *c)
{
    c->walls[0].motion = (MnsMotion){.kind = MNS_SINE, .amplitude = {0, 1e12, 0}, .frequency = 1};
}
static void misfit(MnsCase *c)
{
    c->max[0] = 0.43;
}
static void short_period(MnsCase *c)
{
    c->periodic[0] = true;
    c->max[0] = 0.5;
}
static void held_outside(MnsCase *c)
{
    c->scheme.name = "differences";
    c->scheme.differences.holds_pressure = true;
    c->scheme.differences.zero_pressure[0] = c->min[0];
    c->scheme.differences.zero_pressure[1] = c->max[1] + 1e-3;
}
static void tense_riemann(MnsCase *c)
{
    c->tension[0][1] = c->tension[1][0] = 0.07;
}
static void negative_delta(MnsCase *c)
{
    c->scheme.name = "dissipation";
    c->scheme.dissipation.delta = -1;
}
static void fast_gas(MnsCase *c)
{
    c->scheme.name = "dissipation";
    c->fluids[1].density = 0.001 * c->fluids[0].density;
    c->fluids[1].sound_speed = 1.3 * c->fluids[0].sound_speed;
}
static void negative_delta_of_volumes(MnsCase *c)
{
    c->scheme.name = "interfacial";
    c->scheme.interfacial.delta = -1;
}
static void negative_tolerance(MnsCase *c)
{
    c->scheme.name = "incompressible";
    c->scheme.incompressible.density_tolerance = -1;
}
static void negative_threshold(MnsCase *c)
{
    c->scheme.name = "differences";
    c->scheme.differences.interface_threshold = -1;
}
static void three_mixed(MnsCase *c)
{
    c->scheme.name = "differences";
    c->n_fluids = 3;
}
static void differences_by_cg(MnsCase *c)
{
    c->scheme.name = "differences";
    c->scheme.differences.solver = MNS_SOLVER_CG;
}
static void buoyant_in_nothing(MnsCase *c)
{
    c->scheme.name = "differences";
    c->scheme.differences.buoyant_in = (int)c->n_fluids;
}
static void unknown_kernel(MnsCase *c)
{
    c->scheme.kernel = (MnsKernel)(MNS_QUINTIC_SPLINE + 1);
}
static void endless_half_space(MnsCase *c)
{
    MnsPart *p = &c->walls[1].shape.parts[0];
    c->periodic[1] = true;
    *p = (MnsPart){.primitive = MNS_HALF_SPACE, .b = {0, -1, 0}, .formula = p->formula};
}
static void too_fine(MnsCase *c)
{
    c->resolution = 1e6;
}
static void bad_gravity(MnsCase *c)
{
    case_set_text(&c->gravity[1], "-g");
}
static void gravity_of_place(MnsCase *c)
{
    case_set_text(&c->gravity[0], "x");
}
static void bad_constant(MnsCase *c)
{
    case_set_text(&c->constants[1].value, "2*late"); /* defined only after it */
}
static void no_density(MnsCase *c)
{
    c->fluids[1].density = 0;
}
static void vanishing_density(MnsCase *c) /* its square is 0 */
{
    c->fluids[1].density = 1e-310;
}
static void infinite_density(MnsCase *c)
{
    c->fluids[1].density = INFINITY;
}
static void no_sound(MnsCase *c)
{
    c->fluids[0].sound_speed = 0;
}
static void negative_viscosity(MnsCase *c)
{
    c->fluids[0].viscosity = -1e-9;
}
static void nan_viscosity(MnsCase *c)
{
    c->fluids[0].viscosity = NAN;
}
static void drop_shape(MnsShape *shape)
{
    for (size_t k = 0; k < shape->n; k++) free(shape->parts[k].formula);
    shape->n = 0;
}
static void two_without_shape(MnsCase *c)
{
    drop_shape(&c->fluids[0].shape);
}
static void empty_box(MnsCase *c)
{
    fluid_part(c, (MnsPart){.primitive = MNS_BOX, .b = {1, 0, 1}});
}
static void empty_ball(MnsCase *c)
{
    fluid_part(c, (MnsPart){.primitive = MNS_BALL});
}
static void short_cylinder(MnsCase *c)
{
    fluid_part(c, (MnsPart){.primitive = MNS_CYLINDER, .a = {1, 1, 0}, .b = {1, 1, 0}, .radius = 1});
}
static void thin_cylinder(MnsCase *c)
{
    fluid_part(c, (MnsPart){.primitive = MNS_CYLINDER, .b = {1, 1, 0}});
}
static void lost_plane(MnsCase *c)
{
    fluid_part(c, (MnsPart){.primitive = MNS_HALF_SPACE, .a = {1, 1, 0}});
}
static void unknown_primitive(MnsCase *c)
{
    fluid_part(c, (MnsPart){.primitive = (MnsPrimitive)99});
}
static void bad_region(MnsCase *c)
{
    case_set_text(&fluid_part(c, (MnsPart){.primitive = MNS_FORMULA})->formula, "y < q");
}
static void bad_velocity(MnsCase *c)
{
    case_set_text(&c->fluids[1].velocity[1], "t");
}
static void bad_pressure(MnsCase *c)
{
    case_set_text(&c->fluids[1].pressure, "hydrostatics");
}
static void no_wall_shape(MnsCase *c)
{
    drop_shape(&c->walls[1].shape);
}
static void wall_by_formula(MnsCase *c)
{
    c->walls[1].shape.parts[0].primitive = MNS_FORMULA;
}
static void flat_plate(MnsCase *c)
{
    c->walls[1].shape.parts[0].thickness = 0;
}
static void thin_plate(MnsCase *c)
{
    c->walls[1].shape.parts[0].thickness = 0.2599;
}
static void plate_along_nothing(MnsCase *c)
{
    c->walls[1].shape.parts[0].b[0] = c->walls[1].shape.parts[0].b[1] = 0;
}
static void plate_without_normal(MnsCase *c)
{
    memset(c->walls[1].shape.parts[0].c, 0, sizeof(double[3]));
}
static void plate_with_normal_along(MnsCase *c)
{
    for (int d = 0; d < 3; d++) c->walls[1].shape.parts[0].c[d] = -2 * c->walls[1].shape.parts[0].b[d];
}
static void plate_without_width(MnsCase *c)
{
    c->walls[1].shape.parts[0].width = 0;
}
static void still_sine(MnsCase *c)
{
    c->walls[1].motion.kind = MNS_SINE;
}
static void endless_cosine(MnsCase *c)
{
    c->walls[0].motion = (MnsMotion){.kind = MNS_ONE_MINUS_COSINE, .frequency = INFINITY};
}
static void move(MnsCase *c, size_t n, double second)
{
    MnsMotion *motion = &c->walls[0].motion;
    motion->kind = MNS_TABLE;
    motion->n = n;
    motion->points = calloc(n, sizeof *motion->points);
    for (size_t k = 0; k < n; k++) motion->points[k].t = k == 1 ? second : (double)k;
}
static void unknown_motion(MnsCase *c)
{
    c->walls[0].motion.kind = (MnsMotionKind)7;
}
static void lone_point(MnsCase *c)
{
    move(c, 1, 0);
}
static void falling_table(MnsCase *c)
{
    move(c, 3, -1);
}
static void standing_table(MnsCase *c)
{
    move(c, 3, 2);
}
static void bad_surface(MnsCase *c)
{
    case_set_text(&c->walls[0].surface_velocity[1], "y");
}
static void constant_called_as_a_function(MnsCase *c)
{
    case_set_text(&c->constants[1].name, "sqrt");
}
static void constant_called_as_a_word(MnsCase *c)
{
    case_set_text(&c->constants[2].name, "_ENV");
}
static void probe_called_as_a_column(MnsCase *c)
{
    case_set_text(&c->probes[1].name, "time");
}
static void probe_of_no_fluid(MnsCase *c)
{
    c->probes[0].fluid = 2;
}
static void probe_on_no_wall(MnsCase *c)
{
    c->probes[1].wall = 2;
}
static void probe_along_no_axis(MnsCase *c)
{
    c->probes[0].axis = c->dim;
}
static void probe_along_less_than_none(MnsCase *c)
{
    c->probes[0].axis = -1;
}
static void probe_of_no_kind(MnsCase *c)
{
    c->probes[0].kind = (MnsProbeKind)99;
}
static void probe_of_no_field(MnsCase *c)
{
    case_set_text(&c->probes[1].field, "speed");
}
static void probe_of_no_fluids(MnsCase *c)
{
    c->probes[0].fluids = 4;
}
static void jump_of_all_fluids(MnsCase *c)
{
    c->probes[0].kind = MNS_PROBE_PRESSURE_JUMP;
}
static void jump_with_wide_margin(MnsCase *c)
{
    c->probes[0].kind = MNS_PROBE_PRESSURE_JUMP;
    c->probes[0].fluid = 1;
    c->probes[0].radius = 1;
}
static void bad_deviation(MnsCase *c)
{
    case_set_text(&c->probes[2].formula, "1 -");
}

static const Refusal REFUSALS[] = {
    {"dimensions", MNS_E_INVALID, wrong_dimension},
    {"resolution", MNS_E_INVALID, no_resolution},
    {"resolution", MNS_E_INVALID, nan_resolution},
    {"reference_length", MNS_E_INVALID, no_reference_length},
    {"end_time", MNS_E_INVALID, negative_end},
    {"end_time", MNS_E_INVALID, nan_end},
    {"scheme.smoothing", MNS_E_INVALID, no_smoothing},
    {"scheme.cfl", MNS_E_INVALID, tiny_cfl},
    {"scheme.skin", MNS_E_INVALID, wide_skin},
    {"scheme.riemann.limiter", MNS_E_INVALID, steep_limiter},
    {"scheme.riemann.guard", MNS_E_INVALID, deep_guard},
    {"limits.time_step_floor", MNS_E_INVALID, tiny_floor},
    {"limits.density_min", MNS_E_INVALID, dense_floor},
    {"limits.density_max", MNS_E_INVALID, light_ceiling},
    {"output.snapshot_interval", MNS_E_INVALID, negative_interval},
    {"threads", MNS_E_INVALID, many_threads},
    {"scheme", MNS_E_INVALID, unknown_scheme},
    {"fluids", MNS_E_LIMIT, no_fluid},
    {"fluids", MNS_E_LIMIT, many_fluids},
    {"walls", MNS_E_LIMIT, many_walls},
    {"probes", MNS_E_LIMIT, many_probes},
    {"domain", MNS_E_INVALID, empty_domain},
    {"domain.displacement[1]", MNS_E_INVALID, bad_displacement},
    {"domain", MNS_E_INVALID, nan_domain},
    {"domain", MNS_E_INVALID, far_origin},
    {"fluids[0].shape[0]", MNS_E_INVALID, far_ball},
    {"fluids[0].shape[0]", MNS_E_INVALID, far_plane},
    {"walls[1].shape[0]", MNS_E_INVALID, far_plate},
    {"walls[0].motion", MNS_E_INVALID, far_motion},
    {"resolution", MNS_E_INVALID, misfit},
    {"domain", MNS_E_INVALID, short_period},
    {"scheme.differences.zero_pressure", MNS_E_INVALID, held_outside},
    {"interfaces", MNS_E_INVALID, tense_riemann},
    {"scheme.dissipation.delta", MNS_E_INVALID, negative_delta},
    {"fluids[1].sound_speed", MNS_E_INVALID, fast_gas},
    {"scheme.interfacial.delta", MNS_E_INVALID, negative_delta_of_volumes},
    {"scheme.incompressible.density_tolerance", MNS_E_INVALID, negative_tolerance},
    {"scheme.differences.interface_threshold", MNS_E_INVALID, negative_threshold},
    {"fluids", MNS_E_INVALID, three_mixed},
    {"scheme.differences.solver", MNS_E_INVALID, differences_by_cg},
    {"scheme.differences.buoyant_in", MNS_E_INVALID, buoyant_in_nothing},
    {"scheme.kernel", MNS_E_INVALID, unknown_kernel},
    {"resolution", MNS_E_LIMIT, too_fine},
    {"gravity[1]", MNS_E_INVALID, bad_gravity},
    {"gravity[0]", MNS_E_INVALID, gravity_of_place},
    {"constants[1].value", MNS_E_INVALID, bad_constant},
    {"fluids[1].density", MNS_E_INVALID, no_density},
    {"fluids[1].density", MNS_E_INVALID, vanishing_density},
    {"fluids[1].density", MNS_E_INVALID, infinite_density},
    {"fluids[0].sound_speed", MNS_E_INVALID, no_sound},
    {"fluids[0].viscosity", MNS_E_INVALID, negative_viscosity},
    {"fluids[0].viscosity", MNS_E_INVALID, nan_viscosity},
    {"fluids[1]", MNS_E_INVALID, two_without_shape},
    {"fluids[0].shape[0]", MNS_E_INVALID, empty_box},
    {"fluids[0].shape[0]", MNS_E_INVALID, empty_ball},
    {"fluids[0].shape[0]", MNS_E_INVALID, short_cylinder},
    {"fluids[0].shape[0]", MNS_E_INVALID, thin_cylinder},
    {"fluids[0].shape[0]", MNS_E_INVALID, lost_plane},
    {"fluids[0].shape[0]", MNS_E_INVALID, unknown_primitive},
    {"fluids[0].shape[0].formula", MNS_E_INVALID, bad_region},
    {"fluids[1].velocity[1]", MNS_E_INVALID, bad_velocity},
    {"fluids[1].pressure", MNS_E_INVALID, bad_pressure},
    {"walls[1].shape", MNS_E_INVALID, no_wall_shape},
    {"walls[1].shape[0]", MNS_E_INVALID, wall_by_formula},
    {"walls[1].shape[0]", MNS_E_INVALID, flat_plate},
    {"walls[1].shape[0]", MNS_E_INVALID, plate_along_nothing},
    {"walls[1].shape[0]", MNS_E_INVALID, endless_half_space},
    {"walls[1].motion", MNS_E_INVALID, still_sine},
    {"walls[0].motion", MNS_E_INVALID, endless_cosine},
    {"walls[0].motion", MNS_E_INVALID, unknown_motion},
    {"walls[0].motion", MNS_E_INVALID, lone_point},
    {"walls[0].motion", MNS_E_INVALID, falling_table},
    {"walls[0].motion", MNS_E_INVALID, standing_table},
    {"walls[0].surface_velocity[1]", MNS_E_INVALID, bad_surface},
    {"probes[0]", MNS_E_INVALID, probe_of_no_fluid},
    {"probes[1]", MNS_E_INVALID, probe_on_no_wall},
    {"probes[0]", MNS_E_INVALID, probe_along_no_axis},
    {"probes[0]", MNS_E_INVALID, probe_along_less_than_none},
    {"constants[1].name", MNS_E_INVALID, constant_called_as_a_function},
    {"constants[2].name", MNS_E_INVALID, constant_called_as_a_word},
    {"probes[1].name", MNS_E_INVALID, probe_called_as_a_column},
    {"probes[0]", MNS_E_INVALID, probe_of_no_kind},
    {"probes[1]", MNS_E_INVALID, probe_of_no_field},
    {"probes[0]", MNS_E_INVALID, probe_of_no_fluids},
    {"probes[0].pressure_jump.inside", MNS_E_INVALID, jump_of_all_fluids},
    {"probes[0].pressure_jump.margin", MNS_E_INVALID, jump_with_wide_margin},
    {"probes[2]", MNS_E_INVALID, bad_deviation},
};

static const Refusal ONLY_3D[] = {
    {"walls[1].shape[0]", MNS_E_INVALID, plate_without_normal},
    {"walls[1].shape[0]", MNS_E_INVALID, plate_with_normal_along},
    {"walls[1].shape[0]", MNS_E_INVALID, plate_without_width},
};

/* Spoil a shallow copy, so that the lists' lengths are still known when the case is freed. */
static void assert_refused(int dim, const Refusal *refusal, size_t k, bool build)
{
    MnsCase *c = good(dim), spoilt = *c;
    MnsError error = {0};
    MnsSim *sim = NULL;
    refusal->spoil(&spoilt);
    memcpy(c->gravity, spoilt.gravity, sizeof c->gravity);
    memcpy(c->displacement, spoilt.displacement, sizeof c->displacement);
    const MnsStatus status = build ? mns_sim_new(&spoilt, &sim, &error) : mns_case_check(&spoilt, &error);
    if (status != refusal->status || strcmp(error.path, refusal->path) != 0)
        fail_msg("%d dimensions, refusal %zu, \"%s\": status %s, path \"%s\", \"%s\"", dim, k, refusal->path,
                 mns_status_name(status), error.path, error.text);
    assert_int_equal(error.status, status);
    assert_true(strlen(error.text) > 10);
    assert_null(sim);
    assert_int_equal(build ? mns_sim_new(&spoilt, &sim, NULL) : mns_case_check(&spoilt, NULL), status);
    mns_case_free(c);
}

static void what_is_good_is_not_refused(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        MnsCase *c = good(dim);
        MnsError error = {0};
        if (mns_case_check(c, &error)) fail_msg("%s: %s", error.path, error.text);
        mns_case_free(c);
    }
}

static void every_fault_is_refused_where_it_is(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (size_t k = 0; k < sizeof REFUSALS / sizeof *REFUSALS; k++) assert_refused(dim, &REFUSALS[k], k, false);
    for (size_t k = 0; k < sizeof ONLY_3D / sizeof *ONLY_3D; k++) assert_refused(3, &ONLY_3D[k], k, false);
}

/* Numbers near 2^k are 2^(k-52) apart. With dx = 0.1 m, 2^29 m = 5.4e8 m is where that becomes more than 1e-7 m. What is far away
 * and decides nothing near is no matter: sides of a box, the point of a plane along it. */
static void coordinates_are_refused_where_their_rounding_is_a_millionth_of_a_spacing(void **state)
{
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int k = 0; k < dim; k++) {
            MnsCase *c = case_blank(dim, 10);
            MnsError error = {0};
            case_add_fluid(c, "water", 1, 10);
            MnsPart *box = case_add_part(&c->fluids[0].shape, MNS_BOX);
            for (int d = 0; d < 3; d++) box->b[d] = -(box->a[d] = -1e30);
            MnsPart *plane = case_add_part(&c->fluids[0].shape, MNS_HALF_SPACE);
            plane->a[0] = 1e30;
            plane->b[1] = 2;
            for (int sign = -1; sign <= 1; sign += 2) {
                c->min[k] = sign * (ldexp(1, 29) - 2);
                c->max[k] = c->min[k] + 1;
                if (mns_case_check(c, &error)) fail_msg("%s: %s", error.path, error.text);
                c->min[k] = sign * (ldexp(1, 29) + 2);
                c->max[k] = c->min[k] + 1;
                assert_int_equal(mns_case_check(c, &error), MNS_E_INVALID);
                assert_string_equal(error.path, "domain");
                assert_non_null(strstr(error.text, "allowed: up to 5.36871e+08 m"));
            }
            mns_case_free(c);
        }
}

/* The plate of two dimensions has no width, and its normal follows from its length. */
static void what_only_three_dimensions_need_is_not_asked_of_two(void **state)
{
    (void)state;
    for (size_t k = 0; k < sizeof ONLY_3D / sizeof *ONLY_3D; k++) {
        MnsCase *c = good(2);
        ONLY_3D[k].spoil(c);
        assert_int_equal(mns_case_check(c, NULL), MNS_OK);
        mns_case_free(c);
    }
}

/* What the complaint says is allowed is so, with room for particles that move; two dimensions never come near. */
static void kernel_that_reaches_too_many_is_refused_with_what_is_allowed(void **state)
{
    (void)state;
    static const struct {
        MnsKernel kernel;
        double most;
        const char *allowed;
    } rows[] = {{MNS_WENDLAND_C2, 2.86, "up to 2.86"},
                {MNS_TRUNCATED_GAUSSIAN, 1.91, "up to 1.91"},
                {MNS_QUINTIC_SPLINE, 1.91, "up to 1.91"}};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        MnsCase *c = case_periodic(3, 15), *flat = case_periodic(2, 30);
        MnsError error = {0};
        MnsSim *sim = NULL;
        c->scheme.kernel = flat->scheme.kernel = rows[k].kernel;
        c->scheme.smoothing = rows[k].most + 0.01;
        assert_int_equal(mns_case_check(c, &error), MNS_E_LIMIT);
        assert_string_equal(error.path, "scheme.smoothing");
        if (!strstr(error.text, rows[k].allowed)) fail_msg("%s", error.text);
        c->scheme.smoothing = rows[k].most;
        if (mns_sim_new(c, &sim, &error)) fail_msg("%s", error.text);
        for (int step = 0; step < 3; step++) assert_int_equal(mns_sim_step(sim, INFINITY, &error), MNS_OK);
        mns_sim_free(sim);
        flat->scheme.smoothing = 4;
        assert_int_equal(mns_case_check(flat, &error), MNS_OK);
        mns_case_free(flat);
        mns_case_free(c);
    }
}

static void new_simulation_refuses_what_the_check_refuses(void **state)
{
    (void)state;
    assert_refused(2, &REFUSALS[0], 0, true);
    assert_refused(3, &ONLY_3D[0], 0, true);
}

static void overlap(MnsCase *c)
{
    MnsPart *part = case_add_part(&c->fluids[1].shape, MNS_BOX);
    part->a[0] = 1.5;
    part->b[0] = 5.4;
    part->b[1] = part->b[2] = 2;
}
static void sliver(MnsCase *c)
{
    MnsPart *part = &c->fluids[0].shape.parts[0];
    part->a[1] = 0.06;
    part->b[1] = 0.14; /* between two rows of points */
}
static void wall_far_away(MnsCase *c)
{
    MnsPart *part = &c->walls[1].shape.parts[0];
    part->a[0] = 40;
}
static void oblique_gravity(MnsCase *c)
{
    case_set_text(&c->gravity[0], "0.1");
    case_set_text(&c->fluids[1].pressure, "hydrostatic");
}
static void weightless_column(MnsCase *c)
{
    case_set_text(&c->gravity[1], "0");
    case_set_text(&c->fluids[0].pressure, "hydrostatic");
}
static void vacuum(MnsCase *c)
{
    case_set_text(&c->fluids[0].pressure, "-401");
} /* rho c^2 = 400 */
static void infinite_pressure(MnsCase *c)
{
    case_set_text(&c->fluids[1].pressure, "1/(x - x)");
}
static void nan_velocity(MnsCase *c)
{
    case_set_text(&c->fluids[0].velocity[1], "sqrt(-x)");
}

static void what_only_placing_particles_shows_is_refused_then(void **state)
{
    (void)state;
    static const Refusal refusals[] = {
        {"fluids[1].shape", MNS_E_INVALID, overlap},
        {"fluids[0]", MNS_E_INVALID, sliver},
        {"walls[1].shape", MNS_E_INVALID, wall_far_away},
        {"walls[1].shape", MNS_E_INVALID, thin_plate},
        {"fluids[1].pressure", MNS_E_INVALID, oblique_gravity},
        {"fluids[0].pressure", MNS_E_INVALID, weightless_column},
        {"fluids[0].pressure", MNS_E_INVALID, vacuum},
        {"fluids[1].pressure", MNS_E_INVALID, infinite_pressure},
        {"fluids[0].velocity[1]", MNS_E_INVALID, nan_velocity},
    };
    for (int dim = 2; dim <= 3; dim++)
        for (size_t k = 0; k < sizeof refusals / sizeof *refusals; k++) assert_refused(dim, &refusals[k], k, true);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_good_is_not_refused),
        cmocka_unit_test(every_fault_is_refused_where_it_is),
        cmocka_unit_test(coordinates_are_refused_where_their_rounding_is_a_millionth_of_a_spacing),
        cmocka_unit_test(what_only_three_dimensions_need_is_not_asked_of_two),
        cmocka_unit_test(kernel_that_reaches_too_many_is_refused_with_what_is_allowed),
        cmocka_unit_test(new_simulation_refuses_what_the_check_refuses),
        cmocka_unit_test(what_only_placing_particles_shows_is_refused_then),
    };
    return cmocka_run_group_tests_name("check", tests, NULL, NULL);
}
