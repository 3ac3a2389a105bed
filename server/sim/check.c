/* SPDX-License-Identifier: BSD-3-Clause */
/* Is a case physical, and can it be built? Each complaint names the entry, what was found and what is allowed. */
#include "sim/check.h"
#include "sim/case_bounds.h"
#include "sim/probes/probes.h"
#include "sim/solve/solve.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

static const char *const XYZ[] = {"x", "y", "z", NULL}, *const XYZT[] = {"x", "y", "z", "t", NULL},
                         *const T[] = {"t", NULL};
static const double STRETCH_MAX = 0.02, PARTICLES_MAX = 2e9;

static double kernel_support(const MnsCase *c)
{
    const double h = c->scheme.smoothing * c->reference_length / c->resolution;
    return kernel_make(c->scheme.kernel, c->dim, h).support;
}

size_t case_fit(const MnsCase *c, int d, double *ret_spacing)
{
    const double length = c->max[d] - c->min[d], dx = c->reference_length / c->resolution;
    const double count = fmax(1, round(length / dx));
    *ret_spacing = length / count;
    return (size_t)count;
}

MnsStatus check_bounds(const char *at, const Bounded *list, size_t n, MnsError *error)
{
    for (size_t k = 0; k < n; k++) {
        char entry[96];
        if (bounds_hold(list[k].bounds, list[k].value)) continue;
        snprintf(entry, sizeof entry, "%s%s%s", at, *at ? "." : "", list[k].entry);
        return mns_fail_at(error, MNS_E_INVALID, entry, "found %g, allowed: %s", list[k].value, list[k].bounds.words);
    }
    return MNS_OK;
}

static MnsStatus check_options(const MnsCase *c, MnsError *error)
{
    const MnsSchemeOptions *o = &c->scheme;
    const MnsLimits *l = &c->limits;
    const MnsOutput *w = &c->output;
    const Bounded list[] = {
        {"scheme.smoothing", o->smoothing, BOUNDS_Scheme_smoothing},
        {"scheme.cfl", o->cfl, BOUNDS_Scheme_cfl},
        {"scheme.skin", o->skin, BOUNDS_Scheme_skin},
        {"domain.disorder", c->disorder, BOUNDS_Domain_disorder},
        {"limits.time_step_floor", l->time_step_floor, BOUNDS_Limits_time_step_floor},
        {"limits.density_min", l->density_min, BOUNDS_Limits_density_min},
        {"limits.density_max", l->density_max, BOUNDS_Limits_density_max},
        {"output.probe_interval", w->probe_interval, BOUNDS_Output_probe_interval},
        {"output.snapshot_interval", w->snapshot_interval, BOUNDS_Output_snapshot_interval},
        {"output.checkpoint_interval", w->checkpoint_interval, BOUNDS_Output_checkpoint_interval},
        {"output.checkpoint_wall_interval", w->checkpoint_wall_interval, BOUNDS_Output_checkpoint_wall_interval},
    };
    if (o->kernel > MNS_QUINTIC_SPLINE)
        return mns_fail_at(error, MNS_E_INVALID, "scheme.kernel", "%u is not one of MnsKernel", (unsigned)o->kernel);
    return CHECK_BOUNDS("", list, error);
}

MnsStatus check_solver(MnsSolver solver, const char *at, MnsError *error)
{
    if (solver != MNS_SOLVER_AMG || amg_exists()) return MNS_OK;
    return mns_fail_at(error, MNS_E_INVALID, at,
                       "found amg, which this program was built without, as it needs the library hypre; write by-size "
                       "or bicgstab");
}

static const double ROUNDING_MAX =
    1e-6; /* of a coordinate, in spacings: differences between neighbours are made of them */

/* Numbers have 53 bits, of which a distant origin leaves few for what is around it. */
static MnsStatus check_rounding(const MnsCase *c, double coordinate, const char *at, MnsError *error)
{
    const double dx = c->reference_length / c->resolution, size = fabs(coordinate);
    const double rounding = nextafter(size, INFINITY) - size;
    if (rounding <= ROUNDING_MAX * dx) return MNS_OK;
    return mns_fail_at(error, MNS_E_INVALID, at,
                       "a coordinate of %g m is rounded to %.2g m, and the spacing is %g m; allowed: up to %g m, with "
                       "which rounding is %g of a spacing. Put the origin near the fluids",
                       coordinate, rounding, dx, ldexp(1, ilogb(ROUNDING_MAX * dx) + 53), ROUNDING_MAX);
}

