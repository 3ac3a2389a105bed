/* SPDX-License-Identifier: BSD-3-Clause */
/* Cost of a time step, as JSON lines: whole step, each pass, neighbour search, in nanoseconds per particle and per pair, memory, and
 * the time to place the particles. Where a pressure is solved for: making its matrix, setting up the method, solving, iterations, and what
 * the matrix takes. Processor time is of all threads, and says more than the clock on a machine that is shared. The fluids are stirred at the
 * start, so that neighbour lists age as fast as in a developed flow. All steps count: search, walls, forces, integration; nothing is written.
 * Threads wait as in the daemon.
 *
 * usage: bench_step [small | large | NAME [THREADS [RESOLUTION [STEPS]]]]
 * Without arguments: the small cases, with one thread and with all. With STEPS: that many, once, without a start to
 * warm up, for those who count instructions (tests/system/test_instructions.sh). */
#include "run/environment.h"
#include "sim/sim.h"
#include "tests/support/bench_cases.h"
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { WARM_UP = 10 };

typedef struct Bench {
    const char *name;
    MnsCase *(*make)(int dim, double resolution);
    int dim;
    double resolution;
    int steps;
    bool large; /* of those that are asked for by that word or by name only */
} Bench;

static const Bench BENCHES[] = {
    {"dambreak2d-p3", bench_dam_break, 2, 95, 180, false},
    {"dambreak3d-p3", bench_dam_break, 3, 20, 36, false},
    {"droplet2d-p3", bench_droplet, 2, 316, 180, false},
    {"droplet3d-p3", bench_droplet, 3, 46, 36, false},
    {"drop2d-p2", bench_tense_droplet, 2, 316, 180, false},
    {"drop3d-p2", bench_narrow_droplet, 3, 46, 36, false},
    {"drop3d-p2-142", bench_tense_droplet, 3, 46, 36, false}, /* with the smoothing of P2's cases */
    {"drop2d-p1", bench_drop_in_tank, 2, 316, 90, false},
    {"drop3d-p1", bench_drop_in_tank, 3, 46, 18, false},
    {"dambreak3d-p3-200k", bench_dam_break, 3, 26, 36, true},
    {"dambreak3d-p3-1m", bench_dam_break, 3, 45, 24, true},
    {"drop2d-p4", bench_incompressible_droplet, 2, 100, 60, false},
    {"drop3d-p4", bench_incompressible_droplet, 3, 22, 18, false},
    {"drop2d-p5", bench_differenced_droplet, 2, 100, 60, false},
    {"drop3d-p5", bench_differenced_droplet, 3, 22, 18, false},
    {"drop2d-p4-100k", bench_incompressible_droplet, 2, 316, 18, true},
    {"drop2d-p4-1m", bench_incompressible_droplet, 2, 1000, 6, true},
    {"drop3d-p4-100k", bench_incompressible_droplet, 3, 46, 9, true},
    {"drop3d-p4-1m", bench_incompressible_droplet, 3, 100, 3, true},
    {"vortices2d-p4-100k", bench_projected_vortices, 2, 316, 18, true},
    {"vortices2d-p4-1m", bench_projected_vortices, 2, 1000, 6, true},
    {"vortices2d-p5-100k", bench_differenced_vortices, 2, 316, 18, true},
    {"vortices2d-p5-1m", bench_differenced_vortices, 2, 1000, 6, true},
    {"tank3d-p4-100k", bench_projected_tank, 3, 46, 9, true},
    {"tank3d-p4-1m", bench_projected_tank, 3, 100, 3, true},
    {"tank3d-p5-100k", bench_differenced_tank, 3, 46, 9, true},
    {"tank3d-p5-1m", bench_differenced_tank, 3, 100, 3, true},
    {"dambreak3d-p3-4m", bench_dam_break, 3, 72, 24, true},
    {"droplet3d-p3-1m", bench_droplet, 3, 100, 24, true}, /* of fluids alone: what a particle costs is comparable */
    {"droplet3d-p3-4m", bench_droplet, 3, 160, 24, true},
};

