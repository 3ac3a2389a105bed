/* SPDX-License-Identifier: BSD-3-Clause */
/* The C client of streams against a daemon that misbehaves: sizes that are wrong, pieces out of place, checksums, connections that end within an item. */
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

enum { ROWS = 1000, COMPONENTS = 3, VALUES = ROWS * COMPONENTS, STREAM = 77, PIECE = 5000 };

typedef enum Manner {
    GOOD,
    WRONG_CHECKSUM, /* of the array                                          */
    WRONG_SIZE,     /* of the item                                           */
    TOO_MANY_BYTES, /* in its last piece                                     */
    STRAY_PIECES,   /* of another stream and of another item, between others */
    HOLE,           /* a piece is left out                                   */
    STOPPED,        /* the connection ends within the item, and it is resumed */
    FORGOTTEN,      /* the same, and nobody remembers                        */
    NEVER_SENT,
    CANCELLED,
    REFUSED,
    NO_CODE
} Manner;

typedef struct Fixture {
    StreamStand stand;
    _Atomic Manner manner;
    atomic_bool files;
    atomic_uint subscribed, resumed, cancelled, unsubscribed;
    _Atomic uint64_t granted, sent, from_row, from_offset;
    uint64_t sequence, offset; /* of the item under way */
    double x[VALUES];
} Fixture;

/* One message of the item of this number, if it is covered. */
static bool send_piece(Fixture *f, FakeStreams *streams, const Packed *packed)
{
    Meniscus__StreamItem item = MENISCUS__STREAM_ITEM__INIT;
    Meniscus__PackedArray array = *packed->manifest, *arrays[] = {&array};
    Meniscus__FileBegin file = MENISCUS__FILE_BEGIN__INIT;
    Meniscus__Cursor next = MENISCUS__CURSOR__INIT;
    const size_t left = packed->size - f->offset, n = left < PIECE ? left : PIECE;
    if (f->granted < f->sent + n + 400) return false;
    item.stream = STREAM;
    item.sequence = f->sequence;
    item.offset = f->offset;
    item.size = packed->size;
    if (!f->offset && f->files) {
        file.name = (char *)"snapshot-00000001.hdf";
        item.file = &file;
    }
    if (!f->offset && !f->files) {
        item.n_arrays = 1;
        item.arrays = arrays;
        item.has_step = true;
        item.step = 10 * f->sequence;
    }
    if (f->manner == WRONG_CHECKSUM) array.xxh64++;
    if (f->manner == WRONG_SIZE) item.size++;
    if (left == n) {
        next.has_line = next.has_row = true;
        next.line = 5;
        next.row = 100 * f->sequence;
        item.next = &next;
        item.has_xxh64 = f->files;
        item.xxh64 = XXH64(packed->data, packed->size, 0) + (f->manner == WRONG_CHECKSUM);
    }
    const uint8_t *bytes = (const uint8_t *)packed->data + f->offset;
    uint8_t *more = calloc(1, n + 1);
    memcpy(more, bytes, n);
    if (f->manner == STRAY_PIECES && f->offset) {
        Meniscus__StreamItem stray = item;
        stray.stream = STREAM + 1;
        fake_streams_send(streams, &stray, more, n);
    }
    fake_streams_send(streams, &item, more, n + (f->manner == TOO_MANY_BYTES && left == n));
    free(more);
    f->sent += n + 400; /* not less than it is */
    f->offset += n;
    if (f->manner == HOLE && f->offset == PIECE) f->offset += PIECE;
    if (f->offset < packed->size) return true;
    f->sequence++;
    f->offset = 0;
    return true;
}

static void send_covered(Fixture *f, FakeStreams *streams)
{
    Packed *packed = NULL;
    const PackingArray array = {
        .name = "velocity", .unit = "m/s", .type = "<f8", .n_dims = 2, .shape = {ROWS, COMPONENTS}, .data = f->x};
    assert_int_equal(packing_pack(&array, &(PackingHow){0}, &packed, NULL), MNS_OK);
    const bool stops = (f->manner == STOPPED || f->manner == FORGOTTEN) && f->subscribed + f->resumed == 1;
    while (f->manner != NEVER_SENT && send_piece(f, streams, packed))
        if (stops && f->sequence == 2 && f->offset == 2 * PIECE) {
            fake_streams_disconnect(streams);
            f->granted = 0;
        }
    packing_free(packed);
}

