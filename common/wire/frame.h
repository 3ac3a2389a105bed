/* SPDX-License-Identifier: BSD-3-Clause */
/* Requests as they come off the wire: read within limits, whatever the bytes are. And what else both ends must know alike. */
#ifndef COMMON_WIRE_FRAME_H
#define COMMON_WIRE_FRAME_H

#include "meniscus.pb-c.h"
#include "stream.pb-c.h"
#include <meniscus/status.h>
#include <stddef.h>

enum {
    FRAME_MAJOR = MENISCUS__PROTOCOL_VERSION__PROTOCOL_MAJOR,
    FRAME_MAX = 1 << 20,     /* bytes of a request                                           */
    FRAME_STREAM = 64 << 10, /* bytes of a request for streams                               */
    FRAME_MEMORY = 16 << 20, /* bytes that one may take once it is read                      */
    FRAME_ID = 16            /* bytes of a request id                                        */
};

/* Bytes of a request that is refused by a reply; one that is longer ends its connection, as ZeroMQ keeps each in memory until it is whole. From afar, where any
 * key may send, less is taken. */
enum { FRAME_TAKEN = 64 << 20, FRAME_TAKEN_FAR = 3 << 20, FRAME_STREAM_FAR = 1 << 20 };

/* Fields of a frame that are looked at for its id: a request has no more. */
enum { FRAME_FIELDS = FRAME_MAX / 2 };

/* Read a request: version, id and command are there. MNS_OK; MNS_E_INVALID if it is no request, MNS_E_LIMIT if it takes too
 * much memory, MNS_E_MEMORY if there is none, MNS_E_VERSION for another major version or a command that is not known here.
 * Free *ret in any case with request_free(). */
MnsStatus request_read(const void *data, size_t size, Meniscus__Request **ret, MnsError *error);

/* The same of what comes over the data socket; credit and cancel need no id. */
MnsStatus stream_request_read(const void *data, size_t size, Meniscus__StreamRequest **ret, MnsError *error);
void stream_request_free(Meniscus__StreamRequest *request);

/* The id of a request of either kind, without reading the rest of it; borrowed from the data. Of no length if there is none, or one of more than 64
 * bytes. */
ProtobufCBinaryData request_id(const void *data, size_t size);

/* NULL is fine. */
void request_free(Meniscus__Request *request);

/* Bytes of one number of a raw frame by its type, as numpy writes it: 8 of "<f8"; 0 for a type there is not. */
size_t number_size(const char *type);

/* What a failure is called in a reply. */
Meniscus__Code code_of(MnsStatus status);

#endif
