/* SPDX-License-Identifier: BSD-3-Clause */
/** status.h - what can go wrong: a code for programs, a sentence for people. Used by every library of the project. */
#ifndef MENISCUS_STATUS_H
#define MENISCUS_STATUS_H

#ifdef __cplusplus
extern "C" {
#endif

typedef enum MnsStatus {
    MNS_OK = 0,
    MNS_E_INVALID,     /* an input is malformed or out of its bounds                                */
    MNS_E_NOT_FOUND,   /* no file, fluid, probe, field ... of that name                             */
    MNS_E_STATE,       /* not possible in the present state                                         */
    MNS_E_LIMIT,       /* a documented limit of this program is reached                             */
    MNS_E_MEMORY,      /* no memory                                                                 */
    MNS_E_DIVERGED,    /* the simulation has diverged                                               */
    MNS_E_IO,          /* the operating system refused to read or write                             */
    MNS_E_NO_SPACE,    /* the disk is full                                                          */
    MNS_E_CORRUPT,     /* a file is damaged                                                         */
    MNS_E_VERSION,     /* file or peer speaks another version                                       */
    MNS_E_UNAVAILABLE, /* nobody answers                                                            */
    MNS_E_TIMEOUT,     /* not done in time                                                          */
    MNS_E_INTERRUPTED, /* stopped by a signal or a request                                          */
    MNS_E_HELD,        /* somebody else holds the lease                                             */
    MNS_E_EXPIRED,     /* the lease it was sent under is over                                       */
    MNS_E_DENIED,      /* who asks may not do that, or is not let in                                */
    MNS_E_INTERNAL     /* a defect of this program                                                  */
} MnsStatus;

/** Why a call failed. Every function that can fail takes one as its last parameter; it may be NULL. */
typedef struct MnsError {
    MnsStatus status;
    char path[128]; /* the entry to blame, as in "fluids[1].density"; empty if there is none         */
    char text[512]; /* a sentence: what was found, what is allowed, what to do                       */
} MnsError;

/** Short name of a status, as in "invalid"; never NULL. */
const char *mns_status_name(MnsStatus status);

/** What to do about a failure of that kind, as a sentence; "" if the failure says all there is to say. Never NULL. */
const char *mns_status_hint(MnsStatus status);

/** What to do where the operating system has refused a file or directory with this number of <errno.h>, as the end of a sentence; never NULL. */
const char *mns_refusal_hint(int number);

/** Fill in error, if there is one, and return status: `return mns_fail(error, MNS_E_IO, "cannot ...", ...);`
 *  An over-long sentence is cut. */
MnsStatus mns_fail(MnsError *error, MnsStatus status, const char *format, ...) __attribute__((format(printf, 3, 4)));

/** The same with the entry to blame. */
MnsStatus mns_fail_at(MnsError *error, MnsStatus status, const char *path, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

#ifdef __cplusplus
}
#endif
#endif
