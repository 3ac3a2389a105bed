/* SPDX-License-Identifier: BSD-3-Clause */
/* Notes on their way out of the runner. Putting one never waits for the reader. */
#include "run/outbox.h"

#include <sys/eventfd.h>
#include <unistd.h>

enum { LIVE_MAX = 1024 };

MnsStatus outbox_init(Outbox *box, MnsError *error)
{
    *box = (Outbox){.wake = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)};
    if (box->wake < 0) return mns_fail(error, MNS_E_LIMIT, "the operating system refuses an eventfd: %m");
    pthread_mutex_init(&box->lock, NULL);
    return MNS_OK;
}

void outbox_done(Outbox *box)
{
    for (Note *note; (note = outbox_take(box));) note_free(note);
    pthread_mutex_destroy(&box->lock);
    close(box->wake);
}

static bool is_live(const Note *note)
{
    return note->kind == NOTE_PROGRESS || note->kind == NOTE_PROBES;
}

/* With the lock held. */
static void append(Outbox *box, Note *note)
{
    note->next = NULL;
    if (box->last) box->last->next = note;
    else box->first = note;
    box->last = note;
    box->live += is_live(note);
    eventfd_write(box->wake, 1);
}

/* Take out the oldest live note; there is one. With the lock held. */
static Note *drop_live(Outbox *box)
{
    Note **list = &box->first, *before = NULL;
    for (; !is_live(*list); list = &before->next) before = *list;
    Note *note = *list;
    *list = note->next;
    if (box->last == note) box->last = before;
    box->live--;
    box->dropped[note->kind]++;
    return note;
}

void outbox_put(Outbox *box, Note *note)
{
    pthread_mutex_lock(&box->lock);
    Note *stale = is_live(note) && box->live >= LIVE_MAX ? drop_live(box) : NULL;
    append(box, note);
    pthread_mutex_unlock(&box->lock);
    note_free(stale);
}

Note *outbox_take(Outbox *box)
{
    pthread_mutex_lock(&box->lock);
    Note *note = box->first;
    if (note) {
        box->first = note->next;
        if (!box->first) box->last = NULL;
        box->live -= is_live(note);
    } else {
        eventfd_t count;
        eventfd_read(box->wake, &count);
    }
    pthread_mutex_unlock(&box->lock);
    return note;
}

uint64_t outbox_dropped(Outbox *box)
{
    return box->dropped[NOTE_PROGRESS] + box->dropped[NOTE_PROBES];
}
