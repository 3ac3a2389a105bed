/* SPDX-License-Identifier: BSD-3-Clause */
/* Small cases made in C, for tests and benchmarks that need no file. Free with mns_case_free(). */
#ifndef SUPPORT_CASES_H
#define SUPPORT_CASES_H

#include <meniscus/sim.h>

/* Water column 2 x 1 under air in a closed tank 5.366 x 2 (x 1), H = g = 1: P3 3.1 and 3.3. */
MnsCase *case_dam_break(int dim, double resolution);

/* Two fluids of density ratio 10, side by side as stripes in a periodic box without gravity, stirred: nothing outside acts. */
MnsCase *case_periodic(int dim, double resolution);

/* The same at rest, with the density of both fluids found in one way. */
MnsCase *case_still(int dim, double resolution, MnsDensityMethod method);

/* A tank that shakes, sticky, with water and air: all the solver can do at once. */
MnsCase *case_shaken(int dim, unsigned threads);

/* The same by another scheme, with surface tension if it has any. The name is borrowed. */
MnsCase *case_shaken_by(const char *scheme, int dim, unsigned threads);

/* A full tank under `incompressible`: a liquid this dense under one of density 1, each half a metre high, gravity 1. */
MnsCase *case_layers(int dim, double resolution, double heavy);

/* A case like any other but empty of parts, to be filled by the test. */
MnsCase *case_blank(int dim, double resolution);
void case_add_fluid(MnsCase *c, const char *name, double density, double sound_speed);
void case_add_wall(MnsCase *c, const char *name);
MnsProbe *case_add_probe(MnsCase *c, MnsProbeKind kind); /* of all fluids, along x, on no wall */
MnsPart *case_add_part(MnsShape *shape, MnsPrimitive primitive);
void case_set_text(char **entry, const char *text);

/* Add this part; in the plane without its third coordinates. */
MnsPart *case_put_part(int dim, MnsShape *shape, MnsPart part);

#endif
