/* SPDX-License-Identifier: BSD-3-Clause */
/* The gate, from within: three sockets for those from afar, a door, and what lies behind it in another process. */
#include "net/gate_keeper.h"

#include "base/clock.h"
#include "base/log.h"
#include "common/wire/frame.h"
#include "net/crowd.h"
#include "net/far.h"
#include "net/gate.h"
#include "net/relay.h"
#include "net/visitors.h"
#include <errno.h>
#include <meniscus/exit.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

enum { LEVEL = 2, KEYS, CONTROL, TELEMETRY, DATA };

enum { SUBSCRIPTION = 256, LINGER_MS = 200, SUBSCRIPTIONS_AT_ONCE = 256, SUBSCRIPTIONS_EACH = 64 };
enum { TAKERS = 256 };                     /* of data: three MiB each, where they take nothing, fit into the memory */
enum { NEAR_THREAD = 1, DATA_THREAD = 2 }; /* of ZeroMQ: so those who take data keep nobody from steering */

#ifndef MENISCUS_SANITIZED
static const size_t RESIDENT_MOST = (size_t)1 << 30;
#endif

static const double WATCH = 0.2;   /* [s] between two looks at what has no end */
static const double TELL = 0.02;   /* [s] between two news */
static const double LEAVING = 0.1; /* [s] in which nothing more has come: all is carried */

/* Each has three descriptors here and one in the daemon, of as many, which needs some for its files. */
static size_t fit(size_t clients)
{
    const size_t most = (size_t)far_descriptors() / 8;
    return clients < most ? clients : most;
}

typedef struct Keeper {
    void *context, *listeners, *daemon; /* XPUB for those from afar, XSUB to the daemon */
    Access *access;
    Relay *control, *data;
    Links links; /* of the listeners */
    GateNews told;
    double watched, moved, told_at;
    bool leaving, news; /* news: what is true is not what was told last */
} Keeper;

bool gate_keeper_is(int argc, char **argv)
{
    return argc == GATE_WORDS && !strcmp(argv[1], GATE_WORD);
}

/* --- telemetry ------------------------------------------------------------------------------------------------------------ */

static void set(void *socket, int option, int value)
{
    zmq_setsockopt(socket, option, &value, sizeof value);
}

/* A connection that has subscribed, and to how much. */
typedef struct Listener {
    Who who;
    unsigned topics;
} Listener;

static void forget_listener(void *user)
{
    free(user);
}

static MnsStatus open_telemetry(Keeper *keeper, const char *daemon, MnsError *error)
{
    const int64_t largest = SUBSCRIPTION;
    const uint64_t thread = NEAR_THREAD;
    void *listeners = keeper->listeners = zmq_socket(keeper->context, ZMQ_XPUB);
    keeper->daemon = zmq_socket(keeper->context, ZMQ_XSUB);
    if (!listeners || !keeper->daemon)
        return mns_fail(error, MNS_E_MEMORY, "cannot make sockets: %s", zmq_strerror(zmq_errno()));
    set(listeners, ZMQ_LINGER, 0);
    set(listeners, ZMQ_HEARTBEAT_IVL, 8000);
    set(listeners, ZMQ_HEARTBEAT_TIMEOUT, 24000);
    set(listeners, ZMQ_XPUB_VERBOSER, 1);
    zmq_setsockopt(listeners, ZMQ_MAXMSGSIZE, &largest, sizeof largest);
    zmq_setsockopt(listeners, ZMQ_AFFINITY, &thread, sizeof thread);
    set(keeper->daemon, ZMQ_LINGER, 0);
    zmq_setsockopt(keeper->daemon, ZMQ_AFFINITY, &thread, sizeof thread);
    const MnsStatus status =
        links_init(&keeper->links, keeper->context, listeners, "inproc://listeners", forget_listener, error);
    if (status) return status;
    if (!far_take(keeper->access, listeners, GATE_TELEMETRY) || zmq_connect(keeper->daemon, daemon) ||
        zmq_send(keeper->daemon, "\1", 1, 0) < 0)
        return mns_fail(error, MNS_E_IO, "cannot carry telemetry: %s", zmq_strerror(zmq_errno()));
    return MNS_OK;
}

