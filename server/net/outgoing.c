/* SPDX-License-Identifier: BSD-3-Clause */
/* Replies on their way out. */
#include "net/outgoing.h"

#include "base/log.h"
#include "proto/frame.h"
#include <assert.h>
#include <stdlib.h>
#include <string.h>
#include <zmq.h>

/* --- the reply in reserve ---------------------------------------------------------------------------------------------- */

enum { ID_AT = 2, ID_END = ID_AT + ORDER_ID }; /* the first field, with its tag and length before it */

/* Made while there is memory for certain. Fields are packed by their numbers: the id, the code, then words. */
void outgoing_init(Outgoing *out, void *socket, uint64_t epoch)
{
    static uint8_t id[ORDER_ID];
    Meniscus__Reply reply = MENISCUS__REPLY__INIT;
    *out = (Outgoing){.socket = socket};
    reply.has_id = reply.has_code = true;
    reply.id = (ProtobufCBinaryData){.len = ORDER_ID, .data = id};
    reply.code = code_of(MNS_E_MEMORY);
    out->brief_size = meniscus__reply__get_packed_size(&reply);
    reply.message = (char *)"there is no memory for the answer; the status tells what has been done";
    reply.reason = (char *)mns_status_name(MNS_E_MEMORY);
    reply.has_daemon_epoch = true;
    reply.daemon_epoch = epoch;
    out->excuse_size = meniscus__reply__get_packed_size(&reply);
    assert(out->excuse_size <= sizeof out->excuse);
    meniscus__reply__pack(&reply, out->excuse);
}

/* ZeroMQ keeps up to 33 bytes in the message itself: id and code go out even where there is no memory for the words. */
static void excuse(Outgoing *out, const Recipient *to)
{
    zmq_msg_t message;
    const size_t from = to->id ? 0 : ID_END;
    size_t size = out->excuse_size - from;
    if (zmq_msg_init_size(&message, size) && zmq_msg_init_size(&message, size = out->brief_size - from)) return;
    uint8_t *data = zmq_msg_data(&message);
    memcpy(data, out->excuse + from, size);
    if (to->id) memcpy(data + ID_AT, to->id, ORDER_ID);
    if (zmq_send(out->socket, to->identity, to->identity_size, ZMQ_SNDMORE | ZMQ_DONTWAIT) < 0 ||
        zmq_msg_send(&message, out->socket, ZMQ_DONTWAIT) < 0)
        zmq_msg_close(&message);
}

/* --- parcels ----------------------------------------------------------------------------------------------------------- */

/* A raw frame on its way, to be counted until ZeroMQ lets go of it, on its own thread. The size is written last and read
 * first, so that what is handed over is in order for race detectors too, which do not see into ZeroMQ. */
typedef struct Parcel {
    _Atomic size_t *unread;
    _Atomic size_t size;
} Parcel;

static void let_go(void *data, void *hint)
{
    Parcel *parcel = hint;
    const size_t size = parcel->size;
    *parcel->unread -= size;
    free(parcel);
    free(data);
}

/* Takes over data, if there is memory for the parcel. */
static bool wrap(Outgoing *out, void *data, size_t size, zmq_msg_t *ret)
{
    Parcel *parcel = data ? malloc(sizeof *parcel) : NULL;
    if (!parcel || zmq_msg_init_data(ret, data, size, let_go, parcel)) {
        free(parcel);
        return false;
    }
    parcel->unread = &out->unread;
    parcel->size = size;
    out->unread += size;
    return true;
}

/* A message that is begun must be ended, or the next one would be taken for the rest of it: so all is wrapped before. */
void outgoing_send(Outgoing *out, const Recipient *to, size_t n, void *const parts[], const size_t sizes[])
{
    zmq_msg_t messages[OUTGOING_PARTS];
    size_t wrapped = 0;
    const bool room = out->unread < 2 * (size_t)OUTGOING_UNREAD;
    assert(n > 0 && n <= OUTGOING_PARTS);
    while (wrapped < n && wrap(out, parts[wrapped], sizes[wrapped], &messages[wrapped])) wrapped++;
    for (size_t k = wrapped; k < n; k++) free(parts[k]);
    const bool whole = wrapped == n;
    const bool begun =
        whole && room && zmq_send(out->socket, to->identity, to->identity_size, ZMQ_SNDMORE | ZMQ_DONTWAIT) >= 0;
    if (whole && !begun)
        log_line(LOG_DETAIL, "a reply is not sent: %s",
                 room ? zmq_strerror(zmq_errno()) : "clients leave too many unread");
    for (size_t k = 0; k < wrapped; k++)
        if (!begun || zmq_msg_send(&messages[k], out->socket, ZMQ_DONTWAIT | (k + 1 < n ? ZMQ_SNDMORE : 0)) < 0)
            zmq_msg_close(&messages[k]);
    if (!whole && room) excuse(out, to);
}
