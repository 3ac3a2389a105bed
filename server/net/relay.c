/* SPDX-License-Identifier: BSD-3-Clause */
/* Those from afar, and their connections to the daemon. */
#include "net/relay.h"

#include "base/clock.h"
#include "common/wire/frame.h"
#include "net/far.h"
#include "net/flight.h"
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

enum { IDENTITY = 256, AT_ONCE = 256, ROUNDS = 16, REQUESTS_WAITING = 100, FAREWELL_MS = 300 };

/* Bytes of requests of one client that the daemon has not taken; and of all that is on its way out, beyond which each may have one message. */
enum { UPWARD_MOST = 8 << 20, OUTWARD_MOST = 64 << 20 };

/* What a client has sent may still come when it is known to have gone. */
static const double LINGERING = 0.05; /* [s] */

typedef struct Client {
    Relay *relay;
    uint8_t identity[IDENTITY]; /* of its connection to us */
    size_t size;
    char key[KEY_TEXT]; /* public */
    int fd;             /* the same, of the operating system      */
    Who who;            /* whose it is, as its key said when it came */
    void *daemon;       /* its connection there: a DEALER         */
    Flight *in, *out;
    bool shut;   /* there is no room: it is not looked at   */
    double gone; /* clock_now() when it went; 0: it is here */
} Client;

struct Relay {
    RelayOptions options;
    void *socket; /* ROUTER */
    Links links;
    size_t n, asked; /* asked: of whom relay_items() has written, in order */
    Client *clients[RELAY_CLIENTS], *waited[RELAY_CLIENTS];
    _Atomic size_t outward; /* bytes on their way to all        */
    _Atomic bool shut;      /* somebody waits for room          */
    int wake;               /* eventfd: there is some           */
    bool departing;         /* somebody has gone                */
};

/* --- parcels -------------------------------------------------------------------------------------------------------------- */

/* A frame on its way. */
typedef struct Parcel {
    zmq_msg_t frame; /* as it came, whose bytes go on without a copy */
    Flight *flight;
    Relay *relay;        /* NULL: it goes to the daemon */
    _Atomic size_t size; /* written last and read first, as ZeroMQ hands it over unseen by race detectors */
} Parcel;

static void let_go(void *data, void *hint)
{
    (void)data;
    Parcel *parcel = hint;
    const size_t size = parcel->size;
    Relay *relay = parcel->relay;
    zmq_msg_close(&parcel->frame);
    flight_end(parcel->flight, size);
    if (relay) {
        relay->outward -= size;
        if (atomic_exchange(&relay->shut, false)) eventfd_write(relay->wake, 1);
    }
    free(parcel);
}

/* The frame itself becomes the parcel's. False if there is no memory: then it goes uncounted. */
static bool wrap(Flight *flight, Relay *relay, zmq_msg_t *frame)
{
    Parcel *parcel = malloc(sizeof *parcel);
    if (!parcel) return false;
    const size_t size = zmq_msg_size(frame) + sizeof *parcel;
    zmq_msg_init(&parcel->frame);
    zmq_msg_move(&parcel->frame, frame);
    zmq_msg_close(frame);
    if (zmq_msg_init_data(frame, zmq_msg_data(&parcel->frame), zmq_msg_size(&parcel->frame), let_go, parcel)) {
        zmq_msg_init(frame);
        zmq_msg_move(frame, &parcel->frame);
        free(parcel);
        return false;
    }
    parcel->flight = flight;
    parcel->relay = relay;
    flight_begin(flight, size);
    if (relay) relay->outward += size;
    parcel->size = size;
    return true;
}

/* The frame is taken over, whatever becomes of it. */
static bool send_on(void *socket, Flight *flight, Relay *relay, zmq_msg_t *frame, bool more)
{
    wrap(flight, relay, frame);
    const bool sent = zmq_msg_send(frame, socket, ZMQ_DONTWAIT | (more ? ZMQ_SNDMORE : 0)) >= 0;
    if (!sent) zmq_msg_close(frame);
    return sent;
}

