/* SPDX-License-Identifier: BSD-3-Clause */
/* meniscus stream: take data of a run at one's own pace. */
#include "client/cli/stream.h"
#include "client/cli/command.h"
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { FIELDS_MAX = 16 };

static const char *const kinds[] = {[MNS_STREAM_PROBES] = "probes",
                                    [MNS_STREAM_FIELDS] = "fields",
                                    [MNS_STREAM_EVENTS] = "events",
                                    [MNS_STREAM_SERIES] = "series",
                                    [MNS_STREAM_SNAPSHOTS] = "snapshots"};

static MnsStatus read_kind(const Options *options, MnsStreamOptions *to, MnsError *error)
{
    const char *word = options->n_words ? options->words[0] : "probes";
    for (unsigned k = 0; k < MNS_STREAM_KINDS; k++) {
        if (strcmp(word, kinds[k]) != 0) continue;
        to->kind = (MnsStreamKind)k;
        to->names = options->words + 1;
        to->n_names = options->n_words ? options->n_words - 1 : 0;
        const bool named = k != MNS_STREAM_EVENTS && k != MNS_STREAM_SNAPSHOTS;
        if (to->n_names && !named) return mns_fail(error, MNS_E_INVALID, "stream %s takes no names", word);
        if (k == MNS_STREAM_FIELDS && (to->n_names < 1 || to->n_names > FIELDS_MAX))
            return mns_fail(error, MNS_E_INVALID, "stream fields takes 1 to %d names, as in: fields position pressure",
                            (int)FIELDS_MAX);
        return MNS_OK;
    }
    return mns_fail(error, MNS_E_INVALID,
                    "there is no stream of \"%.60s\"; there are probes, fields, events, series and snapshots", word);
}

/* "f32", a bound for all, or NAME=BOUND for a field. */
static MnsStatus read_exactness(const Options *options, MnsStreamOptions *to, double bounds[FIELDS_MAX],
                                MnsError *error)
{
    const char *given[MAX_WORDS];
    const size_t n = options_all(options, OPT_EXACT, given);
    for (size_t k = 0; k < n; k++) {
        const char *equals = strchr(given[k], '=');
        double bound = 0;
        if (!strcmp(given[k], "f64")) continue;
        if (!strcmp(given[k], "f32")) {
            to->f32 = true;
            continue;
        }
        const MnsStatus status = parse_number("--exact", equals ? equals + 1 : given[k], &bound, error);
        if (status) return status;
        if (!(bound > 0)) return mns_fail(error, MNS_E_INVALID, "--exact %.80s: a bound is above 0", given[k]);
        if (!equals) {
            to->bound = bound;
            continue;
        }
        size_t field = 0;
        const size_t length = (size_t)(equals - given[k]);
        while (to->kind == MNS_STREAM_FIELDS && field < to->n_names &&
               (strlen(to->names[field]) != length || strncmp(to->names[field], given[k], length) != 0))
            field++;
        if (to->kind != MNS_STREAM_FIELDS || field == to->n_names)
            return mns_fail(error, MNS_E_INVALID, "--exact %.80s: that field is not asked for", given[k]);
        bounds[field] = bound;
        to->bounds = bounds;
    }
    return MNS_OK;
}

static MnsStatus read_codec(const Options *options, MnsStreamOptions *to, MnsError *error)
{
    static const char *const codecs[] = {"none", "lz4", "zstd"};
    const char *word = options_get(options, OPT_PACK);
    for (unsigned k = 0; k < sizeof codecs / sizeof *codecs; k++)
        if (!word || !strcmp(word, codecs[k])) {
            to->codec = (MnsCodec)k;
            return MNS_OK;
        }
    return mns_fail(error, MNS_E_INVALID, "--pack %.40s: bytes are packed by none, lz4 or zstd", word);
}

static MnsStatus read_box(const Options *options, MnsStreamOptions *to, MnsError *error)
{
    const char *text = options_get(options, OPT_WITHIN);
    double corners[6];
    size_t n;
    if (!text) return MNS_OK;
    const MnsStatus status = parse_numbers("--box", text, 6, corners, &n, error);
    if (status) return status;
    if (n != 4 && n != 6)
        return mns_fail(error, MNS_E_INVALID,
                        "--box takes two corners, X0,Y0,X1,Y1 or X0,Y0,Z0,X1,Y1,Z1, not %zu numbers", n);
    to->in_box = true;
    to->dim = (int)n / 2;
    for (int d = 0; d < to->dim; d++) {
        to->min[d] = corners[d];
        to->max[d] = corners[to->dim + d];
    }
    return MNS_OK;
}

