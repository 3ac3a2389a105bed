/* SPDX-License-Identifier: BSD-3-Clause */
/* meniscus-dashboard: a daemon in the browser. A process of its own, so that whatever browsers do costs the simulation no more than any
 * other client. */
#include "client/dashboard/server.h"
#include "client/dashboard/watcher.h"
#include "common/host/open_files.h"
#include "common/host/process.h"
#include <getopt.h>
#include <math.h>
#include <meniscus/exit.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char usage[] =
    "Usage: meniscus-dashboard [OPTION]...\n"
    "Show a meniscusd in the browser, and steer it from there.\n"
    "\n"
    "  -d, --daemon NAME|ENDPOINT  which daemon; default $MENISCUS_DAEMON, or the one named default\n"
    "      --http [ADDRESS:]PORT   where to serve browsers; default 127.0.0.1:9465; port 0 is any free one\n"
    "      --http-token FILE       ask browsers for the word in this file, which only its owner can read; without it "
    "one "
    "is\n"
    "                              made, and is in the address that is printed\n"
    "      --http-plain            serve other machines, though on the way there all can be read, the word too\n"
    "      --no-token              ask for none: whoever has an account on this machine can steer the run\n"
    "      --allow-host NAME       a name by which browsers call this machine, besides its own; may be repeated\n"
    "      --frames N              at most N pictures a second, for all browsers together; default 30\n"
    "  -h, --help                  print this\n"
    "  -V, --version               print the version\n";

typedef struct Options {
    const char *daemon;
    double frames;
    ServerOptions server;
    char host[256]; /* of this machine */
    bool has_token, no_token, plain;
} Options;

static MnsStatus read_frames(const char *text, double *ret, MnsError *error)
{
    char *end;
    const double value = strtod(text, &end);
    if (end == text || *end || !(value >= 0.1 && value <= 120))
        return mns_fail(error, MNS_E_INVALID, "--frames takes a number from 0.1 to 120; found \"%.80s\"", text);
    *ret = value;
    return MNS_OK;
}

static MnsStatus add_host(Guard *guard, const char *name, MnsError *error)
{
    if (guard->n == GUARD_NAMES)
        return mns_fail(error, MNS_E_INVALID, "--allow-host can be given at most %d times", GUARD_NAMES - 1);
    guard->names[guard->n++] = name;
    return MNS_OK;
}

static MnsStatus take(int letter, Options *options, MnsError *error)
{
    switch (letter) {
    case 'd': options->daemon = optarg; return MNS_OK;
    case 'p': return address_parse(optarg, &options->server.address, error);
    case 't': options->has_token = true; return token_read(optarg, &options->server.token, error);
    case 'n': options->no_token = true; return MNS_OK;
    case 'c': options->plain = true; return MNS_OK;
    case 'a': return add_host(&options->server.guard, optarg, error);
    case 'f': return read_frames(optarg, &options->frames, error);
    default: return mns_fail(error, MNS_E_INVALID, "`meniscus-dashboard --help` lists the options");
    }
}

static MnsStatus settle_token(Options *options, MnsError *error)
{
    if (options->has_token && options->no_token)
        return mns_fail(error, MNS_E_INVALID, "--http-token and --no-token exclude each other");
    if (options->no_token && !options->server.address.loopback)
        return mns_fail_at(
            error, MNS_E_INVALID, "http",
            "other machines reach that address, so whoever knows it could steer the run: do without --no-token");
    if (!options->plain && !options->server.address.loopback)
        return mns_fail_at(error, MNS_E_INVALID, "http",
                           "other machines reach that address, and HTTP is not encrypted: whoever reads the word on "
                           "its way can steer the "
                           "run. Use a port of 127.0.0.1 with a tunnel, or with a proxy that speaks TLS; or, where "
                           "everybody on the network "
                           "may, say --http-plain");
    return options->has_token || options->no_token ? MNS_OK : token_make(&options->server.token, error);
}

