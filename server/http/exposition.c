/* SPDX-License-Identifier: BSD-3-Clause */
/* Metrics as text. */
#include "http/exposition.h"

#include "common/host/text.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

bool exposition_begin(Exposition *exposition, bool open_metrics)
{
    *exposition = (Exposition){.open_metrics = open_metrics};
    exposition->to = open_memstream(&exposition->text, &exposition->size);
    return exposition->to;
}

/* In both forms a value may hold all but these three as they are; help may hold quotes, but may not have to. */
static void print_escaped(FILE *to, const char *text, bool quotes)
{
    for (; *text; text++) {
        if (*text == '\\') fputs("\\\\", to);
        else if (*text == '\n') fputs("\\n", to);
        else if (*text == '"' && quotes) fputs("\\\"", to);
        else fputc(*text, to);
    }
}

/* The name of the family; with `sample`, that of its samples. */
static void print_name(const Exposition *exposition, const Family *family, bool sample)
{
    FILE *to = exposition->to;
    fprintf(to, "%s%s%s", family->name, *family->unit ? "_" : "", family->unit);
    if (!sample && exposition->open_metrics) return; /* there the family of a counter is called without it */
    if (family->type == METRIC_COUNTER) fputs("_total", to);
    if (family->type == METRIC_INFO) fputs("_info", to);
}

static const char *type_name(const Exposition *exposition, MetricType type)
{
    if (type == METRIC_COUNTER) return "counter";
    return type == METRIC_INFO && exposition->open_metrics ? "info" : "gauge";
}

static void print_head(const Exposition *exposition, const Family *family)
{
    FILE *to = exposition->to;
    fputs("# HELP ", to);
    print_name(exposition, family, false);
    fputc(' ', to);
    print_escaped(to, family->help, exposition->open_metrics);
    fputs(".\n# TYPE ", to);
    print_name(exposition, family, false);
    fprintf(to, " %s\n", type_name(exposition, family->type));
    if (!exposition->open_metrics || !*family->unit) return;
    fputs("# UNIT ", to);
    print_name(exposition, family, false);
    fprintf(to, " %s\n", family->unit);
}

/* With as few digits as give the same number again. */
static void print_number(FILE *to, double value)
{
    char text[32];
    if (isnan(value)) snprintf(text, sizeof text, "NaN");
    else if (isinf(value)) snprintf(text, sizeof text, value > 0 ? "+Inf" : "-Inf");
    else
        for (int digits = 15; digits <= 17; digits++) {
            snprintf(text, sizeof text, "%.*g", digits, value);
            if (strtod(text, NULL) == value) break;
        }
    fputs(text, to);
}

void exposition_sample(Exposition *exposition, const Family *family, double value, size_t n, const Label *labels)
{
    FILE *to = exposition->to;
    if (exposition->family != family) print_head(exposition, family);
    exposition->family = family;
    print_name(exposition, family, true);
    for (size_t k = 0; k < n; k++) {
        fprintf(to, "%s%s=\"", k ? "," : "{", labels[k].name);
        print_escaped(to, text_shown(labels[k].value), true);
        fputc('"', to);
    }
    fputs(n ? "} " : " ", to);
    print_number(to, value);
    fputc('\n', to);
}

char *exposition_end(Exposition *exposition, size_t *ret_size)
{
    if (exposition->open_metrics) fputs("# EOF\n", exposition->to);
    const bool failed = ferror(exposition->to);
    if (fclose(exposition->to) || failed) {
        free(exposition->text);
        return NULL;
    }
    *ret_size = exposition->size;
    return exposition->text;
}

const char *exposition_type(bool open_metrics)
{
    return open_metrics ? "application/openmetrics-text; version=1.0.0; charset=utf-8"
                        : "text/plain; version=0.0.4; charset=utf-8";
}

/* The weight of one element, as in "text/plain;version=0.0.4;q=0.5", which ends at `end`. */
static double weight_of(const char *element, const char *end)
{
    for (const char *c = element; (c = memchr(c, ';', (size_t)(end - c)));) {
        c += 1 + strspn(c + 1, " \t");
        if (end - c > 2 && strncasecmp(c, "q=", 2) == 0) return strtod(c + 2, NULL);
    }
    return 1;
}

/* The greatest weight that a type is given; 0 if it is not named. */
static double weight(const char *accept, const char *type)
{
    double greatest = 0;
    const size_t n = strlen(type);
    for (const char *element = accept, *end; *element; element = *end ? end + 1 : end) {
        element += strspn(element, " \t");
        end = element + strcspn(element, ",");
        const bool named = (size_t)(end - element) >= n && strncasecmp(element, type, n) == 0;
        if (named && strchr(";, \t", element[n])) greatest = fmax(greatest, weight_of(element, end));
    }
    return greatest;
}

bool exposition_accepts_open_metrics(const char *accept)
{
    if (!accept) return false;
    const double open_metrics = weight(accept, "application/openmetrics-text");
    return open_metrics > 0 && open_metrics >= weight(accept, "text/plain");
}
