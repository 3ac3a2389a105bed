/* SPDX-License-Identifier: BSD-3-Clause */
/* Requests off the wire, read within limits; and every command of the protocol has somebody who does it. */
#include "common/wire/frame.h"
#include "net/handlers.h"
#include "tests/support/check.h"
#include <stdlib.h>
#include <string.h>

static void every_command_of_the_protocol_has_a_handler_and_a_name(void **state)
{
    (void)state;
    const ProtobufCMessageDescriptor *request = &meniscus__request__descriptor;
    const char *names[HANDLER_NAMES];
    size_t commands = 0, n = 0;
    handler_names(names);
    for (unsigned k = 0; k < request->n_fields; k++) {
        const ProtobufCFieldDescriptor *field = &request->fields[k];
        if (!(field->flags & PROTOBUF_C_FIELD_FLAG_ONEOF)) continue;
        const Handler *handler = handler_find((Meniscus__Request__CommandCase)field->id);
        assert_non_null(handler);
        assert_string_equal(handler->name, field->name);
        bool named = false;
        for (size_t j = 0; names[j]; j++) named = named || !strcmp(names[j], field->name);
        assert_true(named);
        commands++;
    }
    while (names[n]) n++;
    assert_int_equal(n, commands);
    assert_null(handler_find(MENISCUS__REQUEST__COMMAND__NOT_SET));
    assert_null(handler_find((Meniscus__Request__CommandCase)9999));
}

static void every_state_of_the_protocol_is_one_of_the_run(void **state)
{
    (void)state;
    assert_int_equal(meniscus__state__descriptor.n_values, RUN_STATES);
    for (int k = 0; k < RUN_STATES; k++)
        assert_string_equal(run_state_name((RunState)k),
                            protobuf_c_enum_descriptor_get_value(&meniscus__state__descriptor, k)->name);
}

/* A request of n empty assignments: two bytes each on the wire, many more in memory. */
static uint8_t *bloated(size_t n, size_t *ret_size)
{
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    Meniscus__Set set = MENISCUS__SET__INIT;
    Meniscus__Assignment empty = MENISCUS__ASSIGNMENT__INIT, **list = malloc(n * sizeof *list);
    for (size_t k = 0; k < n; k++) list[k] = &empty;
    set.n_assignments = n;
    set.assignments = list;
    request.command_case = MENISCUS__REQUEST__COMMAND_SET;
    request.set = &set;
    *ret_size = meniscus__request__get_packed_size(&request);
    uint8_t *packed = malloc(*ret_size);
    meniscus__request__pack(&request, packed);
    free(list);
    return packed;
}

static void a_small_frame_cannot_take_much_memory(void **state)
{
    (void)state;
    size_t size;
    uint8_t *packed = bloated(500000, &size);
    Meniscus__Request *request;
    assert_true(size < FRAME_MAX);
    assert_int_equal(request_read(packed, size, &request, NULL), MNS_E_LIMIT);
    assert_null(request);
    free(packed);
}

static void a_truncated_request_is_none(void **state)
{
    (void)state;
    size_t size;
    uint8_t *packed = bloated(3, &size);
    Meniscus__Request *request;
    assert_int_equal(request_read(packed, size - 1, &request, NULL), MNS_E_INVALID);
    assert_null(request);
    free(packed);
}

/* What reading a request says of it, and at which field. */
static MnsStatus status_of(Meniscus__Request *request, const char *path)
{
    MnsError error = {.path = ""};
    uint8_t id[FRAME_ID] = {1};
    Meniscus__Request *read;
    request->has_major = request->has_id = true;
    request->major = FRAME_MAJOR;
    request->id = (ProtobufCBinaryData){sizeof id, id};
    const size_t size = meniscus__request__get_packed_size(request);
    uint8_t *packed = malloc(size);
    meniscus__request__pack(request, packed);
    const MnsStatus status = request_read(packed, size, &read, &error);
    assert_string_equal(error.path, path);
    request_free(read);
    free(packed);
    return status;
}

