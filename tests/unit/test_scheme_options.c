/* SPDX-License-Identifier: BSD-3-Clause */
/* What a case says of its scheme is what its run does: every option makes another run of a case in which it has something to do, and what
 * a fluid does not say is what the page of its scheme has for it. */
#include "sim/solve/solve.h"
#include "tests/support/check.h"
#include "tests/support/sims.h"
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

typedef enum Kind { NUMBER, COUNT, CHOICE, SWITCH } Kind;

/* Of a scheme, where it is in a case, and a value that is not the one that is there without a word. */
typedef struct Option {
    const char *scheme, *name;
    size_t at;
    Kind kind;
    double value;
} Option;

#define OF(scheme, entry) #scheme, #entry, offsetof(MnsSchemeOptions, scheme.entry)

static const Option OPTIONS[] = {
    {OF(riemann, limiter), NUMBER, 0},
    {OF(riemann, background_pressure), NUMBER, 1},
    {OF(riemann, heavy_background_pressure), NUMBER, 2},
    {OF(riemann, transport_stress), SWITCH, false},
    {OF(riemann, guard), NUMBER, 0.5},
    {OF(dissipation, delta), NUMBER, 2},
    {OF(dissipation, repulsion), NUMBER, 0},
    {OF(dissipation, background_pressure), NUMBER, 3},
    {OF(dissipation, guard), NUMBER, 0.5},
    {OF(dissipation, pair_average), CHOICE, MNS_AVERAGE_DENSITY},
    {OF(dissipation, gradient_correction), SWITCH, true},
    {OF(dissipation, form), CHOICE, MNS_DISSIPATION_NO_VOLUME_FACTOR},
    {OF(dissipation, form), CHOICE, MNS_DISSIPATION_PLAIN},
    {OF(interfacial, delta), NUMBER, 0.5},
    {OF(interfacial, repulsion), NUMBER, 0.2},
    {OF(interfacial, background_pressure), NUMBER, 3},
    {OF(interfacial, guard), NUMBER, 0.5},
    {OF(interfacial, pair_average), CHOICE, MNS_AVERAGE_ARITHMETIC},
    {OF(interfacial, gradient_correction), SWITCH, true},
    {OF(interfacial, shifting_strength), NUMBER, 1},
    {OF(interfacial, shifting), CHOICE, MNS_SHIFTING_OFF},
    {OF(interfacial, shifting), CHOICE, MNS_SHIFTING_ORIGINAL},
    {OF(incompressible, density_tolerance), NUMBER, 0.1},
    {OF(incompressible, density_offset), NUMBER, 0.1},
    {OF(incompressible, tolerance), NUMBER, 1e-2},
    {OF(incompressible, density_solver_tolerance), NUMBER, 1e-6},
    {OF(incompressible, guard), NUMBER, 0.5},
    {OF(incompressible, reference_speed), NUMBER, 30},
    {OF(incompressible, density_corrections), COUNT, 1},
    {OF(incompressible, density_patience), COUNT, 1},
    {OF(incompressible, mobility), CHOICE, MNS_MOBILITY_DENSITY},
    {OF(incompressible, gauge), CHOICE, MNS_GAUGE_MEAN},
    {OF(incompressible, solver), CHOICE, MNS_SOLVER_BICGSTAB},
    {OF(differences, interface_threshold), NUMBER, 1},
    {OF(differences, shifting_strength), NUMBER, 0.01},
    {OF(differences, tolerance), NUMBER, 1e-2},
    {OF(differences, guard), NUMBER, 0.5},
    {OF(differences, reference_speed), NUMBER, 30},
    {OF(differences, buoyant_in), CHOICE, 0},
    {OF(differences, shift_across_interfaces), SWITCH, false},
    {OF(differences, holds_pressure), SWITCH, true},
    {OF(differences, solver), CHOICE, MNS_SOLVER_AMG},
    {OF(differences, diffusion), CHOICE, MNS_DIFFUSION_HARMONIC},
    {OF(differences, diffusion), CHOICE, MNS_DIFFUSION_CONSERVATIVE},
    {OF(differences, diffusion), CHOICE, MNS_DIFFUSION_SPH},
};
enum { N_OPTIONS = sizeof OPTIONS / sizeof *OPTIONS };

static void set(MnsSchemeOptions *of, const Option *option)
{
    char *at = (char *)of + option->at;
    const unsigned count = (unsigned)option->value;
    const int choice = (int)option->value;
    const bool on = option->value != 0;
    switch (option->kind) {
    case NUMBER: memcpy(at, &option->value, sizeof option->value); break;
    case COUNT: memcpy(at, &count, sizeof count); break;
    case CHOICE: memcpy(at, &choice, sizeof choice); break;
    case SWITCH: memcpy(at, &on, sizeof on); break;
    }
}

/* Of a tank that shakes, in disorder, some steps from the start; with an option, or as it is. */
static uint64_t hash_with(const char *scheme, const Option *option)
{
    MnsCase *c = case_shaken_by(scheme, 2, 1);
    c->disorder = 0.2;
    c->scheme.incompressible.density_tolerance = 1e-4; /* so that corrections come to where patience ends */
    c->scheme.incompressible.density_corrections = 40;
    if (strcmp(scheme, "interfacial") == 0) c->fluids[1].density = 0.1; /* or the original shifting blows up */
    if (option) set(&c->scheme, option);
    MnsSim *sim = sim_of(c);
    sim_steps(sim, 12);
    const uint64_t hash = mns_sim_hash(sim);
    sim_done(sim, c);
    return hash;
}

static bool is_multigrid(const Option *option)
{
    return strcmp(option->name, "solver") == 0 && option->value == MNS_SOLVER_AMG;
}

/* Another than without it, and than with another choice of the same. Multigrid where it was built. */
static void every_option_makes_another_run(void **state)
{
    (void)state;
    uint64_t hash[N_OPTIONS], plain = 0;
    for (size_t k = 0; k < N_OPTIONS; k++) {
        const Option *option = &OPTIONS[k];
        if (k == 0 || strcmp(option->scheme, option[-1].scheme) != 0) plain = hash_with(option->scheme, NULL);
        hash[k] = ~plain;
        if (is_multigrid(option) && !amg_exists()) continue;
        hash[k] = hash_with(option->scheme, option);
        if (hash[k] == plain) fail_msg("scheme.%s.%s does nothing", option->scheme, option->name);
        for (size_t other = 0; other < k; other++)
            if (OPTIONS[other].at == option->at && hash[other] == hash[k])
                fail_msg("scheme.%s.%s: two choices are one", option->scheme, option->name);
    }
}

/* P2's state equation: 7 of liquids, 1.4 of gases, and what the case says of either. */
static void a_gas_has_an_exponent_of_its_own(void **state)
{
    (void)state;
    for (int said = 0; said < 2; said++) {
        MnsCase *c = case_shaken_by("interfacial", 2, 1);
        for (size_t k = 0; said && k < 2; k++) c->fluids[k].exponent = 3 + (double)k;
        MnsSim *sim = sim_of(c);
        assert_close(sim->model.phase[0].exponent, said ? 3 : 7, 0);
        assert_close(sim->model.phase[1].exponent, said ? 4 : 1.4, 0);
        sim_done(sim, c);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_option_makes_another_run),
        cmocka_unit_test(a_gas_has_an_exponent_of_its_own),
    };
    return cmocka_run_group_tests_name("scheme options", tests, NULL, NULL);
}
