/* SPDX-License-Identifier: BSD-3-Clause */
/* What waits to be sent to one browser. Bounded, however slow it is: of frames only the newest waits, samples that nobody fetches give way,
 * and what gave way is counted. */
#ifndef DASHBOARD_SESSION_H
#define DASHBOARD_SESSION_H

#include "client/dashboard/frame.h"

enum {
    SESSION_AHEAD = 2,             /* frames that a browser may have and not have drawn          */
    SESSION_LOSSY_BYTES = 4 << 20, /* beyond this much waiting text, samples are dropped          */
    SESSION_MOST_BYTES = 16 << 20  /* beyond this the browser is taken for dead: its own limit    */
};

/* Text for several browsers, counted by the thread that serves them. */
typedef struct Text {
    unsigned users;
    bool lossy; /* samples and progress: later ones say as much */
    size_t size;
    unsigned char bytes[]; /* [FRAME_HEADROOM + size] */
} Text;

/* A copy of a text that nobody uses yet; NULL if there is no memory. */
Text *text_new(const char *text, bool lossy);
void text_release(Text *text);

typedef struct Waiting Waiting;

/* The history on its way to a browser: a message for each probe, the next when the one before has gone, so that little of it waits. */
typedef struct Past {
    bool due;
    size_t next;       /* probe                                        */
    uint64_t version;  /* of the history when it began                 */
    const Text *piece; /* the one that waits, borrowed; NULL: none     */
} Past;

typedef struct Session {
    uint64_t id;
    bool welcome; /* it has shown the token, if one is asked for */
    bool shows;   /* it wants frames: the wish holds             */
    Wish wish;
    Waiting *first, *last;
    size_t waiting_bytes;
    Past past;
    uint64_t lost; /* texts that gave way, since it was told */
    Frame *frame;  /* newest, not sent yet                   */
    FrameKey seen; /* of the latest frame that was sent      */
    bool has_seen;
    unsigned ahead;   /* frames sent and not drawn yet    */
    uint64_t skipped; /* frames that gave way, in all     */
} Session;

void session_init(Session *session, uint64_t id);
void session_done(Session *session);

/* Queue a text. @return false: too much waits, close the connection. */
bool session_send(Session *session, Text *text);

/* A newer frame; taken if it is what the browser wants and has not seen. */
void session_offer(Session *session, Frame *frame);

/* The browser has drawn n frames. */
void session_drawn(Session *session, uint64_t n);

/* May it be sent another frame? */
bool session_has_room(const Session *session);

/* What goes out next: a text or a frame, which is then the caller's to release; both NULL: nothing. */
void session_next(Session *session, Text **ret_text, Frame **ret_frame);

bool session_has_next(const Session *session);

/* Count a user of a frame less. */
void frame_release(Frame *frame);

#endif
