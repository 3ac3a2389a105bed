/* SPDX-License-Identifier: BSD-3-Clause */
/** client.h - steer and watch a meniscusd from a C program. Plain structs, SI units; no message or socket type is
 * needed.
 *
 *  A client belongs to one thread at a time; a program may have many. Every command returns after its effect, with the
 *  reply in *ret_reply (may be NULL if nobody wants it; untouched on failure). A command that was cut off by a lost
 *  connection is sent again under the same request id, so it happens once. What every command may return:
 *    MNS_E_INVALID      refused: an input is malformed or out of bounds; error->path names the entry
 *    MNS_E_NOT_FOUND    no checkpoint, probe, field or entry of that name
 *    MNS_E_STATE        not possible in the present state; the sentence says in which it is
 *    MNS_E_LIMIT        too much at once: too many requests or particles
 *    MNS_E_DIVERGED     the simulation has diverged; it can be inspected and restored
 *    MNS_E_IO, MNS_E_NO_SPACE, MNS_E_CORRUPT  the daemon could not read or write a file; or an array came damaged
 *    MNS_E_VERSION      the daemon speaks another version
 *    MNS_E_UNAVAILABLE  nobody answers, also not within five seconds of a lost connection
 *    MNS_E_TIMEOUT      not done within the time limit
 *    MNS_E_INTERRUPTED  cancelled by another client
 *    MNS_E_HELD         somebody else holds the lease; MNS_E_EXPIRED: the lease of this client is over
 *    MNS_E_DENIED       the key lacks the role that this takes, or is not let in (any more) */
#ifndef MENISCUS_CLIENT_H
#define MENISCUS_CLIENT_H

#include <meniscus/status.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct MnsClient MnsClient;

enum { MNS_REQUEST_ID_SIZE = 16, MNS_ENDPOINT_SIZE = 160 };

#define MNS_NO_STEP UINT64_MAX

/** States of a daemon, with the numbers of the protocol. */
typedef enum MnsState {
    MNS_STATE_EMPTY, /* no case                                          */
    MNS_STATE_LOADING,
    MNS_STATE_READY, /* loaded, t = 0 or restored, not run since         */
    MNS_STATE_RUNNING,
    MNS_STATE_PAUSED,
    MNS_STATE_DONE,  /* end time reached                                 */
    MNS_STATE_FAULT, /* diverged, or an output failed                    */
    MNS_STATE_STOPPING,
    MNS_STATE_RECOVERING, /* after a crash, on the way to where it was    */
    MNS_STATE_COUNT
} MnsState;

/** "RUNNING"; "UNKNOWN" for a number that is no state. */
const char *mns_state_name(MnsState state);

/** By name, in any case of letters. @return false if there is no such state. */
bool mns_state_parse(const char *name, MnsState *ret_state);

/* --- replies
 * ----------------------------------------------------------------------------------------------------------- */

/** A named value: a number, a text, or an entry of a case as text and, where it is one, as a number. */
typedef struct MnsValue {
    const char *name, *text, *unit; /* text is NULL if it is only a number; unit is never NULL */
    double number;                  /* NAN if there is none */
} MnsValue;

/** An array, row-major, checked by its checksum and aligned for its type. */
typedef struct MnsArray {
    const char *name, *unit, *type; /* type as numpy writes it: "<f8", "<u4", "|u1" */
    size_t n_dims, shape[4];
    size_t size; /* bytes */
    const void *data;
} MnsArray;

/** Time spent in a part of the step. */
typedef struct MnsTimerInfo {
    const char *name;
    double seconds;
    uint64_t calls;
} MnsTimerInfo;

/** A place at which the run pauses. */
typedef struct MnsBreakpoint {
    const char *name, *condition; /* condition: NULL if there is none                        */
    double time;                  /* [s]; NAN if it is not about time                        */
    uint64_t step;                /* 0 if it is not about a step                             */
} MnsBreakpoint;

/** A command that waits for a step or a time. */
typedef struct MnsScheduled {
    uint8_t id[MNS_REQUEST_ID_SIZE]; /* for mns_client_cancel()                                */
    uint64_t at_step;                /* MNS_NO_STEP if it waits for a time                     */
    double at_time;                  /* [s]; NAN if it waits for a step                        */
    const char *who, *what;          /* who gave it; "set gravity = [0, -2], at step 5000"     */
} MnsScheduled;