/* --- clients -------------------------------------------------------------------------------------------------------------- */

static void set(void *socket, int option, int value)
{
    zmq_setsockopt(socket, option, &value, sizeof value);
}

static void leave(Client *client)
{
    Relay *relay = client->relay;
    size_t k = 0;
    while (relay->clients[k] != client) k++;
    relay->clients[k] = relay->clients[--relay->n];
    zmq_close(client->daemon);
    flight_leave(client->in);
    flight_leave(client->out);
    free(client);
}

/* Its connection to us has ended. */
static void note_gone(void *user)
{
    Client *client = user;
    client->gone = clock_now();
    client->relay->departing = true;
}

static void show_out(Client *client)
{
    if (client->gone == 0) links_show_out(&client->relay->links, client->fd);
}

/* A connection to the daemon, as who has this key. It breaks only where one of the two ends, so nobody asks whether the other is there. */
static void *connect_daemon(const Relay *relay, const char *key)
{
    void *socket = zmq_socket(relay->options.context, ZMQ_DEALER);
    if (!socket) return NULL;
    set(socket, ZMQ_LINGER, FAREWELL_MS);
    set(socket, ZMQ_SNDHWM, 0);
    set(socket, ZMQ_RCVHWM, relay->options.ahead);
    access_introduce(socket, key);
    zmq_setsockopt(socket, ZMQ_AFFINITY, &relay->options.threads, sizeof relay->options.threads);
    if (!zmq_connect(socket, relay->options.daemon)) return socket;
    zmq_close(socket);
    return NULL;
}

/* A quarter of the places is for those who may steer: however many look on, the run can be stopped. And one key does not take them all. */
static MnsStatus check_place(const Relay *relay, const Who *who, MnsError *error)
{
    const size_t most = relay->options.most;
    const bool looks = quota_pool(who) == POOL_VIEWERS;
    QuotaUse use = {0};
    for (size_t k = 0; k < relay->n; k++)
        if (relay->clients[k]->gone == 0) quota_count(&use, who, &relay->clients[k]->who);
    const MnsStatus status = quota_check(relay->options.quota, who, &use, error);
    if (status || (relay->n < most && (!looks || use.pool < most - most / 4))) return status;
    return mns_fail(error, MNS_E_LIMIT,
                    "clients with a key have %zu connections here, and the daemon takes no more of %s; close one, or "
                    "raise its limit on open files (`ulimit -n`, LimitNOFILE=)",
                    relay->n, looks ? "viewers" : "them");
}

/* --- refusals ------------------------------------------------------------------------------------------------------------- */

static void *pack(const ProtobufCMessage *message, size_t *ret_size)
{
    *ret_size = protobuf_c_message_get_packed_size(message);
    uint8_t *packed = malloc(*ret_size);
    if (packed) protobuf_c_message_pack(message, packed);
    return packed;
}

/* Replies of both protocols have these fields. */
#define SAY_WHY(reply, of, why)                                                                                        \
    do {                                                                                                               \
        (reply).has_id = (of).len > 0;                                                                                 \
        (reply).id = (of);                                                                                             \
        (reply).has_code = true;                                                                                       \
        (reply).code = code_of((why)->status);                                                                         \
        (reply).message = (char *)(why)->text;                                                                         \
        (reply).reason = (char *)mns_status_name((why)->status);                                                       \
    } while (0)

static void *pack_reply(ProtobufCBinaryData id, const MnsError *why, size_t *ret_size)
{
    Meniscus__Reply reply = MENISCUS__REPLY__INIT;
    SAY_WHY(reply, id, why);
    return pack(&reply.base, ret_size);
}

