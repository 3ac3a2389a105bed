/* SPDX-License-Identifier: BSD-3-Clause */
/* meniscus render: draw the particles of a snapshot file or of a live daemon as a PNG picture. */
#include "client/cli/command.h"
#include "client/cli/output.h"
#include "client/cli/render_picture.h"
#include <stdio.h>

static MnsStatus report(const Invocation *in, const Frame *frame, const RenderOptions *o, const Drawn *drawn,
                        MnsError *error)
{
    if (drawn->skipped)
        fprintf(stderr, "meniscus: %zu particles have no finite position or value and were left out\n", drawn->skipped);
    if (in->json)
        return output_json(json_pack("{so si si so so sI sI s[oo]}", "path", output_text(o->out), "width", drawn->width,
                                     "height", drawn->height, "field", output_text(o->field), "time",
                                     output_number(frame->time), "particles", (json_int_t)drawn->particles, "skipped",
                                     (json_int_t)drawn->skipped, "range", output_number(drawn->range[0]),
                                     output_number(drawn->range[1])),
                           error);
    puts(o->out);
    return MNS_OK;
}

static MnsStatus get_frame(Invocation *in, const RenderOptions *o, Frame *frame, MnsError *error)
{
    if (o->snapshot) return frame_read_file(o->snapshot, o->field, frame, error);
    const MnsStatus status = command_connect(in, error);
    return status == MNS_OK ? frame_read_daemon(in->client, o->field, o->view.walls, frame, error) : status;
}

MnsStatus command_render(Invocation *in, MnsError *error)
{
    RenderOptions o;
    Frame frame;
    Drawn drawn;
    MnsStatus status = command_usage(in, render_options_read(&in->options, &o, error));
    if (status == MNS_OK) status = get_frame(in, &o, &frame, error);
    if (status != MNS_OK) return status;
    status = picture_write(&frame, &o, &drawn, error);
    if (status == MNS_OK) status = report(in, &frame, &o, &drawn, error);
    frame_done(&frame);
    return status;
}
