/* SPDX-License-Identifier: BSD-3-Clause */
/* The C client of streams against a daemon that answers late, gives up what it began, and sends what is of no use: no stream is left behind that
 * nobody reads, nothing is left out in silence, and nobody starves. */
#include "common/wire/packing.h"
#include "tests/support/check.h"
#include "tests/support/fake_streams.h"
#include <meniscus/stream.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <xxhash.h>

enum { FIRST_STREAM = 70, CHUNK = 262144, LATE_US = 150000, BYTES = 3000, HALF = 1000 };

static const char before[] = "snapshot-0000000001.hdf", within[] = "snapshot-0000000002.hdf";

typedef struct Fixture {
    StreamStand stand;
    /* What the daemon of a test does; begun is the number of subscriptions so far, the last one included. */
    void (*serve)(struct Fixture *f, const Meniscus__StreamRequest *request);
    atomic_uint begun, ended;       /* of subscriptions */
    atomic_bool held;               /* the answer to a subscription, until the client has waited in vain */
    _Atomic uint64_t last_ended;    /* number of the stream */
    _Atomic uint64_t granted, sent; /* bytes */
    char from_file[MNS_STREAM_FILE_SIZE];
    _Atomic uint64_t from_offset;
    uint8_t bytes[BYTES];
} Fixture;

/* --- what daemons do ---------------------------------------------------------------------------------------------------- */

static void agree(Fixture *f, const Meniscus__StreamRequest *request, uint64_t number)
{
    Meniscus__StreamReply reply = MENISCUS__STREAM_REPLY__INIT;
    reply.has_stream = reply.has_chunk_bytes = true;
    reply.stream = number;
    reply.chunk_bytes = CHUNK;
    fake_streams_reply(f->stand.streams, request, &reply);
}

static void refuse(Fixture *f, const Meniscus__StreamRequest *request)
{
    Meniscus__StreamReply reply = MENISCUS__STREAM_REPLY__INIT;
    reply.code = MENISCUS__CODE__NOT_FOUND;
    fake_streams_reply(f->stand.streams, request, &reply);
}

static Meniscus__StreamItem of_last_stream(const Fixture *f, uint64_t sequence, uint64_t offset, uint64_t size)
{
    Meniscus__StreamItem item = MENISCUS__STREAM_ITEM__INIT;
    item.stream = FIRST_STREAM + f->begun;
    item.sequence = sequence;
    item.offset = offset;
    item.size = size;
    return item;
}

/* An item of one array in one message. */
static void send_array(Fixture *f, uint64_t sequence, const PackingArray *array, const PackingHow *how)
{
    Packed *packed = NULL;
    assert_int_equal(packing_pack(array, how, &packed, NULL), MNS_OK);
    Meniscus__PackedArray manifest = *packed->manifest, *arrays[] = {&manifest};
    Meniscus__StreamItem item = of_last_stream(f, sequence, 0, packed->size);
    item.n_arrays = 1;
    item.arrays = arrays;
    fake_streams_send(f->stand.streams, &item, packed->size ? packed->data : NULL, packed->size);
    packing_free(packed);
}

static void send_bytes(Fixture *f, uint64_t sequence)
{
    const PackingArray array = {
        .name = "phase", .unit = "", .type = "|u1", .n_dims = 1, .shape = {BYTES}, .data = f->bytes};
    send_array(f, sequence, &array, &(PackingHow){0});
}

static void send_cancelled(Fixture *f, uint64_t sequence, const char *reason, Meniscus__Cursor *next)
{
    Meniscus__StreamItem item = of_last_stream(f, sequence, 0, 0);
    Meniscus__StreamEnd end = MENISCUS__STREAM_END__INIT;
    end.has_code = true;
    end.code = MENISCUS__CODE__RESOURCE_EXHAUSTED;
    end.reason = (char *)reason;
    end.message = (char *)"given up, as others needed the memory";
    item.cancelled = &end;
    item.next = next;
    fake_streams_send(f->stand.streams, &item, NULL, 0);
}

