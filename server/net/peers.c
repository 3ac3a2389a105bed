/* SPDX-License-Identifier: BSD-3-Clause */
/* Connections of this machine and their processes. */
#include "net/peers.h"

#include "base/clock.h"
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <sys/socket.h>

/* A client says its first word within this time [s] of its connection: where no process has more than another, newcomers get so long. It is less than the time
 * for which clients try. */
static const double FIRST_WORD = 0.25;

enum { FILES_MOST = 1 << 20 }; /* connections beyond this descriptor are not kept here */

typedef struct Group {
    int process;
    int n; /* connections */
} Group;

typedef struct Peer {
    _Atomic bool open;
    bool ending; /* it was ended, and is not closed yet */
    bool heard;  /* it has sent a message               */
    int process;
    double last; /* clock_now() of its latest message, or when it came */
} Peer;

static struct {
    Peer *peers;   /* [size], by descriptor; NULL: none is kept */
    Group *groups; /* [n_groups], room for `size`               */
    int size, end, n_groups;
    pthread_mutex_t lock;
} all = {.lock = PTHREAD_MUTEX_INITIALIZER};

void peers_begin(int files)
{
    const int size = files < FILES_MOST ? files : FILES_MOST;
    Peer *peers = size > 0 ? calloc((size_t)size, sizeof *peers) : NULL;
    Group *groups = peers ? calloc((size_t)size, sizeof *groups) : NULL;
    if (!groups) free(peers);
    free(all.peers);
    free(all.groups);
    all.end = all.n_groups = 0;
    all.peers = groups ? peers : NULL;
    all.groups = groups;
    all.size = groups ? size : 0;
}

static bool is_kept(int fd)
{
    return fd >= 0 && fd < all.size && all.peers[fd].open;
}

static Group *find(int process)
{
    for (int k = 0; k < all.n_groups; k++)
        if (all.groups[k].process == process) return &all.groups[k];
    return NULL;
}

static int count(int process)
{
    const Group *group = find(process);
    return group ? group->n : 0;
}

static void leave(int process)
{
    Group *group = find(process);
    if (--group->n == 0) *group = all.groups[--all.n_groups];
}

void peers_add(int fd, int process)
{
    if (fd < 0 || fd >= all.size) return;
    pthread_mutex_lock(&all.lock);
    Group *group = find(process);
    if (!group) {
        group = &all.groups[all.n_groups++];
        *group = (Group){.process = process};
    }
    group->n++;
    Peer *peer = &all.peers[fd];
    peer->ending = peer->heard = false;
    peer->process = process;
    peer->last = clock_now();
    peer->open = true;
    if (fd >= all.end) all.end = fd + 1;
    pthread_mutex_unlock(&all.lock);
}

void peers_heard(int fd)
{
    if (!is_kept(fd)) return;
    pthread_mutex_lock(&all.lock);
    all.peers[fd].heard = true;
    all.peers[fd].last = clock_now();
    pthread_mutex_unlock(&all.lock);
}

void peers_remove(int fd)
{
    if (!is_kept(fd)) return;
    pthread_mutex_lock(&all.lock);
    if (!all.peers[fd].ending) leave(all.peers[fd].process);
    all.peers[fd].open = false;
    pthread_mutex_unlock(&all.lock);
}

int peers_beyond(int fd)
{
    int n = 0;
    pthread_mutex_lock(&all.lock);
    while (all.end > 0 && !all.peers[all.end - 1].open) all.end--;
    for (int k = fd + 1; k < all.end; k++) n += all.peers[k].open && !all.peers[k].ending;
    pthread_mutex_unlock(&all.lock);
    return n;
}

static Group largest(void)
{
    Group most = {.n = 0};
    for (int k = 0; k < all.n_groups; k++)
        if (all.groups[k].n > most.n && all.groups[k].process != PEER_HTTP) most = all.groups[k];
    return most;
}

static bool goes_before(const Peer *a, const Peer *b)
{
    return a->heard != b->heard ? b->heard : a->last < b->last;
}

/* The connection to end: of one process, or of any where each has one. -1 if all came or spoke after that time. */
static int choose(int process, bool any, double before)
{
    int chosen = -1;
    for (int fd = 0; fd < all.end; fd++) {
        const Peer *peer = &all.peers[fd];
        if (!peer->open || peer->ending || peer->last > before) continue;
        if (peer->process != process && (!any || peer->process == PEER_HTTP)) continue;
        if (chosen < 0 || goes_before(peer, &all.peers[chosen])) chosen = fd;
    }
    return chosen;
}

/* It cannot be closed by its library, and its descriptor not be another's, before peers_remove() has the lock. */
static void end_one(int fd)
{
    all.peers[fd].ending = true;
    leave(all.peers[fd].process);
    shutdown(fd, SHUT_RDWR);
}

bool peers_make_room(int process)
{
    int fd = -1;
    pthread_mutex_lock(&all.lock);
    const Group most = largest();
    const bool alike = most.n == 1 || most.process == PEER_TCP;
    if (process == PEER_HTTP) fd = choose(PEER_HTTP, false, INFINITY);
    else if (count(process) < most.n || process == PEER_TCP)
        fd = choose(most.process, most.n == 1, alike ? clock_now() - FIRST_WORD : INFINITY);
    if (fd >= 0) end_one(fd);
    pthread_mutex_unlock(&all.lock);
    return fd >= 0;
}

int peers_largest(int *ret_n)
{
    pthread_mutex_lock(&all.lock);
    const Group most = largest();
    pthread_mutex_unlock(&all.lock);
    *ret_n = most.n;
    return most.process;
}