static void reply_subscribe(Fixture *f, FakeStreams *streams, const Meniscus__StreamRequest *request)
{
    Meniscus__StreamReply reply = MENISCUS__STREAM_REPLY__INIT;
    Meniscus__StreamColumn column = MENISCUS__STREAM_COLUMN__INIT, *columns[] = {&column};
    const Meniscus__Cursor *from = request->subscribe->from;
    const bool wrong = f->manner >= WRONG_CHECKSUM && f->manner <= HOLE;
    if (++f->subscribed > 1 && wrong) f->manner = GOOD; /* from then on it behaves */
    /* A daemon that was started again has no case yet. */
    const bool empty = f->manner == FORGOTTEN && f->subscribed == 2;
    if (f->manner == REFUSED || empty) {
        reply.code = empty ? MENISCUS__CODE__FAILED_PRECONDITION : MENISCUS__CODE__NOT_FOUND;
        reply.path = (char *)"fields[0].name";
        reply.message = (char *)"there is no such field";
        f->granted = 0;
        fake_streams_reply(streams, request, &reply);
        return;
    }
    if (f->manner == NO_CODE) {
        f->granted = 0;
        fake_streams_reply_without_code(streams, request);
        return;
    }
    f->from_row = from ? from->row : 0;
    f->from_offset = from ? from->offset : 0;
    f->sequence = from && from->has_row && from->row ? from->row / 100 + 1 : 1;
    f->offset = 0;
    f->sent = 0;
    f->granted = request->subscribe->credit;
    column.name = (char *)"velocity";
    column.unit = (char *)"m/s";
    reply.has_stream = reply.has_chunk_bytes = true;
    reply.stream = STREAM;
    reply.chunk_bytes = PIECE;
    reply.n_columns = 1;
    reply.columns = columns;
    fake_streams_reply(streams, request, &reply);
}

static void reply_resume(Fixture *f, FakeStreams *streams, const Meniscus__StreamRequest *request)
{
    Meniscus__StreamReply reply = MENISCUS__STREAM_REPLY__INIT;
    f->resumed++;
    reply.code = f->manner == FORGOTTEN ? MENISCUS__CODE__NOT_FOUND : MENISCUS__CODE__OK;
    reply.has_sequence = reply.has_offset = true;
    reply.sequence = f->sequence = request->resume->sequence;
    reply.offset = f->offset = request->resume->offset;
    f->sent = 0;
    f->granted = f->manner == FORGOTTEN ? 0 : request->resume->credit;
    fake_streams_reply(streams, request, &reply);
}

static void cancel(Fixture *f, FakeStreams *streams)
{
    Meniscus__StreamItem item = MENISCUS__STREAM_ITEM__INIT;
    Meniscus__StreamEnd end = MENISCUS__STREAM_END__INIT;
    f->cancelled++;
    item.stream = STREAM;
    item.sequence = f->sequence;
    item.cancelled = &end;
    fake_streams_send(streams, &item, NULL, 0);
    f->sequence++;
    f->offset = 0;
    f->manner = GOOD;
}

static void handle(void *arg, FakeStreams *streams, const Meniscus__StreamRequest *request)
{
    Fixture *f = arg;
    switch (request->command_case) {
    case MENISCUS__STREAM_REQUEST__COMMAND_SUBSCRIBE: reply_subscribe(f, streams, request); break;
    case MENISCUS__STREAM_REQUEST__COMMAND_RESUME: reply_resume(f, streams, request); break;
    case MENISCUS__STREAM_REQUEST__COMMAND_CREDIT: f->granted += request->credit->bytes; break;
    case MENISCUS__STREAM_REQUEST__COMMAND_CANCEL: cancel(f, streams); break;
    default: f->unsubscribed++; return;
    }
    send_covered(f, streams);
}

static int set_up(void **state)
{
    Fixture *f = calloc(1, sizeof *f);
    for (size_t k = 0; k < VALUES; k++) f->x[k] = 0.25 * (double)k;
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
    f->files = kind == MNS_STREAM_SNAPSHOTS;
    return stream_stand_take(&f->stand, kind, "velocity", memory);
}

static void check_item(const Fixture *f, const MnsStreamItem *item, uint64_t sequence)
{
    assert_int_equal(item->sequence, sequence);
    assert_int_equal(item->step, 10 * sequence);
    assert_int_equal(item->n_arrays, 1);
    assert_string_equal(item->arrays[0].name, "velocity");
    assert_string_equal(item->arrays[0].unit, "m/s");
    assert_int_equal(item->arrays[0].shape[1], COMPONENTS);
    assert_memory_equal(item->arrays[0].data, f->x, sizeof f->x);
}

