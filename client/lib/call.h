/* SPDX-License-Identifier: BSD-3-Clause */
/* A request and its reply, whatever the command is: ids, deadlines, safe repetition, checks. */
#ifndef CLIENT_CALL_H
#define CLIENT_CALL_H

#include "client/lib/wire.h"
#include "meniscus.pb-c.h"

struct MnsClient {
    Wire wire;
    uint64_t epoch;         /* of the daemon that was greeted       */
    double timeout;         /* [s]; negative: none                  */
    Meniscus__Request next; /* what was said for the next command: its conditions and schedule, that it has next_id */
    uint8_t next_id[MNS_REQUEST_ID_SIZE];
    uint64_t lease_epoch; /* of all commands; 0: none          */
    void *telemetry;      /* SUB socket, or NULL                  */
    struct {
        uint64_t epoch, sequence; /* of the last message; epoch 0: none   */
    } heard[4];                   /* by topic                             */
};

/* Fill with random bytes. MNS_OK; MNS_E_IO. */
MnsStatus call_random(uint8_t *data, size_t size, MnsError *error);

/* A reason of the protocol as a status; MNS_OK if it is NULL or unknown. */
MnsStatus call_reason(const char *reason);

/* What a refusal means. */
MnsStatus call_status(Meniscus__Code code, const char *reason);

/* Ask the daemon who it is: sets client->epoch. MNS_E_UNAVAILABLE if it does not answer until the deadline (monotonic), MNS_E_VERSION. */
MnsStatus call_greet(MnsClient *client, double deadline, MnsError *error);

/* The request of a command, with what was said for it, which is for no other, whether this one is sent or refused before: so every command
 * begins with this. */
Meniscus__Request call_begin(MnsClient *client);

/* Send a request that began as above and wait for its reply. Version, id, lease and deadline are filled in here. Each array of the reply
 * has its frame, checked. On failure, when the daemon refused, error->path is the reply's.
 * MNS_OK: free *ret_reply with meniscus__reply__free_unpacked() and *ret_frames with frames_done(); all else: as
 * client.h says, nothing to free. */
MnsStatus call_make(MnsClient *client, Meniscus__Request *request, Meniscus__Reply **ret_reply, Frames *ret_frames,
                    MnsError *error);

#endif
