/* SPDX-License-Identifier: BSD-3-Clause */
/* Copy fields out of a simulation and a state back in, and fingerprint it. */
#include "base/array.h"
#include "sim/energy.h"
#include "sim/home.h"
#include "sim/integrator.h"
#include "sim/level.h"
#include "sim/shown.h"
#include <stdlib.h>
#include <string.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

/* Room for these fields, as far as there is none yet. */
static bool make_room(MnsCapture *capture, uint64_t fields)
{
    const MnsFieldInfo *info = mns_fields();
    for (int f = 0; info[f].name; f++) {
        if (!(fields >> f & 1)) continue;
        for (int d = 0; d < (info[f].components == 1 ? 1 : capture->dim); d++)
            if (!capture->data[f][d] && !(capture->data[f][d] = array_room(capture->n, field_size(&info[f]))))
                return false;
    }
    return true;
}

MnsCapture *mns_capture_new(int dim, size_t n, size_t n_fluid, uint64_t fields)
{
    MnsCapture *capture = calloc(1, sizeof *capture);
    if (!capture) return NULL;
    capture->dim = dim;
    capture->n = n;
    capture->n_fluid = n_fluid;
    capture->fields = fields;
    if (make_room(capture, fields)) return capture;
    mns_capture_free(capture);
    return NULL;
}

void mns_capture_free(MnsCapture *capture)
{
    if (!capture) return;
    for (int f = 0; f < MNS_MAX_FIELDS; f++)
        for (int d = 0; d < 3; d++) free(capture->data[f][d]);
    free(capture);
}

/* An array to be copied, or a part of one. */
typedef struct Stretch {
    char *to;
    const char *from;
    size_t bytes;
} Stretch;

enum { SHARE = 1 << 18, STRETCHES = 3 * MNS_MAX_FIELDS }; /* bytes that one thread copies at a time */

static void copy_share(const Stretch *of, size_t begin)
{
    if (begin < of->bytes)
        memcpy(of->to + begin, of->from + begin, of->bytes - begin < SHARE ? of->bytes - begin : SHARE);
}

/* All in one parallel region: to wake threads for each array would take as long as to copy it. */
static void copy(const Stretch *stretches, int n, size_t longest, int threads)
{
#pragma omp parallel for collapse(2) schedule(dynamic) num_threads(threads) if (longest > SHARE)
    for (int k = 0; k < n; k++)
        for (size_t begin = 0; begin < longest; begin += SHARE) copy_share(&stretches[k], begin);
}

/* Between the particles and all arrays that the capture has, out or in. */
static void copy_all(const MnsSim *sim, const MnsCapture *capture, bool out)
{
    const Particles *s = &sim->s;
    Stretch stretches[STRETCHES];
    size_t longest = 0;
    int n = 0;
    for (int f = 0; mns_fields()[f].name; f++) {
        const Owners owners = particles_owners(s, f);
        const size_t size = field_size(&mns_fields()[f]), bytes = (owners.last - owners.first) * size;
        if (out && shown_made(sim) >> f & 1) continue;
        for (int d = 0; d < 3; d++) {
            char *copied = capture->data[f][d], *own = particles_field(s, f, d);
            if (!(capture->fields >> f & 1) || !copied || !own) continue;
            copied += owners.first * size;
            stretches[n++] = out ? (Stretch){copied, own, bytes} : (Stretch){own, copied, bytes};
            longest = bytes > longest ? bytes : longest;
        }
    }
    copy(stretches, n, longest, sim->threads);
}

static void copy_out(const MnsSim *sim, MnsCapture *capture)
{
    capture->spacing = sim->model.dx;
    capture->progress = sim->progress;
    capture->level = level_name(sim->model.level);
    capture->arithmetic = level_arithmetic(sim->model.level);
    capture->solver = sim->solver;
    copy_all(sim, capture, true);
    for (int f = 0; f < FIELDS_END; f++)
        for (int d = 0; d < 3 && capture->fields & shown_made(sim) & UINT64_C(1) << f; d++)
            if (capture->data[f][d]) shown_make(sim, f, d, capture->data[f][d]);
}

MnsStatus mns_sim_capture(const MnsSim *sim, uint64_t fields, MnsCapture **ret_capture, MnsError *error)
{
    const Particles *s = &sim->s;
    MnsCapture *capture = mns_capture_new(s->dim, s->n, particles_fluid(s), fields & shown_fields(sim));
    if (!capture) return mns_fail(error, MNS_E_MEMORY, "no memory to copy %zu particles", s->n);
    copy_out(sim, capture);
    *ret_capture = capture;
    return MNS_OK;
}

