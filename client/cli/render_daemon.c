/* SPDX-License-Identifier: BSD-3-Clause */
/* Frames from a daemon while it runs: all particles of one step boundary. */
#include "client/cli/output.h"
#include "client/cli/render_frame.h"
#include <math.h>
#include <meniscus/client.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_PARTICLES = 50000000 };

static size_t columns(const MnsArray *a)
{
    return a->n_dims > 1 ? a->shape[1] : 1;
}

static MnsStatus find(const MnsReply *reply, const char *name, size_t rows, const MnsArray **ret, MnsError *error)
{
    const MnsArray *a = mns_reply_array(reply, name);
    if (!a || a->n_dims < 1 || a->n_dims > 2 || a->shape[0] != rows || columns(a) < 1 || columns(a) > 9)
        return mns_fail_at(error, MNS_E_CORRUPT, name, "the daemon's answer lacks a usable array \"%s\"", name);
    *ret = a;
    return MNS_OK;
}

static MnsStatus take_scalars(const MnsArray *a, double **ret, MnsError *error)
{
    const size_t n = a->shape[0], width = columns(a);
    double *values = malloc((n * width + 1) * sizeof *values);
    if (!values) return mns_fail(error, MNS_E_MEMORY, "there is no memory for %zu particles", n);
    for (size_t i = 0; i < n * width; i++) values[i] = output_element(a, i);
    frame_magnitude(n, (int)width, values, values);
    *ret = values;
    return MNS_OK;
}

static void take_places(const MnsArray *a, Frame *frame)
{
    const size_t width = columns(a);
    for (size_t i = 0; i < frame->n; i++)
        for (size_t d = 0; d < width && d < 3; d++) frame->x[i][d] = output_element(a, i * width + d);
}

/* Fluid particles come first. */
static void take_phases(const MnsArray *a, Frame *frame)
{
    frame->n_fluid = 0;
    for (size_t i = 0; i < frame->n; i++) {
        const double phase = output_element(a, i);
        frame->phase[i] = phase >= 0 && phase < 1e6 ? (int)phase : 0;
        frame->n_fluid += (size_t)frame->phase[i] < frame->n_fluids;
    }
}

static MnsStatus take_value(const MnsReply *reply, const char *field, Frame *frame, MnsError *error)
{
    const MnsArray *a;
    if (!strcmp(field, "phase")) return MNS_OK;
    MnsStatus status = find(reply, field, frame->n, &a, error);
    if (!status) status = take_scalars(a, &frame->value, error);
    if (status) return status;
    frame->is_magnitude = columns(a) > 1;
    snprintf(frame->field, sizeof frame->field, "%s", field);
    snprintf(frame->unit, sizeof frame->unit, "%s", a->unit);
    return MNS_OK;
}

/* The particles of a reply, with what is known of the case in *about. */
static MnsStatus take_all(const MnsReply *reply, const char *field, const Frame *about, Frame *ret, MnsError *error)
{
    const MnsArray *places, *phases, *weights;
    const MnsArray *first = mns_reply_array(reply, "position");
    const size_t n = first && first->n_dims ? first->shape[0] : 0;
    MnsStatus status = find(reply, "position", n, &places, error);
    if (!status) status = find(reply, "phase", n, &phases, error);
    if (!status) status = find(reply, "density", n, &weights, error);
    Frame frame, empty;
    if (!status) status = frame_init(&empty, n, error);
    if (status) return status;
    frame = *about;
    frame.n = n;
    frame.x = empty.x;
    frame.phase = empty.phase;
    frame.time = reply->time;
    take_places(places, &frame);
    take_phases(phases, &frame);
    status = take_scalars(weights, &frame.weight, error);
    if (!status) status = take_value(reply, field, &frame, error);
    if (status) frame_done(&frame);
    else *ret = frame;
    return status;
}

static double number_of(const MnsValue *value)
{
    return value->text ? strtod(value->text, NULL) : value->number;
}