/* NULL if its key has as many connections as it may, or there is no memory. */
static Listener *new_listener(const Links *links, const Who *who)
{
    QuotaUse use = {0};
    for (int fd = 0; fd < links->end; fd++) {
        const Listener *other = links->links[fd].open ? links->links[fd].user : NULL;
        if (other) quota_count(&use, who, &other->who);
    }
    Listener *listener = quota_check(QUOTA_TELEMETRY, who, &use, NULL) ? NULL : calloc(1, sizeof *listener);
    if (listener) listener->who = *who;
    return listener;
}

/* Take note of who subscribes, or does no longer. False if that is more than a key or a connection may have. */
static bool note_subscription(Keeper *keeper, zmq_msg_t *frame, bool begins)
{
    Who who;
    links_note(&keeper->links); /* another connection may have had its descriptor */
    Link *link = links_find(&keeper->links, zmq_msg_get(frame, ZMQ_SRCFD));
    if (!link) return true; /* it has gone already */
    if (!link->user && access_who(keeper->access, frame, &who)) link->user = new_listener(&keeper->links, &who);
    Listener *listener = link->user;
    if (!listener) return false;
    if (begins) listener->topics++;
    else listener->topics -= listener->topics > 0;
    return listener->topics <= SUBSCRIPTIONS_EACH;
}

/* The daemon publishes each message once, for all who listen from afar. Of who subscribes it is told by a word that is no subscription, so that whatever
 * is subscribed to lies in our memory and not in the daemon's. */
static bool take_subscription(Keeper *keeper)
{
    zmq_msg_t frame;
    zmq_msg_init(&frame);
    if (zmq_msg_recv(&frame, keeper->listeners, ZMQ_DONTWAIT) < 0) return false;
    uint8_t *data = zmq_msg_data(&frame);
    links_took(&keeper->links, zmq_msg_get(&frame, ZMQ_SRCFD));
    const bool known = zmq_msg_size(&frame) && zmq_msg_size(&frame) <= SUBSCRIPTION && data[0] <= 1;
    if (known && !note_subscription(keeper, &frame, data[0] == 1))
        links_show_out(&keeper->links, zmq_msg_get(&frame, ZMQ_SRCFD));
    else if (known && data[0] == 1) {
        data[0] = GATE_LISTENER;
        zmq_send(keeper->daemon, data, zmq_msg_size(&frame), ZMQ_DONTWAIT);
    }
    zmq_msg_close(&frame);
    return true;
}

static bool publish(Keeper *keeper)
{
    zmq_msg_t frame;
    zmq_msg_init(&frame);
    if (zmq_msg_recv(&frame, keeper->daemon, ZMQ_DONTWAIT) < 0) return false;
    for (bool more = true; more;) {
        more = zmq_msg_more(&frame);
        if (zmq_msg_send(&frame, keeper->listeners, ZMQ_DONTWAIT | (more ? ZMQ_SNDMORE : 0)) < 0) zmq_msg_close(&frame);
        if (!more) break;
        zmq_msg_init(&frame);
        more = zmq_msg_recv(&frame, keeper->daemon, ZMQ_DONTWAIT) >= 0;
    }
    return true;
}

static bool turn_telemetry(Keeper *keeper)
{
    int n = 0, m = 0;
    while (n < SUBSCRIPTIONS_AT_ONCE && take_subscription(keeper)) n++;
    while (m < SUBSCRIPTIONS_AT_ONCE && publish(keeper)) m++;
    links_note(&keeper->links);
    return n + m > 0;
}

/* --- turns ---------------------------------------------------------------------------------------------------------------- */

/* Not each by itself, as there may be thousands in a second; without any, as a sign of life. A line that is full will be empty, and the news are always
 * of all. */
static void tell(Keeper *keeper, double now)
{
    const Links *control = relay_links(keeper->control), *data = relay_links(keeper->data);
    GateNews news = {.listeners = keeper->links.n,
                     .shown_out = control->shown_out + data->shown_out + keeper->links.shown_out};
    memcpy(news.failures, control->failed, sizeof news.failures);
    keeper->news = memcmp(&news, &keeper->told, sizeof news) != 0;
    if (now < keeper->told_at + (keeper->news ? TELL : GATE_SIGN)) return;
    keeper->told_at = now;
    if (send(GATE_LINE, &news, sizeof news, MSG_DONTWAIT | MSG_NOSIGNAL) != sizeof news) return;
    keeper->told = news;
    keeper->news = false;
}

