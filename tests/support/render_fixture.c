/* SPDX-License-Identifier: BSD-3-Clause */
/* What the tests of pictures share: small frames whose picture is known. */
#include "tests/support/render_fixture.h"
#include <stdio.h>
#include <stdlib.h>

static void place(Frame *frame, size_t i, double x, double y, double z, int phase)
{
    frame->x[i][0] = x;
    frame->x[i][1] = y;
    frame->x[i][2] = z;
    frame->phase[i] = phase;
    frame->value[i] = 1000 * x;
    frame->weight[i] = phase == 0 ? 1000 : 1;
}

Frame tank_frame(int dim, int per_metre)
{
    const int nx = 2 * per_metre, ny = per_metre, nz = dim == 3 ? per_metre / 2 : 1;
    const double dx = 1.0 / per_metre;
    const size_t fluid = (size_t)(nx * ny * nz);
    Frame f;
    if (frame_init(&f, fluid + (size_t)nx, NULL)) exit(1);
    f.value = calloc(f.n, sizeof *f.value);
    f.weight = calloc(f.n, sizeof *f.weight);
    if (!f.value || !f.weight) exit(1);
    f.n_fluid = fluid;
    f.dim = dim;
    f.spacing = dx;
    f.time = 1.25;
    f.gravity[1] = -1;
    frame_take_domain(&f, (const double[]){0, 0, 0}, (const double[]){2, 1, 0.5});
    f.n_fluids = 2;
    snprintf(f.title, sizeof f.title, "Tank");
    snprintf(f.fluids[0], FRAME_NAME, "water");
    snprintf(f.fluids[1], FRAME_NAME, "air");
    snprintf(f.field, sizeof f.field, "pressure");
    snprintf(f.unit, sizeof f.unit, "Pa");
    for (int i = 0; i < nx * ny * nz; i++) {
        const double x = (i % nx + 0.5) * dx, y = (i / nx % ny + 0.5) * dx;
        place(&f, (size_t)i, x, y, dim == 3 ? (i / (nx * ny) + 0.5) * dx : 0, y > 0.5);
    }
    for (int i = 0; i < nx; i++) place(&f, fluid + (size_t)i, (i + 0.5) * dx, -dx / 2, 0, 2);
    return f;
}