static MnsStatus ask_case(MnsClient *client, Frame *about, MnsError *error)
{
    static const char *const paths[] = {"dimensions", "reference_length", "resolution"};
    MnsReply *reply;
    MnsStatus status = mns_client_get(client, 3, paths, &reply, error);
    if (status) return status;
    if (reply->n_values == 3) {
        about->dim = number_of(&reply->values[0]) == 3 ? 3 : 2;
        about->spacing = number_of(&reply->values[1]) / number_of(&reply->values[2]);
    }
    mns_reply_free(reply);
    if (!(about->spacing > 0) || !isfinite(about->spacing))
        return mns_fail(error, MNS_E_CORRUPT, "the daemon does not say how far apart its particles are");
    return MNS_OK;
}

/* Where the fluids may be, and where down is. A daemon that does not say costs the picture nothing else. */
static MnsStatus ask_space(MnsClient *client, Frame *about, MnsError *error)
{
    static const char *const paths[] = {"domain.min", "domain.max", "gravity"};
    MnsReply *reply;
    const MnsStatus status = mns_client_get(client, 3, paths, &reply, error);
    if (status) return status;
    if (reply->n_values == 3) {
        double min[3] = {0}, max[3] = {0};
        frame_vector(reply->values[0].text, min);
        frame_vector(reply->values[1].text, max);
        frame_take_domain(about, min, max);
        frame_vector(reply->values[2].text, about->gravity);
    }
    mns_reply_free(reply);
    return MNS_OK;
}

/* Names of the fluids, one by one until there are no more. */
static MnsStatus ask_fluids(MnsClient *client, Frame *about, MnsError *error)
{
    while (about->n_fluids < FRAME_MAX_FLUIDS) {
        char path[32];
        MnsReply *reply;
        snprintf(path, sizeof path, "fluids[%zu].name", about->n_fluids);
        const MnsStatus status = mns_client_get(client, 1, (const char *const[]){path}, &reply, error);
        if (status && about->n_fluids && status != MNS_E_UNAVAILABLE) return MNS_OK;
        if (status) return status;
        const char *name = reply->n_values == 1 && reply->values[0].text ? reply->values[0].text : "fluid";
        snprintf(about->fluids[about->n_fluids++], FRAME_NAME, "%s", name);
        mns_reply_free(reply);
    }
    return MNS_OK;
}

static MnsStatus ask_title(MnsClient *client, Frame *about, MnsError *error)
{
    MnsReply *reply;
    const MnsStatus status = mns_client_status(client, &reply, error);
    if (status) return status;
    if (reply->info) snprintf(about->title, sizeof about->title, "%s", reply->info->title);
    mns_reply_free(reply);
    return MNS_OK;
}

static MnsStatus ask_particles(MnsClient *client, const char *field, bool walls, const Frame *about, Frame *ret,
                               MnsError *error)
{
    const char *fields[4] = {"position", "phase", "density"};
    MnsParticleQuery query = {.fields = fields, .n_fields = 3, .limit = MOST_PARTICLES, .walls = walls};
    if (strcmp(field, "phase") != 0 && strcmp(field, "density") != 0) fields[query.n_fields++] = field;
    MnsReply *reply;
    MnsStatus status = mns_client_query_particles(client, &query, &reply, error);
    if (status) return status;
    status = take_all(reply, field, about, ret, error);
    mns_reply_free(reply);
    return status;
}

MnsStatus frame_read_daemon(MnsClient *client, const char *field, bool walls, Frame *ret, MnsError *error)
{
    Frame about = {0};
    MnsStatus status = ask_title(client, &about, error);
    if (!status) status = ask_case(client, &about, error);
    if (!status) status = ask_space(client, &about, error);
    if (!status) status = ask_fluids(client, &about, error);
    if (!status) status = ask_particles(client, field, walls, &about, ret, error);
    return status;
}