static MnsStatus check_domain(const MnsCase *c, MnsError *error)
{
    const double dx = c->reference_length / c->resolution;
    const double reach = 2 * (kernel_support(c) + c->scheme.skin * dx);
    double particles = 1;
    for (int d = 0; d < c->dim; d++) {
        const char axis = "xyz"[d];
        const double length = c->max[d] - c->min[d];
        if (!(length > 0))
            return mns_fail_at(error, MNS_E_INVALID, "domain", "the domain is empty: %c runs from %g to %g m", axis,
                               c->min[d], c->max[d]);
        const MnsStatus status = check_rounding(c, fmax(fabs(c->min[d]), fabs(c->max[d])), "domain", error);
        if (status) return status;
        particles *= length / dx;
        if (!(particles < PARTICLES_MAX))
            return mns_fail_at(error, MNS_E_LIMIT, "resolution", "that is %.3g particles or more; %.0e at most",
                               particles, PARTICLES_MAX);
        double spacing = 0;
        case_fit(c, d, &spacing);
        if (fabs(spacing / dx - 1) > STRETCH_MAX)
            return mns_fail_at(error, MNS_E_INVALID, "resolution",
                               "the spacing does not fit: the domain's %c side, %g m, is %.3f spacings of %g m; change "
                               "the resolution or the side so that it is within 2 %% of a whole number",
                               "xyz"[d], length, length / dx, dx);
        if (c->periodic[d] && length < reach)
            return mns_fail_at(error, MNS_E_INVALID, "domain",
                               "the periodic side %c is %g m long; it must be at least twice the reach of a particle, "
                               "%g m, so that none meets its own image",
                               "xyz"[d], length, reach);
    }
    return MNS_OK;
}

/* A row holds the neighbours of a particle in reach of the kernel and the skin, on a lattice and a tenth denser. */
static MnsStatus check_neighbours(const MnsCase *c, MnsError *error)
{
    const double most = 0.9 * ROW_MAX;
    const double dx = c->reference_length / c->resolution, reach = kernel_support(c) / (c->scheme.smoothing * dx);
    const double ball = c->dim == 2 ? M_PI : 4 * M_PI / 3;
    double cell = 1;
    for (int d = 0; d < c->dim; d++) {
        double spacing = 0;
        case_fit(c, d, &spacing);
        cell *= spacing / dx;
    }
    const double distance = pow(most * cell / ball, 1.0 / c->dim), smoothing = (distance - c->scheme.skin) / reach;
    if (c->scheme.smoothing <= smoothing) return MNS_OK;
    return mns_fail_at(error, MNS_E_LIMIT, "scheme.smoothing",
                       "with %g a particle would have more than %g neighbours; in %d dimensions, with this kernel of "
                       "support %g h and a skin of %g, allowed: up to %.2f",
                       c->scheme.smoothing, floor(most), c->dim, reach, c->scheme.skin, floor(100 * smoothing) / 100);
}

static double norm2(const double a[3])
{
    return a[0] * a[0] + a[1] * a[1] + a[2] * a[2];
}

static MnsStatus check_plate(const MnsPart *p, int dim, const char *at, MnsError *error)
{
    const double along = p->b[0] * p->c[0] + p->b[1] * p->c[1] + p->b[2] * p->c[2];
    if (!(norm2(p->b) > 0)) return mns_fail_at(error, MNS_E_INVALID, at, "`along` must not be zero");
    if (dim == 3 && !(norm2(p->b) * norm2(p->c) - along * along > 1e-12 * norm2(p->b) * norm2(p->c)))
        return mns_fail_at(error, MNS_E_INVALID, at, "`normal` is missing or parallel to `along`");
    if (dim == 3 && !(p->width > 0))
        return mns_fail_at(error, MNS_E_INVALID, at, "in three dimensions a plate needs a `width` above 0, found %g m",
                           p->width);
    if (!(p->thickness > 0))
        return mns_fail_at(error, MNS_E_INVALID, at, "the thickness must be above 0, found %g m", p->thickness);
    return MNS_OK;
}

/* The largest number that is rounded where a distance from the surface is found. Sides and ends that are far away are nowhere near, and
 * the point of a plane may be far along it. */
