/* SPDX-License-Identifier: BSD-3-Clause */
/* Flows that benchmarks measure, stirred from the start. Free with mns_case_free(). */
#ifndef SUPPORT_BENCH_CASES_H
#define SUPPORT_BENCH_CASES_H

#include <meniscus/sim.h>

MnsCase *bench_dam_break(int dim, double resolution);

/* A drop in a box of another liquid: by P3, by P2, by P2 with 80 neighbours in space, in a tank by P1, by P4 and by P5. */
MnsCase *bench_droplet(int dim, double resolution);
MnsCase *bench_tense_droplet(int dim, double resolution);
MnsCase *bench_narrow_droplet(int dim, double resolution);
MnsCase *bench_drop_in_tank(int dim, double resolution);
MnsCase *bench_incompressible_droplet(int dim, double resolution);
MnsCase *bench_differenced_droplet(int dim, double resolution);

/* One liquid by P4 and by P5: in a periodic box, and heavy in a closed tank. */
MnsCase *bench_projected_vortices(int dim, double resolution);
MnsCase *bench_differenced_vortices(int dim, double resolution);
MnsCase *bench_projected_tank(int dim, double resolution);
MnsCase *bench_differenced_tank(int dim, double resolution);

#endif
