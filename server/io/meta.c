/* SPDX-License-Identifier: BSD-3-Clause */
/* The group /meniscus of every output file: which run, which moment. */
#include "io/meta.h"

static const char group[] = "/meniscus";

static void put_names(H5 *h, const MnsCase *c)
{
    const char *names[MNS_MAX_WALLS > MNS_MAX_FLUIDS ? MNS_MAX_WALLS : MNS_MAX_FLUIDS];
    for (size_t k = 0; k < c->n_fluids; k++) names[k] = c->fluids[k].name;
    h5_put_texts(h, "/meniscus/fluids", c->n_fluids, names);
    for (size_t k = 0; k < c->n_walls; k++) names[k] = c->walls[k].name;
    h5_put_texts(h, "/meniscus/walls", c->n_walls, names);
}

void meta_put_run(H5 *h, const FileMeta *meta)
{
    h5_make_group(h, group);
    h5_mark_text(h, group, "title", meta->c->title);
    h5_mark_text(h, group, "case", meta->case_name);
    h5_mark_text(h, group, "scheme", meta->c->scheme.name);
    h5_mark_text(h, group, "version", MENISCUS_VERSION);
    h5_mark_text(h, group, "units", "SI");
    h5_mark(h, group, "dim", H5T_NATIVE_INT, 0, &meta->c->dim);
    h5_put_texts(h, "/meniscus/case_text", 1, &meta->case_text);
    put_names(h, meta->c);
}

void meta_put_level(H5 *h, const char *level, const char *arithmetic)
{
    h5_mark_text(h, group, "level", level);
    h5_mark_text(h, group, "arithmetic", arithmetic);
}

const char *meta_arithmetic(H5 *h)
{
    static const char *const known[] = {"fused", "separate"};
    for (size_t k = 0; k < sizeof known / sizeof *known; k++)
        if (h5_has_mark(h, group, "arithmetic") && h5_mark_is(h, group, "arithmetic", known[k])) return known[k];
    return NULL;
}

void meta_put_moment(H5 *h, const MnsCapture *capture, size_t n)
{
    const uint64_t particles = n, fluid = capture->n_fluid;
    h5_mark(h, group, "spacing", H5T_NATIVE_DOUBLE, 0, &capture->spacing);
    h5_mark(h, group, "particles", H5T_NATIVE_UINT64, 0, &particles);
    h5_mark(h, group, "fluid_particles", H5T_NATIVE_UINT64, 0, &fluid);
    h5_mark(h, group, "step", H5T_NATIVE_UINT64, 0, &capture->progress.step);
    h5_mark(h, group, "time", H5T_NATIVE_DOUBLE, 0, &capture->progress.t);
    h5_mark(h, group, "dt", H5T_NATIVE_DOUBLE, 0, &capture->progress.dt);
    if (capture->level && capture->arithmetic) meta_put_level(h, capture->level, capture->arithmetic);
    if (capture->solver) h5_mark_text(h, group, "solver", capture->solver);
}

void meta_put_field(H5 *h, const char *name, const MnsFieldInfo *field)
{
    h5_mark_text(h, name, "unit", field->unit);
    h5_mark_text(h, name, "meaning", field->meaning);
}