#ifndef MENISCUS_SANITIZED
/* Bytes of memory that it really has. */
static size_t resident(void)
{
    unsigned long all, pages = 0;
    FILE *file = fopen("/proc/self/statm", "re");
    if (!file) return 0;
    if (fscanf(file, "%lu %lu", &all, &pages) != 2) pages = 0;
    fclose(file);
    return (size_t)pages * (size_t)sysconf(_SC_PAGESIZE);
}
#endif

/* Whatever fills it: another one begins with none, and everybody with a key comes back. */
static void watch_memory(void)
{
#ifndef MENISCUS_SANITIZED
    const size_t now = resident();
    if (now <= RESIDENT_MOST) return;
    log_line(LOG_ERROR, "the gate for those from afar holds %zu MiB, more than it may; it begins anew", now >> 20);
    _exit(MNS_EXIT_FAILED);
#endif
}

static void watch(Keeper *keeper, double now)
{
    const double passed = now - keeper->watched;
    if (passed < WATCH) return;
    keeper->watched = now;
    links_watch(relay_links(keeper->control), passed);
    links_watch(relay_links(keeper->data), passed);
    links_watch(&keeper->links, passed);
    watch_memory();
}

/* Milliseconds for which there is nothing to do, whatever comes. */
static long patience(const Keeper *keeper, bool more)
{
    enum { SOON_MS = 20 };
    const bool anybody =
        relay_links(keeper->control)->n || relay_links(keeper->data)->n || keeper->links.n || keeper->leaving;
    if (more) return 0;
    if (relay_is_busy(keeper->control) || relay_is_busy(keeper->data) || keeper->leaving || keeper->news)
        return SOON_MS;
    return (long)(1e3 * (anybody ? WATCH : GATE_SIGN));
}

/* Nothing is ever written to the line by the daemon: what can be read is its end. */
static void look_at_line(Keeper *keeper, const zmq_pollitem_t *line)
{
    if (!line->revents || keeper->leaving) return;
    keeper->leaving = true;
    keeper->moved = clock_now();
}

static void answer_door(Keeper *keeper)
{
    do access_refresh(keeper->access);
    while (access_answer(keeper->access));
}

static bool moves(const zmq_pollitem_t *items, size_t n)
{
    for (size_t k = 0; k < n; k++)
        if (items[k].revents) return true;
    return false;
}

static void serve(Keeper *keeper)
{
    static zmq_pollitem_t items[6 + 2 * RELAY_ITEMS];
    bool more = false;
    while (!keeper->leaving || clock_now() < keeper->moved + LEAVING) {
        const int watched = access_watch(keeper->access);
        size_t n = 0;
        items[n++] = (zmq_pollitem_t){.socket = access_socket(keeper->access), .events = ZMQ_POLLIN};
        items[n++] = (zmq_pollitem_t){.socket = keeper->listeners, .events = ZMQ_POLLIN};
        items[n++] = (zmq_pollitem_t){.socket = keeper->daemon, .events = ZMQ_POLLIN};
        items[n++] = (zmq_pollitem_t){.socket = keeper->links.monitor, .events = ZMQ_POLLIN};
        zmq_pollitem_t *line = &items[n++], *control = &items[n + (watched >= 0)];
        *line = (zmq_pollitem_t){.fd = keeper->leaving ? -1 : GATE_LINE, .events = ZMQ_POLLIN};
        if (watched >= 0) items[n++] = (zmq_pollitem_t){.fd = watched, .events = ZMQ_POLLIN};
        n += relay_items(keeper->control, control);
        zmq_pollitem_t *data = &items[n];
        n += relay_items(keeper->data, data);
        if (zmq_poll(items, (int)n, patience(keeper, more)) < 0 && errno != EINTR) return;
        look_at_line(keeper, line);
        answer_door(keeper);
        more = relay_turn(keeper->control, control);
        more |= relay_turn(keeper->data, data);
        more |= turn_telemetry(keeper);
        const double now = clock_now();
        if (more || moves(control, n - (size_t)(control - items))) keeper->moved = now;
        watch(keeper, now);
        tell(keeper, now);
    }
}

/* --- beginning and end ---------------------------------------------------------------------------------------------------- */

/* What the system has noted of this process. */
static void write_own(const char *name, const char *value)
{
    char path[64];
    snprintf(path, sizeof path, "/proc/self/%s", name);
    FILE *file = fopen(path, "we");
    if (file) fputs(value, file);
    if (file) fclose(file);
}

