/* SPDX-License-Identifier: BSD-3-Clause */
/* An address for those from afar. */
#include "net/far.h"

#include "base/clock.h"
#include "base/log.h"
#include <string.h>
#include <sys/resource.h>

/* What is encrypted is a little longer than what is in it, and frames of the handshake are longer than some sockets allow. */
static void make_room(void *socket)
{
    enum { ENVELOPE = 64, HANDSHAKE = 1024 };
    int64_t largest;
    size_t size = sizeof largest;
    zmq_getsockopt(socket, ZMQ_MAXMSGSIZE, &largest, &size);
    largest = largest + ENVELOPE < HANDSHAKE ? HANDSHAKE : largest + ENVELOPE;
    zmq_setsockopt(socket, ZMQ_MAXMSGSIZE, &largest, sizeof largest);
}

/* Each who knocks has a descriptor until the handshake is over. Many must not leave the run without any for its files: the soft limit
 * is often 1024, and the hard one far beyond what can knock in the time that a handshake may take. */
static void make_descriptors(void)
{
    struct rlimit limit;
    const rlim_t enough = 65536;
    if (getrlimit(RLIMIT_NOFILE, &limit) || limit.rlim_cur >= enough) return;
    limit.rlim_cur = limit.rlim_max < enough ? limit.rlim_max : enough;
    setrlimit(RLIMIT_NOFILE, &limit);
}

/* Those from afar have a thread of ZeroMQ of their own, so that many who knock keep nobody on this machine waiting. Options hold
 * for what is bound after them. */
MnsStatus far_bind(Far *far, const Access *access, void *socket, const char *address, MnsError *error)
{
    const uint64_t second_thread = 2;
    const int six = address[strlen("tcp://")] == '[';
    zmq_setsockopt(socket, ZMQ_AFFINITY, &second_thread, sizeof second_thread);
    zmq_setsockopt(socket, ZMQ_IPV6, &six, sizeof six);
    make_descriptors();
    make_room(socket);
    access_guard_remote(access, socket);
    if (zmq_bind(socket, address))
        return mns_fail(error, MNS_E_IO, "cannot listen at %s: %s", address, zmq_strerror(zmq_errno()));
    *far = (Far){.socket = socket, .bound = true};
    size_t size = sizeof far->address; /* as ZeroMQ calls it, which lets go of it by no other name */
    zmq_getsockopt(socket, ZMQ_LAST_ENDPOINT, far->address, &size);
    return MNS_OK;
}

void far_cut(Far *far)
{
    if (!far->bound || zmq_unbind(far->socket, far->address)) return;
    far->bound = far->told = false;
    far->cut = clock_now();
}

bool far_is_cut(const Far *far)
{
    return far->socket && !far->bound;
}

/* The address is free again when a thread of ZeroMQ has let go of it, which takes milliseconds; somebody else may take it first. */
void far_mend(Far *far)
{
    if (!far_is_cut(far)) return;
    far->bound = !zmq_bind(far->socket, far->address);
    if (far->bound || far->told || clock_now() < far->cut + 1) return;
    log_line(LOG_ERROR, "cannot listen at %s again: %s; trying on", far->address, zmq_strerror(zmq_errno()));
    far->told = true;
}