/* Bytes `from` to `to` of a file of BYTES, as they are in the fixture. */
static void send_file(Fixture *f, uint64_t sequence, const char *name, size_t from, size_t to)
{
    Meniscus__StreamItem item = of_last_stream(f, sequence, from, BYTES);
    Meniscus__FileBegin file = MENISCUS__FILE_BEGIN__INIT;
    Meniscus__Cursor next = MENISCUS__CURSOR__INIT;
    file.name = (char *)name;
    item.file = from ? NULL : &file;
    if (to == BYTES) {
        next.has_line = next.has_offset = true;
        next.line = 5;
        next.file = (char *)name;
        next.offset = UINT64_MAX;
        item.next = &next;
        item.has_xxh64 = true;
        item.xxh64 = XXH64(f->bytes, BYTES, 0);
    }
    fake_streams_send(f->stand.streams, &item, f->bytes + from, to - from);
}

static void handle(void *arg, FakeStreams *streams, const Meniscus__StreamRequest *request)
{
    Fixture *f = arg;
    (void)streams;
    if (request->command_case == MENISCUS__STREAM_REQUEST__COMMAND_UNSUBSCRIBE) {
        f->ended++;
        f->last_ended = request->unsubscribe->stream;
        return;
    }
    if (request->command_case == MENISCUS__STREAM_REQUEST__COMMAND_CREDIT) f->granted += request->credit->bytes;
    if (request->command_case == MENISCUS__STREAM_REQUEST__COMMAND_SUBSCRIBE) {
        const Meniscus__Cursor *from = request->subscribe->from;
        f->begun++;
        f->granted = request->subscribe->credit;
        f->sent = 0;
        strncpy(f->from_file, from && from->file ? from->file : "", sizeof f->from_file - 1);
        f->from_offset = from ? from->offset : 0;
    }
    f->serve(f, request);
}

static bool subscribes(const Meniscus__StreamRequest *request)
{
    return request->command_case == MENISCUS__STREAM_REQUEST__COMMAND_SUBSCRIBE;
}

/* --- what tests do ------------------------------------------------------------------------------------------------------ */

static int set_up(void **state)
{
    Fixture *f = calloc(1, sizeof *f);
    for (size_t k = 0; k < BYTES; k++) f->bytes[k] = (uint8_t)(7 * k + k / 251);
    *state = f;
    return stream_stand_begin(&f->stand, handle, f);
}

static int tear_down(void **state)
{
    Fixture *f = *state;
    stream_stand_end(&f->stand);
    free(f);
    return 0;
}

static MnsStream *open_stream(Fixture *f, MnsStreamKind kind, size_t memory)
{
    return stream_stand_take(&f->stand, kind, "phase", memory);
}

/* Until the daemon was told of the end of so many. */
static void check_ended(const Fixture *f, unsigned n)
{
    for (int k = 0; k < 60000 && f->ended < n; k++) usleep(1000);
    assert_int_equal(f->ended, n);
}

/* --- late answers ------------------------------------------------------------------------------------------------------- */

static void serve_late(Fixture *f, const Meniscus__StreamRequest *request)
{
    if (!subscribes(request)) return;
    for (int k = 0; k < 60000 && f->held; k++) usleep(1000);
    agree(f, request, FIRST_STREAM + f->begun);
    if (f->begun > 1) {
        send_bytes(f, 1);
        return;
    }
    f->held = true;
    fake_streams_garbage(f->stand.streams); /* then another is subscribed to */
}

