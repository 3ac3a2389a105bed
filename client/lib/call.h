/* SPDX-License-Identifier: BSD-3-Clause */
/* A request and its reply, whatever the command is: ids, deadlines, safe repetition, checks. */
#ifndef CLIENT_CALL_H
#define CLIENT_CALL_H

#include "client/lib/wire.h"
#include "meniscus.pb-c.h"

enum { CALL_MAX_REQUEST = 1 << 20 }; /* bytes; a daemon takes no more */

struct MnsClient {
    Wire wire;
    uint64_t epoch; /* of the daemon that was greeted       */
    double timeout; /* [s]; negative: none                  */
    bool has_id;    /* next_id is to be used                */
    uint8_t next_id[MNS_REQUEST_ID_SIZE];
    bool has_if_step; /* the next command is conditional    */
    uint64_t if_step;
    uint64_t if_version;                    /* of the next command; 0: whichever */
    bool has_at_step, has_at_time, no_wait; /* the next command is scheduled */
    uint64_t at_step;
    double at_time;       /* [s] */
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

/* Send a request and wait for its reply. Version, id and deadline are filled in here. Each array of the reply
 * has its frame, checked. On failure, when the daemon refused, error->path is the reply's.
 * MNS_OK: free *ret_reply with meniscus__reply__free_unpacked() and *ret_frames with frames_done(); all else: as
 * client.h says, nothing to free. */
MnsStatus call_make(MnsClient *client, Meniscus__Request *request, Meniscus__Reply **ret_reply, Frames *ret_frames,
                    MnsError *error);

#endif
