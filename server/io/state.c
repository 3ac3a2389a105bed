/* SPDX-License-Identifier: BSD-3-Clause */
/* The group /state of a checkpoint: a capture, bit for bit, each part with its checksum. */
#include "io/state.h"
#include "io/meta.h"

#include <stdio.h>
#include <xxhash.h>

static const char group[] = "/state";

/* The scalars in the order in which they are hashed, without the padding of any struct. */
enum { DIM, N, N_FLUID, STEP, REBUILDS, GUARDED, WHOLE };
enum { SPACING, T, DT, DT_FIRST, REAL };

typedef struct Scalars {
    uint64_t whole[WHOLE];
    double real[REAL];
} Scalars;

static const char *const whole_names[WHOLE] = {"dim", "n", "n_fluid", "step", "rebuilds", "guarded"};
static const char *const real_names[REAL] = {"spacing", "t", "dt", "dt_first"};

/* The account of energy, in the order in which it is hashed. */
static const char account_group[] = "/energy";
enum { ACCOUNT = 14 };
static const char *const account_names[ACCOUNT] = {"start",  "work",      "excess",    "scale",     "potential",
                                                   "power",  "gravity_x", "gravity_y", "gravity_z", "misplaced",
                                                   "lifted", "middle_x",  "middle_y",  "middle_z"};

static int components(const MnsFieldInfo *field, int dim)
{
    return field->components > 1 ? dim : 1;
}

static void name_of(char name[static 128], const MnsFieldInfo *field)
{
    snprintf(name, 128, "%s/%s", group, field->name);
}

static uint64_t hash_columns(void *const *columns, int n_columns, size_t bytes)
{
    uint64_t hash = 0;
    for (int d = 0; d < n_columns; d++) hash = XXH64(columns[d], bytes, hash);
    return hash;
}

/* --- writing ----------------------------------------------------------------------------------------------------- */

static void put_scalars(H5 *h, const MnsCapture *state)
{
    const MnsProgress *p = &state->progress;
    const Scalars s = {{(uint64_t)state->dim, state->n, state->n_fluid, p->step, p->rebuilds, p->guarded},
                       {state->spacing, p->t, p->dt, p->dt_first}};
    const uint64_t hash = XXH64(&s, sizeof s, 0);
    for (int k = 0; k < WHOLE; k++) h5_mark(h, group, whole_names[k], H5T_NATIVE_UINT64, 0, &s.whole[k]);
    for (int k = 0; k < REAL; k++) h5_mark(h, group, real_names[k], H5T_NATIVE_DOUBLE, 0, &s.real[k]);
    h5_mark(h, group, "xxh64", H5T_NATIVE_UINT64, 0, &hash);
}

static void put_account(H5 *h, const MnsEnergy *e)
{
    const double of[ACCOUNT] = {e->start,  e->work,       e->excess,     e->scale,      e->potential,
                                e->power,  e->gravity[0], e->gravity[1], e->gravity[2], e->misplaced,
                                e->lifted, e->middle[0],  e->middle[1],  e->middle[2]};
    const uint64_t hash = XXH64(of, sizeof of, 0);
    h5_make_group(h, account_group);
    for (int k = 0; k < ACCOUNT; k++) h5_mark(h, account_group, account_names[k], H5T_NATIVE_DOUBLE, 0, &of[k]);
    h5_mark(h, account_group, "xxh64", H5T_NATIVE_UINT64, 0, &hash);
}

static void put_field(H5 *h, const MnsCapture *state, int k)
{
    const MnsFieldInfo *field = &mns_fields()[k];
    const int width = components(field, state->dim);
    const uint64_t hash = hash_columns(state->data[k], width, state->n * h5_size(field->type));
    char name[128];
    name_of(name, field);
    h5_make(h, name, h5_type(field->type), 2, (hsize_t[]){(hsize_t)width, state->n});
    for (int d = 0; d < width; d++) h5_put_rows(h, name, h5_type(field->type), (size_t)d, 1, state->data[k][d]);
    h5_mark(h, name, "xxh64", H5T_NATIVE_UINT64, 0, &hash);
    meta_put_field(h, name, field);
}

void state_put(H5 *h, const MnsCapture *state)
{
    h5_make_group(h, group);
    put_scalars(h, state);
    if (state->progress.energy.known) put_account(h, &state->progress.energy);
    for (int k = 0; mns_fields()[k].name; k++)
        if (state->fields >> k & 1) put_field(h, state, k);
}

/* --- reading ----------------------------------------------------------------------------------------------------- */

