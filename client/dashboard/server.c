/* SPDX-License-Identifier: BSD-3-Clause */
/* The thread that serves browsers. Nothing here waits: what browsers ask is done by other threads, whose answers wake this one. */
#include "client/dashboard/server.h"
#include "client/dashboard/files.h"
#include "client/dashboard/watcher.h"
#include <arpa/inet.h>
#include <errno.h>
#include <libwebsockets.h>
#include <netinet/in.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>

enum { GREETING_S = 10, PING_S = 10, HANGUP_S = 30, HEADERS = 2048, PATH = 256 };
/* At once; the rest of a longer message is kept by the library. */
enum { HEAR_BYTES = 4096, SEND_BYTES = 256 << 10 };
_Static_assert(LWS_PRE <= FRAME_HEADROOM, "the library writes its header before each message");

/* One connection: a file being sent, or a browser. */
typedef struct Visit {
    const File *file; /* whose body is due */
    bool is_browser;  /* until it has parted, which may be before its connection is closed */
    struct lws *wsi;
    Session session;
    char *heard; /* [ASK_BYTES] the message so far */
    size_t n_heard;
    bool hung_up;
    enum lws_close_status why; /* it is to be closed for, once what has begun to be sent is gone; 0: it is not */
    const char *words;
} Visit;

typedef struct Server {
    Hub *hub;
    const ServerOptions *options;
    struct lws_context *context;
    struct lws_vhost *vhost;
    Visit *browsers[HUB_BROWSERS];
    Frame *newest[HUB_BROWSERS]; /* of each wish that a browser has, for those that come later */
    size_t n_browsers, n_newest;
    uint64_t next_id;
} Server;

static volatile sig_atomic_t stopped;
static struct lws_context *to_wake;

void server_stop(void)
{
    stopped = 1;
    if (to_wake) lws_cancel_service(to_wake);
}

static void wake(void *arg)
{
    lws_cancel_service(arg);
}

/* --- frames ------------------------------------------------------------------------------------------------------------ */

static bool is_wanted(const Server *server, const Wish *wish)
{
    for (size_t k = 0; k < server->n_browsers; k++) {
        const Session *session = &server->browsers[k]->session;
        if (session->shows && wish_equal(&session->wish, wish)) return true;
    }
    return false;
}

static Frame *newest_of(const Server *server, const Wish *wish)
{
    for (size_t k = 0; k < server->n_newest; k++)
        if (wish_equal(&server->newest[k]->wish, wish)) return server->newest[k];
    return NULL;
}

static void forget_unwanted(Server *server)
{
    for (size_t k = 0; k < server->n_newest;) {
        if (is_wanted(server, &server->newest[k]->wish)) {
            k++;
            continue;
        }
        frame_release(server->newest[k]);
        server->newest[k] = server->newest[--server->n_newest];
    }
}

/* What browsers that can take another frame want. Others with the same wish get theirs too, as the newest. */
static void demand(Server *server)
{
    Demand demands[HUB_BROWSERS];
    size_t n = 0;
    for (size_t k = 0; k < server->n_browsers; k++) {
        const Session *session = &server->browsers[k]->session;
        size_t d = 0;
        if (!session_has_room(session) || session->frame) continue;
        while (d < n && !wish_equal(&demands[d].wish, &session->wish)) d++;
        if (d < n) continue;
        const Frame *newest = newest_of(server, &session->wish);
        demands[n++] = (Demand){.wish = session->wish, .has = newest, .have = newest ? newest->key : (FrameKey){0}};
    }
    hub_set_demands(server->hub, n, demands);
}

static void ask_to_write(const Visit *visit)
{
    if (session_has_next(&visit->session)) lws_callback_on_writable(visit->wsi);
}

