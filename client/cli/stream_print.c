/* SPDX-License-Identifier: BSD-3-Clause */
/* Items of a stream as lines: a table for plotting programs, CSV, or a JSON object each. */
#include "client/cli/csv.h"
#include "client/cli/output.h"
#include "client/cli/stream.h"
#include "common/host/screen.h"
#include "common/host/text.h"
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

static const MnsArray *find(const MnsStreamItem *item, const char *name)
{
    for (size_t a = 0; a < item->n_arrays; a++)
        if (!strcmp(item->arrays[a].name, name)) return &item->arrays[a];
    return NULL;
}

static size_t components(const MnsArray *array)
{
    return array->n_dims > 1 ? array->shape[1] : 1;
}

/* --- tables ------------------------------------------------------------------------------------------------------------- */

static void print_csv_title(const StreamSink *sink)
{
    csv_heading(stdout, "step", 0, 1, "1");
    putchar(',');
    csv_heading(stdout, "time", 0, 1, "s");
    for (size_t k = 0; k < sink->n_columns; k++)
        for (unsigned c = 0; c < sink->columns[k].components; c++) {
            putchar(',');
            csv_heading(stdout, sink->columns[k].name, c, sink->columns[k].components, sink->columns[k].unit);
        }
}

/* For plotting programs, which take blanks for the ends of columns. */
static void print_text_title(const StreamSink *sink)
{
    printf("# step time[s]");
    for (size_t k = 0; k < sink->n_columns; k++) {
        const MnsStreamColumn *column = &sink->columns[k];
        for (unsigned c = 0; c < column->components; c++) {
            printf(" %s", column->name);
            if (column->components > 1) printf("_%c", "xyz"[c % 3]);
            if (*output_unit(column->unit)) printf("[%s]", column->unit);
        }
    }
}

static void print_title(StreamSink *sink)
{
    if (sink->titled) return;
    sink->titled = true;
    if (sink->format == STREAM_CSV) print_csv_title(sink);
    else print_text_title(sink);
    printf("\n");
}

static void print_value(const StreamSink *sink, double value)
{
    putchar(sink->format == STREAM_CSV ? ',' : ' ');
    if (sink->format == STREAM_CSV) csv_number(stdout, value);
    else printf("%.17g", value);
}

static void begin_row(const StreamSink *sink, double step, double time)
{
    printf("%.0f", step);
    print_value(sink, time);
}

/* Particles, a row each. */
static MnsStatus print_fields(StreamSink *sink, const MnsStreamItem *item, MnsError *error)
{
    const size_t n = item->n_arrays && item->arrays[0].n_dims ? item->arrays[0].shape[0] : 0;
    for (size_t a = 0; a < item->n_arrays; a++)
        if (item->arrays[a].n_dims < 1 || item->arrays[a].n_dims > 2 || item->arrays[a].shape[0] != n)
            return mns_fail(error, MNS_E_CORRUPT, "the arrays of an item differ in length");
    for (size_t i = 0; i < n; i++) {
        begin_row(sink, (double)item->step, item->time);
        for (size_t a = 0; a < item->n_arrays; a++)
            for (size_t c = 0, m = components(&item->arrays[a]); c < m; c++)
                print_value(sink, output_element(&item->arrays[a], i * m + c));
        printf("\n");
    }
    return MNS_OK;
}

/* Probes: one row, or those of a series, which has steps and times of its own. */
static MnsStatus print_probes(const StreamSink *sink, const MnsStreamItem *item, MnsError *error)
{
    const MnsArray *values = find(item, "values"), *step = find(item, "step"), *time = find(item, "time");
    const bool series = sink->kind == MNS_STREAM_SERIES;
    const size_t rows = series && values && values->n_dims == 2 ? values->shape[0] : 1;
    const size_t n = values && values->n_dims ? values->shape[values->n_dims - 1] : 0;
    const bool fits = values && values->n_dims == (series ? 2 : 1) &&
                      (!series || (step && time && step->n_dims == 1 && time->n_dims == 1 && step->shape[0] == rows &&
                                   time->shape[0] == rows));
    if (!fits) return mns_fail(error, MNS_E_CORRUPT, "the arrays of an item do not fit together");
    for (size_t i = 0; i < rows; i++) {
        if (series) begin_row(sink, output_element(step, i), output_element(time, i));
        else begin_row(sink, (double)item->step, item->time);
        for (size_t k = 0; k < n; k++) print_value(sink, output_element(values, i * n + k));
        printf("\n");
    }
    return MNS_OK;
}

