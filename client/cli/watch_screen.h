/* SPDX-License-Identifier: BSD-3-Clause */
/* What `meniscus watch` knows of a run, and how it looks: a few lines redrawn in place on a terminal, with charts, one line at a
 * time elsewhere. */
#ifndef CLI_WATCH_SCREEN_H
#define CLI_WATCH_SCREEN_H

#include "client/cli/sparkline.h"
#include <meniscus/client.h>

enum { SCREEN_MAX_PROBES = 256, SCREEN_NAME_SIZE = 64 };

typedef struct Reading {
    char name[SCREEN_NAME_SIZE], unit[16];
    double value;
    History history; /* as long as this probe is at this place, on one time line */
} Reading;

typedef struct Screen {
    bool is_terminal, has_blocks;
    int drawn;       /* lines on the terminal that belong to us */
    char title[128]; /* name and title of the case */
    MnsState state;
    char news[256];        /* the last event; empty: none */
    double time, end_time; /* simulated [s] */
    double eta_s, steps_per_second;
    uint64_t step, lost;
    uint64_t recovery_step; /* that the run is on its way back to; MNS_NO_STEP: it is not */
    double sampled;         /* time of the newest values [s] */
    size_t n;               /* probes */
    Reading probes[SCREEN_MAX_PROBES];
} Screen;

/* Begin. On a terminal that may be drawn on, the cursor is hidden until screen_done(). */
void screen_init(Screen *screen, bool may_redraw);

/* Take over what a status, a reply with probes, a message say. */
void screen_take_info(Screen *screen, const MnsRunInfo *info);
void screen_take_reply(Screen *screen, const MnsReply *probes);
void screen_take(Screen *screen, const MnsTelemetry *telemetry);

/* Terminal: redraw. Elsewhere: print one line. */
void screen_draw(Screen *screen);

/* Print a line that stays, above what is redrawn. */
void screen_say(Screen *screen, const char *text);

/* Leave the terminal as it was found, below the last picture. */
void screen_done(Screen *screen);

#endif
