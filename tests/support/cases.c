/* SPDX-License-Identifier: BSD-3-Clause */
/* Small cases made in C. */
#include "tests/support/cases.h"
#include <stdlib.h>
#include <string.h>

static void *must(void *p)
{
    if (!p) abort();
    return p;
}

void case_set_text(char **entry, const char *text)
{
    free(*entry);
    *entry = must(strdup(text));
}

MnsCase *case_blank(int dim, double resolution)
{
    MnsCase *c = must(calloc(1, sizeof *c));
    case_set_text(&c->title, "a test");
    c->dim = dim;
    c->reference_length = 1;
    c->resolution = resolution;
    for (int d = 0; d < 3; d++) {
        c->max[d] = d < dim ? 1 : 0;
        case_set_text(&c->gravity[d], "0");
        case_set_text(&c->displacement[d], "0");
    }
    c->scheme = (MnsSchemeOptions){.name = "riemann",
                                   .kernel = MNS_WENDLAND_C2,
                                   .smoothing = 1.3,
                                   .cfl = 0.25,
                                   .skin = 0.3,
                                   .riemann = {.limiter = 3,
                                               .reconstruction = MNS_RECONSTRUCTION_VELOCITY,
                                               .background_pressure = 4,
                                               .heavy_background_pressure = 0.5,
                                               .guard = 0.25,
                                               .transport_stress = true},
                                   .dissipation = {.delta = 0.5, .repulsion = 0.08, .guard = 0.25},
                                   .interfacial = {.delta = 1,
                                                   .shifting = MNS_SHIFTING_INTERFACE,
                                                   .shifting_strength = 2,
                                                   .pair_average = MNS_AVERAGE_DENSITY,
                                                   .guard = 0.25},
                                   .incompressible = {.density_tolerance = 0.01,
                                                      .density_corrections = 200,
                                                      .density_patience = 50,
                                                      .density_offset = 0.3,
                                                      .reference_speed = -1,
                                                      .tolerance = 1e-4,
                                                      .density_solver_tolerance = 0.1,
                                                      .iterations = 5000,
                                                      .guard = 0.25},
                                   .differences = {.interface_threshold = 0.01,
                                                   .shifting_strength = 0.2,
                                                   .shift_across_interfaces = true,
                                                   .buoyant_in = -1,
                                                   .reference_speed = -1,
                                                   .tolerance = 1e-6,
                                                   .iterations = 5000,
                                                   .guard = 0.25}};
    c->end_time = 1;
    c->threads = 1;
    c->limits = (MnsLimits){1e-4, 0.1, 10};
    return c;
}

void case_add_fluid(MnsCase *c, const char *name, double density, double sound_speed)
{
    c->fluids = must(realloc(c->fluids, (c->n_fluids + 1) * sizeof *c->fluids));
    MnsFluid *f = &c->fluids[c->n_fluids++];
    *f = (MnsFluid){.density = density, .sound_speed = sound_speed};
    case_set_text(&f->name, name);
    case_set_text(&f->pressure, "0");
    for (int d = 0; d < 3; d++) case_set_text(&f->velocity[d], "0");
}

void case_add_wall(MnsCase *c, const char *name)
{
    c->walls = must(realloc(c->walls, (c->n_walls + 1) * sizeof *c->walls));
    MnsWall *wall = &c->walls[c->n_walls++];
    *wall = (MnsWall){0};
    case_set_text(&wall->name, name);
    for (int d = 0; d < 3; d++) case_set_text(&wall->surface_velocity[d], "0");
}

MnsProbe *case_add_probe(MnsCase *c, MnsProbeKind kind)
{
    c->probes = must(realloc(c->probes, (c->n_probes + 1) * sizeof *c->probes));
    MnsProbe *probe = &c->probes[c->n_probes++];
    *probe = (MnsProbe){.kind = kind, .fluid = -1, .wall = -1};
    case_set_text(&probe->name, "probe");
    case_set_text(&probe->field, "");
    case_set_text(&probe->formula, "0");
    return probe;
}

MnsPart *case_add_part(MnsShape *shape, MnsPrimitive primitive)
{
    shape->parts = must(realloc(shape->parts, (shape->n + 1) * sizeof *shape->parts));
    MnsPart *part = &shape->parts[shape->n++];
    *part = (MnsPart){.primitive = primitive};
    case_set_text(&part->formula, "");
    return part;
}

