/* SPDX-License-Identifier: BSD-3-Clause */
/* What waits to be sent to one browser. */
#include "client/dashboard/session.h"
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct Waiting {
    Waiting *next;
    Text *text;
};

Text *text_new(const char *text, bool lossy)
{
    const size_t size = strlen(text);
    Text *copy = malloc(sizeof *copy + FRAME_HEADROOM + size + 1);
    if (!copy) return NULL;
    *copy = (Text){.lossy = lossy, .size = size};
    memcpy(copy->bytes + FRAME_HEADROOM, text, size + 1);
    return copy;
}

void text_release(Text *text)
{
    if (text->users) text->users--;
    if (!text->users) free(text);
}

void frame_release(Frame *frame)
{
    if (frame->users) frame->users--;
    if (!frame->users) frame_free(frame);
}

void session_init(Session *session, uint64_t id)
{
    *session = (Session){.id = id};
}

void session_done(Session *session)
{
    for (Waiting *item = session->first, *next; item; item = next) {
        next = item->next;
        text_release(item->text);
        free(item);
    }
    if (session->frame) frame_release(session->frame);
    session_init(session, session->id);
}

static bool append(Session *session, Text *text)
{
    Waiting *item = malloc(sizeof *item);
    if (!item) return false;
    *item = (Waiting){.text = text};
    text->users++;
    if (session->last) session->last->next = item;
    else session->first = item;
    session->last = item;
    session->waiting_bytes += text->size;
    return true;
}

/* Say how many texts gave way, now that there is room again. */
static bool confess(Session *session)
{
    char words[80];
    snprintf(words, sizeof words, "{\"topic\":\"lost\",\"messages\":%" PRIu64 "}", session->lost);
    Text *text = text_new(words, false);
    session->lost = 0;
    return text && append(session, text);
}

bool session_send(Session *session, Text *text)
{
    const size_t waiting = session->waiting_bytes + text->size;
    if (text->lossy && waiting > SESSION_LOSSY_BYTES) {
        session->lost++;
        return true;
    }
    if (waiting > SESSION_MOST_BYTES) return false;
    if (session->lost && waiting < SESSION_LOSSY_BYTES && !confess(session)) return false;
    return append(session, text);
}

void session_offer(Session *session, Frame *frame)
{
    if (!session->shows || !wish_equal(&session->wish, &frame->wish)) return;
    if (session->has_seen && key_equal(session->seen, frame->key)) return;
    if (session->frame == frame) return;
    if (session->frame) {
        session->skipped++;
        frame_release(session->frame);
    }
    session->frame = frame;
    frame->users++;
}

void session_drawn(Session *session, uint64_t n)
{
    session->ahead = n < session->ahead ? session->ahead - (unsigned)n : 0;
}

bool session_has_room(const Session *session)
{
    return session->welcome && session->shows && session->ahead < SESSION_AHEAD;
}

bool session_has_next(const Session *session)
{
    return session->first || (session->frame && session_has_room(session));
}

void session_next(Session *session, Text **ret_text, Frame **ret_frame)
{
    Waiting *item = session->first;
    *ret_text = NULL;
    *ret_frame = NULL;
    if (item) {
        *ret_text = item->text;
        session->waiting_bytes -= item->text->size;
        if (item->text == session->past.piece) session->past.piece = NULL;
        session->first = item->next;
        if (!session->first) session->last = NULL;
        free(item);
    } else if (session->frame && session_has_room(session)) {
        *ret_frame = session->frame;
        session->seen = session->frame->key;
        session->has_seen = true;
        session->frame = NULL;
        session->ahead++;
        frame_set_skipped(*ret_frame, session->skipped);
    }
}
