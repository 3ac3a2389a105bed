/* SPDX-License-Identifier: BSD-3-Clause */
/* What a few steps of each scheme end in: a line for each with its name, dimensions and the hash of its state. For machines that are
 * to compute the same bits (aarch64.sh, x86_64.sh). Its cases have numbers where others have formulas.
 *
 * usage: states [THREADS [LEVEL]]   with the instructions of a level, or the best of this machine */
#include "sim/sim.h"
#include "tests/support/bench_cases.h"
#include "tests/support/cases.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { STEPS = 6, RESOLUTION_2D = 12, RESOLUTION_3D = 9 };

typedef MnsCase *Make(int dim, double resolution);

static Make *const MAKES[] = {
    bench_droplet,                /* P3 */
    bench_tense_droplet,          /* P2 */
    bench_drop_in_tank,           /* P1 */
    bench_incompressible_droplet, /* P4 */
    bench_differenced_droplet,    /* P5 */
};

/* Moved by disorder and by tension instead of a velocity. */
static MnsCase *without_formulas(Make *make, int dim)
{
    MnsCase *c = make(dim, dim == 2 ? RESOLUTION_2D : RESOLUTION_3D);
    for (size_t k = 0; k < c->n_fluids; k++)
        for (int d = 0; d < dim; d++) case_set_text(&c->fluids[k].velocity[d], "0");
    c->disorder = 0.2;
    return c;
}

static bool tell(Make *make, int dim, unsigned threads)
{
    MnsCase *c = without_formulas(make, dim);
    MnsSim *sim = NULL;
    MnsError error;
    c->threads = threads;
    MnsStatus status = mns_sim_new(c, &sim, &error);
    for (int k = 0; k < STEPS && !status; k++) status = mns_sim_step(sim, INFINITY, &error);
    if (status) fprintf(stderr, "states: %s: %s\n", c->scheme.name, error.text);
    else printf("%s %dD %016" PRIx64 "\n", c->scheme.name, dim, mns_sim_hash(sim));
    mns_sim_free(sim);
    mns_case_free(c);
    return !status;
}

int main(int argc, char **argv)
{
    const unsigned threads = argc > 1 ? (unsigned)strtoul(argv[1], NULL, 10) : 1;
    MnsError error;
    bool well = argc < 3 || !mns_level_force(argv[2], &error);
    if (!well) fprintf(stderr, "states: %s\n", error.text);
    for (size_t k = 0; well && k < sizeof MAKES / sizeof *MAKES; k++)
        for (int dim = 2; dim <= 3; dim++) well = tell(MAKES[k], dim, threads) && well;
    return well ? 0 : 1;
}