static void take_frame(Server *server, Frame *frame)
{
    frame->users = 1;
    for (size_t k = 0; k < server->n_newest; k++) {
        if (!wish_equal(&server->newest[k]->wish, &frame->wish)) continue;
        frame_release(server->newest[k]);
        server->newest[k] = server->newest[--server->n_newest];
        break;
    }
    if (is_wanted(server, &frame->wish)) server->newest[server->n_newest++] = frame;
    for (size_t k = 0; k < server->n_browsers; k++) session_offer(&server->browsers[k]->session, frame);
    if (!newest_of(server, &frame->wish)) frame_release(frame);
}

/* --- what comes from other threads ------------------------------------------------------------------------------------- */

static void hang_up(Visit *visit)
{
    visit->hung_up = true;
    lws_set_timeout(visit->wsi, PENDING_TIMEOUT_USER_OK, LWS_TO_KILL_ASYNC);
}

static void deliver(Server *server, uint64_t browser, Text *text)
{
    text->users++;
    for (size_t k = 0; k < server->n_browsers; k++) {
        Visit *visit = server->browsers[k];
        const bool addressed = browser ? visit->session.id == browser : visit->session.welcome;
        if (addressed && !session_send(&visit->session, text)) hang_up(visit);
    }
    text_release(text);
}

static void take_post(Server *server)
{
    uint64_t browser;
    Text *text;
    Frame *frame;
    while ((text = hub_take_text(server->hub, &browser))) deliver(server, browser, text);
    while ((frame = hub_take_frame(server->hub))) take_frame(server, frame);
    for (size_t k = 0; k < server->n_browsers; k++) {
        Visit *visit = server->browsers[k];
        if (!hub_recall_more(server->hub, &visit->session)) hang_up(visit);
        ask_to_write(visit);
    }
    demand(server);
}

/* --- browsers ---------------------------------------------------------------------------------------------------------- */

static void say(Visit *visit, json_t *object)
{
    char *words = json_dumps(object, JSON_COMPACT);
    Text *text = words ? text_new(words, false) : NULL;
    json_decref(object);
    free(words);
    if (!text) return;
    text->users++;
    if (!session_send(&visit->session, text)) hang_up(visit);
    text_release(text);
    lws_callback_on_writable(visit->wsi);
}

/* The library says why only while it keeps nothing of a message: with half a picture to send it would close without a word. */
static int close_for(Visit *visit, enum lws_close_status why, const char *words)
{
    if (lws_partial_buffered(visit->wsi)) {
        visit->why = why;
        visit->words = words;
        visit->session.shows = false;
        if (!visit->hung_up) lws_set_timeout(visit->wsi, PENDING_TIMEOUT_USER_OK, GREETING_S);
        lws_callback_on_writable(visit->wsi);
        return 0;
    }
    lws_close_reason(visit->wsi, why, (unsigned char *)words, strlen(words));
    return -1;
}

static void part(Server *server, Visit *visit)
{
    size_t k = 0;
    if (!visit->is_browser) return;
    while (k < server->n_browsers && server->browsers[k] != visit) k++;
    if (k < server->n_browsers) server->browsers[k] = server->browsers[--server->n_browsers];
    session_done(&visit->session);
    free(visit->heard);
    *visit = (Visit){0};
    forget_unwanted(server);
    demand(server);
}

/* Of those that have not said who they are the one that has been here longest goes, lest they keep out who does: each of them may say
 * nothing for GREETING_S. */
static void show_out_silent(Server *server)
{
    Visit *oldest = NULL;
    for (size_t k = 0; k < server->n_browsers; k++) {
        Visit *visit = server->browsers[k];
        if (!visit->session.welcome && (!oldest || visit->session.id < oldest->session.id)) oldest = visit;
    }
    if (!oldest) return;
    hang_up(oldest);
    part(server, oldest);
}

static bool admit(Server *server, Visit *visit, struct lws *wsi)
{
    if (server->n_browsers == HUB_BROWSERS) show_out_silent(server);
    if (server->n_browsers == HUB_BROWSERS) return false;
    *visit = (Visit){.is_browser = true, .wsi = wsi, .heard = malloc(ASK_BYTES)};
    if (!visit->heard) return false;
    session_init(&visit->session, ++server->next_id);
    server->browsers[server->n_browsers++] = visit;
    lws_set_timer_usecs(wsi, (lws_usec_t)GREETING_S * LWS_USEC_PER_SEC);
    return true;
}

