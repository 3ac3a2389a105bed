/* SPDX-License-Identifier: BSD-3-Clause */
/* meniscus export: the particles of a snapshot or the series of the probes, for programs that do not read HDF5. */
#include "client/cli/command.h"
#include "client/cli/csv.h"
#include "client/cli/hdf_source.h"
#include "client/cli/output.h"
#include "client/cli/whole_file.h"
#include "common/host/screen.h"
#include <endian.h>
#include <meniscus/exit.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { COLUMNS_MAX = 512, NAME_SIZE = 256, UNIT_SIZE = 32 };

/* A field of the particles, or a probe. */
typedef struct Column {
    char name[NAME_SIZE], unit[UNIT_SIZE];
    int components;
    double *values; /* [rows][components] */
} Column;

typedef struct Table {
    size_t rows, n;
    Column column[COLUMNS_MAX];
    bool is_particles; /* the first column is their position [rows][3] */
} Table;

/* --- reading -------------------------------------------------------------------------------------------------------------- */

static MnsStatus add(const Source *s, Table *table, const char *path, const char *name)
{
    if (table->n == COLUMNS_MAX)
        return mns_fail(s->error, MNS_E_LIMIT, "%s has more than %d columns", s->path, COLUMNS_MAX);
    Column *column = &table->column[table->n];
    const MnsStatus status = source_numbers(s, path, table->rows, &column->components, &column->values);
    if (status) return status;
    snprintf(column->name, sizeof column->name, "%s", name);
    source_text(s, path, "unit", sizeof column->unit, column->unit);
    table->n++;
    return MNS_OK;
}

/* A group while it is gone through. */
typedef struct Walk {
    const Source *source;
    Table *table;
    const char *group;
    MnsStatus status;
} Walk;

static herr_t add_member(hid_t id, const char *name, const H5L_info_t *info, void *arg)
{
    (void)id;
    (void)info;
    Walk *walk = arg;
    char path[2 * NAME_SIZE];
    if (snprintf(path, sizeof path, "%s/%s", walk->group, name) >= (int)sizeof path || strlen(name) >= NAME_SIZE)
        walk->status = source_damaged(walk->source, "a name in it has no end");
    else walk->status = add(walk->source, walk->table, path, name);
    return walk->status != MNS_OK;
}

static MnsStatus add_group(const Source *s, Table *table, const char *group)
{
    Walk walk = {s, table, group, MNS_OK};
    if (!source_has(s, group)) return source_damaged(s, group);
    const herr_t code =
        H5Literate_by_name(s->file, group, H5_INDEX_NAME, H5_ITER_INC, NULL, add_member, &walk, H5P_DEFAULT);
    return code < 0 && !walk.status ? source_damaged(s, group) : walk.status;
}

static MnsStatus read_table(const Source *s, Table *table)
{
    static const char points[] = "/VTKHDF/Points";
    hsize_t shape[2] = {0, 0};
    table->is_particles = source_has(s, points);
    const char *first = table->is_particles ? points : "/step";
    if (!source_has(s, first)) return source_damaged(s, "it is neither a snapshot nor a series of probes");
    if (!source_shape(s, first, shape) || shape[1] != (table->is_particles ? 3 : 1)) return source_damaged(s, first);
    table->rows = shape[0];
    if (table->is_particles) {
        const MnsStatus status = add(s, table, points, "position");
        return status ? status : add_group(s, table, "/VTKHDF/PointData");
    }
    MnsStatus status = add(s, table, "/step", "step");
    if (!status) status = add(s, table, "/time", "time");
    return status ? status : add_group(s, table, "/probes");
}

/* --- writing -------------------------------------------------------------------------------------------------------------- */

/* Of the position, the axis says it all. */
static void write_heading(const Column *column, int k, bool is_position, FILE *out)
{
    static const char *const axes[] = {"x", "y", "z"};
    if (is_position) csv_heading(out, axes[k], 0, 1, column->unit);
    else csv_heading(out, column->name, (size_t)k, (size_t)column->components, column->unit);
}