static Scalars get_scalars(H5 *h)
{
    Scalars s = {{0}, {0}};
    uint64_t hash = 0;
    for (int k = 0; k < WHOLE; k++) h5_get_mark(h, group, whole_names[k], H5T_NATIVE_UINT64, &s.whole[k]);
    for (int k = 0; k < REAL; k++) h5_get_mark(h, group, real_names[k], H5T_NATIVE_DOUBLE, &s.real[k]);
    h5_get_mark(h, group, "xxh64", H5T_NATIVE_UINT64, &hash);
    if (hash != XXH64(&s, sizeof s, 0))
        h5_raise(h, MNS_E_CORRUPT, "'%s' is damaged: the checksum of its scalars does not match", h->path);
    if (s.whole[DIM] < 2 || s.whole[DIM] > 3 || s.whole[N] > UINT32_MAX || s.whole[N_FLUID] > s.whole[N])
        h5_raise(h, MNS_E_CORRUPT, "'%s' is damaged: its numbers of dimensions and particles make no sense", h->path);
    return s;
}

static MnsEnergy get_account(H5 *h)
{
    double of[ACCOUNT] = {0};
    uint64_t hash = 0;
    if (!h5_has(h, account_group)) return (MnsEnergy){.known = false};
    for (int k = 0; k < ACCOUNT; k++) h5_get_mark(h, account_group, account_names[k], H5T_NATIVE_DOUBLE, &of[k]);
    h5_get_mark(h, account_group, "xxh64", H5T_NATIVE_UINT64, &hash);
    if (hash != XXH64(of, sizeof of, 0))
        h5_raise(h, MNS_E_CORRUPT, "'%s' is damaged: the checksum of its account of energy does not match", h->path);
    return (MnsEnergy){.known = true,
                       .start = of[0],
                       .work = of[1],
                       .excess = of[2],
                       .scale = of[3],
                       .potential = of[4],
                       .power = of[5],
                       .gravity = {of[6], of[7], of[8]},
                       .misplaced = of[9],
                       .lifted = of[10],
                       .middle = {of[11], of[12], of[13]}};
}

/* Which fields the file holds: none that this program does not know. Whether they are what the scheme goes on from is for those to
 * ask who have one. */
static uint64_t get_fields(H5 *h)
{
    char name[128];
    uint64_t fields = 0;
    size_t found = 0;
    for (int k = 0; mns_fields()[k].name; k++) {
        name_of(name, &mns_fields()[k]);
        if (!h5_has(h, name)) continue;
        fields |= UINT64_C(1) << k;
        found++;
    }
    if (h5_members(h, group) != found)
        h5_raise(h, MNS_E_VERSION, "the fields in '%s' are not those of this version (%s) of the program", h->path,
                 MENISCUS_VERSION);
    return fields;
}

/* Fields are stored as they are in memory. */
static uint64_t bytes_of(uint64_t fields, int dim, uint64_t n)
{
    uint64_t width = 0;
    for (int k = 0; mns_fields()[k].name; k++)
        if (fields >> k & 1) width += (uint64_t)components(&mns_fields()[k], dim) * h5_size(mns_fields()[k].type);
    return width * n;
}

static void get_field(H5 *h, MnsCapture *state, int k)
{
    const MnsFieldInfo *field = &mns_fields()[k];
    const int width = components(field, state->dim);
    uint64_t hash = 0;
    char name[128];
    name_of(name, field);
    h5_expect(h, name, 2, (hsize_t[]){(hsize_t)width, state->n});
    for (int d = 0; d < width; d++) h5_get_rows(h, name, h5_type(field->type), (size_t)d, 1, state->data[k][d]);
    h5_get_mark(h, name, "xxh64", H5T_NATIVE_UINT64, &hash);
    if (!h->status && hash != hash_columns(state->data[k], width, state->n * h5_size(field->type)))
        h5_raise(h, MNS_E_CORRUPT, "'%s' is damaged: the checksum of '%s' does not match", h->path, name);
}

MnsCapture *state_get(H5 *h)
{
    const Scalars s = get_scalars(h);
    const uint64_t fields = get_fields(h);
    const MnsEnergy energy = get_account(h);
    h5_expect_bytes(h, bytes_of(fields, (int)s.whole[DIM], s.whole[N]));
    if (h->status) return NULL;
    MnsCapture *state = mns_capture_new((int)s.whole[DIM], s.whole[N], s.whole[N_FLUID], fields);
    if (!state) {
        h5_raise(h, MNS_E_MEMORY, "no memory for the particles of '%s'", h->path);
        return NULL;
    }
    state->spacing = s.real[SPACING];
    state->progress = (MnsProgress){.t = s.real[T],
                                    .dt = s.real[DT],
                                    .dt_first = s.real[DT_FIRST],
                                    .step = s.whole[STEP],
                                    .rebuilds = s.whole[REBUILDS],
                                    .guarded = s.whole[GUARDED],
                                    .energy = energy};
    for (int k = 0; mns_fields()[k].name; k++)
        if (fields >> k & 1) get_field(h, state, k);
    if (!h->status) return state;
    mns_capture_free(state);
    return NULL;
}