/** Streams that are subscribed to, of all clients together. */
typedef struct MnsStreamsNow {
    uint64_t latest, lossless; /* streams of the newest: probes, fields, events; of everything: series, snapshots */
    uint64_t memory_bytes;     /* that they hold                                                                  */
    uint64_t skipped;          /* items that gave way to newer ones, since the daemon began                       */
} MnsStreamsNow;

/** What a daemon is doing. Strings are never NULL; numbers that the daemon does not know are NAN or 0. */
typedef struct MnsRunInfo {
    MnsState state;
    MnsStatus fault_status; /* in FAULT: MNS_E_DIVERGED, MNS_E_NO_SPACE ... */
    const char *case_name, *title, *run_directory, *fault, *version;
    double time, end_time, time_step; /* [s], simulated */
    double eta_s, wall_s;             /* [s], wall clock: to the end, since the start */
    double steps_per_second, ns_per_particle_step;
    double
        energy_excess; /* that the scheme has made of nothing, over the largest of kinetic energy and change of potential energy */
    uint64_t step, particles, fluid_particles, guarded, uncorrected, samples_dropped, memory_bytes;
    uint64_t recovery_step;   /* in RECOVERING: at which it is back; else MNS_NO_STEP */
    uint64_t state_hash;      /* 0 while it runs */
    uint64_t case_version;    /* 1 when the case was loaded, one more with every change */
    const char *lease_holder; /* who may change the run; empty if everybody may         */
    double lease_s;           /* for how long yet                                       */
    unsigned threads;
    size_t n_timers, n_breakpoints, n_scheduled;
    const MnsTimerInfo *timers;
    const MnsBreakpoint *breakpoints;
    const MnsScheduled *scheduled; /* in the order in which they were accepted */
    const MnsStreamsNow *streams;  /* NULL: the daemon does not tell */
} MnsRunInfo;

/** A file the daemon has written. */
typedef struct MnsOutputFile {
    const char *path;
    uint64_t step;
    double time; /* [s] */
} MnsOutputFile;

/** Something that has a name and an explanation: a parameter, a field, a scheme. */
typedef struct MnsTopicInfo {
    const char *name, *type, *unit, *range, *value, *meaning; /* never NULL, empty where it does not apply */
    const char *takes_effect;                                 /* of a parameter: when, after a set; "" of others */
    unsigned components;                                      /* of a field */
} MnsTopicInfo;

/** What a daemon can do. */
typedef struct MnsCapabilities {
    const char *version, *build, *compiler, *commit;
    size_t n_commands, n_probes, n_topics, n_parameters, n_fields, n_schemes;
    const char *const *commands, *const *probes, *const *topics; /* topics: what can be subscribed to */
    const MnsTopicInfo *parameters, *fields, *schemes;
} MnsCapabilities;

/** The answer to a command. All it points to lives as long as it does. */
typedef struct MnsReply {
    const char *message;   /* a sentence for people; may be empty */
    MnsState state;        /* after the effect */
    uint64_t daemon_epoch; /* another number after every start of the daemon */
    uint64_t step;         /* at the time of the reply */
    uint64_t
        effect_step; /* the step boundary at which the command took effect; MNS_NO_STEP: nothing did, as of a get */
    double time;     /* simulated time of the reply [s] */
    uint64_t case_version; /* 1 when a case is loaded, one more with every change; 0 without a case */
    uint64_t lease_epoch;  /* that was given; 0: none */
    double lease_s;        /* for which it lives      */
    size_t n_values, n_arrays;
    const MnsValue *values; /* get, set, query of probes */
    const MnsArray *arrays; /* query of points and particles */
    const MnsRunInfo *info; /* status, else NULL */
    const MnsOutputFile
        *output; /* checkpoint, snapshot; of load, reset, restore, stop, shutdown the run directory; or NULL */
    const MnsCapabilities *capabilities; /* capabilities, else NULL */
    bool state_reached;                  /* wait: one of the states, rather than the time or the step */
} MnsReply;

/** Free a reply; NULL is fine. */
void mns_reply_free(MnsReply *reply);

/** The array of that name, or NULL. */
const MnsArray *mns_reply_array(const MnsReply *reply, const char *name);

/* --- the connection
 * ---------------------------------------------------------------------------------------------------- */

/** Where a daemon listens for commands.
 *  @param daemon  a name: its socket is control.ipc in the first that exists of $XDG_RUNTIME_DIR/meniscus/NAME,
 *                 /run/meniscus/NAME and /tmp/meniscus-UID/NAME where nobody else may put one; or an endpoint: ipc://PATH or tcp://HOST:PORT.
 *                 NULL: $MENISCUS_DAEMON, or "default".
 *  @return MNS_OK; MNS_E_INVALID; MNS_E_UNAVAILABLE if there is no such socket: the sentence says where it looked. */