static MnsStatus read_when(const Options *options, MnsStreamOptions *to, uint64_t *ret_count, MnsError *error)
{
    const char *steps = options_get(options, OPT_EVERY_STEPS), *interval = options_get(options, OPT_INTERVAL),
               *hz = options_get(options, OPT_MAX_HZ), *count = options_get(options, OPT_COUNT),
               *every = options_get(options, OPT_EVERY);
    MnsStatus status = steps ? parse_count("--every-steps", steps, &to->every_steps, error) : MNS_OK;
    if (!status && interval) status = parse_number("--interval", interval, &to->interval, error);
    if (!status && hz) status = parse_number("--max-hz", hz, &to->max_hz, error);
    if (!status && count) status = parse_count("--count", count, ret_count, error);
    if (!status && every) status = parse_count("--every", every, &to->every, error);
    to->first = options_get(options, OPT_FIRST);
    to->walls = options_get(options, OPT_WALLS);
    return status;
}

static MnsStatus make_directory(const StreamSink *sink, MnsError *error)
{
    if (!sink->directory || !mkdir(sink->directory, 0777) || errno == EEXIST) return MNS_OK;
    return mns_fail(error, MNS_E_IO, "cannot make the directory %.300s: %s; %s", sink->directory, strerror(errno),
                    mns_refusal_hint(errno));
}

static MnsStatus read_sink(const Invocation *in, MnsStreamKind kind, StreamSink *ret, MnsError *error)
{
    const bool csv = options_get(&in->options, OPT_CSV);
    *ret = (StreamSink){.format = in->json ? STREAM_JSON
                                  : csv    ? STREAM_CSV
                                           : STREAM_TEXT,
                        .kind = kind,
                        .directory = options_get(&in->options, OPT_TO)};
    if (kind == MNS_STREAM_SNAPSHOTS && !ret->directory)
        return mns_fail(error, MNS_E_INVALID, "stream snapshots needs --to DIR, where the files go");
    if (ret->directory && kind != MNS_STREAM_SNAPSHOTS && kind != MNS_STREAM_FIELDS)
        return mns_fail(error, MNS_E_INVALID,
                        "--to is for fields and snapshots; send the others where you want them with >");
    return MNS_OK;
}

/* Until there were so many (0: for ever), or the time is over. */
static MnsStatus take(const Invocation *in, MnsStream *stream, StreamSink *sink, uint64_t count, MnsError *error)
{
    const double deadline = in->timeout < 0 ? INFINITY : command_clock() + in->timeout;
    MnsStatus status = MNS_OK;
    for (uint64_t n = 0; !status && (!count || n < count);) {
        const MnsStreamItem *item;
        status = mns_stream_next(stream, in->timeout < 0 ? -1 : fmax(0, deadline - command_clock()), &item, error);
        if (status == MNS_E_TIMEOUT) status = mns_fail(error, status, "the %g s of --timeout are over", in->timeout);
        if (status) break;
        sink->columns = mns_stream_columns(stream, &sink->n_columns);
        n += !item->file || item->whole || item->abandoned;
        status = stream_put(sink, item, error);
    }
    return status;
}

MnsStatus command_stream(Invocation *in, MnsError *error)
{
    MnsStreamOptions options = {.kind = MNS_STREAM_PROBES};
    double bounds[FIELDS_MAX] = {0};
    StreamSink sink = {.directory = NULL};
    MnsStream *stream = NULL;
    uint64_t count = 0;
    MnsStatus status = read_kind(&in->options, &options, error);
    if (!status) status = read_exactness(&in->options, &options, bounds, error);
    if (!status) status = read_codec(&in->options, &options, error);
    if (!status) status = read_box(&in->options, &options, error);
    if (!status) status = read_when(&in->options, &options, &count, error);
    if (!status) status = read_sink(in, options.kind, &sink, error);
    if (status) return command_usage(in, status);
    status = make_directory(&sink, error);
    if (!status) status = command_connect(in, error);
    if (!status) status = mns_stream_open(in->client, &options, &stream, error);
    if (!status) status = take(in, stream, &sink, count, error);
    mns_stream_close(stream);
    return status;
}