static double largest_coordinate(const MnsPart *p, int dim)
{
    const double length = sqrt(norm2(p->b));
    const bool round = p->primitive == MNS_BALL || p->primitive == MNS_CYLINDER;
    double largest = round ? p->radius : 0;
    for (int d = 0; d < dim; d++) {
        if (round || p->primitive == MNS_PLATE) largest = fmax(largest, fabs(p->a[d]));
        if (p->primitive == MNS_CYLINDER) largest = fmax(largest, fabs(p->b[d]));
        if (p->primitive == MNS_HALF_SPACE) largest = fmax(largest, fabs(p->a[d] * p->b[d] / length));
    }
    return largest;
}

static MnsStatus check_primitive(const MnsPart *p, const MnsCase *c, bool solid, const char *at, MnsError *error)
{
    switch (p->primitive) {
    case MNS_BOX:
        for (int d = 0; d < c->dim; d++) {
            const char axis = "xyz"[d];
            if (!(p->b[d] > p->a[d]))
                return mns_fail_at(error, MNS_E_INVALID, at, "the box is empty: %c runs from %g to %g m", axis, p->a[d],
                                   p->b[d]);
        }
        return MNS_OK;
    case MNS_BALL:
        if (!(p->radius > 0))
            return mns_fail_at(error, MNS_E_INVALID, at, "the radius must be above 0, found %g m", p->radius);
        return MNS_OK;
    case MNS_CYLINDER: {
        const double axis[3] = {p->b[0] - p->a[0], p->b[1] - p->a[1], p->b[2] - p->a[2]};
        if (!(norm2(axis) > 0))
            return mns_fail_at(error, MNS_E_INVALID, at, "the cylinder is empty: both ends are at (%g, %g, %g) m",
                               p->a[0], p->a[1], p->a[2]);
        if (!(p->radius > 0))
            return mns_fail_at(error, MNS_E_INVALID, at, "the radius must be above 0, found %g m", p->radius);
        return MNS_OK;
    }
    case MNS_PLATE: return check_plate(p, c->dim, at, error);
    case MNS_HALF_SPACE:
        if (!(norm2(p->b) > 0)) return mns_fail_at(error, MNS_E_INVALID, at, "the normal must not be zero");
        for (int d = 0; d < c->dim; d++)
            if (solid && c->periodic[d] && fabs(p->b[d]) > 1e-9 * sqrt(norm2(p->b)))
                return mns_fail_at(error, MNS_E_INVALID, at,
                                   "a half space has no end, so it cannot repeat itself along %c, which is periodic: "
                                   "use a box or a plate",
                                   "xyz"[d]);
        return MNS_OK;
    case MNS_FORMULA:
        if (solid)
            return mns_fail_at(error, MNS_E_INVALID, at,
                               "a wall cannot be given by a formula, which does not say how far away its surface is");
        return MNS_OK;
    }
    return mns_fail_at(error, MNS_E_INVALID, at, "unknown primitive");
}

static MnsStatus check_part(const MnsPart *p, const MnsCase *c, bool solid, const char *at, MnsError *error)
{
    const MnsStatus status = check_primitive(p, c, solid, at, error);
    return status ? status : check_rounding(c, largest_coordinate(p, c->dim), at, error);
}

static MnsStatus check_shape(const MnsShape *shape, const MnsCase *c, const Constants *constants, bool solid,
                             const char *at, MnsError *error)
{
    for (size_t k = 0; k < shape->n; k++) {
        char part[96];
        snprintf(part, sizeof part, "%s[%zu]", at, k);
        const MnsStatus status = check_part(&shape->parts[k], c, solid, part, error);
        if (status) return status;
    }
    Shape compiled;
    const MnsStatus status = shape_init(&compiled, shape, c->dim, constants->list, constants->n, at, error);
    shape_done(&compiled);
    return status;
}

static MnsStatus check_formula(const char *text, const char *const *variables, const Constants *constants,
                               const char *at, MnsError *error)
{
    Formula *formula = NULL;
    MnsStatus status = formula_new(text, variables, constants->list, constants->n, &formula, error);
    if (!status && formula_is_condition(formula))
        status = mns_fail(error, MNS_E_INVALID, "\"%.120s\" is true or false; a number is needed", text);
    if (status && error) snprintf(error->path, sizeof error->path, "%s", at);
    formula_free(formula);
    return status;
}

