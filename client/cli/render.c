/* SPDX-License-Identifier: BSD-3-Clause */
/* Draw the particles of a snapshot file or of a live daemon as a PNG picture. */
#include "client/cli/render.h"
#include "client/cli/render_picture.h"
#include <jansson.h>
#include <meniscus/exit.h>
#include <stdio.h>

static int complain(const MnsError *error)
{
    fprintf(stderr, "meniscus render: %s\n", error->text);
    switch (error->status) {
    case MNS_E_IO:
    case MNS_E_NO_SPACE: return MNS_EXIT_IO;
    case MNS_E_UNAVAILABLE: return MNS_EXIT_UNREACHABLE;
    case MNS_E_TIMEOUT: return MNS_EXIT_TIMEOUT;
    default: return MNS_EXIT_FAILED;
    }
}

static int complain_of_usage(const MnsError *error)
{
    fprintf(stderr, "meniscus render: %s\nTry `meniscus render --help`.\n", error->text);
    return MNS_EXIT_USAGE;
}

/* A number for JSON, which has no NaN. */
static json_t *number(double value)
{
    json_t *json = json_real(value);
    return json ? json : json_null();
}

static int report_json(const Frame *frame, const RenderOptions *o, const Drawn *drawn)
{
    json_t *report =
        json_pack("{ss si si ss sf sI sI s[oo]}", "path", o->out, "width", o->width, "height", o->height, "field",
                  o->field, "time", frame->time, "particles", (json_int_t)drawn->particles, "skipped",
                  (json_int_t)drawn->skipped, "range", number(drawn->range[0]), number(drawn->range[1]));
    const bool said = report && !json_dumpf(report, stdout, 0) && putchar('\n') != EOF && !fflush(stdout);
    json_decref(report);
    return said ? MNS_EXIT_DONE : MNS_EXIT_IO;
}

static int report(const Frame *frame, const RenderOptions *o, const Drawn *drawn)
{
    if (drawn->skipped)
        fprintf(stderr, "meniscus render: %zu particles have no finite position or value and were left out.\n",
                drawn->skipped);
    if (o->json) return report_json(frame, o, drawn);
    return printf("%s\n", o->out) < 0 || fflush(stdout) ? MNS_EXIT_IO : MNS_EXIT_DONE;
}

int command_render(int argc, char **argv)
{
    RenderOptions o;
    MnsError error = {0};
    Frame frame;
    Drawn drawn;
    if (render_options_parse(argc, argv, &o, &error)) return complain_of_usage(&error);
    if (o.help) return fputs(render_usage(), stdout) < 0 ? MNS_EXIT_IO : MNS_EXIT_DONE;
    const MnsStatus got = o.snapshot ? frame_read_file(o.snapshot, o.field, &frame, &error)
                                     : frame_read_daemon(o.daemon, o.field, o.view.walls, &frame, &error);
    if (got) return complain(&error);
    const MnsStatus drew = picture_write(&frame, &o, &drawn, &error);
    const int code = drew ? complain(&error) : report(&frame, &o, &drawn);
    frame_done(&frame);
    return code;
}
