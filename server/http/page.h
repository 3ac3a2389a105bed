/* SPDX-License-Identifier: BSD-3-Clause */
/* What is answered to a request, whoever carries it. */
#ifndef HTTP_PAGE_H
#define HTTP_PAGE_H

#include "common/wire/token.h"
#include "http/view.h"

typedef struct Question {
    const char *method, *path;
    const char *host, *accept, *authorization; /* headers; NULL: not there */
    bool body;                                 /* one comes with it */
    bool near;                                 /* it comes from this machine */
    size_t n_parameters;                       /* after the path */
    const char *run;                           /* the value of the one called "run"; NULL: not there */
} Question;

typedef struct Answer {
    unsigned code;
    const char *type; /* of the text */
    char *text;       /* from malloc; NULL: there is no memory */
    size_t size;
} Answer;

/* What requests must show. */
typedef struct PageGuard {
    Token token;
    bool liveness; /* other machines get /healthz without it */
} PageGuard;

/* Is an answer that tells nothing of the run: what was asked is refused. Else the page must be made. */
bool page_refuse(const Question *question, const PageGuard *guard, Answer *ret);

void page_make(const Question *question, const View *view, Answer *ret);

#endif
