/* SPDX-License-Identifier: BSD-3-Clause */
/* What streams take of a run. The lock is held for a walk over the feeds, never while something is copied or packed. */
#include "run/tap.h"

#include "base/clock.h"
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

/* Room for a copy, used again and again. The runner takes one that nobody uses; whoever leaves it last gives it back. */
typedef struct Room {
    Shot shot;
    _Atomic unsigned users; /* 0: free */
    MnsCapture *capture;    /* its room; NULL: none yet */
    double values[MNS_MAX_PROBES];
} Room;

struct Feed {
    Feed *next;
    uint64_t generation;
    Wish wish;
    DueState due;
    bool asked;     /* for the state as it is                                                  */
    bool is_due;    /* at the boundary that is looked at, and counted                          */
    bool wanted;    /* its wish is part of the shot that is taken; who asks later has to wait  */
    uint64_t count; /* of those that were due                    */
    Room *newest;   /* not taken yet, or NULL                    */
};

struct Tap {
    pthread_mutex_t lock; /* of all until `rooms` */
    Feed *feeds;
    TapCase now;
    Room rooms[TAP_ROOMS];
    _Atomic size_t n_feeds; /* looked at without the lock: mostly nobody watches */
    size_t limit;
    int wake;
    TapTally tally;
};

Tap *tap_new(size_t limit)
{
    Tap *tap = calloc(1, sizeof *tap);
    if (!tap) return NULL;
    tap->limit = limit;
    tap->wake = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (tap->wake < 0) {
        free(tap);
        return NULL;
    }
    pthread_mutex_init(&tap->lock, NULL);
    return tap;
}

void tap_free(Tap *tap)
{
    if (!tap) return;
    while (tap->feeds) tap_close(tap, tap->feeds);
    for (int k = 0; k < TAP_ROOMS; k++) mns_capture_free(tap->rooms[k].capture);
    document_leave(tap->now.document);
    pthread_mutex_destroy(&tap->lock);
    close(tap->wake);
    free(tap);
}

const TapTally *tap_tally(const Tap *tap)
{
    return &tap->tally;
}

size_t tap_limit(const Tap *tap)
{
    return tap->limit;
}

/* --- who watches -------------------------------------------------------------------------------------------------------- */

int tap_wake(const Tap *tap)
{
    return tap->wake;
}

void tap_woken(Tap *tap)
{
    eventfd_t count;
    eventfd_read(tap->wake, &count);
}

void tap_case(Tap *tap, TapCase *ret)
{
    pthread_mutex_lock(&tap->lock);
    *ret = tap->now;
    document_share(ret->document);
    pthread_mutex_unlock(&tap->lock);
}

Feed *tap_open(Tap *tap, uint64_t generation, const Wish *wish)
{
    Feed *feed = calloc(1, sizeof *feed);
    if (!feed) return NULL;
    feed->generation = generation;
    feed->wish = *wish;
    feed->due = due_begin();
    pthread_mutex_lock(&tap->lock);
    const bool current = tap->now.generation == generation;
    if (current) {
        feed->next = tap->feeds;
        tap->feeds = feed;
        tap->n_feeds++;
    }
    pthread_mutex_unlock(&tap->lock);
    if (current) return feed;
    free(feed);
    return NULL;
}

static void leave(Room *room)
{
    if (room) room->users--;
}

void tap_close(Tap *tap, Feed *feed)
{
    pthread_mutex_lock(&tap->lock);
    Feed **at = &tap->feeds;
    while (*at != feed) at = &(*at)->next;
    *at = feed->next;
    tap->n_feeds--;
    leave(feed->newest);
    pthread_mutex_unlock(&tap->lock);
    free(feed);
}

void tap_ask(Tap *tap, Feed *feed)
{
    pthread_mutex_lock(&tap->lock);
    feed->asked = true;
    pthread_mutex_unlock(&tap->lock);
}

const Shot *tap_take(Tap *tap, Feed *feed, uint64_t *ret_due)
{
    pthread_mutex_lock(&tap->lock);
    Room *room = feed->newest;
    feed->newest = NULL;
    *ret_due = feed->count;
    pthread_mutex_unlock(&tap->lock);
    return room ? &room->shot : NULL;
}

