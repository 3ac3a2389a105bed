/* SPDX-License-Identifier: BSD-3-Clause */
/* What a LOSSLESS stream has next: rows of the series, or a snapshot file, from its cursor on. */
#include "net/streams_inside.h"

#include "base/clock.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double LOOK_EVERY = 0.2; /* [s] for another file */

/* What was taken belongs to a past that was undone. */
static bool leave_line(Stream *stream, const StreamCursor *now)
{
    Meniscus__Abandoned *left = malloc(sizeof *left);
    if (!left) return false;
    meniscus__abandoned__init(left);
    left->has_line = true;
    left->line = stream->cursor.line;
    left->has_row = stream->spec.kind == STREAM_SERIES;
    left->row = now->row;
    free(stream->abandoned); /* of an item that was cancelled before it was told */
    stream->abandoned = left;
    stream->looked = 0;
    stream->cursor = *now;
    stream->skipped = 0;
    stream_close_item(stream);
    subscription_take(&stream->books, 0, 0);
    return true;
}

/* The next rows, as many as are on the disk and paid for. */
static bool begin_rows(Streams *streams, Stream *stream)
{
    enum { HEAD = 1024 }; /* more than is said of three arrays */
    const StreamSpec *spec = &stream->spec;
    const size_t width = (2 + spec->n) * sizeof(double);
    StreamCursor *cursor = &stream->cursor;
    SeriesRows rows;
    StreamItem *item;
    if (stream->books.credit < HEAD + width) return false;
    const uint64_t paid = stream->books.credit - HEAD, room = paid < spec->chunk ? paid : spec->chunk;
    const size_t most = room / width ? room / width : 1;
    if (!streams_reclaim(streams, most * width, NULL)) return false;
    if (run_rows(streams->options.run, streams->now.document, cursor->given ? cursor->line : 0, cursor->row, most,
                 spec->n, spec->columns, &rows, NULL))
        return false;
    const StreamCursor next = {.line = rows.line, .row = rows.first + rows.n, .given = true};
    if (rows.left) return leave_line(stream, &next);
    if (!rows.n || stream_item_rows(spec, rows.n, rows.step, rows.time, rows.values, &streams->memory, &item, NULL))
        return false;
    if (stream_item_pack(item, spec, NULL)) {
        stream_item_leave(item);
        return false;
    }
    stream_close_item(stream);
    stream->item = item;
    stream->cursor = next;
    stream->skipped = subscription_take(&stream->books, 0, item->size);
    return true;
}

static SnapshotPlace place_of(const StreamCursor *cursor)
{
    SnapshotPlace place = {.written = cursor->line, .offset = cursor->offset};
    snprintf(place.name, sizeof place.name, "%.*s", NUMBERED_NAME - 1, cursor->file);
    return place;
}

/* offset: where to go on in the file. */
static StreamCursor cursor_at(const SnapshotPlace *place, uint64_t offset)
{
    StreamCursor cursor = {.line = place->written, .offset = offset, .given = true};
    snprintf(cursor.file, sizeof cursor.file, "%s", place->name);
    return cursor;
}

/* The next file, or the rest of one. */
static bool begin_file(Streams *streams, Stream *stream)
{
    const double now = clock_now();
    const SnapshotPlace from = place_of(&stream->cursor);
    SnapshotNext next;
    RunStatus status;
    if (now < stream->looked + LOOK_EVERY) return false;
    stream->looked = now;
    run_status(streams->options.run, &status);
    if (!status.directory[0] || snapshots_next(&streams->snapshots, status.directory, &from, &next, NULL)) return false;
    const StreamCursor here = cursor_at(&next.place, next.place.offset);
    if (next.left) return leave_line(stream, &here);
    if (!next.there) return false;
    stream_close_item(stream);
    stream->file.fd = next.fd;
    snprintf(stream->file.name, sizeof stream->file.name, "%s", next.place.name);
    if (!next.place.offset) stream->file.sum = XXH64_createState();
    if (stream->file.sum) XXH64_reset(stream->file.sum, 0);
    stream->cursor = cursor_at(&next.place, next.size);
    stream->skipped = subscription_take(&stream->books, 0, next.size);
    stream->books.offset = next.place.offset;
    return true;
}

StreamSent stream_begin_lossless(Streams *streams, Stream *stream)
{
    const bool series = stream->spec.kind == STREAM_SERIES;
    const bool begun = series ? begin_rows(streams, stream) : begin_file(streams, stream);
    return begun ? stream_post_next(&streams->post, stream) : STREAM_WAITS;
}