static bool write_csv(FILE *out, const void *arg)
{
    const Table *table = arg;
    for (size_t c = 0; c < table->n; c++)
        for (int k = 0; k < table->column[c].components; k++) {
            if (c || k) fputc(',', out);
            write_heading(&table->column[c], k, table->is_particles && !c, out);
        }
    fputc('\n', out);
    for (size_t i = 0; i < table->rows; i++) {
        for (size_t c = 0; c < table->n; c++) {
            const Column *column = &table->column[c];
            for (int k = 0; k < column->components; k++) {
                if (c || k) fputc(',', out);
                csv_number(out, column->values[i * (size_t)column->components + (size_t)k]);
            }
        }
        fputc('\n', out);
    }
    return !ferror(out);
}

static void write_doubles(const double *values, size_t n, FILE *out)
{
    for (size_t k = 0; k < n; k++) {
        uint64_t bits;
        memcpy(&bits, &values[k], sizeof bits);
        bits = htobe64(bits);
        fwrite(&bits, sizeof bits, 1, out);
    }
}

/* VTK's old format, which most programs read: points, a vertex of each, and all fields. Its binary numbers are big-endian. */
static bool write_vtk(FILE *out, const void *arg)
{
    const Table *table = arg;
    fprintf(out, "# vtk DataFile Version 3.0\nparticles of Meniscus\nBINARY\nDATASET POLYDATA\nPOINTS %zu double\n",
            table->rows);
    write_doubles(table->column[0].values, 3 * table->rows, out);
    fprintf(out, "\nVERTICES %zu %zu\n", table->rows, 2 * table->rows);
    for (size_t i = 0; i < table->rows; i++) {
        const uint32_t vertex[2] = {htobe32(1), htobe32((uint32_t)i)};
        fwrite(vertex, sizeof vertex, 1, out);
    }
    fprintf(out, "\nPOINT_DATA %zu\nFIELD FieldData %zu\n", table->rows, table->n - 1);
    for (size_t c = 1; c < table->n; c++) {
        const Column *column = &table->column[c];
        fprintf(out, "%s %d %zu double\n", column->name, column->components, table->rows);
        write_doubles(column->values, (size_t)column->components * table->rows, out);
        fputc('\n', out);
    }
    return !ferror(out);
}

/* --- the command ---------------------------------------------------------------------------------------------------------- */

static bool ends_with(const char *text, const char *end)
{
    const size_t n = strlen(text), m = strlen(end);
    return n > m && !strcmp(text + n - m, end);
}

static MnsStatus write_table(const Invocation *in, const Table *table, MnsError *error)
{
    const char *path = options_get(&in->options, OPT_EXPORT);
    if (!path) {
        write_csv(stdout, table);
        return screen_flush(error);
    }
    MnsStatus status =
        whole_file_write(path, "the table", ends_with(path, ".vtk") ? write_vtk : write_csv, table, error);
    if (status) return status;
    if (in->json)
        return output_json(json_pack("{so, sI}", "path", output_text(path), "rows", (json_int_t)table->rows), error);
    printf("%s: %zu %s\n", path, table->rows, table->is_particles ? "particles" : "samples");
    return MNS_OK;
}

MnsStatus command_export(Invocation *in, MnsError *error)
{
    const char *path = options_get(&in->options, OPT_EXPORT);
    if (path && !ends_with(path, ".csv") && !ends_with(path, ".vtk"))
        return command_usage(in, mns_fail_at(error, MNS_E_INVALID, "--out",
                                             "--out is a name that ends with .csv or .vtk, not \"%.200s\"", path));
    if (!path && in->json)
        return command_usage(in,
                             mns_fail_at(error, MNS_E_INVALID, "--output",
                                         "with -o json --out FILE must be given: standard output is for the object"));
    Table *table = calloc(1, sizeof *table);
    if (!table) return mns_fail(error, MNS_E_MEMORY, "no memory for the columns of %s", in->options.words[0]);
    Source s;
    MnsStatus status = source_open(&s, in->options.words[0], error);
    if (!status) {
        status = read_table(&s, table);
        source_close(&s);
    }
    if (!status && path && ends_with(path, ".vtk") && !table->is_particles)
        status =
            mns_fail_at(error, MNS_E_INVALID, "--out", "a series of probes has no places for a .vtk file: use .csv");
    if (!status) status = write_table(in, table, error);
    for (size_t c = 0; c < table->n; c++) free(table->column[c].values);
    free(table);
    return status;
}
