/* SPDX-License-Identifier: BSD-3-Clause */
/* The thread that answers over HTTP. libmicrohttpd speaks the protocol; what is here is whom it listens to, for how long, and that
 * nobody else ever waits for it. */
#include "http/http.h"

#include "base/log.h"
#include "common/wire/address.h"
#include "http/guests.h"
#include "http/page.h"
#include <limits.h>
#include <microhttpd.h>
#include <poll.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

/* Bounds of what all who connect can cost: so many connections, each with so many bytes for its request, closed after so long
 * without a byte. A few more connections than guests are accepted, as those that must go for others need a moment to close. */
enum { CONNECTIONS = GUESTS + 32, REQUEST_BYTES = 8192, IDLE_SECONDS = 10 };
enum { POLITE = 19 }; /* niceness: the least a thread can ask for */

const unsigned http_codes[HTTP_CODES] = {200, 400, 401, 403, 404, 405, 503};

struct Http {
    int fd; /* that listens; -1: it is libmicrohttpd's to close, or closed */
    PageGuard guard;
    HttpSources sources;
    Figures *figures;
    struct MHD_Daemon *server; /* NULL before http_serve() */
    int wake;                  /* eventfd: readable once the thread is to end */
    pthread_t thread;

    /* Of the thread alone: */
    Guests guests;
    HttpCounts counts;
};

/* --- answers ----------------------------------------------------------------------------------------------------------- */

static void look(Http *http, View *ret)
{
    *ret = (View){.from = &http->sources, .run = figures_look(http->figures), .http = http->counts};
    ret->http.connections = http->guests.n;
    ret->http.crowded_out = http->guests.crowded_out;
    run_counts(http->sources.run, &ret->counts);
    process_look(&ret->process);
    disk_look(http->sources.directory, &ret->disk);
}

static void count(Http *http, unsigned code)
{
    for (int k = 0; k < HTTP_CODES; k++) http->counts.answers[k] += http_codes[k] == code;
}

/* Takes over the text. */
static enum MHD_Result send_answer(Http *http, struct MHD_Connection *connection, const Answer *answer)
{
    struct MHD_Response *response =
        answer->text ? MHD_create_response_from_buffer(answer->size, answer->text, MHD_RESPMEM_MUST_FREE) : NULL;
    if (!response) {
        free(answer->text);
        return MHD_NO; /* the connection is closed */
    }
    MHD_add_response_header(response, MHD_HTTP_HEADER_CONTENT_TYPE, answer->type);
    MHD_add_response_header(response, MHD_HTTP_HEADER_CACHE_CONTROL, "no-store");
    MHD_add_response_header(response, "X-Content-Type-Options", "nosniff");
    if (answer->code == MHD_HTTP_METHOD_NOT_ALLOWED)
        MHD_add_response_header(response, MHD_HTTP_HEADER_ALLOW, "GET, HEAD");
    if (answer->code == MHD_HTTP_UNAUTHORIZED)
        MHD_add_response_header(response, MHD_HTTP_HEADER_WWW_AUTHENTICATE, "Bearer realm=\"meniscus\"");
    const enum MHD_Result queued = MHD_queue_response(connection, answer->code, response);
    MHD_destroy_response(response);
    count(http, answer->code);
    return queued;
}

static const char *header(struct MHD_Connection *connection, const char *name)
{
    return MHD_lookup_connection_value(connection, MHD_HEADER_KIND, name);
}

static bool has_body(struct MHD_Connection *connection)
{
    const char *length = header(connection, MHD_HTTP_HEADER_CONTENT_LENGTH);
    return (length && strcmp(length, "0") != 0) || header(connection, MHD_HTTP_HEADER_TRANSFER_ENCODING);
}

static size_t count_parameters(struct MHD_Connection *connection)
{
    const int n = MHD_get_connection_values(connection, MHD_GET_ARGUMENT_KIND, NULL, NULL);
    return n > 0 ? (size_t)n : 0;
}

/* Called once when the headers are there, and once more when all is: what is refused is so at once, and the connection closed; after
 * other answers it may be used again. */
static enum MHD_Result answer(void *arg, struct MHD_Connection *connection, const char *url, const char *method,
                              const char *version, const char *upload, size_t *upload_size, void **state)
{
    static char headers_seen;
    (void)version, (void)upload, (void)upload_size; /* what comes with a body is refused before it is read */
    Http *http = arg;
    View view;
    Answer answer;
    const union MHD_ConnectionInfo *from = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CLIENT_ADDRESS);
    const Question question = {.method = method,
                               .path = url,
                               .host = header(connection, MHD_HTTP_HEADER_HOST),
                               .accept = header(connection, MHD_HTTP_HEADER_ACCEPT),
                               .authorization = header(connection, MHD_HTTP_HEADER_AUTHORIZATION),
                               .body = has_body(connection),
                               .near = from && from->client_addr && address_is_loopback(from->client_addr),
                               .n_parameters = count_parameters(connection),
                               .run = MHD_lookup_connection_value(connection, MHD_GET_ARGUMENT_KIND, "run")};
    if (!*state && !page_refuse(&question, &http->guard, &answer)) {
        *state = &headers_seen;
        return MHD_YES;
    }
    if (*state) {
        look(http, &view);
        page_make(&question, &view, &answer);
    }
    return send_answer(http, connection, &answer);
}

/* --- the thread -------------------------------------------------------------------------------------------------------- */