static void a_stream_whose_answer_is_late_is_the_one_that_is_read(void **state)
{
    Fixture *f = *state;
    const MnsStreamItem *item;
    f->serve = serve_late;
    MnsStream *stream = open_stream(f, MNS_STREAM_FIELDS, 0);
    assert_int_equal(mns_stream_next(stream, 5, &item, NULL), MNS_E_CORRUPT);
    for (int k = 0; k < 3; k++) assert_int_equal(mns_stream_next(stream, 0.01, &item, NULL), MNS_E_TIMEOUT);
    f->held = false;
    MnsStatus status = MNS_E_TIMEOUT;
    for (int tries = 0; status == MNS_E_TIMEOUT && tries < 6000; tries++)
        status = mns_stream_next(stream, 0.01, &item, NULL);
    assert_int_equal(status, MNS_OK);
    assert_memory_equal(item->arrays[0].data, f->bytes, BYTES);
    assert_int_equal(f->begun, 2);
    check_ended(f, 1); /* of which nothing could be read */
    assert_int_equal(f->last_ended, FIRST_STREAM + 1);
    mns_stream_close(stream);
    check_ended(f, 2);
    assert_int_equal(f->last_ended, FIRST_STREAM + 2);
}

static void serve_soon(Fixture *f, const Meniscus__StreamRequest *request)
{
    if (!subscribes(request)) return;
    usleep(LATE_US);
    agree(f, request, FIRST_STREAM + f->begun);
}

/* The client looks for the answer for a fifth of a second more. Where the machine lets it come before it is given up, or later than that, it is
 * tried again. */
static void a_stream_that_was_given_up_before_it_was_answered_is_ended(void **state)
{
    Fixture *f = *state;
    static const char *const names[] = {"phase"};
    const MnsStreamOptions options = {.kind = MNS_STREAM_FIELDS, .n_names = 1, .names = names};
    MnsStream *stream = NULL;
    f->serve = serve_soon;
    mns_client_set_timeout(f->stand.client, 0.02);
    bool ended = false;
    for (int k = 0; k < 50 && !ended; k++) {
        const unsigned before_it = f->ended;
        const MnsStatus status = mns_stream_open(f->stand.client, &options, &stream, NULL);
        if (!status) {
            mns_stream_close(stream);
            check_ended(f, before_it + 1);
            continue;
        }
        assert_int_equal(status, MNS_E_TIMEOUT);
        for (int ms = 0; ms < 1000 && f->ended == before_it; ms++) usleep(1000);
        ended = f->ended > before_it;
    }
    assert_true(ended);
    assert_int_equal(f->last_ended, FIRST_STREAM + f->begun);
}

/* --- credit ------------------------------------------------------------------------------------------------------------- */

static const uint64_t GIB = UINT64_C(1) << 30;
enum { ABOVE = 1 << 20 };

/* An item of more than may be granted, of which two pieces come. */
static void serve_large(Fixture *f, const Meniscus__StreamRequest *request)
{
    Meniscus__PackedArray array = MENISCUS__PACKED_ARRAY__INIT, *arrays[] = {&array};
    uint64_t shape = GIB + ABOVE, offset = f->sent ? CHUNK : 0;
    if (subscribes(request)) agree(f, request, FIRST_STREAM + f->begun);
    else if (f->sent) return;
    Meniscus__StreamItem item = of_last_stream(f, 1, offset, shape);
    array.name = (char *)"phase";
    array.type = (char *)"|u1";
    array.n_shape = 1;
    array.shape = &shape;
    array.has_raw_bytes = array.has_packed_bytes = array.has_xxh64 = true;
    array.raw_bytes = array.packed_bytes = shape;
    item.n_arrays = 1;
    item.arrays = arrays;
    uint8_t *piece = calloc(1, CHUNK);
    if (!subscribes(request)) f->sent += CHUNK; /* less than it is */
    else fake_streams_send(f->stand.streams, &item, piece, CHUNK);
    free(piece);
}

