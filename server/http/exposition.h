/* SPDX-License-Identifier: BSD-3-Clause */
/* Metrics as text: in the form of Prometheus (0.0.4), or of OpenMetrics (1.0.0). Names follow the conventions of both by themselves:
 * a family is named without unit and suffix, and gets them here. */
#ifndef HTTP_EXPOSITION_H
#define HTTP_EXPOSITION_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

typedef enum MetricType {
    METRIC_GAUGE,   /* goes up and down: NAME_UNIT                                  */
    METRIC_COUNTER, /* only goes up, or begins at 0 again: NAME_UNIT_total          */
    METRIC_INFO     /* always 1, and its labels say something: NAME_info            */
} MetricType;

typedef struct Label {
    const char *name, *value; /* the value may hold anything */
} Label;

/* unit "": a number of things. help: a sentence without its full stop. */
typedef struct Family {
    const char *name, *unit;
    MetricType type;
    const char *help;
} Family;

typedef struct Exposition {
    FILE *to;
    char *text;
    size_t size;
    bool open_metrics;
    const Family *family; /* of which something has been printed last */
} Exposition;

/* False if there is no memory. */
bool exposition_begin(Exposition *exposition, bool open_metrics);

/* A sample of a family; before the first of each, what it means. All of a family must come one after the other. */
void exposition_sample(Exposition *exposition, const Family *family, double value, size_t n, const Label *labels);

/* The whole text, the caller's to free; NULL if there was no memory for it. */
char *exposition_end(Exposition *exposition, size_t *ret_size);

/* What to say in Content-Type. */
const char *exposition_type(bool open_metrics);

/* Whether the value of an Accept header, or NULL, prefers OpenMetrics to plain text. */
bool exposition_accepts_open_metrics(const char *accept);

#endif