/* What the solves of all steps took. */
typedef struct Solves {
    double iterations, corrections, density_iterations;
} Solves;

static int advance(MnsSim *sim, int steps, Solves *solves)
{
    MnsError error = {0};
    for (int k = 0; k < steps; k++) {
        if (mns_sim_step(sim, 1e9, &error)) {
            fprintf(stderr, "bench_step: %s\n", error.text);
            return 0;
        }
        solves->iterations += sim->solved.iterations;
        solves->corrections += sim->solved.corrections;
        solves->density_iterations += sim->solved.density_iterations;
    }
    return 1;
}

/* What is asked for on the command line. */
typedef struct Wish {
    int threads, steps; /* steps: 0 for those of the bench */
    double resolution;  /* 0: the bench's */
} Wish;

/* What was measured. */
typedef struct Result {
    double ns, cpu, build,
        steps; /* of a particle and step, on the clock and of all processors; to make the simulation [s]; how many steps */
    MnsTimer before[SIM_TIMERS_MAX];
    Solves solves;
} Result;

static double spent_on(const MnsSim *sim, const Result *result, size_t timer)
{
    return sim->timers[timer].seconds - result->before[timer].seconds;
}

/* Per particle and step in nanoseconds, per step, and per particle in bytes: rows with their room, and vectors besides. */
static void print_pressure(const MnsSim *sim, const Result *result)
{
    const double n = (double)mns_sim_particles(sim), steps = result->steps;
    const Matrix *m = &sim->system.matrix;
    const double rows = (double)(m->room * ENTRIES * (sizeof *m->column + sizeof *m->c) +
                                 m->n * (sizeof *m->start + sizeof *m->blocks + sizeof *m->diagonal));
    double assembly = 0;
    for (size_t k = 0; k < SCHEME_PASSES_MAX && sim->scheme->rates[k].name; k++)
        if (sim->scheme->rates[k].assembles) assembly += spent_on(sim, result, TIMER_PASSES + k);
    printf(", \"method\": \"%s\", \"pressure_assembly_ns\": %.1f, \"pressure_setup_ns\": %.1f, \"pressure_solve_ns\": "
           "%.1f, "
           "\"setups\": %llu, \"iterations\": %.1f, \"corrections\": %.1f, \"correction_iterations\": %.1f, "
           "\"matrix_bytes_per_particle\": %.0f, \"pressure_bytes_per_particle\": %.0f",
           solve_method(sim->model.projection.solver, &sim->system, sim->scheme->symmetric)->name,
           assembly * 1e9 / (n * steps), spent_on(sim, result, sim->timer_setup) * 1e9 / (n * steps),
           spent_on(sim, result, sim->timer_solve) * 1e9 / (n * steps),
           (unsigned long long)(sim->timers[sim->timer_setup].calls - result->before[sim->timer_setup].calls),
           result->solves.iterations / steps, result->solves.corrections / steps,
           result->solves.density_iterations / steps, rows / n, (double)system_bytes(&sim->system) / n);
}