/* Others are shown what one has named: on terminals, which obey it, and as JSON, which there would be none of. */
static void names_that_a_terminal_would_obey_are_refused(void **state)
{
    (void)state;
    static const char *const bad[] = {"\x1b[2Janna",  "anna\xff", "an\nna",           "anna\x7f", "\xc2\x9b",
                                      "\xed\xa0\x80", "\xc0\xaf", "\xf4\x90\x80\x80", "\xe2\x82", "\x80"};
    Meniscus__Lease lease = MENISCUS__LEASE__INIT;
    Meniscus__SetBreakpoint point = MENISCUS__SET_BREAKPOINT__INIT;
    Meniscus__Request leasing = MENISCUS__REQUEST__INIT, pointing = MENISCUS__REQUEST__INIT;
    leasing.command_case = MENISCUS__REQUEST__COMMAND_LEASE;
    leasing.lease = &lease;
    pointing.command_case = MENISCUS__REQUEST__COMMAND_BREAKPOINT;
    pointing.breakpoint = &point;
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        lease.holder = point.name = (char *)bad[k];
        assert_int_equal(status_of(&leasing, "holder"), MNS_E_INVALID);
        assert_int_equal(status_of(&pointing, "name"), MNS_E_INVALID);
    }
    lease.holder = (char *)"Änne@κόσμος 𝄞";
    assert_int_equal(status_of(&leasing, ""), MNS_OK);
}

/* Values of a case may have several lines, as in its file; paths to them may not. */
static void texts_in_lists_are_named_and_values_may_have_lines(void **state)
{
    (void)state;
    Meniscus__Set set = MENISCUS__SET__INIT;
    Meniscus__Assignment good = MENISCUS__ASSIGNMENT__INIT, bad = good, *items[] = {&good, &bad};
    Meniscus__Request request = MENISCUS__REQUEST__INIT;
    request.command_case = MENISCUS__REQUEST__COMMAND_SET;
    request.set = &set;
    set.n_assignments = 2;
    set.assignments = items;
    good.path = bad.path = (char *)"title";
    good.value = bad.value = (char *)"two\n\tlines";
    assert_int_equal(status_of(&request, ""), MNS_OK);
    bad.value = (char *)"\x07";
    assert_int_equal(status_of(&request, "assignments[1].value"), MNS_E_INVALID);
    bad.path = (char *)"title\n";
    assert_int_equal(status_of(&request, "assignments[1].path"), MNS_E_INVALID);
}

static void assert_id(const void *data, size_t size, const char *id)
{
    const ProtobufCBinaryData found = request_id(data, size);
    assert_int_equal(found.len, strlen(id));
    assert_memory_equal(found.data, id, found.len);
}

/* A refusal without it would reach nobody: clients know replies by their id. */
static void the_id_is_known_of_a_request_that_cannot_be_read(void **state)
{
    (void)state;
    size_t size;
    uint8_t *packed = bloated(500000, &size), *whole = malloc(size + 20);
    memcpy(whole, "\x22\x10sixteen letters!", 18);
    memcpy(whole + 18, packed, size);
    assert_id(whole, size + 18, "sixteen letters!");
    memcpy(whole, packed, size);
    memcpy(whole + size, "\x22\x10sixteen letters!", 18);
    assert_id(whole, size + 18, "sixteen letters!");
    assert_id(whole, size + 17, "");
    assert_id("\x08\x01\x22\x03new\x23", 8, "new");
    free(whole);
    free(packed);
}

static void bytes_that_end_too_soon_have_no_id(void **state)
{
    (void)state;
    static const char bytes[] = "\x0d\1\2\3\4\x09\1\2\3\4\5\6\7\x08\x08\xff\1\x22\x10sixteen letters!";
    for (size_t n = 0; n < sizeof bytes - 1; n++) assert_id(bytes, n, "");
    assert_id(bytes, sizeof bytes - 1, "sixteen letters!");
    assert_id("\x22\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff\1", 12, "");
}

static void numbers_have_the_size_that_numpy_gives_them(void **state)
{
    (void)state;
    assert_int_equal(number_size("<f8"), 8);
    assert_int_equal(number_size("<u4"), 4);
    assert_int_equal(number_size("|u1"), 1);
    assert_int_equal(number_size(">f8"), 0);
    assert_int_equal(number_size(""), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_command_of_the_protocol_has_a_handler_and_a_name),
        cmocka_unit_test(every_state_of_the_protocol_is_one_of_the_run),
        cmocka_unit_test(a_small_frame_cannot_take_much_memory),
        cmocka_unit_test(a_truncated_request_is_none),
        cmocka_unit_test(names_that_a_terminal_would_obey_are_refused),
        cmocka_unit_test(texts_in_lists_are_named_and_values_may_have_lines),
        cmocka_unit_test(the_id_is_known_of_a_request_that_cannot_be_read),
        cmocka_unit_test(bytes_that_end_too_soon_have_no_id),
        cmocka_unit_test(numbers_have_the_size_that_numpy_gives_them),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
