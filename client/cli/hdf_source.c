/* SPDX-License-Identifier: BSD-3-Clause */
/* Files of HDF5 from outside, of which nothing is believed. */
#include "client/cli/hdf_source.h"
#include <errno.h>
#include <glob.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const char about[] = "/meniscus";

/* The list that ParaView opens as one. */
static bool is_list(const char *path)
{
    const size_t n = strlen(path), m = strlen(".series");
    return n > m && strcmp(path + n - m, ".series") == 0;
}

static MnsStatus fail_list(const char *path, MnsError *error)
{
    const char *slash = strrchr(path, '/');
    char pattern[4096];
    glob_t found;
    snprintf(pattern, sizeof pattern, "%.*ssnapshot-*.hdf", slash ? (int)(slash + 1 - path) : 0, path);
    const bool any = glob(pattern, 0, NULL, &found) == 0;
    mns_fail_at(error, MNS_E_IO, path, "%s is a list of snapshots, which ParaView opens: give one of them, as %s", path,
                any ? found.gl_pathv[found.gl_pathc - 1] : "snapshot-0000000000.hdf");
    globfree(&found);
    return MNS_E_IO;
}

/* Who names the directory of a run wants one of its files. */
static MnsStatus fail_directory(const char *path, MnsError *error)
{
    char pattern[4096];
    glob_t found;
    snprintf(pattern, sizeof pattern, "%s/snapshot-*.hdf", path);
    const bool any = glob(pattern, 0, NULL, &found) == 0;
    if (any)
        mns_fail_at(error, MNS_E_IO, path, "%s is a directory: give one of its files, as its newest snapshot, %s", path,
                    found.gl_pathv[found.gl_pathc - 1]);
    else mns_fail_at(error, MNS_E_IO, path, "%s is a directory, and no snapshot is in it", path);
    globfree(&found);
    return MNS_E_IO;
}

MnsStatus source_open(Source *s, const char *path, MnsError *error)
{
    *s = (Source){.file = H5I_INVALID_HID, .path = path, .error = error};
    if (access(path, R_OK))
        return mns_fail_at(error, MNS_E_IO, path, "cannot read %s: %s; %s", path, strerror(errno),
                           mns_refusal_hint(errno));
    struct stat info = {.st_mode = S_IFREG};
    if (!stat(path, &info) && S_ISDIR(info.st_mode)) return fail_directory(path, error);
    if (is_list(path)) return fail_list(path, error);
    if (!S_ISREG(info.st_mode)) return source_damaged(s, "it is no file");
    /* HDF5 would print a page about each failure; the sentence says enough. */
    H5Eget_auto2(H5E_DEFAULT, &s->print, &s->print_arg);
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    s->file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    if (s->file >= 0) return MNS_OK;
    source_close(s);
    return source_damaged(s, "HDF5 cannot open it");
}

void source_close(Source *s)
{
    if (s->file >= 0) H5Fclose(s->file);
    H5Eset_auto2(H5E_DEFAULT, s->print, s->print_arg);
}

MnsStatus source_damaged(const Source *s, const char *what)
{
    return mns_fail_at(s->error, MNS_E_CORRUPT, s->path, "%s is damaged or no file of Meniscus: %s", s->path, what);
}

/* --- attributes of /meniscus -------------------------------------------------------------------------------------- */

bool source_number(const Source *s, const char *name, hid_t type, void *ret)
{
    if (H5Aexists_by_name(s->file, about, name, H5P_DEFAULT) <= 0) return false;
    const hid_t attribute = H5Aopen_by_name(s->file, about, name, H5P_DEFAULT, H5P_DEFAULT);
    const hid_t space = H5Aget_space(attribute);
    const bool good = H5Sget_simple_extent_npoints(space) == 1 && H5Aread(attribute, type, ret) >= 0;
    H5Sclose(space);
    H5Aclose(attribute);
    return good;
}

void source_text(const Source *s, const char *object, const char *name, size_t size, char *ret)
{
    ret[0] = '\0';
    if (H5Aexists_by_name(s->file, object, name, H5P_DEFAULT) <= 0) return;
    const hid_t attribute = H5Aopen_by_name(s->file, object, name, H5P_DEFAULT, H5P_DEFAULT);
    const hid_t type = H5Aget_type(attribute), space = H5Aget_space(attribute);
    const size_t length = H5Tget_size(type);
    if (H5Tget_class(type) == H5T_STRING && H5Tis_variable_str(type) == 0 && H5Sget_simple_extent_npoints(space) == 1) {
        char *text = calloc(length + 1, 1);
        if (text && H5Aread(attribute, type, text) >= 0) snprintf(ret, size, "%s", text);
        free(text);
    }
    H5Sclose(space);
    H5Tclose(type);
    H5Aclose(attribute);
}

/* --- datasets ----------------------------------------------------------------------------------------------------- */

/* Whether every part of a path is there: HDF5 complains of a missing part in the middle. */
bool source_has(const Source *s, const char *name)
{
    char part[256];
    for (const char *end = strchr(name + 1, '/');; end = strchr(end + 1, '/')) {
        snprintf(part, sizeof part, "%.*s", end ? (int)(end - name) : (int)strlen(name), name);
        if (H5Lexists(s->file, part, H5P_DEFAULT) <= 0) return false;
        if (!end) return true;
    }
}

static bool shape_of(hid_t dataset, hsize_t shape[2])
{
    const hid_t space = H5Dget_space(dataset), type = H5Dget_type(dataset);
    const int rank = H5Sget_simple_extent_ndims(space);
    const H5T_class_t class = H5Tget_class(type);
    shape[1] = 1;
    const bool good = (rank == 1 || rank == 2) && (class == H5T_INTEGER || class == H5T_FLOAT) &&
                      H5Sget_simple_extent_dims(space, shape, NULL) == rank && shape[1] >= 1 && shape[1] <= 9;
    H5Tclose(type);
    H5Sclose(space);
    return good;
}

bool source_shape(const Source *s, const char *name, hsize_t shape[2])
{
    const hid_t dataset = H5Dopen2(s->file, name, H5P_DEFAULT);
    const bool good = dataset >= 0 && shape_of(dataset, shape);
    if (dataset >= 0) H5Dclose(dataset);
    return good;
}

MnsStatus source_numbers(const Source *s, const char *name, size_t rows, int *ret_columns, double **ret)
{
    hsize_t shape[2] = {0, 0};
    const hid_t dataset = H5Dopen2(s->file, name, H5P_DEFAULT);
    double *values = NULL;
    MnsStatus status = MNS_OK;
    if (dataset < 0 || !shape_of(dataset, shape) || shape[0] != rows) status = source_damaged(s, name);
    else if (rows >= UINT32_MAX) status = mns_fail(s->error, MNS_E_LIMIT, "%s has more rows than can be read", s->path);
    else if (!(values = malloc((rows ? rows : 1) * shape[1] * sizeof *values)))
        status = mns_fail(s->error, MNS_E_MEMORY, "there is no memory for %zu rows", rows);
    else if (H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0)
        status = source_damaged(s, name);
    if (dataset >= 0) H5Dclose(dataset);
    if (status) {
        free(values);
        return status;
    }
    *ret_columns = (int)shape[1];
    *ret = values;
    return MNS_OK;
}
