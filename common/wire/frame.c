/* SPDX-License-Identifier: BSD-3-Clause */
/* Requests as they come off the wire. A few bytes can ask for much memory, so it is counted while they are unpacked. */
#include "common/wire/frame.h"
#include "common/wire/texts.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

typedef struct Budget {
    size_t left;
    int exceeded, starved; /* it would have taken more; there was no more to take */
} Budget;

static void *take(void *arg, size_t size)
{
    Budget *budget = arg;
    if (size > budget->left) budget->exceeded = 1;
    if (budget->exceeded) return NULL;
    budget->left -= size;
    void *memory = malloc(size);
    if (!memory) budget->starved = 1;
    return memory;
}

static void give_back(void *arg, void *memory)
{
    (void)arg;
    free(memory);
}

static MnsStatus check_version(bool given, uint32_t major, MnsError *error)
{
    if (given && major == FRAME_MAJOR) return MNS_OK;
    return mns_fail_at(error, MNS_E_VERSION, "major",
                       "this daemon speaks version %d of the protocol, the request says %u%s", FRAME_MAJOR, major,
                       given ? "" : " (nothing)");
}

static MnsStatus check_id(bool given, size_t size, MnsError *error)
{
    if (given && size == FRAME_ID) return MNS_OK;
    return mns_fail_at(error, MNS_E_INVALID, "id", "a request needs an id of %d bytes; this one has %zu", FRAME_ID,
                       given ? size : 0);
}

static MnsStatus fail_command(MnsError *error)
{
    return mns_fail_at(error, MNS_E_VERSION, "command", "the request has no command that this daemon knows");
}

/* Is it one we can answer? */
static MnsStatus check(const Meniscus__Request *request, MnsError *error)
{
    MnsStatus status = check_version(request->has_major, request->major, error);
    if (!status) status = check_id(request->has_id, request->id.len, error);
    if (!status && request->command_case == MENISCUS__REQUEST__COMMAND__NOT_SET) status = fail_command(error);
    return status ? status : texts_check(&request->base, error);
}

static MnsStatus check_stream(const Meniscus__StreamRequest *request, MnsError *error)
{
    const bool answered = request->command_case != MENISCUS__STREAM_REQUEST__COMMAND_CREDIT &&
                          request->command_case != MENISCUS__STREAM_REQUEST__COMMAND_CANCEL;
    MnsStatus status = check_version(request->has_major, request->major, error);
    if (!status && (answered || request->has_id)) status = check_id(request->has_id, request->id.len, error);
    if (!status && request->command_case == MENISCUS__STREAM_REQUEST__COMMAND__NOT_SET) status = fail_command(error);
    return status ? status : texts_check(&request->base, error);
}

/* --- bytes on the wire -------------------------------------------------------------------------------------------------- */

typedef struct Bytes {
    const uint8_t *at, *end;
} Bytes;

/* False if they end before it does. */
static bool read_varint(Bytes *bytes, uint64_t *ret)
{
    *ret = 0;
    for (unsigned shift = 0; shift < 64 && bytes->at < bytes->end; shift += 7) {
        const uint8_t byte = *bytes->at++;
        *ret |= (uint64_t)(byte & 0x7f) << shift;
        if (byte < 0x80) return true;
    }
    return false;
}

/* One field of a message: its number, and its bytes if it has a length. */
static bool read_field(Bytes *bytes, uint64_t *ret_number, ProtobufCBinaryData *ret)
{
    enum { VARINT = 0, EIGHT_BYTES = 1, LENGTH = 2, FOUR_BYTES = 5 };
    uint64_t key, size = 0;
    if (!read_varint(bytes, &key)) return false;
    const unsigned kind = key & 7;
    if (kind == VARINT || kind == LENGTH) {
        if (!read_varint(bytes, &size)) return false;
        if (kind == VARINT) size = 0;
    } else if (kind == EIGHT_BYTES || kind == FOUR_BYTES) size = kind == EIGHT_BYTES ? 8 : 4;
    else return false;
    if (size > (uint64_t)(bytes->end - bytes->at)) return false;
    *ret_number = key >> 3;
    *ret = (ProtobufCBinaryData){.len = kind == LENGTH ? size : 0, .data = (uint8_t *)bytes->at};
    bytes->at += size;
    return true;
}

/* Texts are unpacked up to the first zero byte in them, so that what was sent would not be what is taken. Deeper than the schema no message
 * is. */
static MnsStatus check_zeros(const ProtobufCMessageDescriptor *kind, Bytes bytes, MnsError *error)
{
    MnsStatus status = MNS_OK;
    ProtobufCBinaryData data;
    for (uint64_t number; !status && read_field(&bytes, &number, &data);) {
        const ProtobufCFieldDescriptor *field =
            number > UINT32_MAX ? NULL : protobuf_c_message_descriptor_get_field(kind, (unsigned)number);
        if (!field || !data.len) continue;
        if (field->type == PROTOBUF_C_TYPE_MESSAGE)
            status = check_zeros(field->descriptor, (Bytes){data.data, data.data + data.len}, error);
        else if (field->type == PROTOBUF_C_TYPE_STRING && memchr(data.data, 0, data.len))
            status = mns_fail_at(error, MNS_E_INVALID, field->name,
                                 "found a text with a zero byte (U+0000) in it: remove it");
    }
    return status;
}

