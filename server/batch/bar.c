/* SPDX-License-Identifier: BSD-3-Clause */
/* Progress on standard error, where it moves the cursor: what is printed by stderr is escaped. */
#include "batch/bar.h"

#include "base/clock.h"
#include <math.h>
#include <stdio.h>
#include <unistd.h>

static const double LINE_INTERVAL = 5; /* [s] between lines where there is no terminal */
enum { WIDTH = 30 };

void bar_begin(Bar *bar)
{
    *bar = (Bar){.terminal = isatty(STDERR_FILENO) == 1};
}

/* "1:02:03", or "-" while not known. */
static void format_duration(double seconds, char ret[static 32])
{
    if (!(seconds >= 0 && seconds < 1e9)) snprintf(ret, 32, "-");
    else {
        const long s = lround(seconds);
        snprintf(ret, 32, "%ld:%02ld:%02ld", s / 3600, s / 60 % 60, s % 60);
    }
}

void bar_show(Bar *bar, const Note *progress)
{
    char eta[32], filled[WIDTH + 1];
    const double now = clock_now();
    if (!bar->terminal && bar->shown > 0 && now - bar->shown < LINE_INTERVAL) return;
    bar->shown = now;
    format_duration(progress->eta, eta);
    for (int k = 0; k < WIDTH; k++) filled[k] = k < progress->fraction * WIDTH ? '=' : ' ';
    filled[WIDTH] = 0;
    if (bar->terminal) dprintf(STDERR_FILENO, "\r[%s] ", filled);
    dprintf(STDERR_FILENO, "%5.1f %%  t = %.5g s of %.5g s  step %lu  %.4g steps/s  ETA %s%s", 100 * progress->fraction,
            progress->t, progress->end_time, (unsigned long)progress->step,
            isfinite(progress->steps_per_second) ? progress->steps_per_second : 0, eta,
            bar->terminal ? "\033[K" : "\n");
}

void bar_end(const Bar *bar)
{
    if (bar->terminal && bar->shown > 0) dprintf(STDERR_FILENO, "\r\033[K");
}
