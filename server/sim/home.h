/* SPDX-License-Identifier: BSD-3-Clause */
/* Where fields are that neighbours are asked for: what is written by one pass and read by others, or written between passes, needs no array
 * besides its places in bundles, if no pass whose terms write it loads these bundles. */
#ifndef SIM_HOME_H
#define SIM_HOME_H

#include "sim/scheme.h"

/* Fields that may be in bundles alone, by what the passes of a scheme write and load with these options. */
Fields home_fields(const Scheme *scheme, const Model *model, int dim);

/* Have those fields in the bundles alone, with the values they have, and give up their arrays; the other way round, which takes memory: false
 * if there is none, and nothing has changed. Both do nothing where it is so already. */
void home_enter(Particles *s, const Bundles *b, const Scheme *scheme, const Model *model, int threads);
bool home_leave(Particles *s, int threads);

#endif