static int welcome(Server *server, Visit *visit, const Ask *ask)
{
    const Token *token = &server->options->token;
    if (token->text[0] && !token_is(token, ask->token ? ask->token : ""))
        return close_for(visit, LWS_CLOSE_STATUS_POLICY_VIOLATION, "token");
    if (visit->session.welcome) return 0;
    visit->session.welcome = true;
    say(visit,
        json_pack("{ss ss ss}", "topic", "hello", "version", MENISCUS_VERSION, "daemon", hub_daemon(server->hub)));
    return hub_recall(server->hub, &visit->session) ? 0 : -1;
}

static void show(Server *server, Visit *visit, const Ask *ask)
{
    Session *session = &visit->session;
    session->shows = ask->limit > 0 && *ask->field;
    session->wish = (Wish){.limit = ask->limit < FRAME_MOST ? ask->limit : FRAME_MOST, .walls = ask->walls};
    strncpy(session->wish.field, ask->field, FRAME_FIELD - 1);
    session->has_seen = false;
    if (session->frame) frame_release(session->frame);
    session->frame = NULL;
    Frame *newest = newest_of(server, &session->wish);
    if (newest) session_offer(session, newest);
    forget_unwanted(server);
}

/* What is wrong with what one browser says costs that browser an answer, and nobody else anything. */
static int obey(Server *server, Visit *visit, Ask *ask)
{
    MnsError error;
    int result = 0;
    if (ask->kind != ASK_HELLO && !visit->session.welcome) {
        ask_done(ask);
        return close_for(visit, LWS_CLOSE_STATUS_POLICY_VIOLATION, "hello");
    }
    switch (ask->kind) {
    case ASK_HELLO: result = welcome(server, visit, ask); break;
    case ASK_SHOW: show(server, visit, ask); break;
    case ASK_DRAWN: session_drawn(&visit->session, ask->count); break;
    case ASK_HISTORY: result = hub_recall_history(server->hub, &visit->session) ? 0 : -1; break;
    default: {
        const uint64_t id = ask->id;
        if (worker_start(server->hub, visit->session.id, ask, &error)) say(visit, worker_refusal(id, &error));
        return 0;
    }
    }
    ask_done(ask);
    ask_to_write(visit);
    demand(server);
    return result;
}

static int hear(Server *server, Visit *visit, const void *data, size_t size)
{
    struct lws *wsi = visit->wsi;
    MnsError error = {0};
    Ask ask;
    if (visit->why) return 0;
    if (lws_frame_is_binary(wsi)) return close_for(visit, LWS_CLOSE_STATUS_UNACCEPTABLE_OPCODE, "text only");
    if (lws_is_first_fragment(wsi)) visit->n_heard = 0;
    if (size > ASK_BYTES - visit->n_heard) return close_for(visit, LWS_CLOSE_STATUS_MESSAGE_TOO_LARGE, "too long");
    memcpy(visit->heard + visit->n_heard, data, size);
    visit->n_heard += size;
    if (!lws_is_final_fragment(wsi) || lws_remaining_packet_payload(wsi)) return 0;
    const MnsStatus status = ask_parse(visit->heard, visit->n_heard, &ask, &error);
    visit->n_heard = 0;
    if (!status) return obey(server, visit, &ask);
    if (!visit->session.welcome) return close_for(visit, LWS_CLOSE_STATUS_POLICY_VIOLATION, "hello");
    say(visit, worker_refusal(ask.id, &error));
    return 0;
}

/* One message; the library keeps what the network does not take at once, and asks for no more until it is gone. */
static int write_next(Server *server, Visit *visit)
{
    Text *text;
    Frame *frame;
    int written = 0;
    if (visit->why) return close_for(visit, visit->why, visit->words);
    session_next(&visit->session, &text, &frame);
    if (text) {
        written = lws_write(visit->wsi, text->bytes + FRAME_HEADROOM, text->size, LWS_WRITE_TEXT);
        text_release(text);
        if (!hub_recall_more(server->hub, &visit->session)) return -1;
    }
    if (frame) {
        written = lws_write(visit->wsi, frame->bytes + FRAME_HEADROOM, frame->size, LWS_WRITE_BINARY);
        frame_release(frame);
        demand(server);
    }
    ask_to_write(visit);
    return written < 0 ? -1 : 0;
}