void tap_leave(Tap *tap, const Shot *shot)
{
    (void)tap;
    leave((Room *)shot); /* of which it is the first member */
}

/* --- the runner --------------------------------------------------------------------------------------------------------- */

uint64_t tap_fields_of(const MnsSim *sim)
{
    return mns_sim_fields(sim);
}

void tap_place(Tap *tap, const MnsSim *sim, Document *document, bool same)
{
    TapCase now = {.fields = document ? tap_fields_of(sim) : 0,
                   .particles = document ? mns_sim_particles(sim) : 0,
                   .document = document_share(document)};
    pthread_mutex_lock(&tap->lock);
    Document *before = tap->now.document;
    now.generation = tap->now.generation + !same;
    tap->now = now;
    pthread_mutex_unlock(&tap->lock);
    document_leave(before);
    eventfd_write(tap->wake, 1);
}

void tap_renew(Tap *tap, const MnsSim *sim)
{
    pthread_mutex_lock(&tap->lock);
    tap->now.fields = tap_fields_of(sim);
    pthread_mutex_unlock(&tap->lock);
    eventfd_write(tap->wake, 1);
}

/* The feeds that are due, and all they want together. With the lock held. */
static bool find_due(Tap *tap, MnsProgress now, bool stepped, Wish *ret)
{
    const double wall = clock_now();
    bool any = false;
    *ret = (Wish){.fields = 0};
    for (Feed *feed = tap->feeds; feed; feed = feed->next) {
        feed->is_due = feed->wanted = false;
        if (feed->generation != tap->now.generation) continue;
        feed->is_due = stepped && due_now(&feed->wish.when, &feed->due, now.step, now.t, now.dt, wall);
        feed->wanted = feed->is_due || feed->asked;
        if (!feed->wanted) continue;
        feed->count += feed->is_due;
        any = true;
        ret->fields |= feed->wish.fields;
        for (int k = 0; k < TAP_PROBE_WORDS; k++) ret->probes[k] |= feed->wish.probes[k];
    }
    return any;
}

size_t tap_number_size(MnsType type)
{
    return type == MNS_F64 ? sizeof(double) : type == MNS_U32 ? sizeof(uint32_t) : sizeof(uint8_t);
}

/* What the arrays of a capture take, whatever simulation they are of, and whether or not they are filled now. */
static size_t size_of(const MnsCapture *capture)
{
    size_t width = 0;
    for (int f = 0; capture && mns_fields()[f].name; f++) {
        const size_t one = tap_number_size(mns_fields()[f].type);
        for (int d = 0; d < 3; d++) width += capture->data[f][d] ? one : 0;
    }
    return width ? width * capture->n : 0;
}

static void tally_rooms(Tap *tap)
{
    size_t bytes = 0;
    for (int k = 0; k < TAP_ROOMS; k++) bytes += size_of(tap->rooms[k].capture);
    tap->tally.bytes = bytes;
}

static void empty(Tap *tap, Room *room)
{
    mns_capture_free(room->capture);
    room->capture = NULL;
    tally_rooms(tap);
}

/* Room that nobody uses, the one that was used last first: its memory is warm. */
static Room *find_room(Tap *tap)
{
    for (int k = 0; k < TAP_ROOMS; k++)
        if (!tap->rooms[k].users) return &tap->rooms[k];
    return NULL;
}

/* What a room would take more if these fields were copied there, besides those that it has arrays for. */
static size_t growth(const Room *room, const MnsSim *sim, uint64_t fields)
{
    for (int f = 0; room->capture && mns_fields()[f].name; f++)
        if (room->capture->data[f][0]) fields &= ~(UINT64_C(1) << f);
    return mns_sim_capture_size(sim, fields);
}

/* Within the limit with a copy of these fields in this room? What nobody uses gives way: arrays of another case, of fields that nobody
 * wants now, and at last other rooms. */