static void *pack_stream_reply(ProtobufCBinaryData id, const MnsError *why, size_t *ret_size)
{
    Meniscus__StreamMessage message = MENISCUS__STREAM_MESSAGE__INIT;
    Meniscus__StreamReply reply = MENISCUS__STREAM_REPLY__INIT;
    SAY_WHY(reply, id, why);
    message.what_case = MENISCUS__STREAM_MESSAGE__WHAT_REPLY;
    message.reply = &reply;
    return pack(&message.base, ret_size);
}

/* A connection for which there is no place: its first request is answered, and a moment later it ends. Without a word the client would take the daemon for one that
 * hangs. */
static void refuse(Relay *relay, zmq_msg_t *identity, int fd, zmq_msg_t *frame, const MnsError *why)
{
    const Link *link = links_find(&relay->links, fd);
    if (!link || link->refused > 0) return;
    size_t size;
    const ProtobufCBinaryData id = request_id(zmq_msg_data(frame), zmq_msg_size(frame));
    void *packed = (relay->options.quota == QUOTA_DATA ? pack_stream_reply : pack_reply)(id, why, &size);
    if (packed &&
        zmq_send(relay->socket, zmq_msg_data(identity), zmq_msg_size(identity), ZMQ_SNDMORE | ZMQ_DONTWAIT) >= 0)
        zmq_send(relay->socket, packed, size, ZMQ_DONTWAIT);
    free(packed);
    links_refuse(&relay->links, fd);
}

/* --- those who come ------------------------------------------------------------------------------------------------------- */

/* NULL if there is no memory. */
static Client *new_client(Relay *relay, zmq_msg_t *identity, const char *key, const Who *who)
{
    if (zmq_msg_size(identity) > IDENTITY || strlen(key) >= KEY_TEXT) return NULL;
    Client *client = calloc(1, sizeof *client);
    if (!client) return NULL;
    *client = (Client){
        .relay = relay, .fd = -1, .who = *who, .in = flight_new(), .out = flight_new(), .size = zmq_msg_size(identity)};
    memcpy(client->identity, zmq_msg_data(identity), client->size);
    memcpy(client->key, key, strlen(key) + 1);
    client->daemon = client->in && client->out ? connect_daemon(relay, key) : NULL;
    relay->clients[relay->n++] = client;
    if (client->daemon) return client;
    relay->n--;
    flight_leave(client->in);
    flight_leave(client->out);
    free(client);
    return NULL;
}

/* A name is anybody's who takes it, and may be taken again when whoever had it has just gone: so the connection must be the same, and the key. */
static bool is_from(const Client *client, zmq_msg_t *identity, int fd, const char *key)
{
    const size_t size = zmq_msg_size(identity);
    if (client->fd != fd || client->size != size || memcmp(client->identity, zmq_msg_data(identity), size))
        return false;
    return !strcmp(client->key, key) && (client->gone == 0 || !links_find(&client->relay->links, fd));
}

static Client *find(const Relay *relay, zmq_msg_t *identity, int fd, const char *key)
{
    for (size_t k = 0; k < relay->n; k++)
        if (is_from(relay->clients[k], identity, fd, key)) return relay->clients[k];
    return NULL;
}

/* Whose first message this is. All that was told before it came is noted first, as another may have had the same descriptor. */
static Client *welcome(Relay *relay, zmq_msg_t *identity, int fd, const char *key, zmq_msg_t *frame)
{
    Who who = {.role = ROLE_NONE}; /* the key may be gone since */
    links_note(&relay->links);
    Link *link = links_find(&relay->links, fd);
    const bool known = access_who(relay->options.access, frame, &who);
    MnsError why;
    if (known && check_place(relay, &who, &why)) {
        refuse(relay, identity, fd, frame, &why);
        return NULL;
    }
    Client *client = known && !(link && link->refused > 0) ? new_client(relay, identity, key, &who) : NULL;
    if (!client) {
        links_show_out(&relay->links, fd);
        return NULL;
    }
    client->fd = fd;
    if (link && !link->user) link->user = client;
    else note_gone(client); /* it has gone already */
    return client;
}

