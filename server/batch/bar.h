/* SPDX-License-Identifier: BSD-3-Clause */
/* Progress on standard error: a bar on a terminal, now and then a line elsewhere. */
#ifndef BATCH_BAR_H
#define BATCH_BAR_H

#include "run/outbox.h"

typedef struct Bar {
    bool terminal;
    double shown; /* clock_now() of the last line; 0: none yet */
} Bar;

void bar_begin(Bar *bar);
void bar_show(Bar *bar, const Note *progress);

/* Clear the line of the bar, so that something else can be written. */
void bar_end(const Bar *bar);

#endif
