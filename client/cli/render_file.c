/* SPDX-License-Identifier: BSD-3-Clause */
/* Frames from snapshot files. */
#include "client/cli/hdf_source.h"
#include "client/cli/render_frame.h"
#include "common/case/file.h"
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char points[] = "/VTKHDF/Points", group[] = "/VTKHDF/PointData", about[] = "/meniscus";

/* A scalar of each particle, of vectors the magnitude. */
static MnsStatus get_field(const Source *s, const char *name, size_t n, int *ret_columns, double **ret)
{
    char path[sizeof group + FRAME_NAME + 1];
    double *values;
    snprintf(path, sizeof path, "%s/%s", group, name);
    const MnsStatus status = source_numbers(s, path, n, ret_columns, &values);
    if (status) return status;
    frame_magnitude(n, *ret_columns, values, values);
    *ret = values;
    return MNS_OK;
}

enum { NAMES_MAX = 400 }; /* letters of a list of fields */

static herr_t list_one(hid_t id, const char *name, const H5L_info_t *info, void *text)
{
    (void)id;
    (void)info;
    const size_t length = strlen(text);
    snprintf((char *)text + length, NAMES_MAX - length, "%s%s", length ? ", " : "", name);
    return 0;
}

static MnsStatus no_such_field(const Source *s, const char *name)
{
    char text[NAMES_MAX] = "";
    H5Literate_by_name(s->file, group, H5_INDEX_NAME, H5_ITER_INC, NULL, list_one, text, H5P_DEFAULT);
    return mns_fail_at(s->error, MNS_E_NOT_FOUND, "--field", "there is no field \"%s\" in %s; there are: %s", name,
                       s->path, text);
}

/* --- the parts of a frame ----------------------------------------------------------------------------------------- */

/* At most `most` texts of fixed length up to `longest`, in one block to be freed with a zero behind; NULL if there are
 * none. Variable ones are not even tried: in a damaged file HDF5 may search for them without end. */
static char *get_texts(const Source *s, const char *name, size_t most, size_t longest, size_t *ret_n, size_t *ret_size)
{
    if (!source_has(s, name)) return NULL;
    const hid_t dataset = H5Dopen2(s->file, name, H5P_DEFAULT);
    const hid_t type = H5Dget_type(dataset), space = H5Dget_space(dataset);
    const hssize_t n = H5Sget_simple_extent_npoints(space);
    const size_t size = H5Tget_size(type);
    const bool good = n > 0 && n <= (hssize_t)most && H5Tget_class(type) == H5T_STRING &&
                      H5Tis_variable_str(type) == 0 && size >= 1 && size <= longest;
    char *texts = good ? calloc((size_t)n * size + 1, 1) : NULL;
    if (texts && H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, texts) < 0) {
        free(texts);
        texts = NULL;
    }
    H5Sclose(space);
    H5Tclose(type);
    H5Dclose(dataset);
    *ret_n = (size_t)n;
    *ret_size = size;
    return texts;
}

static void get_fluids(const Source *s, Frame *frame)
{
    size_t n, size;
    char *names = get_texts(s, "/meniscus/fluids", FRAME_MAX_FLUIDS, 4096, &n, &size);
    for (size_t k = 0; names && k < n; k++) snprintf(frame->fluids[k], FRAME_NAME, "%.*s", (int)size, names + k * size);
    if (names) frame->n_fluids = n;
    free(names);
}

/* Where the fluids may be, and where down is, from the case in the file. A case that cannot be read is no reason to draw
 * nothing. */
static void get_space(const Source *s, Frame *frame)
{
    enum { LONGEST_CASE = 1 << 24 };
    size_t n, size;
    CaseFile *file;
    char *text = get_texts(s, "/meniscus/case_text", 1, LONGEST_CASE, &n, &size);
    if (!text) return;
    if (case_file_parse(s->path, text, strlen(text), &file, NULL) == MNS_OK) {
        const Meniscus__Case *message = case_file_message(file);
        const Meniscus__Domain *domain = message->domain;
        const size_t dim = (size_t)frame->dim;
        for (size_t d = 0; d < message->n_gravity && d < 3; d++) frame->gravity[d] = strtod(message->gravity[d], NULL);
        if (domain && domain->n_min >= dim && domain->n_max >= dim) frame_take_domain(frame, domain->min, domain->max);
        case_file_free(file);
    }
    free(text);
}

