/* SPDX-License-Identifier: BSD-3-Clause */
/* The daemon over HTTP, to be looked at: metrics, and whether it is well. A thread of its own answers, which looks at what other
 * threads have left for it to see, takes no lock that they wait for, and comes last when processors are short. */
#ifndef HTTP_HTTP_H
#define HTTP_HTTP_H

#include "http/traffic.h"
#include "run/run.h"

typedef struct HttpOptions {
    const char *address;    /* "[ADDRESS:]PORT"; NULL: nothing is served                        */
    const char *token_file; /* holds what whoever asks must know; NULL: this machine only may ask */
    bool liveness;          /* other machines get /healthz without it                             */
    bool plain;             /* other machines may be served, though nothing is encrypted */
} HttpOptions;

/* What is told of; all borrowed until http_stop(). */
typedef struct HttpSources {
    const char *name;              /* of the daemon */
    const char *commit, *compiler; /* of the program */
    const char *directory;         /* where runs keep their files */
    Run *run;                      /* that was given http_figures() */
    const Traffic *traffic;
} HttpSources;

typedef struct Http Http;

/* Listen; answers come later. *ret is NULL if nothing is to be served. MNS_E_INVALID: what the options say cannot be meant, or may not
 * be; MNS_E_IO; MNS_E_MEMORY. */
MnsStatus http_open(const HttpOptions *options, Http **ret, MnsError *error);

/* Where the run is to put its figures; NULL for NULL. */
Figures *http_figures(Http *http);

/* Begin to answer. MNS_E_MEMORY. */
MnsStatus http_serve(Http *http, const HttpSources *sources, MnsError *error);

/* Answer no more, and close the port. The figures stay until http_free(). NULL is fine for both. */
void http_stop(Http *http);
void http_free(Http *http);

#endif