MnsStatus mns_sim_recapture(const MnsSim *sim, uint64_t fields, MnsCapture *capture, MnsError *error)
{
    const Particles *s = &sim->s;
    if (capture->dim != s->dim || capture->n != s->n || capture->n_fluid != particles_fluid(s))
        return mns_fail(error, MNS_E_STATE, "the capture has room for %zu particles, and there are %zu", capture->n,
                        s->n);
    if (!make_room(capture, fields & shown_fields(sim)))
        return mns_fail(error, MNS_E_MEMORY, "no memory to copy %zu particles", s->n);
    capture->fields = fields & shown_fields(sim);
    copy_out(sim, capture);
    return MNS_OK;
}

size_t mns_sim_capture_size(const MnsSim *sim, uint64_t fields)
{
    size_t size = 0;
    const MnsFieldInfo *info = mns_fields();
    for (int f = 0; info[f].name; f++)
        if (fields & shown_fields(sim) & UINT64_C(1) << f)
            size += (size_t)(info[f].components == 1 ? 1 : sim->s.dim) * field_size(&info[f]);
    return size * sim->s.n;
}

/* Groups are contiguous and of the size the case gives them; a capture that disagrees belongs to another case. */
static bool groups_agree(const MnsSim *sim, const uint8_t *phase)
{
    const Particles *s = &sim->s;
    bool agree = true;
#pragma omp parallel for schedule(static) reduction(&& : agree) num_threads(sim->threads)
    for (size_t i = 0; i < s->n; i++) {
        const bool wall = i >= particles_fluid(s);
        if (wall != (phase[i] >= s->n_phases) || phase[i] >= s->n_phases + sim->model.n_walls) agree = false;
        else if (!wall && sim->model.phase[phase[i]].summation != (i >= s->begin[GROUP_SUMMATION])) agree = false;
    }
    return agree;
}

static bool fits(const MnsSim *sim, const MnsCapture *capture)
{
    if (capture->dim != sim->s.dim || capture->n != sim->s.n || capture->n_fluid != particles_fluid(&sim->s))
        return false;
    return groups_agree(sim, capture->data[mns_field_find("phase")][0]);
}

MnsStatus mns_sim_restore(MnsSim *sim, const MnsCapture *capture, MnsError *error)
{
    const Particles *s = &sim->s;
    for (int f = 0; mns_fields()[f].name; f++)
        if (sim->scheme->state & ~capture->fields & UINT64_C(1) << f)
            return mns_fail(error, MNS_E_VERSION,
                            "the saved state has no %s, which the scheme %s goes on from: another version wrote it",
                            mns_fields()[f].name, sim->scheme->name);
    if (!fits(sim, capture))
        return mns_fail(error, MNS_E_INVALID,
                        "the saved state, %zu particles of which %zu fluid, is not of this case, which "
                        "has %zu and %zu",
                        capture->n, capture->n_fluid, s->n, particles_fluid(s));
    if (!home_leave(&sim->s, sim->threads)) return mns_fail(error, MNS_E_MEMORY, "no memory for %zu particles", s->n);
    copy_all(sim, capture, false);
    sim->progress = capture->progress;
    sim->fault = (MnsError){0};
    sim->uncorrected = 0;
    sim->losses = (MnsLosses){0, NAN};
    MnsError why = {0};
    const MnsStatus status = integrator_restart(sim, &why);
    home_enter(&sim->s, &sim->nb.bundles, sim->scheme, &sim->model, sim->threads);
    if (!status) energy_begin(sim);
    return status ? sim_remember(sim, status, &why, error) : MNS_OK; /* the state that was there is gone */
}

static uint64_t hash_particle(const Particles *s, Fields state, size_t i)
{
    XXH64_state_t hash;
    const double none = 0; /* of who does not have a field */
    XXH64_reset(&hash, 0);
    for (int f = 0; mns_fields()[f].name; f++) {
        if (!(state >> f & 1)) continue;
        const size_t size = field_size(&mns_fields()[f]);
        for (int d = 0; d < particles_components(s, f); d++) {
            const void *element = particles_element(s, f, d, i);
            XXH64_update(&hash, element ? element : &none, size);
        }
    }
    return XXH64_digest(&hash);
}

uint64_t mns_sim_hash(const MnsSim *sim)
{
    const Particles *s = &sim->s;
    const MnsProgress *p = &sim->progress;
    uint64_t sum = 0; /* of the particles' hashes: the order of storage does not matter */
#pragma omp parallel for schedule(static) reduction(+ : sum) num_threads(sim->threads)
    for (size_t i = 0; i < s->n; i++) sum += hash_particle(s, sim->scheme->state, i);
    const double times[3] = {p->t, p->dt, p->dt_first};
    const uint64_t counts[4] = {p->step, p->rebuilds, p->guarded, sum};
    return XXH64(counts, sizeof counts, XXH64(times, sizeof times, 0));
}

uint64_t mns_sim_state_fields(const MnsSim *sim)
{
    return sim->scheme->state;
}