static void see_off(Relay *relay)
{
    const double now = clock_now();
    relay->departing = false;
    for (size_t k = relay->n; k-- > 0;) {
        Client *client = relay->clients[k];
        if (client->gone == 0) continue;
        if (now > client->gone + LINGERING) leave(client);
        else relay->departing = true;
    }
}

/* --- in ------------------------------------------------------------------------------------------------------------------- */

/* A request is one frame. Of more the daemon is told that there are, and it has a sentence for that. */
static void bring(Client *client, zmq_msg_t *frame, bool more)
{
    const Relay *relay = client->relay;
    zmq_msg_t rest;
    if (zmq_msg_size(frame) > relay->options.largest || client->in->bytes > UPWARD_MOST) {
        show_out(client);
        return;
    }
    const bool begun = send_on(client->daemon, client->in, NULL, frame, more);
    zmq_msg_init(frame);
    if (!begun || !more) return;
    zmq_msg_init(&rest);
    zmq_msg_send(&rest, client->daemon, ZMQ_DONTWAIT);
}

/* Take a message: who it is from, and its parts, of which all but the first are dropped. False if there is none. */
static bool take(Relay *relay)
{
    zmq_msg_t identity, first, rest;
    zmq_msg_init(&identity);
    if (zmq_msg_recv(&identity, relay->socket, ZMQ_DONTWAIT) < 0) return false;
    zmq_msg_init(&first);
    const bool any = zmq_msg_more(&identity) && zmq_msg_recv(&first, relay->socket, ZMQ_DONTWAIT) >= 0;
    const bool parts = any && zmq_msg_more(&first);
    for (bool more = parts; more; zmq_msg_close(&rest)) {
        zmq_msg_init(&rest);
        more = zmq_msg_recv(&rest, relay->socket, ZMQ_DONTWAIT) >= 0 && zmq_msg_more(&rest);
    }
    const int fd = any ? zmq_msg_get(&first, ZMQ_SRCFD) : -1;
    const char *key = any ? zmq_msg_gets(&first, "User-Id") : NULL;
    Client *client = key ? find(relay, &identity, fd, key) : NULL;
    if (key && !client) client = welcome(relay, &identity, fd, key, &first);
    if (client) {
        links_took(&relay->links, fd);
        bring(client, &first, parts);
    }
    zmq_msg_close(&first);
    zmq_msg_close(&identity);
    return true;
}

/* --- out ------------------------------------------------------------------------------------------------------------------ */

static bool has_room(Client *client)
{
    const size_t own = client->out->bytes;
    return !own || (own < client->relay->options.window && client->relay->outward < OUTWARD_MOST);
}

/* Carry a message to the client. False if there is none, or no room. It is whole when its first frame is there. */
static bool carry(Client *client)
{
    Relay *relay = client->relay;
    zmq_msg_t frame;
    client->shut = !has_room(client);
    if (client->shut) return false;
    zmq_msg_init(&frame);
    if (zmq_msg_recv(&frame, client->daemon, ZMQ_DONTWAIT) < 0) return false;
    bool here = zmq_send(relay->socket, client->identity, client->size, ZMQ_SNDMORE | ZMQ_DONTWAIT) >= 0;
    for (bool more = true; more;) {
        more = zmq_msg_more(&frame);
        if (here) here = send_on(relay->socket, client->out, relay, &frame, more);
        else zmq_msg_close(&frame);
        if (!more) break;
        zmq_msg_init(&frame);
        more = zmq_msg_recv(&frame, client->daemon, ZMQ_DONTWAIT) >= 0;
    }
    return true;
}

/* --- turns ---------------------------------------------------------------------------------------------------------------- */