static MnsStatus check_formulas(char *const *texts, int n, const char *const *variables, const Constants *constants,
                                const char *at, MnsError *error)
{
    for (int d = 0; d < n; d++) {
        char entry[96];
        snprintf(entry, sizeof entry, "%s[%d]", at, d);
        const MnsStatus status = check_formula(texts[d], variables, constants, entry, error);
        if (status) return status;
    }
    return MNS_OK;
}

static MnsStatus check_fluid(const MnsCase *c, size_t k, const Constants *constants, MnsError *error)
{
    const MnsFluid *f = &c->fluids[k];
    char at[64];
    snprintf(at, sizeof at, "fluids[%zu]", k);
    const Bounded list[] = {
        {"density", f->density, BOUNDS_Fluid_density},
        {"viscosity", f->viscosity, BOUNDS_Fluid_viscosity},
        {"sound_speed", scheme_find(c->scheme.name)->projects ? 1 : f->sound_speed, BOUNDS_Fluid_sound_speed},
        {"exponent", f->exponent == 0 ? 1 : f->exponent, BOUNDS_Fluid_exponent}};
    MnsStatus status = CHECK_BOUNDS(at, list, error);
    if (status) return status;
    for (size_t other = 0; other < k; other++)
        if (f->shape.n == 0 && c->fluids[other].shape.n == 0)
            return mns_fail_at(error, MNS_E_INVALID, at,
                               "both %s and %s have no shape; one fluid at most can take what the others leave",
                               c->fluids[other].name, f->name);
    snprintf(at, sizeof at, "fluids[%zu].shape", k);
    status = check_shape(&f->shape, c, constants, false, at, error);
    if (status) return status;
    snprintf(at, sizeof at, "fluids[%zu].velocity", k);
    status = check_formulas(f->velocity, c->dim, XYZ, constants, at, error);
    if (status || strcmp(f->pressure, "hydrostatic") == 0 || strcmp(f->pressure, "laplace") == 0) return status;
    snprintf(at, sizeof at, "fluids[%zu].pressure", k);
    return check_formula(f->pressure, XYZ, constants, at, error);
}

static MnsStatus check_table(const MnsMotion *motion, const char *at, MnsError *error)
{
    if (motion->n < 2) return mns_fail_at(error, MNS_E_INVALID, at, "a table of motion needs two points at least");
    for (size_t k = 1; k < motion->n; k++)
        if (!(motion->points[k].t > motion->points[k - 1].t))
            return mns_fail_at(error, MNS_E_INVALID, at, "times must rise: point %zu is at %g s after %g s", k,
                               motion->points[k].t, motion->points[k - 1].t);
    return MNS_OK;
}

/* By how much a wall is displaced at most, about. */
static double largest_displacement(const MnsMotion *motion, int dim)
{
    double largest = 0;
    for (int d = 0; d < dim; d++) {
        if (motion->kind == MNS_SINE || motion->kind == MNS_ONE_MINUS_COSINE)
            largest = fmax(largest, 2 * fabs(motion->amplitude[d]));
        for (size_t k = 0; motion->kind == MNS_TABLE && k < motion->n; k++)
            largest = fmax(largest, fabs(motion->points[k].x[d]));
    }
    return largest;
}

static MnsStatus check_motion(const MnsMotion *motion, const char *at, MnsError *error)
{
    switch (motion->kind) { /* no default: the compiler tells of a kind that is missing */
    case MNS_STILL: return MNS_OK;
    case MNS_SINE:
    case MNS_ONE_MINUS_COSINE:
        if (bounds_hold(BOUNDS_Oscillation_frequency, motion->frequency)) return MNS_OK;
        return mns_fail_at(error, MNS_E_INVALID, at, "found a frequency of %g, allowed: %s", motion->frequency,
                           BOUNDS_Oscillation_frequency.words);
    case MNS_TABLE: return check_table(motion, at, error);
    }
    return mns_fail_at(error, MNS_E_INVALID, at, "unknown kind of motion, %d", (int)motion->kind);
}

