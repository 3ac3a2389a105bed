/* SPDX-License-Identifier: BSD-3-Clause */
/* Cost of a time step, as JSON lines: whole step, each pass, neighbour search, in nanoseconds per particle and per pair, memory, and
 * the time to place the particles. The fluids are stirred at the start, so that neighbour lists age as fast as in a developed
 * flow. All steps count: search, walls, forces, integration; nothing is written. Threads wait as in the daemon.
 *
 * usage: bench_step [NAME [THREADS [RESOLUTION [STEPS]]]]
 * Without arguments: every case but the large ones, with one thread and with all. With STEPS: that many, once, without a start to
 * warm up, for those who count instructions (tests/system/test_instructions.sh). */
#include "run/environment.h"
#include "sim/sim.h"
#include "tests/support/cases.h"
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WARM_UP = 10, REPEATS = 3 };

typedef struct Bench {
    const char *name;
    MnsCase *(*make)(int dim, double resolution);
    int dim;
    double resolution;
    int steps;  /* in each of the repeats */
    bool large; /* on request only */
} Bench;

static MnsCase *dam_break(int dim, double resolution)
{
    MnsCase *c = case_dam_break(dim, resolution);
    for (size_t k = 0; k < c->n_fluids; k++) {
        case_set_text(&c->fluids[k].velocity[0], "1.5*sin(pi*x/5.366)*cos(pi*y/2)");
        case_set_text(&c->fluids[k].velocity[1], "-1.5*2/5.366*cos(pi*x/5.366)*sin(pi*y/2)");
    }
    return c;
}

/* A drop in a box of another liquid, both viscous: what schemes with surface tension are measured by. */
static MnsCase *droplet(int dim, double resolution)
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
static MnsCase *tense_droplet(int dim, double resolution)
{
    MnsCase *c = droplet(dim, resolution);
    c->scheme.name = "interfacial";
    c->scheme.smoothing = 1.6;
    c->scheme.interfacial.background_pressure = 4;
    c->tension[0][1] = c->tension[1][0] = 0.1;
    return c;
}

/* The same with the smoothing that other programs have for such a drop: 80 neighbours in space. */
static MnsCase *narrow_droplet(int dim, double resolution)
{
    MnsCase *c = tense_droplet(dim, resolution);
    c->scheme.smoothing = 1.3;
    return c;
}

/* The same in a tank to which both stick, by P1 with the kernel of its cases. */
static MnsCase *drop_in_tank(int dim, double resolution)
{
    MnsCase *c = tense_droplet(dim, resolution);
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
static MnsCase *incompressible_droplet(int dim, double resolution)
{
    MnsCase *c = droplet(dim, resolution);
    c->scheme.name = "incompressible";
    c->scheme.kernel = MNS_QUINTIC_SPLINE;
    c->scheme.smoothing = 1;
    c->scheme.incompressible.reference_speed = 1;
    c->tension[0][1] = c->tension[1][0] = 0.1;
    return c;
}

/* The same by P5, with the whole divergence of the stress. */
static MnsCase *differenced_droplet(int dim, double resolution)
{
    MnsCase *c = droplet(dim, resolution);
    c->scheme.name = "differences";
    c->scheme.differences.reference_speed = 1;
    c->tension[0][1] = c->tension[1][0] = 0.1;
    return c;
}

static const Bench BENCHES[] = {
    {"dambreak2d-p3", dam_break, 2, 95, 60, false},
    {"dambreak3d-p3", dam_break, 3, 20, 12, false},
    {"droplet2d-p3", droplet, 2, 316, 60, false},
    {"droplet3d-p3", droplet, 3, 46, 12, false},
    {"drop2d-p2", tense_droplet, 2, 316, 60, false},
    {"drop3d-p2", tense_droplet, 3, 46, 12, false},
    {"drop3d-p2-80", narrow_droplet, 3, 46, 12, false},
    {"drop2d-p1", drop_in_tank, 2, 316, 30, false},
    {"drop3d-p1", drop_in_tank, 3, 46, 6, false},
    {"dambreak3d-p3-200k", dam_break, 3, 26, 6, true},
    {"dambreak3d-p3-1m", dam_break, 3, 45, 3, true},
    {"drop2d-p4", incompressible_droplet, 2, 100, 20, false},
    {"drop3d-p4", incompressible_droplet, 3, 22, 6, false},
    {"drop2d-p5", differenced_droplet, 2, 100, 20, false},
    {"drop3d-p5", differenced_droplet, 3, 22, 6, false},
    {"drop2d-p4-100k", incompressible_droplet, 2, 316, 6, true},
    {"drop2d-p4-1m", incompressible_droplet, 2, 1000, 2, true},
    {"drop3d-p4-100k", incompressible_droplet, 3, 46, 3, true},
    {"drop3d-p4-1m", incompressible_droplet, 3, 100, 1, true},
    {"dambreak3d-p3-4m", dam_break, 3, 72, 2, true},
};

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

/* What is asked for on the command line. */
typedef struct Wish {
    int threads, steps; /* steps: 0 for those of the bench */
    double resolution;  /* 0: the bench's */
} Wish;

/* What was measured. */
typedef struct Result {
    double ns, build, steps; /* of a particle and step, the median; to make the simulation [s]; how many steps */
    MnsTimer before[SIM_TIMERS_MAX];
} Result;

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
           "\"ns_per_particle_step\": %.1f, \"ns_per_pair\": %.2f, \"bytes_per_particle\": %.0f, "
           "\"list_bytes_per_pair\": %.2f, \"build_s\": %.2f, \"steps\": %.0f, \"rebuilds\": %llu",
           bench->name, sim->threads, mns_level(), n, fluid, neighbours, ns, ns * n / (fluid * neighbours),
           ((double)mns_sim_bytes(sim) - lists) / n, lists / pairs, result->build, steps,
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

static int run(const Bench *bench, Wish wish)
{
    MnsCase *c = bench->make(bench->dim, wish.resolution > 0 ? wish.resolution : bench->resolution);
    MnsSim *sim = NULL;
    MnsError error = {0};
    const int steps = wish.steps > 0 ? wish.steps : bench->steps, repeats = wish.steps > 0 ? 1 : REPEATS;
    c->threads = (unsigned)wish.threads;
    const double begin = omp_get_wtime();
    int well = mns_sim_new(c, &sim, &error) == MNS_OK;
    Result result = {.build = omp_get_wtime() - begin, .steps = (double)steps * repeats};
    if (well && !wish.steps) well = advance(sim, WARM_UP);
    if (error.status) fprintf(stderr, "bench_step: %s: %s\n", error.path, error.text);
    double ns[REPEATS];
    if (well) memcpy(result.before, sim->timers, sizeof result.before);
    for (int k = 0; k < repeats && well; k++) {
        const double start = omp_get_wtime();
        well = advance(sim, steps);
        const double spent = omp_get_wtime() - start;
        ns[k] = spent * 1e9 / ((double)mns_sim_particles(sim) * steps);
    }
    if (well) {
        qsort(ns, (size_t)repeats, sizeof *ns, ascending);
        result.ns = ns[repeats / 2];
        print(bench, sim, &result);
    }
    mns_sim_free(sim);
    mns_case_free(c);
    return well;
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
        if (argc > 1 ? strcmp(argv[1], BENCHES[k].name) != 0 : BENCHES[k].large) continue;
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
