/* SPDX-License-Identifier: BSD-3-Clause */
/* The group /meniscus of every output file: which run, which moment.
 *
 *  /meniscus            attributes title, case, scheme, version, level and arithmetic (as mns_level() and mns_arithmetic() name them),
 *                       units, dim; of a moment also spacing [m], particles, fluid_particles, step, time [s], dt [s]; where pressures were solved
 *                       for also solver, the method by which they were last: others have other last bits
 *  /meniscus/case_text  [1] the whole case as YAML
 *  /meniscus/fluids     [fluids] their names; phase k is fluid k
 *  /meniscus/walls      [walls] their names; phase k is wall k - fluids */
#ifndef IO_META_H
#define IO_META_H

#include "io/file.h"
#include "io/h5.h"

void meta_put_run(H5 *h, const FileMeta *meta);

/* With which instructions, and in which arithmetic. */
void meta_put_level(H5 *h, const char *level, const char *arithmetic);

/* In which arithmetic: "fused" or "separate", for good; NULL of versions that did not say. */
const char *meta_arithmetic(H5 *h);

/* @param n  particles in the file */
void meta_put_moment(H5 *h, const MnsCapture *capture, size_t n);

/* Say what a dataset holds and in which unit. */
void meta_put_field(H5 *h, const char *name, const MnsFieldInfo *field);

#endif
