/* SPDX-License-Identifier: BSD-3-Clause */
/* Which requests are heard when: commands at once, behind what their connection asked before; questions at their pace. */
#include "net/hearing.h"

#include "base/clock.h"
#include "common/wire/frame.h"
#include "net/handlers.h"
#include <inttypes.h>
#include <math.h>

/* Does it only ask? What the sender may not do, and what is not understood, is refused in the same time. */
static bool is_question(const Sender *sender, const Meniscus__Request *request)
{
    const Handler *handler = request ? handler_find(request->command_case) : NULL;
    return !handler || handler->where == HERE || handler->traits & LOOKS || sender->who.role < handler->role;
}

/* A request as its frame has it. */
typedef struct Heard {
    Meniscus__Request *request; /* NULL: it could not be read */
    MnsError why;
} Heard;

static void read_frame(zmq_msg_t *frame, uint64_t parts, Heard *ret)
{
    const void *data = zmq_msg_data(frame);
    ret->request = NULL;
    MnsStatus status =
        parts == 1 ? MNS_OK : mns_fail(&ret->why, MNS_E_INVALID, "a request is one frame; these are %" PRIu64, parts);
    if (!status) status = request_read(data, zmq_msg_size(frame), &ret->request, &ret->why);
    if (!status) return;
    request_free(ret->request);
    ret->request = NULL;
}

/* Takes over the request. */
static void hear(Hearing *hearing, const Sender *sender, zmq_msg_t *frame, Heard *heard)
{
    const ProtobufCBinaryData id = request_id(zmq_msg_data(frame), zmq_msg_size(frame));
    if (heard->request) answers_take(hearing->answers, sender, &sender->who, id, heard->request, NULL);
    else answers_refuse(hearing->answers, sender, id, &heard->why);
}

static void hear_held(Hearing *hearing, Held *held)
{
    Heard heard;
    if (!held) return;
    read_frame(&held->frame, held->parts, &heard);
    hear(hearing, &held->sender, &held->frame, &heard);
    held_free(held);
}

void hearing_go_on(Hearing *hearing)
{
    for (Held *held; (held = pace_next(&hearing->pace, !run_state_steps(hearing->answers->state), clock_now()));)
        hear_held(hearing, held);
}

/* What a connection asked before a command is heard before it. */
static void hear_all_of(Hearing *hearing, const Sender *sender)
{
    for (Held *held; (held = pace_pull(&hearing->pace, sender, NULL));) hear_held(hearing, held);
}

/* And what a command cancels is known. */
static void hear_cancelled(Hearing *hearing, const Meniscus__Request *request)
{
    if (request->command_case == MENISCUS__REQUEST__COMMAND_CANCEL && request->cancel->has_id)
        hear_held(hearing, pace_pull(&hearing->pace, NULL, &request->cancel->id));
}

/* Let a question wait, or refuse it. What is too long for a request is refused at once. */
static void hold(Hearing *hearing, const Sender *sender, zmq_msg_t *frame, uint64_t parts, Heard *heard)
{
    const bool ends = heard->request && heard->request->has_deadline_ms;
    const double deadline = ends ? sender->came + 1e-3 * (double)heard->request->deadline_ms : INFINITY;
    MnsStatus status = zmq_msg_size(frame) > FRAME_MAX ? heard->why.status : MNS_OK;
    if (!status) status = pace_hold(&hearing->pace, sender, frame, parts, deadline, &heard->why);
    if (status)
        answers_refuse(hearing->answers, sender, request_id(zmq_msg_data(frame), zmq_msg_size(frame)), &heard->why);
    request_free(heard->request);
}

void hearing_take(Hearing *hearing, const Sender *sender, zmq_msg_t *frame, uint64_t parts)
{
    Heard heard;
    read_frame(frame, parts, &heard);
    const bool asks = is_question(sender, heard.request);
    if (asks && run_state_steps(hearing->answers->state) && !pace_admits(&hearing->pace, sender, clock_now())) {
        hold(hearing, sender, frame, parts, &heard);
        return;
    }
    if (!asks) hear_cancelled(hearing, heard.request);
    hear_all_of(hearing, sender);
    hear(hearing, sender, frame, &heard);
}
