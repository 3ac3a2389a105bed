/* SPDX-License-Identifier: BSD-3-Clause */
/* Cost of a time step, as JSON lines: whole step, each pass, neighbour search, in nanoseconds per particle and per pair, and
 * memory. The fluids are stirred at the start, so that neighbour lists age as fast as in a developed flow. All steps count:
 * search, walls, forces, integration; nothing is written.
 *
 * usage: bench_step [NAME [THREADS]]   without arguments: every case, with one thread and with all */
#include "sim/sim.h"
#include "tests/support/cases.h"
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WARM_UP = 10, REPEATS = 3 };

typedef struct Bench {
    const char *name;
    int dim;
    double resolution;
    int steps; /* in each of the repeats */
} Bench;

static const Bench BENCHES[] = {
    {"dambreak2d-p3", 2, 95, 60},
    {"dambreak3d-p3", 3, 20, 12},
};

static void stir(MnsCase *c)
{
    for (size_t k = 0; k < c->n_fluids; k++) {
        case_set_text(&c->fluids[k].velocity[0], "1.5*sin(pi*x/5.366)*cos(pi*y/2)");
        case_set_text(&c->fluids[k].velocity[1], "-1.5*2/5.366*cos(pi*x/5.366)*sin(pi*y/2)");
    }
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static int advance(MnsSim *sim, int steps)
{
    MnsError error = {0};
    for (int k = 0; k < steps; k++)
        if (mns_sim_step(sim, 1e9, &error)) {
            fprintf(stderr, "bench_step: %s\n", error.text);
            return 0;
        }
    return 1;
}

static void print(const Bench *bench, const MnsSim *sim, double ns, const MnsTimer *before)
{
    const double n = (double)mns_sim_particles(sim), neighbours = mns_sim_mean_neighbours(sim);
    const double fluid = (double)mns_sim_fluid_particles(sim), steps = bench->steps * REPEATS;
    const double pairs = (double)neighbours_pairs(&sim->nb);
    const double lists = (double)slabs_bytes(&sim->nb.slabs);
    printf("{\"name\": \"%s\", \"threads\": %d, \"particles\": %.0f, \"fluid_particles\": %.0f, \"neighbours\": %.1f, "
           "\"ns_per_particle_step\": %.1f, \"ns_per_pair\": %.2f, \"bytes_per_particle\": %.0f, "
           "\"list_bytes_per_pair\": %.2f, \"steps\": %.0f, \"rebuilds\": %llu",
           bench->name, sim->threads, n, fluid, neighbours, ns, ns * n / (fluid * neighbours),
           ((double)mns_sim_bytes(sim) - lists) / n, lists / pairs, steps,
           (unsigned long long)(sim->timers[TIMER_NEIGHBOURS].calls - before[TIMER_NEIGHBOURS].calls));
    size_t n_timers = 0;
    const MnsTimer *timers = mns_sim_timers(sim, &n_timers);
    for (size_t k = 0; k < n_timers; k++) {
        const double spent = (timers[k].seconds - before[k].seconds) * 1e9 / steps;
        printf(", \"%s_ns\": %.1f, \"%s_ns_per_pair\": %.2f", timers[k].name, spent / n, timers[k].name,
               spent / (fluid * neighbours));
    }
    const double rebuilds = (double)(timers[TIMER_NEIGHBOURS].calls - before[TIMER_NEIGHBOURS].calls);
    const double search = timers[TIMER_NEIGHBOURS].seconds - before[TIMER_NEIGHBOURS].seconds;
    printf(", \"search_ns_per_particle\": %.1f, \"search_ns_per_pair\": %.2f}\n",
           rebuilds > 0 ? search * 1e9 / (n * rebuilds) : 0, rebuilds > 0 ? search * 1e9 / (pairs * rebuilds) : 0);
    fflush(stdout);
}

static int run(const Bench *bench, int threads)
{
    MnsCase *c = case_dam_break(bench->dim, bench->resolution);
    MnsSim *sim = NULL;
    MnsError error = {0};
    c->threads = (unsigned)threads;
    stir(c);
    int well = mns_sim_new(c, &sim, &error) == MNS_OK && advance(sim, WARM_UP);
    if (error.status) fprintf(stderr, "bench_step: %s: %s\n", error.path, error.text);
    double ns[REPEATS];
    MnsTimer before[SIM_TIMERS_MAX];
    if (well) memcpy(before, sim->timers, sizeof before);
    for (int k = 0; k < REPEATS && well; k++) {
        const double start = omp_get_wtime();
        well = advance(sim, bench->steps);
        ns[k] = (omp_get_wtime() - start) * 1e9 / ((double)mns_sim_particles(sim) * bench->steps);
    }
    if (well) {
        qsort(ns, REPEATS, sizeof *ns, ascending);
        print(bench, sim, ns[REPEATS / 2], before);
    }
    mns_sim_free(sim);
    mns_case_free(c);
    return well;
}

int main(int argc, char **argv)
{
    int well = 1, found = 0;
    for (size_t k = 0; k < sizeof BENCHES / sizeof *BENCHES && well; k++) {
        if (argc > 1 && strcmp(argv[1], BENCHES[k].name) != 0) continue;
        found = 1;
        if (argc > 2) well = run(&BENCHES[k], atoi(argv[2]));
        else {
            well = run(&BENCHES[k], 1);
            if (well && omp_get_num_procs() > 1) well = run(&BENCHES[k], omp_get_num_procs());
        }
    }
    if (!found) fprintf(stderr, "bench_step: no benchmark \"%s\"\n", argv[1]);
    return well && found ? 0 : 1;
}
