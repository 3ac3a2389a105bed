/* SPDX-License-Identifier: BSD-3-Clause */
/* Replies on their way out. */
#include "net/outgoing.h"

#include "base/log.h"
#include "common/wire/frame.h"
#include "run/quota.h"
#include <assert.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <zmq.h>

/* --- the reply in reserve ---------------------------------------------------------------------------------------------- */

enum { ID_AT = 2, ID_END = ID_AT + ORDER_ID }; /* the first field, with its tag and length before it */

/* Made while there is memory for certain. Fields are packed by their numbers: the id, the code, then words. */
void outgoing_init(Outgoing *out, void *socket, uint64_t epoch)
{
    static uint8_t id[ORDER_ID];
    Meniscus__Reply reply = MENISCUS__REPLY__INIT;
    *out = (Outgoing){.socket = socket};
    reply.has_id = reply.has_code = true;
    reply.id = (ProtobufCBinaryData){.len = ORDER_ID, .data = id};
    reply.code = code_of(MNS_E_MEMORY);
    out->brief_size = meniscus__reply__get_packed_size(&reply);
    reply.message = (char *)"there is no memory for the answer; the status tells what has been done";
    reply.reason = (char *)mns_status_name(MNS_E_MEMORY);
    reply.has_daemon_epoch = true;
    reply.daemon_epoch = epoch;
    out->excuse_size = meniscus__reply__get_packed_size(&reply);
    assert(out->excuse_size <= sizeof out->excuse);
    meniscus__reply__pack(&reply, out->excuse);
}

/* ZeroMQ keeps up to 33 bytes in the message itself: id and code go out even where there is no memory for the words. */
static void excuse(Outgoing *out, const Recipient *to)
{
    zmq_msg_t message;
    const size_t from = to->id ? 0 : ID_END;
    size_t size = out->excuse_size - from;
    if (zmq_msg_init_size(&message, size) && zmq_msg_init_size(&message, size = out->brief_size - from)) return;
    uint8_t *data = zmq_msg_data(&message);
    memcpy(data, out->excuse + from, size);
    if (to->id) memcpy(data + ID_AT, to->id, ORDER_ID);
    if (zmq_send(out->socket, to->identity, to->identity_size, ZMQ_SNDMORE | ZMQ_DONTWAIT) < 0 ||
        zmq_msg_send(&message, out->socket, ZMQ_DONTWAIT) < 0)
        zmq_msg_close(&message);
}

/* --- what is unread ----------------------------------------------------------------------------------------------------- */

/* Parcels have its address, so it stays as long as the socket. */
struct OutgoingAccount {
    OutgoingAccount *next;
    uint8_t identity[EXCHANGE_IDENTITY]; /* of a connection */
    size_t identity_size;
    Who who;
    _Atomic size_t unread; /* [bytes] */
};

void outgoing_done(Outgoing *out)
{
    while (out->accounts) {
        OutgoingAccount *account = out->accounts;
        out->accounts = account->next;
        free(account);
    }
}

size_t outgoing_unread(const Outgoing *out)
{
    size_t sum = 0;
    for (const OutgoingAccount *account = out->accounts; account; account = account->next) sum += account->unread;
    return sum;
}

static bool is_of(const OutgoingAccount *account, const Recipient *to)
{
    return account->identity_size == to->identity_size && !memcmp(account->identity, to->identity, to->identity_size);
}

/* NULL: there is no memory. */
static OutgoingAccount *account_of(Outgoing *out, const Recipient *to)
{
    OutgoingAccount *unused = NULL;
    for (OutgoingAccount *account = out->accounts; account; account = account->next) {
        if (is_of(account, to)) return account;
        if (!account->unread) unused = account;
    }
    OutgoingAccount *account = unused ? unused : calloc(1, sizeof *account);
    if (!account) return NULL;
    if (!unused) {
        account->next = out->accounts;
        out->accounts = account;
    }
    memcpy(account->identity, to->identity, to->identity_size);
    account->identity_size = to->identity_size;
    account->who = *to->who;
    return account;
}

