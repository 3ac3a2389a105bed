/* SPDX-License-Identifier: BSD-3-Clause */
/** stream.h - take data from a meniscusd at your own pace: probes, fields, events, series and snapshot files. Part of client.h.
 *
 *  A stream has a connection of its own, and belongs to one thread at a time. The daemon sends as much as was granted; more is granted
 *  when the caller is done with an item, so a slow caller costs it nothing and needs no memory. When the connection is lost it is made anew, and
 *  the stream goes on where it was: what is LOSSLESS without a gap or a repetition, also over a new start of the daemon. */
#ifndef MENISCUS_STREAM_H
#define MENISCUS_STREAM_H

#include <meniscus/client.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct MnsStream MnsStream;

typedef enum MnsStreamKind {
    MNS_STREAM_PROBES,    /* values of a moment                                               */
    MNS_STREAM_FIELDS,    /* fields of the particles at a moment                              */
    MNS_STREAM_EVENTS,    /* what happens to the run                                          */
    MNS_STREAM_SERIES,    /* LOSSLESS: rows of the probes' series, once they are on the disk  */
    MNS_STREAM_SNAPSHOTS, /* LOSSLESS: the snapshot files, byte for byte                      */
    MNS_STREAM_KINDS
} MnsStreamKind;

/** How bytes are packed, with the numbers of the protocol. */
typedef enum MnsCodec { MNS_CODEC_NONE, MNS_CODEC_LZ4, MNS_CODEC_ZSTD } MnsCodec;

enum { MNS_STREAM_FILE_SIZE = 256 };

/** A place in the files of a run, at which a LOSSLESS stream can go on: keep it with what was taken. All 0: the beginning. */
typedef struct MnsCursor {
    uint64_t line;                   /* the time line: another number after each restore or reset  */
    uint64_t row;                    /* of a series: the next one                                  */
    char file[MNS_STREAM_FILE_SIZE]; /* of snapshots                                               */
    uint64_t offset;                 /* of the first byte that was not taken                       */
} MnsCursor;

/** What is asked for. All 0 but the kind: everything, exact, plain, at every step. */
typedef struct MnsStreamOptions {
    MnsStreamKind kind;
    size_t n_names;
    const char *const *names; /* [n_names] of probes (none: all) or fields (1 to 16)                          */
    bool f32;                 /* numbers of 4 bytes                                                           */
    double bound;             /* no value off by more, in its own unit; 0: as computed                        */
    const double *bounds;     /* [n_names] one for each field, 0: as computed; NULL: f32 or bound for all     */
    MnsCodec codec;
    /* when, not of series and snapshots */
    uint64_t every_steps; /* at steps that are multiples of it                                                */
    double interval;      /* of simulated time [s]                                                            */
    double max_hz;        /* of the wall clock                                                                */
    bool first;           /* one item at once, also if the run stands still                                   */
    /* where, of fields: particles that meet all of it */
    int dim;                  /* of corners and centre; 0: everywhere                                      */
    bool in_box;              /* of min and max [m]                                                        */
    double min[3], max[3];    /* [m]                                                                       */
    double centre[3], radius; /* of a sphere [m]; 0: of none                                               */
    size_t n_phases;          /* 0: all                                                                    */
    const unsigned *phases;   /* [n_phases] values of the field "phase"                                    */
    bool walls;               /* wall particles too                                                        */
    uint64_t every;           /* about one in so many, always the same; 0: all                             */
    size_t memory;            /* bytes an item may have, packed or unpacked; 0: 1 GiB                      */
    const MnsCursor *from;    /* of series and snapshots: go on there; NULL: from the beginning            */
} MnsStreamOptions;

/** What came. All it points to lives until the next call with this stream. Of each kind: */
typedef struct MnsStreamItem {
    uint64_t sequence, skipped; /* items that were due, and are not sent, since the one before               */
    uint64_t daemon_epoch, step;
    double time; /* simulated [s] */
    size_t n_arrays;
    const MnsArray *
        arrays; /* probes: "values" [probes]; series: "step", "time" [rows], "values" [rows, probes]; fields [n] or [n, dim] */
    MnsState state;             /* events */
    const char *what, *text;    /* events; "" */
    const char *file;           /* snapshots: name, without directory; NULL */
    uint64_t file_size, offset; /* of the file, and of this piece in it [bytes]                              */
    const void *data;           /* [size] */
    size_t size;
    bool whole; /* the file ends with this piece; its checksum matches, if it was taken from the beginning */
    /* A restore or reset undid, or a crash may have changed, what came after `row` of the series; of snapshots those that come again by name. */
    bool abandoned;
    uint64_t row;            /* abandoned: the first row that is undone                                          */
    const MnsCursor *cursor; /* LOSSLESS: behind this item; NULL within a file                                */
} MnsStreamItem;

/** What became of a stream so far. */
typedef struct MnsStreamStats {
    uint64_t items, skipped, cancelled, reconnects;
    uint64_t packed_bytes, raw_bytes; /* of arrays as they came, and unpacked; of files both the same */
} MnsStreamStats;

/** A name for each column of the items, as the daemon told when the stream began. */
typedef struct MnsStreamColumn {
    const char *name, *unit, *type; /* type as numpy writes it */
    unsigned components;
} MnsStreamColumn;

/** Begin a stream, over a connection as the client's.
 *  @return MNS_OK; MNS_E_INVALID or MNS_E_NOT_FOUND, error->path names the entry; MNS_E_LIMIT if there are too many streams;
 *          MNS_E_VERSION if this daemon has none; MNS_E_UNAVAILABLE, MNS_E_DENIED. */
MnsStatus mns_stream_open(const MnsClient *client, const MnsStreamOptions *options, MnsStream **ret_stream,
                          MnsError *error);

/** Columns of the items. Borrowed until the stream is closed, or goes on after a lost connection. */
const MnsStreamColumn *mns_stream_columns(const MnsStream *stream, size_t *ret_n);

/** The next item. Being asked for it tells that the caller is done with the one before.
 *  @param timeout_s  [s]; negative: no limit
 *  @param ret_item   borrowed until the next call
 *  @return MNS_OK; MNS_E_TIMEOUT if none was whole by then: ask again. MNS_E_UNAVAILABLE if the daemon is away for more than five seconds: the stream
 *          can be asked again, and goes on when it is back. MNS_E_CORRUPT: an item came damaged; asked again the stream goes on, LOSSLESS with
 *          the same item. MNS_E_LIMIT: the item is larger than `memory`; LATEST goes on with the next. MNS_E_MEMORY. MNS_E_INTERRUPTED: the stream is over, as
 *          another case was loaded; all later calls say the same. */
MnsStatus mns_stream_next(MnsStream *stream, double timeout_s, const MnsStreamItem **ret_item, MnsError *error);

/** Give up the item that is under way; the next one follows. @return MNS_E_STATE of a series, which cannot leave out rows. */
MnsStatus mns_stream_cancel(MnsStream *stream, MnsError *error);

MnsStreamStats mns_stream_stats(const MnsStream *stream);

/** Unsubscribe and disconnect; NULL is fine. */
void mns_stream_close(MnsStream *stream);

#ifdef __cplusplus
}
#endif
#endif
