/* SPDX-License-Identifier: BSD-3-Clause */
/* Asking for values and changing them: set, get, query. */
#include "client/cli/command.h"
#include "client/cli/output.h"
#include "common/host/text.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Print the values of a reply, and forget it. */
static MnsStatus report_values(const Invocation *in, MnsStatus status, MnsReply *reply, MnsError *error)
{
    if (status != MNS_OK) return status;
    if (in->json) {
        json_t *object = output_reply(reply);
        json_object_set_new(object, "values", output_values(reply->n_values, reply->values));
        status = output_json(object, error);
    } else {
        output_print_values(reply->n_values, reply->values);
    }
    mns_reply_free(reply);
    return status;
}

MnsStatus command_set(Invocation *in, MnsError *error)
{
    MnsReply *reply = NULL;
    MnsStatus status = MNS_OK;
    for (size_t k = 0; status == MNS_OK && k < in->options.n_words; k++)
        if (!strchr(in->options.words[k], '='))
            status = command_usage(in, mns_fail(error, MNS_E_INVALID,
                                                "set takes PATH=VALUE, as in end_time=3, but found "
                                                "\"%.200s\"",
                                                in->options.words[k]));
    if (status == MNS_OK) status = command_connect(in, error);
    if (status == MNS_OK) status = mns_client_set(in->client, in->options.n_words, in->options.words, &reply, error);
    if (status == MNS_OK && !in->json && reply->effect_step == MNS_NO_STEP) printf("%s\n", text_shown(reply->message));
    else if (status == MNS_OK && !in->json)
        printf("in effect from step %" PRIu64 "%s%s\n", reply->effect_step, *reply->message ? ": " : "",
               text_shown(reply->message));
    return report_values(in, status, reply, error);
}

MnsStatus command_get(Invocation *in, MnsError *error)
{
    MnsReply *reply = NULL;
    MnsStatus status = command_connect(in, error);
    if (status == MNS_OK) status = mns_client_get(in->client, in->options.n_words, in->options.words, &reply, error);
    return report_values(in, status, reply, error);
}

static MnsStatus query_probes(Invocation *in, size_t n, const char *const *names, MnsError *error)
{
    MnsReply *reply = NULL;
    MnsStatus status = command_connect(in, error);
    if (status == MNS_OK) status = mns_client_query_probes(in->client, n, names, &reply, error);
    return report_values(in, status, reply, error);
}

/* --- a field at points -------------------------------------------------------------------------------------------- */

static MnsStatus report_points(const Invocation *in, const MnsReply *reply, size_t n, int dim, const double *points,
                               MnsError *error)
{
    const MnsArray *array = reply->n_arrays ? &reply->arrays[0] : NULL;
    if (!array || !array->n_dims || array->shape[0] != n)
        return mns_fail(error, MNS_E_CORRUPT, "the daemon's answer does not have one value per point");
    if (in->json) {
        json_t *object = output_reply(reply), *list = json_array();
        for (size_t k = 0; k < n; k++) {
            json_t *at = json_array();
            for (int d = 0; d < dim; d++) json_array_append_new(at, output_number(points[k * (size_t)dim + (size_t)d]));
            json_array_append_new(list, at);
        }
        json_object_set_new(object, "field", output_text(array->name));
        json_object_set_new(object, "points", list);
        json_object_update_new(object, output_array(array));
        return output_json(object, error);
    }
    for (size_t k = 0; k < n; k++) {
        printf("%s(", array->name);
        for (int d = 0; d < dim; d++) printf("%s%.6g", d ? ", " : "", points[k * (size_t)dim + (size_t)d]);
        const double value = output_element(array, k);
        if (isnan(value)) printf("): no particle is near\n");
        else printf(") = %.6g%s%s\n", value, *output_unit(array->unit) ? " " : "", output_unit(array->unit));
    }
    return MNS_OK;
}

/* Points as words "x,y" or "x,y,z", all with the same number of coordinates. ret: [n_words][3], packed to
 * [n_words][dim]. */
static MnsStatus read_points(size_t n_words, const char *const *words, double *ret, int *ret_dim, MnsError *error)
{
    size_t dim = 0, n = 0;
    for (size_t k = 0; k < n_words; k++) {
        size_t found;
        const MnsStatus status = parse_numbers("point", words[k], 3, ret + n, &found, error);
        if (status != MNS_OK) return status;
        if (k == 0) dim = found;
        if (found < 2)
            return mns_fail(
                error, MNS_E_INVALID,
                "\"%.100s\" is one number, and a point has two or three: write them as one word with commas "
                "between, as in 1,0.5 or 1,0.5,0",
                words[k]);
        if (found != dim)
            return mns_fail(
                error, MNS_E_INVALID,
                "\"%.100s\" has %zu coordinates, and \"%.100s\" has %zu: all points have as many as the case "
                "has dimensions",
                words[k], found, words[0], dim);
        n += dim;
    }
    *ret_dim = (int)dim;
    return MNS_OK;
}