MnsStatus mns_daemon_endpoint(const char *daemon, char ret_endpoint[MNS_ENDPOINT_SIZE], MnsError *error);

/** Call visit(arg, name, endpoint) for every daemon of this host that has a socket, alive or not, until it returns
 * false. */
void mns_daemon_list(bool (*visit)(void *arg, const char *name, const char *endpoint), void *arg);

/** How to reach a daemon. A key is for tcp:// only, and off this machine there is no way without: then every byte is encrypted,
 *  each side knows that the other is who it should be, and what the client may do is up to the role of its key. */
typedef struct MnsClientOptions {
    const char *daemon;     /* as above                                                                              */
    const char *key_file;   /* of `meniscus keys new`, mode 0600; NULL: $MENISCUS_KEY. Of neither: plain text        */
    const char *server_key; /* public key of the daemon; NULL: $MENISCUS_SERVER_KEY, or that in the file of the key  */
    double timeout;         /* to connect and be greeted [s]; 0: five seconds, that of commands is set below         */
} MnsClientOptions;

/** Connect and greet. A daemon that was started in the line before is given 0.3 seconds to listen.
 *  @return MNS_OK; as mns_daemon_endpoint(); MNS_E_UNAVAILABLE within the timeout if nobody listens or answers, or if
 *          the daemon has another public key; MNS_E_DENIED if it does not know ours, or there is none; MNS_E_VERSION. Of the file
 *          of the key: MNS_E_NOT_FOUND, MNS_E_INVALID, MNS_E_IO; MNS_E_STATE if others can read it. */
MnsStatus mns_client_open_with(const MnsClientOptions *options, MnsClient **ret_client, MnsError *error);

/** The same with nothing but the daemon said. */
MnsStatus mns_client_open(const char *daemon, MnsClient **ret_client, MnsError *error);

/** Disconnect; NULL is fine. Commands that were accepted go on without the client. */
void mns_client_close(MnsClient *client);

/** For how long the connection has been lost, as by the end of the daemon [s]; 0 while there is one. It is made anew by itself. What has
 *  come in since the last call is taken note of, so this is for the thread that gives the commands. Cost: no message. */
double mns_client_away(MnsClient *client);

/** For how long a command waits for a connection that was lost while it was under way [s]: a daemon may be restarted. 5 unless it is said. */
void mns_client_set_reconnect(MnsClient *client, double seconds);

/** Limit the time that each later command may take [s]; a negative one takes the limit away (the default). A daemon
 * that dies is noticed without it. */
void mns_client_set_timeout(MnsClient *client, double seconds);

/** Use this id for the next command, instead of a random one: the same id never happens twice, so a script may repeat a
 *  command of which it does not know whether it arrived, and mns_client_cancel() can name it. This and what else is said for
 *  the next command is for that one alone, also if it is refused before it is sent, as a set without "=" is. */
void mns_client_set_request_id(MnsClient *client, const uint8_t id[MNS_REQUEST_ID_SIZE]);

/** Make the next command conditional: unless the run is at this step when the command would begin, it is refused with
 *  MNS_E_STATE, error->path is "if_step", and nothing is done. For a change that was made up for what was seen at that step.
 *  Not for status, get and capabilities, which refuse it with MNS_E_INVALID. */
void mns_client_set_if_step(MnsClient *client, uint64_t step);

/** The same for the version of the case that the next command is for: MnsReply.case_version. */
void mns_client_set_if_version(MnsClient *client, uint64_t version);

/** Schedule the next command, a set, rollback, pause, checkpoint or snapshot: it takes effect when the run is at this step, or at this
 *  simulated time [s], at which a step ends exactly. It is checked at once, and again then; a moment that is past is refused with
 *  MNS_E_INVALID. A crash of the daemon does not lose it; a load, reset, restore or stop calls it off. A time limit is for its effect. */
void mns_client_set_at_step(MnsClient *client, uint64_t step);
void mns_client_set_at_time(MnsClient *client, double time);

/** Have the next command, which is scheduled, return when the daemon has accepted it: effect_step is MNS_NO_STEP then. */
void mns_client_set_no_wait(MnsClient *client);

/** Send this epoch of a lease with all later commands, 0 for none; mns_client_lease() does so by itself. */
void mns_client_set_lease(MnsClient *client, uint64_t epoch);

enum { MNS_KEY_SIZE = 41 };