/* --- files ------------------------------------------------------------------------------------------------------------- */

static bool header(struct lws *wsi, enum lws_token_indexes which, char ret[GUARD_TEXT])
{
    return lws_hdr_copy(wsi, ret, GUARD_TEXT, which) > 0;
}

static bool is_let_in(const Server *server, struct lws *wsi)
{
    char host[GUARD_TEXT];
    return header(wsi, WSI_TOKEN_HOST, host) && guard_host(&server->options->guard, host);
}

static int refuse(struct lws *wsi, unsigned code, const char *words)
{
    lws_return_http_status(wsi, code, words);
    return -1;
}

static int begin_file(const Server *server, Visit *visit, struct lws *wsi, const char *path)
{
    unsigned char buffer[LWS_PRE + HEADERS], *start = buffer + LWS_PRE, *at = start, *end = buffer + sizeof buffer - 1;
    const File *file = file_find(path);
    if (!is_let_in(server, wsi))
        return refuse(wsi, HTTP_STATUS_FORBIDDEN, "This is not the name of this machine; give it with --allow-host.");
    if (lws_hdr_total_length(wsi, WSI_TOKEN_POST_URI)) return refuse(wsi, HTTP_STATUS_METHOD_NOT_ALLOWED, NULL);
    if (!file) return refuse(wsi, HTTP_STATUS_NOT_FOUND, NULL);
    if (lws_add_http_common_headers(wsi, HTTP_STATUS_OK, file->type, file->size, &at, end)) return -1;
    if (lws_finalize_write_http_header(wsi, start, &at, end)) return -1;
    *visit = (Visit){.file = file, .wsi = wsi};
    lws_callback_on_writable(wsi);
    return 0;
}

static int send_file(Visit *visit)
{
    const File *file = visit->file;
    if (!file) return 0;
    visit->file = NULL;
    /* HTTP/1 writes nothing before it. */
    if (lws_write(visit->wsi, (unsigned char *)file->bytes, file->size, LWS_WRITE_HTTP_FINAL) < 0) return -1;
    return lws_http_transaction_completed(visit->wsi) ? -1 : 0;
}

/* --- the library ------------------------------------------------------------------------------------------------------- */

/* Before a connection becomes a WebSocket. */
static int filter(const Server *server, struct lws *wsi)
{
    char host[GUARD_TEXT], origin[GUARD_TEXT];
    if (!is_let_in(server, wsi) || !header(wsi, WSI_TOKEN_HOST, host)) return -1;
    return header(wsi, WSI_TOKEN_ORIGIN, origin) && guard_origin(origin, host) ? 0 : -1;
}

static int serve(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in, size_t len)
{
    Server *server = lws_context_user(lws_get_context(wsi));
    Visit *visit = user;
    switch (reason) {
    case LWS_CALLBACK_HTTP: return begin_file(server, visit, wsi, in);
    case LWS_CALLBACK_HTTP_WRITEABLE: return send_file(visit);
    case LWS_CALLBACK_FILTER_PROTOCOL_CONNECTION: return filter(server, wsi);
    case LWS_CALLBACK_ESTABLISHED: return admit(server, visit, wsi) ? 0 : -1;
    case LWS_CALLBACK_RECEIVE: return visit->is_browser ? hear(server, visit, in, len) : -1;
    case LWS_CALLBACK_SERVER_WRITEABLE: return visit->is_browser ? write_next(server, visit) : -1;
    case LWS_CALLBACK_TIMER:
        if (!visit->is_browser) return -1;
        return visit->session.welcome ? 0 : close_for(visit, LWS_CLOSE_STATUS_POLICY_VIOLATION, "hello");
    case LWS_CALLBACK_CLOSED: part(server, visit); return 0;
    case LWS_CALLBACK_EVENT_WAIT_CANCELLED: take_post(server); return 0;
    default: return 0;
    }
}