size_t relay_items(Relay *relay, zmq_pollitem_t *ret)
{
    size_t n = 0;
    ret[n++] = (zmq_pollitem_t){.socket = relay->socket, .events = ZMQ_POLLIN};
    ret[n++] = (zmq_pollitem_t){.socket = relay->links.monitor, .events = ZMQ_POLLIN};
    ret[n++] = (zmq_pollitem_t){.fd = relay->wake, .events = ZMQ_POLLIN};
    relay->asked = 0;
    for (size_t k = 0; k < relay->n; k++) {
        Client *client = relay->clients[k];
        if (client->gone != 0) continue;      /* another may have its name now */
        if (client->shut) relay->shut = true; /* from now on whoever makes room tells */
        if (client->shut && !has_room(client)) continue;
        relay->waited[relay->asked++] = client;
        ret[n++] = (zmq_pollitem_t){.socket = client->daemon, .events = ZMQ_POLLIN};
    }
    return n;
}

bool relay_turn(Relay *relay, const zmq_pollitem_t *items)
{
    eventfd_t count;
    int taken = 0;
    bool more = false;
    if (items[2].revents) eventfd_read(relay->wake, &count);
    for (size_t k = 0; k < relay->asked; k++) {
        int carried = 0;
        if (items[3 + k].revents)
            while (carried < ROUNDS && carry(relay->waited[k])) carried++;
        more |= carried == ROUNDS;
    }
    while (taken < AT_ONCE && take(relay)) taken++;
    links_note(&relay->links);
    if (relay->departing && taken < AT_ONCE) see_off(relay);
    return more || taken == AT_ONCE;
}

bool relay_is_busy(const Relay *relay)
{
    return relay->departing;
}

Links *relay_links(Relay *relay)
{
    return &relay->links;
}

/* --- beginning and end ---------------------------------------------------------------------------------------------------- */

static MnsStatus open_socket(Relay *relay, MnsError *error)
{
    const RelayOptions *options = &relay->options;
    const int64_t largest = (int64_t)options->largest;
    void *socket = relay->socket = zmq_socket(options->context, ZMQ_ROUTER);
    if (!socket || relay->wake < 0)
        return mns_fail(error, MNS_E_MEMORY, "cannot make a socket for those from afar: %m");
    set(socket, ZMQ_LINGER, 0);
    set(socket, ZMQ_HEARTBEAT_IVL, 2000);
    set(socket, ZMQ_HEARTBEAT_TIMEOUT, 6000);
    set(socket, ZMQ_ROUTER_MANDATORY, 1);
    set(socket, ZMQ_SNDHWM, 0);
    set(socket, ZMQ_RCVHWM, REQUESTS_WAITING);
    zmq_setsockopt(socket, ZMQ_MAXMSGSIZE, &largest, sizeof largest);
    zmq_setsockopt(socket, ZMQ_AFFINITY, &options->threads, sizeof options->threads);
    const MnsStatus status = links_init(&relay->links, options->context, socket, options->monitor, note_gone, error);
    if (status || far_take(options->access, socket, options->fd)) return status;
    return mns_fail(error, MNS_E_IO, "cannot take connections from afar: %s", zmq_strerror(zmq_errno()));
}

MnsStatus relay_new(const RelayOptions *options, Relay **ret, MnsError *error)
{
    Relay *relay = calloc(1, sizeof *relay);
    if (!relay) return mns_fail(error, MNS_E_MEMORY, "no memory for those from afar");
    relay->options = *options;
    relay->wake = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    *ret = relay;
    return open_socket(relay, error);
}

void relay_close(Relay *relay, int linger)
{
    if (!relay) return;
    while (relay->n) {
        set(relay->clients[0]->daemon, ZMQ_LINGER, 0);
        leave(relay->clients[0]);
    }
    links_done(&relay->links);
    if (!relay->socket) return;
    set(relay->socket, ZMQ_LINGER, linger);
    zmq_close(relay->socket);
}

void relay_free(Relay *relay)
{
    if (!relay) return;
    if (relay->wake >= 0) close(relay->wake);
    free(relay);
}
