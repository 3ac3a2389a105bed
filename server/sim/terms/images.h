/* SPDX-License-Identifier: BSD-3-Clause */
/* What a particle beside walls sees where interfaces are asked for: fluid and its images, instead of walls. */
#ifndef SIM_TERMS_IMAGES_H
#define SIM_TERMS_IMAGES_H

#include "sim/row.h"

/* The row itself where no flat wall is near; else one made in `room`, of the fluid in it and of its images, x, r, W, F, V, normal and
 * other of each. For rows that are mixed, with F, state and whether pairs are with others; normals where they are needed. */
const Row *row_with_images(const Row *row, const Particles *s, const Model *model, Row *room);

#endif