static void items_come_in_order_and_are_paid_for_when_they_are_done_with(void **state)
{
    Fixture *f = *state;
    MnsStream *stream = open_stream(f, MNS_STREAM_FIELDS, 0);
    const MnsStreamItem *item;
    size_t n;
    assert_string_equal(mns_stream_columns(stream, &n)[0].name, "velocity");
    assert_int_equal(n, 1);
    for (uint64_t k = 1; k <= 50; k++) {
        assert_int_equal(mns_stream_next(stream, 5, &item, NULL), MNS_OK);
        check_item(f, item, k);
        const uint64_t taken = k * sizeof f->x; /* what waits is no more than the window and one item */
        assert_true(f->granted < taken + 600000);
    }
    assert_int_equal(mns_stream_stats(stream).items, 50);
    assert_int_equal(f->subscribed, 1);
    mns_stream_close(stream);
    for (int k = 0; k < 60000 && !f->unsubscribed; k++) usleep(1000);
    assert_int_equal(f->unsubscribed, 1);
}

static void what_is_damaged_is_told_and_a_series_goes_on_without_a_gap(void **state)
{
    Fixture *f = *state;
    static const Manner manners[] = {WRONG_CHECKSUM, WRONG_SIZE, TOO_MANY_BYTES, HOLE};
    for (size_t k = 0; k < sizeof manners / sizeof *manners; k++) {
        f->manner = GOOD;
        f->subscribed = 0;
        MnsStream *stream = open_stream(f, MNS_STREAM_SERIES, 0);
        const MnsStreamItem *item;
        MnsError error = {0};
        uint64_t last = 0;
        unsigned damaged = 0;
        f->manner = manners[k];
        while (last < 200) {
            const MnsStatus status = mns_stream_next(stream, 5, &item, &error);
            if (status == MNS_E_CORRUPT) damaged++;
            else if (status) fail_msg("manner %d: %s", (int)manners[k], error.text);
            else check_item(f, item, ++last);
            assert_true(damaged < 3);
        }
        assert_int_equal(damaged, 1);
        assert_int_equal(f->subscribed, 2);
        mns_stream_close(stream);
    }
}

static void pieces_of_other_streams_are_passed_over(void **state)
{
    Fixture *f = *state;
    f->manner = STRAY_PIECES;
    MnsStream *stream = open_stream(f, MNS_STREAM_FIELDS, 0);
    const MnsStreamItem *item;
    for (uint64_t k = 1; k <= 5; k++) {
        assert_int_equal(mns_stream_next(stream, 5, &item, NULL), MNS_OK);
        check_item(f, item, k);
    }
    mns_stream_close(stream);
}

static void after_a_lost_connection_an_item_goes_on_where_its_bytes_ended(void **state)
{
    Fixture *f = *state;
    for (int forgotten = 0; forgotten < 2; forgotten++) {
        f->manner = forgotten ? FORGOTTEN : STOPPED;
        f->subscribed = f->resumed = 0;
        MnsStream *stream = open_stream(f, MNS_STREAM_SERIES, 0);
        const MnsStreamItem *item;
        MnsError error = {0};
        for (uint64_t k = 1; k <= 20; k++) {
            if (mns_stream_next(stream, 5, &item, &error)) fail_msg("item %u: %s", (unsigned)k, error.text);
            check_item(f, item, k);
            assert_int_equal(item->cursor->row, 100 * k);
        }
        assert_int_equal(f->resumed, 1);
        assert_int_equal(f->subscribed, 1 + 2 * forgotten);
        assert_int_equal(f->from_row, forgotten ? 100 : 0); /* behind the first item */
        assert_int_equal(mns_stream_stats(stream).reconnects, 1);
        mns_stream_close(stream);
    }
}

