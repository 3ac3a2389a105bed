/* SPDX-License-Identifier: BSD-3-Clause */
/* What there is to draw: particles of one moment, wherever they came from. */
#include "client/cli/render_frame.h"
#include <math.h>
#include <stdlib.h>

MnsStatus frame_init(Frame *frame, size_t n, MnsError *error)
{
    *frame = (Frame){.n = n, .n_fluid = n, .dim = 2};
    frame->x = calloc(n ? n : 1, sizeof *frame->x);
    frame->phase = calloc(n ? n : 1, sizeof *frame->phase);
    if (frame->x && frame->phase) return MNS_OK;
    frame_done(frame);
    return mns_fail(error, MNS_E_MEMORY, "there is no memory for %zu particles", n);
}

void frame_done(Frame *frame)
{
    free(frame->x);
    free(frame->phase);
    free(frame->value);
    free(frame->weight);
    *frame = (Frame){0};
}

void frame_magnitude(size_t n, int components, const double *vectors, double *values)
{
    for (size_t i = 0; i < n; i++) {
        const double *v = vectors + i * (size_t)components;
        double sum = 0;
        for (int d = 0; d < components; d++) sum += v[d] * v[d];
        values[i] = components == 1 ? v[0] : sqrt(sum);
    }
}

size_t frame_heaviest(const Frame *frame)
{
    double sum[FRAME_MAX_FLUIDS] = {0}, count[FRAME_MAX_FLUIDS] = {0};
    size_t best = 0;
    if (!frame->weight) return 0;
    for (size_t i = 0; i < frame->n_fluid; i++) {
        const int k = frame->phase[i];
        if (k < 0 || (size_t)k >= frame->n_fluids || !isfinite(frame->weight[i])) continue;
        sum[k] += frame->weight[i];
        count[k]++;
    }
    for (size_t k = 1; k < frame->n_fluids; k++)
        if (count[k] > 0 && (count[best] == 0 || sum[k] / count[k] > sum[best] / count[best])) best = k;
    return best;
}