/** Make a new pair of keys, as text of 40 letters. @return MNS_OK; MNS_E_UNAVAILABLE if this libzmq was built without them. */
MnsStatus mns_key_pair(char ret_public[MNS_KEY_SIZE], char ret_secret[MNS_KEY_SIZE], MnsError *error);

/* --- commands
 * ---------------------------------------------------------------------------------------------------------- */

/** A case to load. */
typedef struct MnsLoad {
    const char *file; /* path of a YAML file; names of cases that came along are for programs, not found here */
    const char *name; /* of the run; NULL: that of the file without directory and suffix */
    size_t n_sets;
    const char *const *sets; /* [n_sets] entries to override, as in "resolution=40"; may be NULL if there are none */
    bool
        resume; /* go on from the newest whole checkpoint of the run, if there is one: as it was steered, but for sets */
} MnsLoad;

/** Replace the case. When the daemon refuses it, the sentence begins with FILE:LINE:COLUMN of the entry to blame. */
MnsStatus mns_client_load(MnsClient *client, const MnsLoad *load, MnsReply **ret_reply, MnsError *error);

MnsStatus mns_client_start(MnsClient *client, MnsReply **ret_reply, MnsError *error);
MnsStatus mns_client_pause(MnsClient *client, MnsReply **ret_reply, MnsError *error);
MnsStatus mns_client_resume(MnsClient *client, MnsReply **ret_reply, MnsError *error);

/** Do count time steps; returns when they are done. */
MnsStatus mns_client_step(MnsClient *client, uint64_t count, MnsReply **ret_reply, MnsError *error);

/** Run until simulated time [s]; returns when it is reached. @param exact  shorten the last step to end exactly there.
 */
MnsStatus mns_client_run_until(MnsClient *client, double time, bool exact, MnsReply **ret_reply, MnsError *error);

/** End the run; its files stay. @param checkpoint  write one first. */
MnsStatus mns_client_stop(MnsClient *client, bool checkpoint, MnsReply **ret_reply, MnsError *error);

/** Back to t = 0 of the same case. */
MnsStatus mns_client_reset(MnsClient *client, MnsReply **ret_reply, MnsError *error);

/** Put a checkpoint back. @param checkpoint  file name in the run directory; NULL: the newest whole one.
 *  @return MNS_E_INVALID if it is a checkpoint of another case, with the entry that differs. */
MnsStatus mns_client_restore(MnsClient *client, const char *checkpoint, MnsReply **ret_reply, MnsError *error);

/** Write a checkpoint now; reply->output says where. */
MnsStatus mns_client_checkpoint(MnsClient *client, MnsReply **ret_reply, MnsError *error);

/** Write a snapshot now. @param fields  [n]; n = 0: those of the case. */
MnsStatus mns_client_snapshot(MnsClient *client, size_t n, const char *const *fields, MnsReply **ret_reply,
                              MnsError *error);

/** Change entries of the running case, all or none. @param assignments  [n], as in "end_time=3". */
MnsStatus mns_client_set(MnsClient *client, size_t n, const char *const *assignments, MnsReply **ret_reply,
                         MnsError *error);

/** Read entries of the case into reply->values. @param paths  [n], as in "output.snapshot_interval"; n = 0: all that
 *  mns_client_set() can change. */
MnsStatus mns_client_get(MnsClient *client, size_t n, const char *const *paths, MnsReply **ret_reply, MnsError *error);

/** Values of probes, now, into reply->values. @param names  [n]; n = 0: all. */
MnsStatus mns_client_query_probes(MnsClient *client, size_t n, const char *const *names, MnsReply **ret_reply,
                                  MnsError *error);

/** A field at points, averaged by the kernel over the fluid, into an array; NAN where no fluid is near.
 *  @param points  [n][dim], m, with the dim of the case; at most 57,000 in the plane, 38,000 in space. */
MnsStatus mns_client_query_points(MnsClient *client, const char *field, size_t n, int dim, const double *points,
                                  MnsReply **ret_reply, MnsError *error);

/** Which particles. */
typedef struct MnsParticleQuery {
    int dim;               /* of the corners; 0: everywhere */
    double min[3], max[3]; /* corners of the box [m] */
    size_t n_fields;
    const char *const *fields; /* [n_fields]; none: position, id and phase */
    uint64_t limit;            /* MNS_E_LIMIT beyond; 0: 100000 */
    bool walls;                /* wall particles too */
    uint64_t every;            /* about one in so many, by chance but always the same; 0: all */
} MnsParticleQuery;

/** Particles of a box, one array per field. */
MnsStatus mns_client_query_particles(MnsClient *client, const MnsParticleQuery *query, MnsReply **ret_reply,
                                     MnsError *error);

