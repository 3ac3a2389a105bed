/* SPDX-License-Identifier: BSD-3-Clause */
/* A picture's worth of particles, as it goes to browsers. README.md has the layout. */
#ifndef DASHBOARD_FRAME_H
#define DASHBOARD_FRAME_H

#include <meniscus/client.h>

/* Bytes before each message, where the WebSocket library writes its own; and the most particles that a browser may ask for. */
enum { FRAME_HEADROOM = 64, FRAME_PREFIX = 8, FRAME_MOST = 1000000, FRAME_FIELD = 48 };

/* What a browser wants to see. */
typedef struct Wish {
    char field[FRAME_FIELD];
    uint64_t limit; /* about so many particles; of more, one in so many */
    bool walls;
} Wish;

bool wish_equal(const Wish *a, const Wish *b);

/* Which state of the run a frame shows: two with the same key show the same. */
typedef struct FrameKey {
    uint64_t generation; /* of what is known of the daemon: see hub.h */
    uint64_t step;
} FrameKey;

bool key_equal(FrameKey a, FrameKey b);

/* Shared by the browsers that want the same; counted by the thread that serves them. */
typedef struct Frame {
    unsigned users;
    Wish wish;
    FrameKey key;
    size_t size;
    unsigned char bytes[]; /* [FRAME_HEADROOM + size] */
} Frame;

/* One particle in how many is shown, so that about `limit` of n are: a little more than that are still all shown. */
uint64_t frame_every(uint64_t n, uint64_t limit);

/* From the answer to a query of "position", "phase" and the field of the wish, for one in `every` of `all` particles. MNS_E_CORRUPT: it
 * lacks one of them, or has it in a type that fields have not; MNS_E_MEMORY. */
MnsStatus frame_new(const Wish *wish, FrameKey key, uint64_t every, uint64_t all, const MnsReply *reply, Frame **ret,
                    MnsError *error);

/* Write how many frames this browser was not sent before this one. */
void frame_set_skipped(Frame *frame, uint64_t skipped);

void frame_free(Frame *frame);

#endif