/* Bytes that have not been read: over one connection, by its key, by the pool of that. */
typedef struct Unread {
    size_t here, own, pool;
} Unread;

static Unread unread_of(const Outgoing *out, const Recipient *to)
{
    Unread sum = {0};
    for (const OutgoingAccount *account = out->accounts; account; account = account->next) {
        const size_t n = account->unread;
        if (is_of(account, to)) sum.here += n;
        if (quota_same(&account->who, to->who)) sum.own += n;
        if (quota_pool(&account->who) == quota_pool(to->who)) sum.pool += n;
    }
    return sum;
}

enum { MIB = 20 };

MnsStatus outgoing_check(const Outgoing *out, const Recipient *to, MnsError *error)
{
    const Unread unread = unread_of(out, to);
    const QuotaUse use = {.own = unread.own >> MIB, .pool = unread.pool >> MIB};
    if (unread.here < OUTGOING_UNREAD) return quota_check(QUOTA_UNREAD, to->who, &use, error);
    return mns_fail(error, MNS_E_LIMIT,
                    "this connection has %zu MiB of replies that are not read, and one has no more than %d; read them, "
                    "or wait",
                    unread.here >> MIB, OUTGOING_UNREAD >> MIB);
}

/* For a small reply, which may be that nothing more is sent. */
static bool has_room(const Outgoing *out, const Recipient *to)
{
    const Unread unread = unread_of(out, to);
    return unread.here < 2 * (size_t)OUTGOING_UNREAD &&
           unread.pool >> MIB < 2 * quota_all(QUOTA_UNREAD, quota_pool(to->who));
}

/* --- parcels ----------------------------------------------------------------------------------------------------------- */

/* A raw frame on its way, to be counted until ZeroMQ lets go of it, on its own thread. The size is written last and read
 * first, so that what is handed over is in order for race detectors too, which do not see into ZeroMQ. */
typedef struct Parcel {
    OutgoingAccount *account;
    _Atomic size_t size;
} Parcel;

static void let_go(void *data, void *hint)
{
    Parcel *parcel = hint;
    const size_t size = parcel->size;
    parcel->account->unread -= size;
    free(parcel);
    free(data);
}

/* Takes over data, if there is memory for the parcel. */
static bool wrap(OutgoingAccount *account, void *data, size_t size, zmq_msg_t *ret)
{
    Parcel *parcel = account && data ? malloc(sizeof *parcel) : NULL;
    if (!parcel || zmq_msg_init_data(ret, data, size, let_go, parcel)) {
        free(parcel);
        return false;
    }
    parcel->account = account;
    account->unread += size;
    parcel->size = size;
    return true;
}

/* A message that is begun must be ended, or the next one would be taken for the rest of it: so all is wrapped before. */
bool outgoing_send(Outgoing *out, const Recipient *to, size_t n, void *const parts[], const size_t sizes[])
{
    zmq_msg_t messages[OUTGOING_PARTS];
    size_t wrapped = 0;
    const bool room = has_room(out, to);
    OutgoingAccount *account = account_of(out, to);
    assert(n > 0 && n <= OUTGOING_PARTS);
    while (wrapped < n && wrap(account, parts[wrapped], sizes[wrapped], &messages[wrapped])) wrapped++;
    for (size_t k = wrapped; k < n; k++) free(parts[k]);
    const bool whole = wrapped == n;
    const bool begun =
        whole && room && zmq_send(out->socket, to->identity, to->identity_size, ZMQ_SNDMORE | ZMQ_DONTWAIT) >= 0;
    const int why = whole && room && !begun ? zmq_errno() : 0;
    if (whole && !begun)
        log_line(LOG_DETAIL, "a reply is not sent: %s", room ? zmq_strerror(why) : "too much is unread");
    for (size_t k = 0; k < wrapped; k++)
        if (!begun || zmq_msg_send(&messages[k], out->socket, ZMQ_DONTWAIT | (k + 1 < n ? ZMQ_SNDMORE : 0)) < 0)
            zmq_msg_close(&messages[k]);
    if (!whole && room) excuse(out, to);
    return why == EHOSTUNREACH;
}