MnsCase *case_dam_break(int dim, double resolution)
{
    MnsCase *c = case_blank(dim, resolution);
    c->max[0] = 5.366;
    c->max[1] = 2;
    case_set_text(&c->gravity[1], "-1");
    case_add_fluid(c, "water", 1, 20);
    case_add_fluid(c, "air", 0.001, 20);
    MnsPart *column = case_add_part(&c->fluids[0].shape, MNS_BOX);
    column->b[0] = 2;
    column->b[1] = column->b[2] = 1;
    case_add_wall(c, "tank");
    MnsPart *tank = case_add_part(&c->walls[0].shape, MNS_BOX);
    tank->outside = true;
    for (int d = 0; d < 3; d++) tank->b[d] = c->max[d];
    return c;
}

MnsCase *case_periodic(int dim, double resolution)
{
    MnsCase *c = case_blank(dim, resolution);
    for (int d = 0; d < dim; d++) c->periodic[d] = true;
    case_add_fluid(c, "water", 1, 10);
    case_add_fluid(c, "oil", 0.1, 10);
    MnsPart *left = case_add_part(&c->fluids[0].shape, MNS_BOX);
    left->b[0] = 0.45;
    left->b[1] = left->b[2] = 1;
    for (size_t k = 0; k < 2; k++) {
        case_set_text(&c->fluids[k].velocity[0], "0.3*sin(2*pi*y)");
        case_set_text(&c->fluids[k].velocity[1], "0.5*cos(2*pi*x) + 0.1");
        if (dim == 3) case_set_text(&c->fluids[k].velocity[2], "0.2*sin(2*pi*(x + y))");
    }
    c->fluids[1].density_method = MNS_DENSITY_SUMMATION;
    return c;
}

MnsCase *case_shaken(int dim, unsigned threads)
{
    MnsCase *c = case_dam_break(dim, dim == 2 ? 12 : 6);
    c->max[0] = c->walls[0].shape.parts[0].b[0] = 3;
    c->fluids[0].viscosity = 1e-3;
    c->fluids[1].viscosity = 1e-6;
    c->walls[0].no_slip = true;
    c->walls[0].motion = (MnsMotion){.kind = MNS_SINE, .amplitude = {0.05, 0.02, 0.01}, .frequency = 1.5, .phase = 0.3};
    c->threads = threads;
    return c;
}

MnsCase *case_shaken_by(const char *scheme, int dim, unsigned threads)
{
    MnsCase *c = case_shaken(dim, threads);
    MnsError error = {0};
    c->scheme.name = scheme;
    c->scheme.skin = 0.1; /* lists are built again soon */
    c->tension[0][1] = c->tension[1][0] = 0.01;
    if (mns_case_check(c, &error) && strcmp(error.path, "interfaces") == 0) c->tension[0][1] = c->tension[1][0] = 0;
    return c;
}

MnsCase *case_still(int dim, double resolution, MnsDensityMethod method)
{
    MnsCase *c = case_periodic(dim, resolution);
    for (int k = 0; k < 2; k++) {
        c->fluids[k].density_method = method;
        for (int d = 0; d < 3; d++) case_set_text(&c->fluids[k].velocity[d], "0");
    }
    return c;
}

MnsPart *case_put_part(int dim, MnsShape *shape, MnsPart part)
{
    MnsPart *p = case_add_part(shape, part.primitive);
    part.formula = p->formula;
    if (dim == 2) part.a[2] = part.b[2] = part.c[2] = 0;
    *p = part;
    return p;
}

MnsCase *case_layers(int dim, double resolution, double heavy)
{
    MnsCase *c = case_blank(dim, resolution);
    c->scheme.name = "incompressible";
    c->scheme.kernel = MNS_QUINTIC_SPLINE;
    c->scheme.smoothing = 1;
    case_set_text(&c->gravity[1], "-1");
    case_add_fluid(c, "heavy", heavy, 10);
    case_add_fluid(c, "light", 1, 10);
    case_add_part(&c->fluids[0].shape, MNS_BOX)->b[1] = 0.5;
    c->fluids[0].shape.parts[0].b[0] = c->fluids[0].shape.parts[0].b[2] = 1;
    for (int k = 0; k < 2; k++) c->fluids[k].viscosity = 0.01 * c->fluids[k].density;
    case_add_wall(c, "tank");
    c->walls[0].no_slip = true;
    MnsPart *tank = case_add_part(&c->walls[0].shape, MNS_BOX);
    tank->outside = true;
    for (int d = 0; d < 3; d++) tank->b[d] = c->max[d];
    return c;
}
