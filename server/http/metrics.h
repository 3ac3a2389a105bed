/* SPDX-License-Identifier: BSD-3-Clause */
/* The metrics of a daemon: /metrics. README.md lists them. */
#ifndef HTTP_METRICS_H
#define HTTP_METRICS_H

#include "http/exposition.h"
#include "http/view.h"

void metrics_print(Exposition *to, const View *view);

#endif