static MnsStatus query_points(Invocation *in, size_t n_words, const char *const *words, MnsError *error)
{
    double points[3 * MAX_WORDS];
    int dim = 0;
    MnsReply *reply = NULL;
    if (n_words < 2)
        return command_usage(in,
                             mns_fail(error, MNS_E_INVALID, "query at needs a field and points: at pressure 0.5,0.1"));
    MnsStatus status = command_usage(in, read_points(n_words - 1, words + 1, points, &dim, error));
    if (status == MNS_OK) status = command_connect(in, error);
    if (status == MNS_OK)
        status = mns_client_query_points(in->client, words[0], n_words - 1, dim, points, &reply, error);
    if (status == MNS_OK) status = report_points(in, reply, n_words - 1, dim, points, error);
    mns_reply_free(reply);
    return status;
}

/* --- the particles of a box --------------------------------------------------------------------------------------- */

static size_t columns(const MnsArray *array)
{
    return array->n_dims > 1 ? array->shape[1] : 1;
}

static size_t rows(const MnsReply *reply)
{
    return reply->n_arrays && reply->arrays[0].n_dims ? reply->arrays[0].shape[0] : 0;
}

/* A table that plotting programs read: a line of names that begins with #, then a line per particle. */
static MnsStatus print_table(const MnsReply *reply, MnsError *error)
{
    const size_t n = rows(reply);
    printf("#");
    for (size_t a = 0; a < reply->n_arrays; a++) {
        const MnsArray *array = &reply->arrays[a];
        if (array->n_dims < 1 || array->n_dims > 2 || array->shape[0] != n)
            return mns_fail(error, MNS_E_CORRUPT, "the daemon's arrays differ in length");
        for (size_t c = 0; c < columns(array); c++) {
            printf(" %s", array->name);
            if (columns(array) > 1) printf("_%c", "xyz"[c % 3]);
            if (*output_unit(array->unit)) printf("[%s]", array->unit);
        }
    }
    for (size_t i = 0; i < n; i++)
        for (size_t a = 0; a < reply->n_arrays; a++) {
            const MnsArray *array = &reply->arrays[a];
            for (size_t c = 0; c < columns(array); c++)
                printf("%s%.9g", a + c ? " " : "\n", output_element(array, i * columns(array) + c));
        }
    putchar('\n');
    return MNS_OK;
}

static MnsStatus report_particles(const Invocation *in, const MnsReply *reply, MnsError *error)
{
    if (!in->json) return print_table(reply, error);
    json_t *object = output_reply(reply), *fields = json_object();
    for (size_t a = 0; a < reply->n_arrays; a++)
        json_object_set_new(fields, reply->arrays[a].name, output_array(&reply->arrays[a]));
    json_object_set_new(object, "particles", json_integer((json_int_t)rows(reply)));
    json_object_set_new(object, "fields", fields);
    return output_json(object, error);
}

static MnsStatus read_box(const Invocation *in, size_t n_words, const char *const *words, MnsParticleQuery *ret,
                          MnsError *error)
{
    double corners[6];
    const char *limit = options_get(&in->options, OPT_LIMIT);
    ret->walls = options_get(&in->options, OPT_WALLS);
    if (n_words != 0 && n_words != 2)
        return mns_fail(error, MNS_E_INVALID, "query box takes two corners, MIN and MAX, or none: box 0,0 1,0.5");
    if (limit) {
        const MnsStatus status = parse_count("--limit", limit, &ret->limit, error);
        if (status != MNS_OK) return status;
        if (ret->limit == 0) return mns_fail(error, MNS_E_INVALID, "--limit 0 allows no particles; write 1 or more");
    }
    const MnsStatus status = read_points(n_words, words, corners, &ret->dim, error);
    if (status != MNS_OK || n_words == 0) return status;
    memcpy(ret->min, corners, (size_t)ret->dim * sizeof *corners);
    memcpy(ret->max, corners + ret->dim, (size_t)ret->dim * sizeof *corners);
    return MNS_OK;
}

static MnsStatus query_box(Invocation *in, size_t n_words, const char *const *words, MnsError *error)
{
    const char *fields[MAX_WORDS];
    char *text = NULL;
    MnsReply *reply = NULL;
    MnsParticleQuery query = {.fields = fields};
    MnsStatus status = command_usage(in, read_box(in, n_words, words, &query, error));
    if (status == MNS_OK) status = command_fields(in, fields, &query.n_fields, &text, error);
    if (status == MNS_OK) status = command_connect(in, error);
    if (status == MNS_OK) status = mns_client_query_particles(in->client, &query, &reply, error);
    if (status == MNS_OK) status = report_particles(in, reply, error);
    mns_reply_free(reply);
    free(text);
    return status;
}

MnsStatus command_query(Invocation *in, MnsError *error)
{
    const size_t n = in->options.n_words;
    const char *const *words = in->options.words;
    if (n == 0) return query_probes(in, 0, NULL, error);
    if (strcmp(words[0], "probes") == 0) return query_probes(in, n - 1, words + 1, error);
    if (strcmp(words[0], "at") == 0) return query_points(in, n - 1, words + 1, error);
    if (strcmp(words[0], "box") == 0) return query_box(in, n - 1, words + 1, error);
    return command_usage(in, mns_fail(error, MNS_E_INVALID,
                                      "query \"%.100s\": ask for probes [NAME...], at FIELD X,Y..., or "
                                      "box MIN MAX; a probe of that name is `meniscus query probes %.100s`",
                                      words[0], words[0]));
}
