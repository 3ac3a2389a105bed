/* SPDX-License-Identifier: BSD-3-Clause */
/* What the tests of pictures share: small frames whose picture is known. */
#ifndef TESTS_RENDER_FIXTURE_H
#define TESTS_RENDER_FIXTURE_H

#include "client/cli/render_frame.h"

/* A lattice of water below y = 0.5 and air above it in a box of 2 x 1 (x 0.5 in 3D), `per_metre` particles each way. The
 * field "pressure" [Pa] is 1000 x, that is 0 to 2000 from left to right. Behind the fluid come walls: a row below it. */
Frame tank_frame(int dim, int per_metre);

#endif
