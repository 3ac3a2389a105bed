/* SPDX-License-Identifier: BSD-3-Clause */
/* A frame from a socket: it is no request, and a sentence says why; or it is one, and what it asks for is a case or a complaint. */
#include "cases/translate.h"
#include "common/case/file.h"
#include "common/wire/frame.h"
#include "tests/fuzz/fuzz.h"
#include <meniscus/case.h>
#include <string.h>

static void look_at_case(const Meniscus__Case *message)
{
    MnsCase *c = NULL;
    MnsError error = {0};
    MnsStatus status = case_message_check(message, &error);
    if (!status) status = case_translate(message, &c, &error);
    PROMISE(!status == (c != NULL));
    if (status) PROMISE(*error.text);
    mns_case_free(c);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    MnsError error = {0};
    Meniscus__Request *request = NULL;
    const ProtobufCBinaryData id = request_id(data, size);
    PROMISE(id.len <= 64 && (!id.len || (id.data >= data && id.data + id.len <= data + size)));
    const MnsStatus status = request_read(data, size, &request, &error);
    if (status) PROMISE(error.status == status && *error.text);
    else {
        PROMISE(request->id.len == FRAME_ID && request->major == FRAME_MAJOR);
        PROMISE(id.len == FRAME_ID && !memcmp(id.data, request->id.data, FRAME_ID));
        if (request->command_case == MENISCUS__REQUEST__COMMAND_LOAD && request->load->case_)
            look_at_case(request->load->case_);
    }
    request_free(request);
    return 0;
}