static MnsStatus check_wall(const MnsCase *c, size_t k, const Constants *constants, MnsError *error)
{
    const MnsWall *wall = &c->walls[k];
    char at[64];
    snprintf(at, sizeof at, "walls[%zu].shape", k);
    if (wall->shape.n == 0) return mns_fail_at(error, MNS_E_INVALID, at, "a wall needs a shape");
    MnsStatus status = check_shape(&wall->shape, c, constants, true, at, error);
    if (status) return status;
    snprintf(at, sizeof at, "walls[%zu].motion", k);
    status = check_motion(&wall->motion, at, error);
    if (!status) status = check_rounding(c, largest_displacement(&wall->motion, c->dim), at, error);
    if (status) return status;
    snprintf(at, sizeof at, "walls[%zu].surface_velocity", k);
    return check_formulas(wall->surface_velocity, c->dim, T, constants, at, error);
}

/* Forces of a surface reach as far as the kernel does, and lists of neighbours not much farther. */
static MnsStatus check_margin(const MnsCase *c, const MnsProbe *probe, const char *at, MnsError *error)
{
    const double support = kernel_support(c);
    if (probe->radius >= 0 && probe->radius <= support * (1 + 1e-9)) return MNS_OK;
    return mns_fail_at(error, MNS_E_INVALID, at, "found %g, allowed: up to %g m, the kernel's support", probe->radius,
                       support);
}

/* What a kind uses is told by the table of kinds. */
static MnsStatus check_probe(const MnsCase *c, size_t k, const Constants *constants, MnsError *error)
{
    const MnsProbe *probe = &c->probes[k];
    const ProbeKind *kind = probe_kind(probe);
    char at[64], entry[96];
    snprintf(at, sizeof at, "probes[%zu]", k);
    if (!kind) return mns_fail_at(error, MNS_E_INVALID, at, "unknown kind of probe, %d", (int)probe->kind);
    if (!strcmp(probe->name, "time") || !strcmp(probe->name, "step")) {
        snprintf(entry, sizeof entry, "%s.name", at);
        return mns_fail_at(error, MNS_E_INVALID, entry,
                           "\"%s\" is a column that every series has: choose another name. Reserved are time and step",
                           probe->name);
    }
    if (probe->fluid >= (int)c->n_fluids)
        return mns_fail_at(error, MNS_E_INVALID, at, "there is no fluid %d: allowed 0 to %zu, or -1 for all",
                           probe->fluid, c->n_fluids - 1);
    if (probe->fluids >> c->n_fluids)
        return mns_fail_at(error, MNS_E_INVALID, at, "a set of fluids, %#x, has more than the case's %zu",
                           probe->fluids, c->n_fluids);
    if (probe->wall >= (int)c->n_walls)
        return mns_fail_at(error, MNS_E_INVALID, at, "there is no wall %d: the case has %zu", probe->wall, c->n_walls);
    if (probe->axis < 0 || probe->axis >= c->dim)
        return mns_fail_at(error, MNS_E_INVALID, at, "there is no axis %d: allowed 0 to %d", probe->axis, c->dim - 1);
    if (kind->uses & PROBE_FIELD && mns_field_find(probe->field) < 0)
        return mns_fail_at(error, MNS_E_INVALID, at, "there is no field \"%s\"", probe->field);
    snprintf(entry, sizeof entry, "%s.%s.inside", at, kind->name);
    if (kind->uses & PROBE_INSIDE && probe->fluid < 0)
        return mns_fail_at(error, MNS_E_INVALID, entry, "all fluids have no outside: name one");
    snprintf(entry, sizeof entry, "%s.%s.margin", at, kind->name);
    if (kind->uses & PROBE_INSIDE && check_margin(c, probe, entry, error)) return MNS_E_INVALID;
    return kind->uses & PROBE_FORMULA ? check_formula(probe->formula, XYZT, constants, at, error) : MNS_OK;
}