static void a_file_comes_byte_for_byte_over_several_connections(void **state)
{
    Fixture *f = *state;
    for (int forgotten = 0; forgotten < 3; forgotten++) {
        f->manner = forgotten == 2 ? WRONG_CHECKSUM : forgotten ? FORGOTTEN : GOOD;
        f->subscribed = f->resumed = 0;
        MnsStream *stream = open_stream(f, MNS_STREAM_SNAPSHOTS, 0);
        const MnsStreamItem *item = NULL;
        MnsStatus status = MNS_OK;
        for (size_t got = 0, k = 0; k < 3 && got < sizeof f->x && !status;) {
            status = mns_stream_next(stream, 5, &item, NULL);
            if (status) break;
            assert_string_equal(item->file, "snapshot-00000001.hdf");
            assert_int_equal(item->offset, got);
            assert_memory_equal(item->data, (const char *)f->x + got, item->size);
            got += item->size;
            assert_int_equal(item->whole, got == sizeof f->x);
            if (item->whole) k++, got = 0;
        }
        assert_int_equal(status, forgotten == 2 ? MNS_E_CORRUPT : MNS_OK);
        mns_stream_close(stream);
    }
}

static void an_item_larger_than_there_is_memory_for_is_cancelled(void **state)
{
    Fixture *f = *state;
    const MnsStreamItem *item;
    MnsError error = {0};
    MnsStream *stream = open_stream(f, MNS_STREAM_FIELDS, 1000);
    assert_int_equal(mns_stream_next(stream, 5, &item, &error), MNS_E_LIMIT);
    assert_non_null(strstr(error.text, "velocity"));
    mns_stream_close(stream);
    for (int k = 0; k < 60000 && !f->cancelled; k++) usleep(1000);
    assert_true(f->cancelled > 0);
}

static void nothing_within_the_time_limit_is_told_as_that(void **state)
{
    Fixture *f = *state;
    const MnsStreamItem *item;
    f->manner = NEVER_SENT;
    MnsStream *stream = open_stream(f, MNS_STREAM_FIELDS, 0);
    assert_int_equal(mns_stream_next(stream, 0.05, &item, NULL), MNS_E_TIMEOUT);
    assert_int_equal(mns_stream_cancel(stream, NULL), MNS_OK);
    assert_int_equal(mns_stream_next(stream, 5, &item, NULL), MNS_OK);
    check_item(f, item, 2);
    assert_int_equal(mns_stream_stats(stream).cancelled, 1);
    mns_stream_close(stream);
}

static void a_refusal_names_the_entry(void **state)
{
    Fixture *f = *state;
    static const char *const names[] = {"velocty"};
    MnsStream *stream = NULL;
    MnsError error = {0};
    f->manner = REFUSED;
    const MnsStreamOptions options = {.kind = MNS_STREAM_FIELDS, .n_names = 1, .names = names};
    assert_int_equal(mns_stream_open(f->stand.client, &options, &stream, &error), MNS_E_NOT_FOUND);
    assert_string_equal(error.path, "fields[0].name");
    assert_string_equal(error.text, "there is no such field");
    const MnsStreamOptions flat = {.kind = MNS_STREAM_FIELDS, .n_names = 1, .names = names, .in_box = true};
    assert_int_equal(mns_stream_open(f->stand.client, &flat, &stream, &error), MNS_E_INVALID);
    assert_string_equal(error.path, "dim");
    assert_null(stream);
}

static void a_reply_without_a_code_opens_no_stream(void **state)
{
    Fixture *f = *state;
    MnsStream *stream = NULL;
    const MnsStreamOptions options = {.kind = MNS_STREAM_FIELDS};
    f->manner = NO_CODE;
    assert_int_equal(mns_stream_open(f->stand.client, &options, &stream, NULL), MNS_E_VERSION);
    assert_null(stream);
}

int main(void)
{
#define STREAM_TEST(test) cmocka_unit_test_setup_teardown(test, set_up, tear_down)
    const struct CMUnitTest tests[] = {
        STREAM_TEST(items_come_in_order_and_are_paid_for_when_they_are_done_with),
        STREAM_TEST(what_is_damaged_is_told_and_a_series_goes_on_without_a_gap),
        STREAM_TEST(pieces_of_other_streams_are_passed_over),
        STREAM_TEST(after_a_lost_connection_an_item_goes_on_where_its_bytes_ended),
        STREAM_TEST(a_file_comes_byte_for_byte_over_several_connections),
        STREAM_TEST(an_item_larger_than_there_is_memory_for_is_cancelled),
        STREAM_TEST(nothing_within_the_time_limit_is_told_as_that),
        STREAM_TEST(a_refusal_names_the_entry),
        STREAM_TEST(a_reply_without_a_code_opens_no_stream),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
