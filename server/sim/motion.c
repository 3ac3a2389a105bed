/* SPDX-License-Identifier: BSD-3-Clause */
/* Prescribed rigid translation of a wall. */
#include "sim/motion.h"
#include "base/vector.h"
#include <math.h>
#include <string.h>

static void sine(const MnsMotion *m, double t, double x[3], double v[3], double a[3])
{
    const double w = 2 * M_PI * m->frequency, angle = w * t + m->phase;
    for (int d = 0; d < 3; d++) {
        x[d] = m->amplitude[d] * (sin(angle) - sin(m->phase));
        v[d] = m->amplitude[d] * w * cos(angle);
        a[d] = -m->amplitude[d] * w * w * sin(angle);
    }
}

static void one_minus_cosine(const MnsMotion *m, double t, double x[3], double v[3], double a[3])
{
    const double w = 2 * M_PI * m->frequency;
    for (int d = 0; d < 3; d++) {
        x[d] = m->amplitude[d] * (1 - cos(w * t));
        v[d] = m->amplitude[d] * w * sin(w * t);
        a[d] = m->amplitude[d] * w * w * cos(w * t);
    }
}

/* The interval [k, k+1] of the table that holds t, which lies within the table. */
static size_t interval(const MnsMotion *m, double t)
{
    size_t low = 0, high = m->n - 1;
    while (high - low > 1) {
        const size_t middle = (low + high) / 2;
        if (m->points[middle].t <= t) low = middle;
        else high = middle;
    }
    return low;
}

/* Cubic Hermite polynomial through positions and velocities of both ends. */
static void table_at(const MnsMotion *m, double t, double x[3], double v[3], double a[3])
{
    const MnsMotionPoint *first = &m->points[0], *last = &m->points[m->n - 1];
    if (t <= first->t || t >= last->t) {
        memcpy(x, t <= first->t ? first->x : last->x, 3 * sizeof *x);
        return;
    }
    const MnsMotionPoint *p = &m->points[interval(m, t)], *q = p + 1;
    const double T = q->t - p->t, s = (t - p->t) / T;
    for (int d = 0; d < 3; d++) {
        const double jump = q->x[d] - p->x[d], c2 = 3 * jump - T * (2 * p->v[d] + q->v[d]),
                     c3 = T * (p->v[d] + q->v[d]) - 2 * jump;
        x[d] = p->x[d] + s * (T * p->v[d] + s * (c2 + s * c3));
        v[d] = p->v[d] + s * (2 * c2 + s * 3 * c3) / T;
        a[d] = (2 * c2 + s * 6 * c3) / (T * T);
    }
}

/* Counted from t = 0, when the wall is where the case puts it, whatever the table begins with. */
static void table(const MnsMotion *m, double t, double x[3], double v[3], double a[3])
{
    double x0[3] = {0}, v0[3] = {0}, a0[3] = {0};
    table_at(m, 0, x0, v0, a0);
    table_at(m, t, x, v, a);
    for (int d = 0; d < 3; d++) x[d] -= x0[d];
}

void motion_at(const MnsMotion *motion, double t, double x[3], double v[3], double a[3])
{
    for (int d = 0; d < 3; d++) x[d] = v[d] = a[d] = 0;
    switch (motion->kind) {
    case MNS_STILL: break;
    case MNS_SINE: sine(motion, t, x, v, a); break;
    case MNS_ONE_MINUS_COSINE: one_minus_cosine(motion, t, x, v, a); break;
    case MNS_TABLE: table(motion, t, x, v, a); break;
    }
}

bool motion_same(const MnsMotion *a, const MnsMotion *b)
{
    if (a->kind != b->kind || a->n != b->n || !same_vector(a->amplitude, b->amplitude) ||
        a->frequency != b->frequency || a->phase != b->phase)
        return false;
    for (size_t k = 0; k < a->n; k++) {
        const MnsMotionPoint *p = &a->points[k], *q = &b->points[k];
        if (p->t != q->t || !same_vector(p->x, q->x) || !same_vector(p->v, q->v)) return false;
    }
    return true;
}

bool motion_of_all(const MnsCase *c)
{
    for (size_t k = 1; k < c->n_walls; k++)
        if (!motion_same(&c->walls[k].motion, &c->walls[0].motion)) return false;
    return true;
}