static MnsStatus read_options(int argc, char **argv, Options *options, MnsError *error)
{
    static const struct option longs[] = {
        {"daemon", required_argument, NULL, 'd'},     {"http", required_argument, NULL, 'p'},
        {"http-token", required_argument, NULL, 't'}, {"no-token", no_argument, NULL, 'n'},
        {"http-plain", no_argument, NULL, 'c'},       {"allow-host", required_argument, NULL, 'a'},
        {"frames", required_argument, NULL, 'f'},     {"help", no_argument, NULL, 'h'},
        {"version", no_argument, NULL, 'V'},          {0},
    };
    MnsStatus status = address_parse("9465", &options->server.address, error);
    if (!gethostname(options->host, sizeof options->host - 1)) add_host(&options->server.guard, options->host, NULL);
    for (int letter; !status && (letter = getopt_long(argc, argv, "d:hV", longs, NULL)) != -1;) {
        if (letter == 'h') fputs(usage, stdout);
        if (letter == 'V') printf("meniscus-dashboard %s\n", MENISCUS_VERSION);
        if (letter == 'h' || letter == 'V') exit(MNS_EXIT_DONE);
        status = take(letter, options, error);
    }
    if (status) return status;
    if (optind < argc) return mns_fail(error, MNS_E_INVALID, "there is no use for \"%.200s\"", argv[optind]);
    return settle_token(options, error);
}

static void end(int signal)
{
    (void)signal;
    server_stop();
}

enum { PLACE_SIZE = 280 };

typedef struct Start {
    Hub *hub;
    const Options *options;
} Start;

/* Where browsers find it: by the name of this machine, where all of its addresses are served. */
static void find_place(const Options *options, int port, char ret[static PLACE_SIZE])
{
    const Address *address = &options->server.address;
    if (address_is_any(address) && *options->host) snprintf(ret, PLACE_SIZE, "%s:%d", options->host, port);
    else address_print(address, port, ret);
}

static MnsStatus started(void *arg, int port, MnsError *error)
{
    const Start *start = arg;
    char where[PLACE_SIZE], endpoint[MNS_ENDPOINT_SIZE];
    MnsError missing;
    find_place(start->options, port, where);
    MnsStatus status = watcher_start(start->hub, error);
    if (!status) status = painter_start(start->hub, start->options->frames, error);
    if (status) return status;
    /* A word that somebody keeps in a file stays there. */
    const char *word = start->options->has_token ? "" : start->options->server.token.text;
    fprintf(stderr, "meniscus-dashboard: %s is at http://%s/%s%s\n", hub_daemon(start->hub), where,
            *word ? "#token=" : "", word);
    if (mns_daemon_endpoint(hub_daemon(start->hub), endpoint, &missing))
        fprintf(stderr, "meniscus-dashboard: %s; waiting for it\n", missing.text);
    if (!start->options->server.address.loopback)
        fprintf(stderr,
                "meniscus-dashboard: HTTP is not encrypted: between machines use a tunnel or a proxy with TLS\n");
    return MNS_OK;
}

static int run(int argc, char **argv)
{
    static Options options = {.frames = 30};
    MnsError error = {0};
    MnsStatus status = read_options(argc, argv, &options, &error);
    if (!options.daemon) options.daemon = getenv("MENISCUS_DAEMON");
    if (!options.daemon || !*options.daemon) options.daemon = "default";
    if (!status && open_files_need(OPEN_FILES_DASHBOARD, &error)) status = MNS_E_IO;
    Hub *hub = status ? NULL : hub_new(options.daemon);
    const struct sigaction action = {.sa_handler = end};
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    signal(SIGPIPE, SIG_IGN);
    if (hub) status = server_run(hub, &options.server, started, &(Start){hub, &options}, &error);
    if (!status && !hub) status = mns_fail(&error, MNS_E_MEMORY, "no memory");
    if (!status) return MNS_EXIT_DONE;
    fprintf(stderr, "meniscus-dashboard: %s\n", error.text);
    return status == MNS_E_IO ? MNS_EXIT_IO : status == MNS_E_INVALID ? MNS_EXIT_USAGE : MNS_EXIT_FAILED;
}

int main(int argc, char **argv)
{
    process_main(argc, argv, run);
}
