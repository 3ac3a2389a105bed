/* SPDX-License-Identifier: BSD-3-Clause */
/* The table of probes: what each kind is called, in what unit it is, how it is measured. */
#include "sim/probes/probes.h"
#include <math.h>

static const ProbeKind kinds[] = {
    [MNS_PROBE_PRESSURE] = {"pressure", "Pa", probe_pressure, PROBE_AT_POINT},
    [MNS_PROBE_HEIGHT] = {"height", "m", probe_height, PROBE_ON_LINE},
    [MNS_PROBE_FRONT] = {"front", "m", probe_front, 0},
    [MNS_PROBE_KINETIC_ENERGY] = {"kinetic_energy", "J", probe_kinetic_energy, 0},
    [MNS_PROBE_POTENTIAL_ENERGY] = {"potential_energy", "J", probe_potential_energy, 0},
    [MNS_PROBE_MASS_CENTRE] = {"mass_centre", "m", probe_mass_centre, 0},
    [MNS_PROBE_MOMENTUM] = {"momentum", "kg m/s", probe_momentum, 0},
    [MNS_PROBE_MASS] = {"mass", "kg", probe_mass, 0},
    [MNS_PROBE_EXTREMUM] = {"extremum", NULL, probe_extremum, PROBE_FIELD},
    [MNS_PROBE_COVERAGE] = {"coverage", "1", probe_coverage, 0},
    [MNS_PROBE_ESCAPED] = {"escaped", "1", probe_escaped, 0},
    [MNS_PROBE_PRESSURE_DEVIATION] = {"pressure_deviation", "Pa", probe_pressure_deviation, PROBE_FORMULA},
    [MNS_PROBE_VELOCITY] = {"velocity", "m/s", probe_velocity, 0},
    [MNS_PROBE_VOLUME] = {"volume", "m^3", probe_volume, 0},
    [MNS_PROBE_ELEVATION] = {"elevation", "m", probe_elevation, PROBE_ON_LINE},
    [MNS_PROBE_EXTENT] = {"extent", "m", probe_extent, 0},
    [MNS_PROBE_ROUNDNESS] = {"roundness", "1", probe_roundness, 0},
    [MNS_PROBE_SURFACE_AREA] = {"surface_area", "m^2", probe_surface_area, 0},
    [MNS_PROBE_PRESSURE_JUMP] = {"pressure_jump", "Pa", probe_pressure_jump, PROBE_INSIDE},
    [MNS_PROBE_SOLVER] = {"solver", "1", probe_solver, 0},
};

const ProbeKind *probe_kind(const MnsProbe *probe)
{
    const size_t kind = (size_t)probe->kind;
    return kind < sizeof kinds / sizeof *kinds ? &kinds[kind] : NULL;
}

double mns_sim_probe(const MnsSim *sim, size_t k)
{
    const MnsProbe *probe = &sim->c->probes[k];
    Measure m = {.sim = sim, .probe = probe, .formula = &sim->probe_formula[k], .threads = sim->threads};
    return probe_kind(probe)->measure(&m);
}

static const char *unit_of_field(const char *name)
{
    const int field = mns_field_find(name);
    return field < 0 ? "1" : mns_fields()[field].unit;
}

const char *mns_probe_unit(const MnsProbe *probe)
{
    const ProbeKind *kind = probe_kind(probe);
    if (!kind) return "1";
    return kind->unit ? kind->unit : unit_of_field(probe->field);
}
