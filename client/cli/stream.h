/* SPDX-License-Identifier: BSD-3-Clause */
/* Items of a stream, printed or written to files. */
#ifndef CLI_STREAM_H
#define CLI_STREAM_H

#include <meniscus/stream.h>

typedef enum StreamFormat { STREAM_TEXT, STREAM_CSV, STREAM_JSON } StreamFormat;

typedef struct StreamSink {
    StreamFormat format;
    MnsStreamKind kind;
    const char *directory; /* NULL: standard output */
    const MnsStreamColumn *columns;
    size_t n_columns;
    bool titled; /* the line of names is out */
} StreamSink;

/* Print what came, or write it below the directory. MNS_E_IO, MNS_E_NO_SPACE; MNS_E_CORRUPT if its arrays do not fit together. */
MnsStatus stream_put(StreamSink *sink, const MnsStreamItem *item, MnsError *error);

/* Write the arrays of fields as DIR/NAME-STEP.npy. */
MnsStatus stream_put_arrays(const char *directory, const MnsStreamItem *item, MnsError *error);

/* A piece of a snapshot file: DIR/NAME has its final name when it is whole. */
MnsStatus stream_put_file(const char *directory, const MnsStreamItem *item, MnsError *error);

#endif