static bool make_room(Tap *tap, Room *room, const MnsSim *sim, uint64_t fields)
{
    for (int k = 0; k < TAP_ROOMS; k++) {
        Room *other = &tap->rooms[k];
        if (!other->users && other->capture && other->capture->n != mns_sim_particles(sim)) empty(tap, other);
    }
    if (tap->tally.bytes + growth(room, sim, fields) > tap->limit) empty(tap, room);
    for (int k = 0; k < TAP_ROOMS && tap->tally.bytes + growth(room, sim, fields) > tap->limit; k++)
        if (!tap->rooms[k].users) empty(tap, &tap->rooms[k]);
    return tap->tally.bytes + growth(room, sim, fields) <= tap->limit;
}

/* A copy of the fields, in room from before if that fits. False: there is no room for it. */
static bool copy_fields(Tap *tap, Room *room, const MnsSim *sim, uint64_t fields)
{
    if (!make_room(tap, room, sim, fields)) return false;
    MnsStatus status = room->capture ? mns_sim_recapture(sim, fields, room->capture, NULL) : MNS_E_STATE;
    if (status == MNS_E_STATE) {
        empty(tap, room);
        status = mns_sim_capture(sim, fields, &room->capture, NULL);
    }
    tally_rooms(tap);
    return !status;
}

static void measure(Room *room, const MnsSim *sim, const uint64_t probes[TAP_PROBE_WORDS], const double *known)
{
    room->shot.values = NULL;
    for (size_t k = 0; k < mns_sim_case(sim)->n_probes; k++)
        if (probes[k / 64] >> k % 64 & 1) {
            room->values[k] = known ? known[k] : mns_sim_probe(sim, k);
            room->shot.values = room->values;
        }
}

/* NULL: there is no room for it. */
static Room *shoot(Tap *tap, const MnsSim *sim, const Wish *wish, const double *known)
{
    Room *room = find_room(tap);
    if (!room || (wish->fields && !copy_fields(tap, room, sim, wish->fields))) return NULL;
    room->shot.progress = mns_sim_progress(sim);
    room->shot.capture = wish->fields ? room->capture : NULL;
    measure(room, sim, wish->probes, known);
    room->users = 1; /* ours, while it is handed out */
    return room;
}

/* Nobody watches any longer. */
static void drop_rooms(Tap *tap)
{
    for (int k = 0; k < TAP_ROOMS; k++)
        if (!tap->rooms[k].users) empty(tap, &tap->rooms[k]);
}

/* Has it all that a feed is for? Fields of an option go with it, by a set or by a restore to before it was on. */
static bool serves(const Shot *shot, const Wish *wish)
{
    return !wish->fields || !(wish->fields & ~shot->capture->fields);
}

/* Each feed keeps the newest alone, of those whose wish it was taken for: somebody may have asked meanwhile. Where fields are gone it counts
 * as one for which there was no room. With the lock held. */
static void hand_out(Tap *tap, Room *room)
{
    for (Feed *feed = tap->feeds; feed; feed = feed->next) {
        if (!feed->wanted) continue;
        feed->count += !feed->is_due;
        feed->wanted = feed->is_due = feed->asked = false;
        if (!serves(&room->shot, &feed->wish)) continue;
        leave(feed->newest);
        feed->newest = room;
        room->users++;
    }
}

void tap_look(Tap *tap, const MnsSim *sim, bool stepped, const double *known)
{
    Wish wish;
    if (!tap->n_feeds && tap->tally.bytes) drop_rooms(tap);
    if (!tap->n_feeds) return;
    const double began = clock_now();
    pthread_mutex_lock(&tap->lock);
    const bool due = find_due(tap, mns_sim_progress(sim), stepped, &wish);
    pthread_mutex_unlock(&tap->lock);
    if (!due) return;
    Room *room = shoot(tap, sim, &wish, known);
    if (room) tap->tally.shots++;
    else tap->tally.without_room++;
    if (room) {
        pthread_mutex_lock(&tap->lock);
        hand_out(tap, room);
        pthread_mutex_unlock(&tap->lock);
        leave(room);
    }
    eventfd_write(tap->wake, 1);
    tap->tally.seconds = tap->tally.seconds + clock_now() - began;
}