/* --- JSON --------------------------------------------------------------------------------------------------------------- */

static json_t *columns_json(const StreamSink *sink)
{
    json_t *list = json_array();
    for (size_t k = 0; k < sink->n_columns; k++)
        json_array_append_new(list, json_pack("{soso}", "name", output_text(sink->columns[k].name), "unit",
                                              output_text(sink->columns[k].unit)));
    return list;
}

static MnsStatus print_json(const StreamSink *sink, const MnsStreamItem *item, MnsError *error)
{
    json_t *object =
        json_pack("{sIsIsIso}", "sequence", (json_int_t)item->sequence, "skipped", (json_int_t)item->skipped, "step",
                  (json_int_t)item->step, "time", output_number(item->time));
    if (item->n_arrays) {
        json_t *arrays = json_object();
        for (size_t a = 0; a < item->n_arrays; a++)
            json_object_set_new(arrays, item->arrays[a].name, output_array(&item->arrays[a]));
        json_object_set_new(object, "columns", columns_json(sink));
        json_object_set_new(object, "arrays", arrays);
    }
    if (sink->kind == MNS_STREAM_EVENTS) {
        json_object_set_new(object, "state", json_string(mns_state_name(item->state)));
        json_object_set_new(object, "what", output_text(item->what));
        json_object_set_new(object, "text", output_text(item->text));
    }
    if (item->file) json_object_set_new(object, "file", output_text(item->file));
    if (item->file && !item->abandoned) json_object_set_new(object, "bytes", json_integer((json_int_t)item->file_size));
    if (item->abandoned) json_object_set_new(object, "abandoned_from_row", json_integer((json_int_t)item->row));
    return output_json(object, error);
}

/* --- any ---------------------------------------------------------------------------------------------------------------- */

static MnsStatus print(StreamSink *sink, const MnsStreamItem *item, MnsError *error)
{
    if (sink->format == STREAM_JSON) return print_json(sink, item, error);
    if (item->abandoned) {
        printf("# undone: what came after row %" PRIu64 "%s%s\n", item->row, item->file ? ", and from " : "",
               item->file ? item->file : "");
        return MNS_OK;
    }
    switch (sink->kind) {
    case MNS_STREAM_EVENTS:
        printf("%.6g s  %s  %s\n", item->time, mns_state_name(item->state), text_shown(item->text));
        break;
    case MNS_STREAM_SNAPSHOTS: printf("%s\n", item->file ? item->file : ""); break;
    case MNS_STREAM_FIELDS: print_title(sink); return print_fields(sink, item, error);
    default: print_title(sink); return print_probes(sink, item, error);
    }
    return MNS_OK;
}

MnsStatus stream_put(StreamSink *sink, const MnsStreamItem *item, MnsError *error)
{
    MnsStatus status = MNS_OK;
    const bool files = sink->kind == MNS_STREAM_SNAPSHOTS, arrays = sink->kind == MNS_STREAM_FIELDS && sink->directory;
    if (files) status = stream_put_file(sink->directory, item, error);
    if (arrays) status = stream_put_arrays(sink->directory, item, error);
    if (status || (files && !item->whole && !item->abandoned)) return status;
    if (arrays && sink->format != STREAM_JSON) printf("step %" PRIu64 ", %.6g s\n", item->step, item->time);
    else if (arrays) {
        MnsStreamItem told = *item;
        told.n_arrays = 0; /* they are in the files */
        status = print_json(sink, &told, error);
    } else status = print(sink, item, error);
    return status ? status : screen_flush(error);
}
