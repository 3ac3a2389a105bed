/* SPDX-License-Identifier: BSD-3-Clause */
/* All that a page may tell, looked at for one answer. */
#ifndef HTTP_VIEW_H
#define HTTP_VIEW_H

#include "http/http.h"
#include "http/machine.h"
#include "run/watch.h"

enum { HTTP_CODES = 7 }; /* those that pages are answered with */

/* Of this server, by its own thread. */
typedef struct HttpCounts {
    double began;         /* since 1970 [s] */
    unsigned connections; /* open now                                             */
    uint64_t crowded_out; /* connections closed early, to make room for newer ones */
    uint64_t answers[HTTP_CODES];
} HttpCounts;

typedef struct View {
    const HttpSources *from;
    const RunFigures *run;
    RunCounts counts;
    HttpCounts http;
    ProcessFigures process;
    DiskFigures disk;
} View;

/* The codes of HttpCounts.answers, as in 200. */
extern const unsigned http_codes[HTTP_CODES];

#endif