static void print(const Bench *bench, const MnsSim *sim, const Result *result)
{
    const MnsTimer *before = result->before;
    const double ns = result->ns, steps = result->steps;
    const double n = (double)mns_sim_particles(sim), neighbours = mns_sim_mean_neighbours(sim);
    const double fluid = (double)mns_sim_fluid_particles(sim);
    const double pairs = (double)neighbours_pairs(&sim->nb);
    const double lists = (double)slabs_bytes(&sim->nb.slabs);
    printf("{\"name\": \"%s\", \"threads\": %d, \"level\": \"%s\", \"particles\": %.0f, \"fluid_particles\": %.0f, "
           "\"neighbours\": %.1f, "
           "\"ns_per_particle_step\": %.1f, \"cpu_ns_per_particle_step\": %.1f, \"ns_per_pair\": %.2f, "
           "\"bytes_per_particle\": %.0f, "
           "\"list_bytes_per_pair\": %.2f, \"build_s\": %.2f, \"steps\": %.0f, \"rebuilds\": %llu",
           bench->name, sim->threads, mns_level(), n, fluid, neighbours, ns, result->cpu, ns * n / (fluid * neighbours),
           ((double)mns_sim_bytes(sim) - lists) / n, lists / pairs, result->build, steps,
           (unsigned long long)(sim->timers[TIMER_NEIGHBOURS].calls - before[TIMER_NEIGHBOURS].calls));
    size_t n_timers = 0;
    const MnsTimer *timers = mns_sim_timers(sim, &n_timers);
    for (size_t k = 0; k < n_timers; k++) {
        const double spent = (timers[k].seconds - before[k].seconds) * 1e9 / steps;
        printf(", \"%s_ns\": %.1f, \"%s_ns_per_pair\": %.2f", timers[k].name, spent / n, timers[k].name,
               spent / (fluid * neighbours));
    }
    if (sim->scheme->projects) print_pressure(sim, result);
    const double rebuilds = (double)(timers[TIMER_NEIGHBOURS].calls - before[TIMER_NEIGHBOURS].calls);
    const double search = timers[TIMER_NEIGHBOURS].seconds - before[TIMER_NEIGHBOURS].seconds;
    printf(", \"search_ns_per_particle\": %.1f, \"search_ns_per_pair\": %.2f}\n",
           rebuilds > 0 ? search * 1e9 / (n * rebuilds) : 0, rebuilds > 0 ? search * 1e9 / (pairs * rebuilds) : 0);
    fflush(stdout);
}

static int run(const Bench *bench, Wish wish)
{
    MnsCase *c = bench->make(bench->dim, wish.resolution > 0 ? wish.resolution : bench->resolution);
    MnsSim *sim = NULL;
    MnsError error = {0};
    const int steps = wish.steps > 0 ? wish.steps : bench->steps;
    c->threads = (unsigned)wish.threads;
    const double begin = omp_get_wtime();
    int well = mns_sim_new(c, &sim, &error) == MNS_OK;
    Result result = {.build = omp_get_wtime() - begin, .steps = steps};
    if (well && !wish.steps) well = advance(sim, WARM_UP, &(Solves){0});
    if (error.status) fprintf(stderr, "bench_step: %s: %s\n", error.path, error.text);
    if (well) memcpy(result.before, sim->timers, sizeof result.before);
    const clock_t before = clock();
    const double start = omp_get_wtime();
    if (well) well = advance(sim, steps, &result.solves);
    if (well) {
        const double each = 1e9 / ((double)mns_sim_particles(sim) * steps);
        result.ns =
            (omp_get_wtime() - start) * each; /* with all searches: a median would leave out what one step in six has */
        result.cpu = (double)(clock() - before) / CLOCKS_PER_SEC * each;
        print(bench, sim, &result);
    }
    mns_sim_free(sim);
    mns_case_free(c);
    return well;
}

static int is_meant(const Bench *bench, const char *name)
{
    if (strcmp(name, "small") == 0) return !bench->large;
    return strcmp(name, "large") == 0 ? bench->large : strcmp(name, bench->name) == 0;
}

int main(int argc, char **argv)
{
    MnsError error;
    environment_waiting(argv);
    if (environment_level(&error)) {
        fprintf(stderr, "bench_step: %s\n", error.text);
        return 2;
    }
    int well = 1, found = 0;
    Wish wish = {.threads = argc > 2 ? atoi(argv[2]) : 0,
                 .resolution = argc > 3 ? atof(argv[3]) : 0,
                 .steps = argc > 4 ? atoi(argv[4]) : 0};
    for (size_t k = 0; k < sizeof BENCHES / sizeof *BENCHES && well; k++) {
        if (!is_meant(&BENCHES[k], argc > 1 ? argv[1] : "small")) continue;
        found = 1;
        if (wish.threads) well = run(&BENCHES[k], wish);
        else {
            well = run(&BENCHES[k], (Wish){.threads = 1});
            if (well && omp_get_num_procs() > 1) well = run(&BENCHES[k], (Wish){.threads = omp_get_num_procs()});
        }
    }
    if (!found) fprintf(stderr, "bench_step: no benchmark \"%s\"\n", argv[1]);
    return well && found ? 0 : 1;
}
