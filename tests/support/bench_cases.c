/* SPDX-License-Identifier: BSD-3-Clause */
#include "tests/support/bench_cases.h"
#include "tests/support/cases.h"
#include <string.h>

MnsCase *bench_dam_break(int dim, double resolution)
{
    MnsCase *c = case_dam_break(dim, resolution);
    for (size_t k = 0; k < c->n_fluids; k++) {
        case_set_text(&c->fluids[k].velocity[0], "1.5*sin(pi*x/5.366)*cos(pi*y/2)");
        case_set_text(&c->fluids[k].velocity[1], "-1.5*2/5.366*cos(pi*x/5.366)*sin(pi*y/2)");
    }
    return c;
}

/* A drop in a box of another liquid, both viscous: what schemes with surface tension are measured by. */
MnsCase *bench_droplet(int dim, double resolution)
{
    MnsCase *c = case_blank(dim, resolution);
    case_add_fluid(c, "oil", 1, 20);
    case_add_fluid(c, "water", 0.5, 20);
    MnsPart *drop = case_add_part(&c->fluids[0].shape, MNS_BALL);
    for (int d = 0; d < 3; d++) {
        c->periodic[d] = d < dim;
        drop->a[d] = d < dim ? 0.5 : 0;
    }
    drop->radius = 0.3;
    for (int k = 0; k < 2; k++) {
        c->fluids[k].viscosity = 0.01;
        case_set_text(&c->fluids[k].velocity[0], "sin(2*pi*x)*cos(2*pi*y)");
        case_set_text(&c->fluids[k].velocity[1], "-cos(2*pi*x)*sin(2*pi*y)");
    }
    return c;
}

/* The same with surface tension, by P2 with the smoothing of its cases. */
MnsCase *bench_tense_droplet(int dim, double resolution)
{
    MnsCase *c = bench_droplet(dim, resolution);
    c->scheme.name = "interfacial";
    c->scheme.smoothing = 1.6;
    c->scheme.interfacial.background_pressure = 4;
    c->tension[0][1] = c->tension[1][0] = 0.1;
    return c;
}

/* The same with the smoothing that other programs have for such a drop: 80 neighbours in space. */
MnsCase *bench_narrow_droplet(int dim, double resolution)
{
    MnsCase *c = bench_tense_droplet(dim, resolution);
    c->scheme.smoothing = 1.3;
    return c;
}

/* The same in a tank to which both stick, by P1 with the kernel of its cases. */
MnsCase *bench_drop_in_tank(int dim, double resolution)
{
    MnsCase *c = bench_tense_droplet(dim, resolution);
    c->scheme.name = "dissipation";
    c->scheme.kernel = MNS_TRUNCATED_GAUSSIAN;
    c->scheme.smoothing = 1.1;
    c->scheme.dissipation.background_pressure = 4;
    case_add_wall(c, "tank");
    c->walls[0].no_slip = true;
    MnsPart *tank = case_add_part(&c->walls[0].shape, MNS_BOX);
    tank->outside = true;
    for (int d = 0; d < dim; d++) {
        c->periodic[d] = false;
        tank->b[d] = c->max[d];
    }
    return c;
}

/* Without sound. */
MnsCase *bench_incompressible_droplet(int dim, double resolution)
{
    MnsCase *c = bench_droplet(dim, resolution);
    c->scheme.name = "incompressible";
    c->scheme.kernel = MNS_QUINTIC_SPLINE;
    c->scheme.smoothing = 1;
    c->scheme.incompressible.reference_speed = 1;
    c->tension[0][1] = c->tension[1][0] = 0.1;
    return c;
}

/* The same by P5, with the whole divergence of the stress. */
MnsCase *bench_differenced_droplet(int dim, double resolution)
{
    MnsCase *c = bench_droplet(dim, resolution);
    c->scheme.name = "differences";
    c->scheme.differences.reference_speed = 1;
    c->tension[0][1] = c->tension[1][0] = 0.1;
    return c;
}

/* Without sound, of one fluid: Taylor-Green vortices at Reynolds number 100, in disorder as in the case of that name. */
static MnsCase *vortices(int dim, double resolution, const char *scheme)
{
    MnsCase *c = case_blank(dim, resolution);
    c->scheme.name = scheme;
    c->scheme.kernel = MNS_QUINTIC_SPLINE;
    c->scheme.smoothing = strcmp(scheme, "differences") ? 1 : 0.9;
    c->scheme.incompressible.reference_speed = c->scheme.differences.reference_speed = 1;
    c->disorder = 0.1;
    for (int d = 0; d < dim; d++) c->periodic[d] = true;
    case_add_fluid(c, "liquid", 1, 10);
    c->fluids[0].viscosity = 0.01;
    case_set_text(&c->fluids[0].velocity[0], "-cos(2*pi*x)*sin(2*pi*y)");
    case_set_text(&c->fluids[0].velocity[1], "sin(2*pi*x)*cos(2*pi*y)");
    return c;
}

MnsCase *bench_projected_vortices(int dim, double resolution)
{
    return vortices(dim, resolution, "incompressible");
}

MnsCase *bench_differenced_vortices(int dim, double resolution)
{
    return vortices(dim, resolution, "differences");
}

/* The same fluid, heavy, in a tank that it fills and sticks to. */
static MnsCase *tank(int dim, double resolution, const char *scheme)
{
    MnsCase *c = vortices(dim, resolution, scheme);
    c->disorder = 0;
    case_set_text(&c->gravity[1], "-1");
    case_set_text(&c->fluids[0].velocity[0], "sin(pi*x)*cos(pi*y)");
    case_set_text(&c->fluids[0].velocity[1], "-cos(pi*x)*sin(pi*y)");
    case_add_wall(c, "tank");
    c->walls[0].no_slip = true;
    MnsPart *box = case_add_part(&c->walls[0].shape, MNS_BOX);
    box->outside = true;
    for (int d = 0; d < dim; d++) {
        c->periodic[d] = false;
        box->b[d] = c->max[d];
    }
    return c;
}

MnsCase *bench_projected_tank(int dim, double resolution)
{
    return tank(dim, resolution, "incompressible");
}

MnsCase *bench_differenced_tank(int dim, double resolution)
{
    return tank(dim, resolution, "differences");
}
