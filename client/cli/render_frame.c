/* SPDX-License-Identifier: BSD-3-Clause */
/* What there is to draw: particles of one moment, wherever they came from. */
#include "client/cli/render_frame.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

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

int frame_vector(const char *text, double ret[3])
{
    int n = 0;
    while (n < 3 && text) {
        text += strcspn(text, "+-.0123456789");
        if (!*text) return n;
        ret[n++] = strtod(text, NULL);
        text = strchr(text, ',');
    }
    return n;
}

void frame_take_domain(Frame *frame, const double min[3], const double max[3])
{
    bool good = true;
    for (int d = 0; d < frame->dim; d++) good &= isfinite(min[d]) && isfinite(max[d]) && min[d] < max[d];
    if (!good) return;
    frame->has_domain = true;
    memcpy(frame->domain[0], min, (size_t)frame->dim * sizeof *min);
    memcpy(frame->domain[1], max, (size_t)frame->dim * sizeof *max);
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
