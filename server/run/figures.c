/* SPDX-License-Identifier: BSD-3-Clause */
/* Three copies: one is being written, one is being read, one lies between them and is exchanged for either in one
 * instruction. A lock would let a reader of low priority, sent to sleep while it has it, stop the solver. */
#include "run/figures.h"

#include <stdatomic.h>
#include <stdlib.h>

enum { COPIES = 3, FRESH = 4 }; /* FRESH: the copy between has not been looked at */

struct Figures {
    _Atomic unsigned between;
    unsigned written, read; /* each of one thread alone */
    RunFigures copies[COPIES];
};

Figures *figures_new(void)
{
    Figures *figures = calloc(1, sizeof *figures);
    if (!figures) return NULL;
    figures->between = 1;
    figures->read = 2;
    return figures;
}

void figures_free(Figures *figures)
{
    for (int k = 0; figures && k < COPIES; k++) document_leave(figures->copies[k].document);
    free(figures);
}

void figures_put(Figures *figures, const RunFigures *now)
{
    RunFigures *copy = &figures->copies[figures->written];
    Document *before = copy->document;
    *copy = *now;
    if (before != now->document) {
        document_share(now->document);
        document_leave(before);
    }
    figures->written = atomic_exchange(&figures->between, figures->written | FRESH) & ~(unsigned)FRESH;
}

const RunFigures *figures_look(Figures *figures)
{
    if (atomic_load(&figures->between) & FRESH)
        figures->read = atomic_exchange(&figures->between, figures->read) & ~(unsigned)FRESH;
    return &figures->copies[figures->read];
}
