/* SPDX-License-Identifier: BSD-3-Clause */
/* A stream: what was asked for, its books, and the item that is under way. And the feeds they share: who asks for the same has the same items. All of
 * the streams' thread. */
#ifndef NET_STREAM_H
#define NET_STREAM_H

#include "net/flight.h"
#include "net/stream_item.h"
#include "net/subscription.h"
#include "run/run.h"
#include <xxhash.h>

enum { STREAM_IDENTITY = 256 };

/* What falls due for all who asked for the same. */
typedef struct Channel {
    struct Channel *next;
    StreamSpec spec; /* of the first who asked */
    uint8_t *key;    /* [key_size] what was asked, but for what each has of its own */
    size_t key_size;
    struct Stream *users; /* who takes it: first of a list of its own */
    uint64_t generation;
    Feed *feed;         /* NULL: of events                            */
    uint64_t due;       /* how many were due so far                   */
    StreamItem *newest; /* NULL: none yet                             */
    double since;       /* clock_now() when it came                   */
    bool starved;       /* there was no memory for the last one that was due */
} Channel;

/* A file that is under way. */
typedef struct StreamFile {
    int fd; /* -1: none */
    char name[STREAM_FILE_NAME];
    XXH64_state_t *sum;
} StreamFile;

/* Why the first message of an item could not be sent: until one of these is better, the next one need not be tried. */
typedef struct StreamBlock {
    bool is;
    uint64_t credit;
    size_t flight; /* bytes */
    size_t raw;    /* of the item, before it was packed */
} StreamBlock;

typedef struct Stream {
    struct Stream *next;
    uint64_t id;
    uint8_t identity[STREAM_IDENTITY];
    size_t identity_size;
    Who who;       /* whose it is */
    int fd;        /* of its connection; -1: not known */
    bool gone;     /* nobody is there to send to */
    bool too_slow; /* LOSSLESS: memory was short, and it took nothing; to be dropped */
    Subscription books;
    StreamSpec spec;
    uint64_t skipped;
    uint64_t generation;
    Channel *channel;      /* of LATEST                                             */
    struct Stream *beside; /* the next that takes the same channel                */
    Feed *first;           /* for one item at once, before those of the channel     */
    bool first_due;        /* it is closed, and opened again by a resume            */
    StreamItem *head;      /* that item, until it is begun                          */
    uint64_t at_once;      /* one more than the step it was of: the channel need not send that again; 0: none */
    StreamItem *item;      /* begun last; kept until the next, for a resume         */
    StreamFile file;       /* or this                                               */
    StreamCursor cursor;   /* LOSSLESS: behind the item begun last                  */
    Meniscus__Abandoned *abandoned; /* to be told with the next item              */
    Flight *flight;
    StreamBlock block;
    size_t window; /* of bytes in flight                                           */
    double beaten; /* clock_now() of the last heartbeat of its connection            */
    double looked; /* clock_now() when it was last looked for another file          */
    double moved;  /* clock_now() when bytes of it last moved, or it was asked for */
} Stream;

#endif