/** Return at the first of: one of the states, a simulated time, a step.
 *  @param states  bit s set: wait for state s (1u << MNS_STATE_DONE); 0: for no state
 *  @param time    [s]; NAN: for no time
 *  @param step    MNS_NO_STEP: for no step */
MnsStatus mns_client_wait(MnsClient *client, unsigned states, double time, uint64_t step, MnsReply **ret_reply,
                          MnsError *error);

/** What the daemon is doing: reply->info. */
MnsStatus mns_client_status(MnsClient *client, MnsReply **ret_reply, MnsError *error);

/** What the daemon can do: reply->capabilities. */
MnsStatus mns_client_capabilities(MnsClient *client, MnsReply **ret_reply, MnsError *error);

/** Pause at a time, a step or when a formula of the probes becomes true. A breakpoint of the same name is replaced; one
 *  with none of the three is removed. @param breakpoint  see MnsBreakpoint. */
MnsStatus mns_client_breakpoint(MnsClient *client, const MnsBreakpoint *breakpoint, MnsReply **ret_reply,
                                MnsError *error);

/** Go back to the case as it was at a version, which makes one more: the last 256 are kept, and none from before a load, reset or
 *  restore. @return MNS_E_NOT_FOUND if it is not kept. */
MnsStatus mns_client_rollback(MnsClient *client, uint64_t version, MnsReply **ret_reply, MnsError *error);

/** Take the lease, or renew the one that this client sends: until it is over nobody else can change the run, but for pause, stop and
 *  shutdown. All later commands of this client come under it.
 *  @param seconds  for which it lives, 0.1 to 86400
 *  @param holder   what others are told, at most 63 bytes
 *  @return MNS_E_HELD if another has it, MNS_E_EXPIRED if it was over before it could be renewed. */
MnsStatus mns_client_lease(MnsClient *client, double seconds, const char *holder, MnsReply **ret_reply,
                           MnsError *error);

/** Give the lease back. */
MnsStatus mns_client_release(MnsClient *client, MnsReply **ret_reply, MnsError *error);

/** End a pending step, run_until or wait; it returns MNS_E_INTERRUPTED to who asked. @param id  of that request. */
MnsStatus mns_client_cancel(MnsClient *client, const uint8_t id[MNS_REQUEST_ID_SIZE], MnsReply **ret_reply,
                            MnsError *error);

/** End the daemon. @param checkpoint  write one first. */
MnsStatus mns_client_shutdown(MnsClient *client, bool checkpoint, MnsReply **ret_reply, MnsError *error);

/* --- telemetry
 * --------------------------------------------------------------------------------------------------------- */

/** Topics, as bits. */
typedef enum MnsTopic {
    MNS_TOPIC_EVENT = 1,    /* state, what, text                                                   */
    MNS_TOPIC_LOG = 2,      /* level, text                                                         */
    MNS_TOPIC_PROGRESS = 4, /* state, fraction, eta_s, steps_per_second, time_step, end_time       */
    MNS_TOPIC_PROBE = 8,    /* values                                                              */
    MNS_TOPIC_ALL = 15
} MnsTopic;

/** One message. Strings are never NULL; numbers of other topics are NAN. */
typedef struct MnsTelemetry {
    MnsTopic topic;
    uint64_t daemon_epoch, sequence, step;
    uint64_t lost; /* messages of this topic that were lost just before this one */
    double time;   /* simulated [s] */
    MnsState state;
    const char *what, *text;
    unsigned level; /* as in syslog */
    double fraction, eta_s, steps_per_second, time_step, end_time;
    size_t n_values;
    const MnsValue *values;
} MnsTelemetry;

/** Begin to listen. @param topics  bits of MnsTopic; further calls add topics. */
MnsStatus mns_client_subscribe(MnsClient *client, unsigned topics, MnsError *error);

/** Next message.
 *  @param timeout_s      [s]; negative: no limit
 *  @param ret_telemetry  yours, until mns_telemetry_free()
 *  @return MNS_OK; MNS_E_TIMEOUT if none came; MNS_E_INTERRUPTED by a signal; MNS_E_STATE if nothing is subscribed;
 *          MNS_E_CORRUPT if a message cannot be read. */
MnsStatus mns_client_next(MnsClient *client, double timeout_s, MnsTelemetry **ret_telemetry, MnsError *error);

/** Free a message; NULL is fine. */
void mns_telemetry_free(MnsTelemetry *telemetry);

#ifdef __cplusplus
}
#endif
#endif