/* A message of that kind, within limits. */
static MnsStatus unpack(const ProtobufCMessageDescriptor *kind, const void *data, size_t size, int most,
                        ProtobufCMessage **ret, MnsError *error)
{
    Budget budget = {.left = FRAME_MEMORY};
    ProtobufCAllocator allocator = {.alloc = take, .free = give_back, .allocator_data = &budget};
    *ret = NULL;
    if (size > (size_t)most)
        return mns_fail(error, MNS_E_LIMIT, "a request may have %d bytes, this one has %zu; send it in parts", most,
                        size);
    *ret = protobuf_c_message_unpack(kind, &allocator, size, data);
    if (*ret) return check_zeros(kind, (Bytes){data, (const uint8_t *)data + size}, error);
    if (budget.exceeded)
        return mns_fail(error, MNS_E_LIMIT, "the request takes more than %d bytes of memory", FRAME_MEMORY);
    if (budget.starved) return mns_fail(error, MNS_E_MEMORY, "no memory for the request; nothing was done");
    return mns_fail(error, MNS_E_INVALID, "these %zu bytes are no request of this protocol", size);
}

MnsStatus request_read(const void *data, size_t size, Meniscus__Request **ret, MnsError *error)
{
    ProtobufCMessage *message;
    const MnsStatus status = unpack(&meniscus__request__descriptor, data, size, FRAME_MAX, &message, error);
    *ret = (Meniscus__Request *)message;
    return status ? status : check(*ret, error);
}

MnsStatus stream_request_read(const void *data, size_t size, Meniscus__StreamRequest **ret, MnsError *error)
{
    ProtobufCMessage *message;
    const MnsStatus status = unpack(&meniscus__stream_request__descriptor, data, size, FRAME_STREAM, &message, error);
    *ret = (Meniscus__StreamRequest *)message;
    return status ? status : check_stream(*ret, error);
}

void stream_request_free(Meniscus__StreamRequest *request)
{
    if (request) meniscus__stream_request__free_unpacked(request, NULL);
}

/* --- the id ------------------------------------------------------------------------------------------------------------ */

ProtobufCBinaryData request_id(const void *data, size_t size)
{
    enum { ID_LONGEST = 64 };
    const uint32_t which = protobuf_c_message_descriptor_get_field_by_name(&meniscus__request__descriptor, "id")->id;
    Bytes bytes = {data, (const uint8_t *)data + size};
    ProtobufCBinaryData id = {0}, field;
    uint64_t number;
    for (int k = 0; k < FRAME_FIELDS && read_field(&bytes, &number, &field); k++)
        if (number == which && field.len <= ID_LONGEST) id = field;
    return id;
}

void request_free(Meniscus__Request *request)
{
    if (request) meniscus__request__free_unpacked(request, NULL);
}

size_t number_size(const char *type)
{
    static const char *const types[] = {"<f8", "<f4", "<u8", "<u4", "|u1"};
    for (size_t k = 0; k < sizeof types / sizeof *types; k++)
        if (!strcmp(type, types[k])) return (size_t)(types[k][2] - '0');
    return 0;
}

Meniscus__Code code_of(MnsStatus status)
{
    static const Meniscus__Code codes[] = {
        [MNS_OK] = MENISCUS__CODE__OK,
        [MNS_E_INVALID] = MENISCUS__CODE__INVALID_ARGUMENT,
        [MNS_E_NOT_FOUND] = MENISCUS__CODE__NOT_FOUND,
        [MNS_E_STATE] = MENISCUS__CODE__FAILED_PRECONDITION,
        [MNS_E_LIMIT] = MENISCUS__CODE__RESOURCE_EXHAUSTED,
        [MNS_E_MEMORY] = MENISCUS__CODE__RESOURCE_EXHAUSTED,
        [MNS_E_DIVERGED] = MENISCUS__CODE__ABORTED,
        [MNS_E_IO] = MENISCUS__CODE__INTERNAL,
        [MNS_E_NO_SPACE] = MENISCUS__CODE__RESOURCE_EXHAUSTED,
        [MNS_E_CORRUPT] = MENISCUS__CODE__DATA_LOSS,
        [MNS_E_VERSION] = MENISCUS__CODE__UNIMPLEMENTED,
        [MNS_E_UNAVAILABLE] = MENISCUS__CODE__UNAVAILABLE,
        [MNS_E_TIMEOUT] = MENISCUS__CODE__DEADLINE_EXCEEDED,
        [MNS_E_INTERRUPTED] = MENISCUS__CODE__ABORTED,
        [MNS_E_HELD] = MENISCUS__CODE__FAILED_PRECONDITION,
        [MNS_E_EXPIRED] = MENISCUS__CODE__ABORTED,
        [MNS_E_DENIED] = MENISCUS__CODE__PERMISSION_DENIED,
        [MNS_E_INTERNAL] = MENISCUS__CODE__INTERNAL,
    };
    const unsigned k = (unsigned)status;
    return k < sizeof codes / sizeof *codes ? codes[k] : MENISCUS__CODE__INTERNAL;
}
