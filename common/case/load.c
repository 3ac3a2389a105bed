/* SPDX-License-Identifier: BSD-3-Clause */
/* A case file as a `load`. */
#include "common/case/load.h"

#include <stdlib.h>

static size_t count_settings(const CaseFile *file)
{
    const char *path, *yaml;
    size_t n = 0;
    while (case_file_setting(file, n, &path, &yaml)) n++;
    return n;
}

static Meniscus__Assignment *assignment(const CaseFile *file, size_t k)
{
    const char *path, *yaml;
    Meniscus__Assignment *a = malloc(sizeof *a);
    if (!a) return NULL;
    meniscus__assignment__init(a);
    case_file_setting(file, k, &path, &yaml);
    a->path = (char *)path;
    a->value = (char *)yaml;
    return a;
}

MnsStatus load_init(Meniscus__Load *load, const CaseFile *file, MnsError *error)
{
    const size_t n = count_settings(file);
    meniscus__load__init(load);
    load->case_ = (Meniscus__Case *)case_file_message(file);
    load->settings = calloc(n + 1, sizeof *load->settings);
    bool well = load->settings;
    for (; well && load->n_settings < n; load->n_settings += well)
        well = (load->settings[load->n_settings] = assignment(file, load->n_settings));
    if (well) return MNS_OK;
    load_done(load);
    return mns_fail(error, MNS_E_MEMORY, "no memory for %zu settings", n);
}

void load_done(Meniscus__Load *load)
{
    for (size_t k = 0; k < load->n_settings; k++) free(load->settings[k]);
    free(load->settings);
    meniscus__load__init(load);
}