static void no_more_is_granted_than_a_daemon_counts(void **state)
{
    Fixture *f = *state;
    const MnsStreamItem *item;
    f->serve = serve_large;
    MnsStream *stream = open_stream(f, MNS_STREAM_FIELDS, 2 * GIB);
    for (int k = 0; k < 100 && f->granted <= GIB; k++) /* until what came was paid for */
        assert_int_equal(mns_stream_next(stream, 0.1, &item, NULL), MNS_E_TIMEOUT);
    assert_int_equal(mns_stream_next(stream, 0.3, &item, NULL), MNS_E_TIMEOUT);
    assert_true(f->granted > GIB);
    assert_true(f->granted < GIB + CHUNK + 1000);
    mns_stream_close(stream);
}

/* --- messages of no use ------------------------------------------------------------------------------------------------- */

/* What came already, again and again as far as it was paid for, and then something new. */
static void serve_repeats(Fixture *f, const Meniscus__StreamRequest *request)
{
    enum { REPEATS = 500 };
    if (subscribes(request)) {
        agree(f, request, FIRST_STREAM + f->begun);
        send_bytes(f, 1);
    }
    for (; f->sent + BYTES + 400 <= f->granted && f->sent < (uint64_t)REPEATS * BYTES; f->sent += BYTES)
        send_bytes(f, 1);
    if (f->sent >= (uint64_t)REPEATS * BYTES) send_bytes(f, 2);
}

static void messages_that_make_no_item_are_paid_for_too(void **state)
{
    Fixture *f = *state;
    const MnsStreamItem *item;
    f->serve = serve_repeats;
    for (int lossless = 0; lossless < 2; lossless++) {
        MnsStream *stream = open_stream(f, lossless ? MNS_STREAM_SERIES : MNS_STREAM_FIELDS, 0);
        assert_int_equal(mns_stream_next(stream, 5, &item, NULL), MNS_OK);
        assert_int_equal(item->sequence, 1);
        assert_int_equal(mns_stream_next(stream, 5, &item, NULL), MNS_OK);
        assert_int_equal(item->sequence, 2);
        mns_stream_close(stream);
    }
}

/* --- files -------------------------------------------------------------------------------------------------------------- */

static void serve_given_up(Fixture *f, const Meniscus__StreamRequest *request)
{
    Meniscus__Cursor next = MENISCUS__CURSOR__INIT;
    if (!subscribes(request)) return;
    agree(f, request, FIRST_STREAM + f->begun);
    send_file(f, 1, before, 0, HALF);
    next.has_line = next.has_offset = true;
    next.file = (char *)before;
    next.offset = UINT64_MAX;
    send_cancelled(f, 1, "too slow", &next);
    send_file(f, 2, within, 0, BYTES);
}

static void a_file_that_the_daemon_gave_up_is_told(void **state)
{
    Fixture *f = *state;
    const MnsStreamItem *item;
    MnsError error = {0};
    f->serve = serve_given_up;
    MnsStream *stream = open_stream(f, MNS_STREAM_SNAPSHOTS, 0);
    assert_int_equal(mns_stream_next(stream, 5, &item, NULL), MNS_OK);
    assert_int_equal(item->size, HALF);
    assert_int_equal(mns_stream_next(stream, 5, &item, &error), MNS_E_LIMIT);
    assert_non_null(strstr(error.text, "given up"));
    assert_int_equal(mns_stream_next(stream, 5, &item, NULL), MNS_OK);
    assert_string_equal(item->file, within);
    assert_true(item->whole);
    assert_int_equal(mns_stream_stats(stream).cancelled, 1);
    mns_stream_close(stream);
}

/* The connection ends within the second file, and the daemon has forgotten the stream. */
static void serve_interrupted(Fixture *f, const Meniscus__StreamRequest *request)
{
    if (request->command_case == MENISCUS__STREAM_REQUEST__COMMAND_RESUME) refuse(f, request);
    if (!subscribes(request)) return;
    agree(f, request, FIRST_STREAM + f->begun);
    if (f->begun == 1) {
        send_file(f, 1, before, 0, BYTES);
        send_file(f, 2, within, 0, HALF);
        fake_streams_disconnect(f->stand.streams);
    } else {
        send_file(f, 1, within, 0, 2 * HALF);
        send_file(f, 1, within, 2 * HALF, BYTES);
    }
}