static MnsStatus get_about(const Source *s, Frame *frame)
{
    uint64_t n_fluid = 0;
    const bool good = source_number(s, "time", H5T_NATIVE_DOUBLE, &frame->time) &&
                      source_number(s, "spacing", H5T_NATIVE_DOUBLE, &frame->spacing) &&
                      source_number(s, "dim", H5T_NATIVE_INT, &frame->dim) &&
                      source_number(s, "fluid_particles", H5T_NATIVE_UINT64, &n_fluid);
    if (!good) return source_damaged(s, "time, spacing, dimension or number of particles is missing");
    if (!(frame->spacing > 0) || (frame->dim != 2 && frame->dim != 3) || n_fluid > frame->n)
        return source_damaged(s, "its spacing, dimension or number of particles makes no sense");
    frame->n_fluid = n_fluid;
    source_text(s, about, "title", sizeof frame->title, frame->title);
    get_fluids(s, frame);
    get_space(s, frame);
    return frame->n_fluids ? MNS_OK : source_damaged(s, "it names no fluids");
}

static MnsStatus get_places(const Source *s, Frame *frame)
{
    double *values;
    int columns;
    const MnsStatus status = source_numbers(s, points, frame->n, &columns, &values);
    if (status) return status;
    for (size_t i = 0; i < frame->n; i++)
        for (int d = 0; d < columns && d < 3; d++) frame->x[i][d] = values[i * (size_t)columns + (size_t)d];
    free(values);
    return MNS_OK;
}

static MnsStatus get_phases(const Source *s, Frame *frame)
{
    double *values;
    int columns;
    if (!source_has(s, "/VTKHDF/PointData/phase")) return source_damaged(s, "it has no field \"phase\"");
    const MnsStatus status = get_field(s, "phase", frame->n, &columns, &values);
    if (status) return status;
    for (size_t i = 0; i < frame->n; i++) frame->phase[i] = values[i] >= 0 && values[i] < 1e6 ? (int)values[i] : 0;
    free(values);
    return MNS_OK;
}

static MnsStatus get_value(const Source *s, const char *field, Frame *frame)
{
    char path[sizeof group + FRAME_NAME + 1];
    int columns;
    if (!strcmp(field, "phase")) return MNS_OK;
    snprintf(frame->field, sizeof frame->field, "%s", field);
    snprintf(path, sizeof path, "%s/%s", group, frame->field);
    if (strchr(field, '/') || !*field || !source_has(s, path)) return no_such_field(s, field);
    const MnsStatus status = get_field(s, frame->field, frame->n, &columns, &frame->value);
    if (status) return status;
    frame->is_magnitude = columns > 1;
    source_text(s, path, "unit", sizeof frame->unit, frame->unit);
    return MNS_OK;
}

static MnsStatus get_weight(const Source *s, Frame *frame)
{
    int columns;
    if (!source_has(s, "/VTKHDF/PointData/density")) return MNS_OK;
    return get_field(s, "density", frame->n, &columns, &frame->weight);
}

static MnsStatus read_all(const Source *s, const char *field, Frame *frame)
{
    hsize_t shape[2] = {0, 0};
    if (!source_has(s, points) || !source_has(s, group) || !source_has(s, about))
        return source_damaged(s, "it has no particles");
    if (!source_shape(s, points, shape) || shape[1] != 3 || shape[0] >= UINT32_MAX) return source_damaged(s, points);
    MnsStatus status = frame_init(frame, shape[0], s->error);
    if (status) return status;
    status = get_about(s, frame);
    if (!status) status = get_places(s, frame);
    if (!status) status = get_phases(s, frame);
    if (!status) status = get_value(s, field, frame);
    if (!status) status = get_weight(s, frame);
    if (status) frame_done(frame);
    return status;
}

MnsStatus frame_read_file(const char *path, const char *field, Frame *ret, MnsError *error)
{
    Source s;
    Frame frame;
    MnsStatus status = source_open(&s, path, error);
    if (status) return status;
    status = read_all(&s, field, &frame);
    source_close(&s);
    if (!status) *ret = frame;
    return status;
}