static MnsStatus check_scalars(const MnsCase *c, MnsError *error)
{
    if (c->dim != 2 && c->dim != 3)
        return mns_fail_at(error, MNS_E_INVALID, "dimensions", "found %d, allowed: 2 or 3", c->dim);
    const double end = isinf(c->end_time) && c->end_time > 0 ? 0 : c->end_time; /* a C program may stop when it likes */
    const Bounded list[] = {{"reference_length", c->reference_length, BOUNDS_Case_reference_length},
                            {"resolution", c->resolution, BOUNDS_Case_resolution},
                            {"end_time", end, BOUNDS_Case_end_time},
                            {"threads", c->threads, BOUNDS_Case_threads}};
    const MnsStatus status = CHECK_BOUNDS("", list, error);
    if (status) return status;
    if (!scheme_find(c->scheme.name))
        return mns_fail_at(error, MNS_E_INVALID, "scheme", "there is no scheme \"%s\"", c->scheme.name);
    if (c->n_fluids == 0 || c->n_fluids > MNS_MAX_FLUIDS)
        return mns_fail_at(error, MNS_E_LIMIT, "fluids", "found %zu fluids, allowed: 1 to %d", c->n_fluids,
                           MNS_MAX_FLUIDS);
    if (c->n_walls > MNS_MAX_WALLS)
        return mns_fail_at(error, MNS_E_LIMIT, "walls", "found %zu walls, allowed: up to %d", c->n_walls,
                           MNS_MAX_WALLS);
    if (c->n_probes > MNS_MAX_PROBES)
        return mns_fail_at(error, MNS_E_LIMIT, "probes", "found %zu probes, allowed: up to %d", c->n_probes,
                           MNS_MAX_PROBES);
    return MNS_OK;
}

/* Each with the ones before it. */
static MnsStatus check_constants(const Constants *constants, MnsError *error)
{
    static const char *const none[] = {NULL};
    for (size_t k = 1; k < constants->n; k++) { /* after dx, which is ours */
        const Constants before = {.n = k, .list = constants->list};
        char at[64];
        snprintf(at, sizeof at, "constants[%zu].value", k - 1);
        const MnsStatus status = check_formula(constants->list[k].value, none, &before, at, error);
        if (status) return status;
    }
    return MNS_OK;
}

static MnsStatus check_interfaces(const MnsCase *c, MnsError *error)
{
    for (size_t a = 0; a < c->n_fluids; a++)
        for (size_t b = 0; b < c->n_fluids; b++) {
            const double sigma = c->tension[a][b];
            if (!bounds_hold(BOUNDS_Interface_tension, sigma))
                return mns_fail_at(error, MNS_E_INVALID, "interfaces", "found a tension of %g, allowed: %s", sigma,
                                   BOUNDS_Interface_tension.words);
            if (sigma != c->tension[b][a] || (a == b && sigma != 0))
                return mns_fail_at(error, MNS_E_INVALID, "interfaces",
                                   "a tension is between two fluids, and the same either way round");
        }
    return MNS_OK;
}

static MnsStatus check_entries(const MnsCase *c, const Constants *constants, MnsError *error)
{
    MnsStatus status = check_constants(constants, error);
    if (!status) status = check_formulas(c->gravity, c->dim, T, constants, "gravity", error);
    if (!status) status = check_formulas(c->displacement, c->dim, XYZ, constants, "domain.displacement", error);
    for (size_t k = 0; !status && k < c->n_fluids; k++) status = check_fluid(c, k, constants, error);
    if (!status) status = check_interfaces(c, error);
    for (size_t k = 0; !status && k < c->n_walls; k++) status = check_wall(c, k, constants, error);
    for (size_t k = 0; !status && k < c->n_probes; k++) status = check_probe(c, k, constants, error);
    return status;
}

/* A constant must not take the place of what formulas mean by the same name. */
static MnsStatus check_constant_names(const MnsCase *c, MnsError *error)
{
    char entry[64];
    for (size_t k = 0; k < c->n_constants; k++) {
        const char *meaning = formula_reserved(c->constants[k].name);
        if (!meaning) continue;
        snprintf(entry, sizeof entry, "constants[%zu].name", k);
        return mns_fail_at(
            error, MNS_E_INVALID, entry,
            "\"%.40s\" is %s: choose another name. Reserved are x, y, z, t, dx, step, pi, functions such "
            "as sin, words such as and, and what begins with an underscore and a capital letter",
            c->constants[k].name, meaning);
    }
    return MNS_OK;
}

MnsStatus mns_case_check(const MnsCase *c, MnsError *error)
{
    MnsStatus status = check_scalars(c, error);
    if (!status) status = check_options(c, error);
    if (!status) status = scheme_find(c->scheme.name)->check(c, error);
    if (!status) status = check_domain(c, error);
    if (!status) status = check_neighbours(c, error);
    if (!status) status = check_constant_names(c, error);
    if (status) return status;
    Constants constants;
    status = constants_init(&constants, c, error);
    if (!status) status = check_entries(c, &constants, error);
    constants_done(&constants);
    return status;
}
