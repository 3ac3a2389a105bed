/* SPDX-License-Identifier: BSD-3-Clause */
/* What is answered to a request, whoever carries it. */
#ifndef HTTP_PAGE_H
#define HTTP_PAGE_H

#include "http/view.h"
#include "proto/token.h"

typedef struct Question {
    const char *method, *path;
    const char *host, *accept, *authorization; /* headers; NULL: not there */
    bool body;                                 /* one comes with it */
} Question;

typedef struct Answer {
    unsigned code;
    const char *type; /* of the text */
    char *text;       /* from malloc; NULL: there is no memory */
    size_t size;
} Answer;

/* Is an answer that tells nothing of the run: what was asked is refused. Else the page must be made. */
bool page_refuse(const Question *question, const Token *token, Answer *ret);

void page_make(const Question *question, const View *view, Answer *ret);

#endif