static void receive_guest(void *arg, struct MHD_Connection *connection, void **guest,
                          enum MHD_ConnectionNotificationCode code)
{
    Http *http = arg;
    const union MHD_ConnectionInfo *info = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD);
    if (code == MHD_CONNECTION_NOTIFY_STARTED) *guest = guests_enter(&http->guests, info->connect_fd);
    else guests_leave(&http->guests, *guest);
}

static void log_trouble(void *arg, const char *format, va_list list)
{
    char text[256];
    (void)arg;
    vsnprintf(text, sizeof text, format, list);
    text[strcspn(text, "\n")] = 0;
    log_line(LOG_DETAIL, "http: %s", text);
}

static int milliseconds(struct MHD_Daemon *server)
{
    MHD_UNSIGNED_LONG_LONG left;
    if (MHD_get_timeout(server, &left) != MHD_YES) return -1;
    return left < INT_MAX ? (int)left : INT_MAX;
}

static void *serve(void *arg)
{
    Http *http = arg;
    const union MHD_DaemonInfo *info = MHD_get_daemon_info(http->server, MHD_DAEMON_INFO_EPOLL_FD);
    struct pollfd fds[] = {{.fd = info->epoll_fd, .events = POLLIN}, {.fd = http->wake, .events = POLLIN}};
    /* Linux keeps a niceness for each thread. Whoever asks without end gets what the solver leaves. */
    setpriority(PRIO_PROCESS, (id_t)gettid(), POLITE);
    while (!fds[1].revents) {
        poll(fds, 2, milliseconds(http->server));
        MHD_run(http->server);
    }
    return NULL;
}

/* --- beginning and end ------------------------------------------------------------------------------------------------- */

static MnsStatus check_reach(const Address *address, const HttpOptions *options, MnsError *error)
{
    if (address->loopback || (options->token_file && options->plain)) return MNS_OK;
    return mns_fail_at(error, MNS_E_INVALID, "http",
                       "other machines reach %s, and HTTP is not encrypted: use a port of 127.0.0.1 with a tunnel, or "
                       "with a proxy that "
                       "speaks TLS; or, where everybody on the network may read it, say --http-plain, and with "
                       "--http-token FILE what they "
                       "must know",
                       options->address);
}

static MnsStatus open_port(Http *http, const HttpOptions *options, MnsError *error)
{
    Address address;
    MnsStatus status = address_parse(options->address, &address, error);
    if (!status) status = check_reach(&address, options, error);
    if (!status && options->token_file) status = token_read(options->token_file, &http->guard.token, error);
    http->guard.liveness = options->liveness;
    if (!status) status = address_listen(&address, &http->fd, error);
    if (!status && !address.loopback)
        log_line(LOG_WARNING, "HTTP is not encrypted: on its way from %s, the token can be read", options->address);
    return status;
}

MnsStatus http_open(const HttpOptions *options, Http **ret, MnsError *error)
{
    *ret = NULL;
    if (!options->address) return MNS_OK;
    Http *http = calloc(1, sizeof *http);
    if (!http) return mns_fail(error, MNS_E_MEMORY, "no memory to serve HTTP");
    http->fd = -1;
    http->wake = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    http->figures = figures_new();
    MnsStatus status = open_port(http, options, error);
    if (!status && (http->wake < 0 || !http->figures))
        status = mns_fail(error, MNS_E_MEMORY, "no memory to serve HTTP");
    if (status) http_free(http);
    else *ret = http;
    return status;
}

Figures *http_figures(Http *http)
{
    return http ? http->figures : NULL;
}

static void tell(const Http *http)
{
    char where[64];
    address_of(http->fd, where);
    log_line(LOG_INFORMATION, "metrics at http://%s/metrics%s", where,
             http->guard.token.text[0] ? ", for the token" : "");
}

static void note_beginning(Http *http)
{
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    http->counts.began = (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

MnsStatus http_serve(Http *http, const HttpSources *sources, MnsError *error)
{
    http->sources = *sources;
    note_beginning(http);
    tell(http);
    http->server =
        MHD_start_daemon(MHD_USE_EPOLL | MHD_USE_ERROR_LOG, 0, NULL, NULL, answer, http, MHD_OPTION_EXTERNAL_LOGGER,
                         log_trouble, NULL, MHD_OPTION_LISTEN_SOCKET, http->fd, MHD_OPTION_CONNECTION_LIMIT,
                         (unsigned)CONNECTIONS, MHD_OPTION_CONNECTION_MEMORY_LIMIT, (size_t)REQUEST_BYTES,
                         MHD_OPTION_CONNECTION_TIMEOUT, (unsigned)IDLE_SECONDS, MHD_OPTION_NOTIFY_CONNECTION,
                         receive_guest, http, MHD_OPTION_SIGPIPE_HANDLED_BY_APP, 1, MHD_OPTION_END);
    http->fd = -1; /* it may have been closed where that failed, too */
    if (!http->server) return mns_fail(error, MNS_E_MEMORY, "cannot serve HTTP: there is no memory or no epoll");
    if (!pthread_create(&http->thread, NULL, serve, http)) return MNS_OK;
    MHD_stop_daemon(http->server);
    http->server = NULL;
    return mns_fail(error, MNS_E_MEMORY, "the operating system refuses a thread for HTTP");
}

void http_stop(Http *http)
{
    if (!http || !http->server) return;
    eventfd_write(http->wake, 1);
    pthread_join(http->thread, NULL);
    MHD_stop_daemon(http->server);
    http->server = NULL;
}

void http_free(Http *http)
{
    if (!http) return;
    http_stop(http);
    if (http->fd >= 0) close(http->fd);
    if (http->wake >= 0) close(http->wake);
    figures_free(http->figures);
    free(http);
}