/* Room for what it may hold, and for what is announced: ZeroMQ takes room for a frame of any size that is allowed, before it knows who sends it, and
 * ends the process where there is none. What is never sent takes none of the machine's memory. Where that ends, the gate goes first. Sanitizers
 * have shadows that take more. */
static void limit_memory(void)
{
#ifndef MENISCUS_SANITIZED
    const rlim_t most = RESIDENT_MOST + (rlim_t)far_descriptors() * 2 * (rlim_t)FRAME_TAKEN_FAR;
    setrlimit(RLIMIT_DATA, &(struct rlimit){most, most});
#endif
    write_own("oom_score_adj", "500");
}

/* The daemon ends it, and nobody else: service managers and terminals send their signals to both. What it holds in memory are keys, so there is
 * no picture of it on the disk. */
static void settle(void)
{
    static const int ignored[] = {SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGPIPE};
    for (size_t k = 0; k < sizeof ignored / sizeof *ignored; k++) signal(ignored[k], SIG_IGN);
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    write_own("comm", "gate");
    setrlimit(RLIMIT_CORE, &(struct rlimit){0, 0});
    limit_memory();
    crowd_begin(NULL, far_descriptors());
}

static MnsStatus begin(Keeper *keeper, char **argv, MnsError *error)
{
    keeper->context = zmq_ctx_new();
    if (!keeper->context) return mns_fail(error, MNS_E_MEMORY, "no memory for ZeroMQ");
    zmq_ctx_set(keeper->context, ZMQ_IO_THREADS, 2);
    zmq_ctx_set(keeper->context, ZMQ_MAX_SOCKETS, 4 * RELAY_CLIENTS);
    MnsStatus status = access_new(keeper->context, argv[KEYS], false, &keeper->access, error);
    const RelayOptions control = {.context = keeper->context,
                                  .access = keeper->access,
                                  .fd = GATE_CONTROL,
                                  .daemon = argv[CONTROL],
                                  .monitor = "inproc://control",
                                  .largest = FRAME_TAKEN_FAR,
                                  .most = fit(RELAY_CLIENTS),
                                  .quota = QUOTA_CONTROL,
                                  .window = 4 << 20,
                                  .ahead = 1,
                                  .threads = NEAR_THREAD};
    RelayOptions data = control;
    data.fd = GATE_DATA;
    data.daemon = argv[DATA];
    data.monitor = "inproc://data";
    data.largest = FRAME_STREAM_FAR;
    data.most = fit(TAKERS);
    data.quota = QUOTA_DATA;
    data.threads = DATA_THREAD;
    if (!status) status = relay_new(&control, &keeper->control, error);
    if (!status) status = relay_new(&data, &keeper->data, error);
    return status ? status : open_telemetry(keeper, argv[TELEMETRY], error);
}

static void finish(Keeper *keeper)
{
    relay_close(keeper->control, LINGER_MS);
    relay_close(keeper->data, LINGER_MS);
    for (int fd = 0; fd < keeper->links.end; fd++) free(keeper->links.links[fd].user);
    links_done(&keeper->links);
    if (keeper->daemon) zmq_close(keeper->daemon);
    if (keeper->listeners) set(keeper->listeners, ZMQ_LINGER, LINGER_MS);
    if (keeper->listeners) zmq_close(keeper->listeners);
    access_free(keeper->access);
    if (keeper->context) zmq_ctx_term(keeper->context);
    relay_free(keeper->control);
    relay_free(keeper->data);
}

/* As the command line of the daemon had them, which has checked them. */
static void take_quotas(void)
{
    char text[1024], *rest = NULL;
    const char *all = getenv(GATE_QUOTAS);
    snprintf(text, sizeof text, "%s", all ? all : "");
    for (char *one = strtok_r(text, " ", &rest); one; one = strtok_r(NULL, " ", &rest)) (void)quota_set(one, NULL);
}

int gate_keeper_run(char **argv)
{
    Keeper keeper = {.watched = 0};
    MnsError error;
    log_set_level((LogLevel)(argv[LEVEL][0] - '0'));
    settle();
    take_quotas();
    const MnsStatus status = begin(&keeper, argv, &error);
    if (status) log_line(LOG_ERROR, "the gate for those from afar: %s", error.text);
    else serve(&keeper);
    finish(&keeper);
    return status ? MNS_EXIT_FAILED : MNS_EXIT_DONE;
}