static void within_a_file_a_stream_goes_on_only_with_the_cursor_of_that_file(void **state)
{
    Fixture *f = *state;
    const MnsStreamItem *item;
    size_t got = 0;
    f->serve = serve_interrupted;
    MnsStream *stream = open_stream(f, MNS_STREAM_SNAPSHOTS, 0);
    assert_int_equal(mns_stream_next(stream, 5, &item, NULL), MNS_OK);
    assert_true(item->whole);
    assert_string_equal(item->cursor->file, before);
    do {
        assert_int_equal(mns_stream_next(stream, 5, &item, NULL), MNS_OK);
        assert_string_equal(item->file, within);
        assert_int_equal(item->offset, got);
        assert_memory_equal(item->data, f->bytes + got, item->size);
        got += item->size;
    } while (!item->whole);
    assert_int_equal(got, BYTES);
    assert_int_equal(f->begun, 2);
    assert_string_equal(f->from_file, before); /* behind the last whole one, whose time line is known */
    assert_int_equal(f->from_offset, UINT64_MAX);
    mns_stream_close(stream);
}

/* --- nothing ------------------------------------------------------------------------------------------------------------ */

static const PackingHow ways[] = {
    {0},
    {.exactness = PACKING_F32},
    {.exactness = PACKING_BOUNDED, .bound = 0.5},
    {.codec = MENISCUS__CODEC__CODEC_LZ4},
    {.exactness = PACKING_BOUNDED, .bound = 0.5, .codec = MENISCUS__CODEC__CODEC_ZSTD},
};
enum { WAYS = sizeof ways / sizeof *ways };

static void serve_empty(Fixture *f, const Meniscus__StreamRequest *request)
{
    const PackingArray array = {
        .name = "velocity", .unit = "m/s", .type = "<f8", .n_dims = 2, .shape = {0, 3}, .data = f->bytes};
    if (!subscribes(request)) return;
    agree(f, request, FIRST_STREAM + f->begun);
    for (uint64_t k = 0; k < WAYS; k++) send_array(f, k + 1, &array, &ways[k]);
}

static void arrays_of_nothing_have_their_shape_and_type(void **state)
{
    Fixture *f = *state;
    const MnsStreamItem *item;
    MnsError error = {0};
    f->serve = serve_empty;
    MnsStream *stream = open_stream(f, MNS_STREAM_FIELDS, 0);
    for (size_t k = 0; k < WAYS; k++) {
        if (mns_stream_next(stream, 5, &item, &error)) fail_msg("way %zu: %s", k, error.text);
        const MnsArray *array = &item->arrays[0];
        assert_int_equal(item->n_arrays, 1);
        assert_int_equal(array->n_dims, 2);
        assert_int_equal(array->shape[0], 0);
        assert_int_equal(array->shape[1], 3);
        assert_int_equal(array->size, 0);
        assert_non_null(array->data);
        assert_string_equal(array->type, ways[k].exactness == PACKING_F32 ? "<f4" : "<f8");
    }
    mns_stream_close(stream);
}

int main(void)
{
#define TROUBLE(test) cmocka_unit_test_setup_teardown(test, set_up, tear_down)
    const struct CMUnitTest tests[] = {
        TROUBLE(a_stream_whose_answer_is_late_is_the_one_that_is_read),
        TROUBLE(a_stream_that_was_given_up_before_it_was_answered_is_ended),
        TROUBLE(no_more_is_granted_than_a_daemon_counts),
        TROUBLE(messages_that_make_no_item_are_paid_for_too),
        TROUBLE(a_file_that_the_daemon_gave_up_is_told),
        TROUBLE(within_a_file_a_stream_goes_on_only_with_the_cursor_of_that_file),
        TROUBLE(arrays_of_nothing_have_their_shape_and_type),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