/* Nothing but our own files is run, nothing is said to others, and nobody puts us into a frame. */
static const struct lws_protocol_vhost_options headers[] = {
    {&headers[1], NULL, "content-security-policy:",
     "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; base-uri "
     "'none'; "
     "form-action 'none'; frame-ancestors 'none'"},
    {&headers[2], NULL, "x-content-type-options:", "nosniff"},
    {&headers[3], NULL, "referrer-policy:", "no-referrer"},
    {&headers[4], NULL, "cross-origin-resource-policy:", "same-origin"},
    {NULL, NULL, "cache-control:", "no-cache"},
};

static const lws_retry_bo_t patience = {.secs_since_valid_ping = PING_S, .secs_since_valid_hangup = HANGUP_S};

static MnsStatus listen_at(Server *server, char *where, size_t size, MnsError *error)
{
    static const struct lws_protocols protocols[] = {
        {.name = "meniscus-dashboard",
         .callback = serve,
         .per_session_data_size = sizeof(Visit),
         .rx_buffer_size = HEAR_BYTES,
         .tx_packet_size = SEND_BYTES},
        {0},
    };
    const Address *address = &server->options->address;
    const struct sockaddr_in *v4 = (const struct sockaddr_in *)&address->where;
    const struct sockaddr_in6 *v6 = (const struct sockaddr_in6 *)&address->where;
    const bool is_v6 = address->where.ss_family == AF_INET6;
    inet_ntop(address->where.ss_family, is_v6 ? (const void *)&v6->sin6_addr : &v4->sin_addr, where, (socklen_t)size);
    const struct lws_context_creation_info info = {
        .port = ntohs(is_v6 ? v6->sin6_port : v4->sin_port),
        .iface = where,
        .protocols = protocols,
        .headers = headers,
        .user = server,
        .gid = -1,
        .uid = -1,
        .server_string = "meniscus-dashboard",
        .retry_and_idle_policy = &patience,
        .options = LWS_SERVER_OPTION_VALIDATE_UTF8 | LWS_SERVER_OPTION_FAIL_UPON_UNABLE_TO_BIND |
                   (is_v6 ? 0 : LWS_SERVER_OPTION_DISABLE_IPV6),
        .timeout_secs = GREETING_S,
        .keepalive_timeout = GREETING_S,
    };
    lws_set_log_level(0, NULL); /* what is wrong is said below, once */
    errno = 0;
    server->context = lws_create_context(&info);
    if (!server->context)
        return mns_fail_at(error, MNS_E_IO, "http", "cannot listen at %s port %d%s; choose another port for --http",
                           where, info.port,
                           errno == EADDRINUSE ? ", which another program has, maybe another dashboard" : "");
    lws_set_log_level(LLL_ERR, NULL);
    server->vhost = lws_get_vhost_by_name(server->context, "default");
    return MNS_OK;
}

MnsStatus server_run(Hub *hub, const ServerOptions *options, MnsStatus (*started)(void *arg, int port, MnsError *error),
                     void *arg, MnsError *error)
{
    char where[INET6_ADDRSTRLEN];
    Server *server = calloc(1, sizeof *server);
    if (!server) return mns_fail(error, MNS_E_MEMORY, "no memory for a server");
    server->hub = hub;
    server->options = options;
    MnsStatus status = listen_at(server, where, sizeof where, error);
    if (status) {
        free(server);
        return status;
    }
    to_wake = server->context;
    hub_set_wake(hub, wake, server->context);
    status = started(arg, lws_get_vhost_listen_port(server->vhost), error);
    while (!status && !stopped)
        if (lws_service(server->context, 0) < 0 && !stopped)
            status = mns_fail(error, MNS_E_INTERNAL, "browsers can no longer be served");
    /* The other threads may still wake it: what is left ends with the process. */
    return status;
}
