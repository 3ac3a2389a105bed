/* SPDX-License-Identifier: BSD-3-Clause */
/* The pages: one table. */
#include "http/page.h"

#include "common/wire/guard.h"
#include "http/health.h"
#include "http/metrics.h"
#include <stdlib.h>
#include <string.h>

typedef struct Page {
    const char *path;
    void (*make)(const Question *question, const View *view, Answer *ret);
} Page;

static void take_text(Answer *answer, unsigned code, const char *type, char *text)
{
    *answer = (Answer){.code = code, .type = type, .text = text, .size = text ? strlen(text) : 0};
}

static void make_metrics(const Question *question, const View *view, Answer *ret)
{
    Exposition exposition;
    const bool open_metrics = exposition_accepts_open_metrics(question->accept);
    *ret = (Answer){.code = 200, .type = exposition_type(open_metrics)};
    if (!exposition_begin(&exposition, open_metrics)) return;
    metrics_print(&exposition, view);
    ret->text = exposition_end(&exposition, &ret->size);
}

static void make_health(const Question *question, const View *view, Answer *ret)
{
    (void)question;
    take_text(ret, 200, "application/json", health_alive(view));
}

static void make_readiness(const Question *question, const View *view, Answer *ret)
{
    bool ready;
    char *text = health_ready(view, question->run != NULL, &ready);
    take_text(ret, ready ? 200 : 503, "application/json", text);
}

static const char LIVENESS[] = "/healthz", READINESS[] = "/readyz";

static const Page pages[] = {{"/metrics", make_metrics}, {LIVENESS, make_health}, {READINESS, make_readiness}};

static const Page *find(const char *path)
{
    for (size_t k = 0; k < sizeof pages / sizeof *pages; k++)
        if (!strcmp(pages[k].path, path)) return &pages[k];
    return NULL;
}

static void refuse(Answer *answer, unsigned code, const char *text)
{
    take_text(answer, code, "text/plain; charset=utf-8", strdup(text));
}

/* That the process answers is no secret: what starts and ends services must find it out, and mostly cannot show a token. */
static bool is_open(const Question *question, const PageGuard *guard)
{
    return !strcmp(question->path, LIVENESS) && (question->near || guard->liveness);
}

/* A page of another site can have its name point here, and then its browser asks us (DNS rebinding). It does not know the token; where none is
 * shown, the name gives it away, which browsers always say. Other machines know us by any name. */
static bool is_rebound(const Question *question, const PageGuard *guard)
{
    static const Guard nobody = {.n = 0};
    const bool shown = guard->token.text[0] && token_shown(&guard->token, question->authorization);
    const bool far = guard->token.text[0] && guard->liveness;
    return !shown && !far && question->host && !guard_host(&nobody, question->host);
}

/* Only what is known is passed over nowhere: a probe with a mistake in it would be answered as if it had asked for less. */
static bool has_wrong_parameter(const Question *question)
{
    if (strcmp(question->path, READINESS) != 0 || !question->n_parameters) return false;
    return question->n_parameters > 1 || !question->run || strcmp(question->run, "loaded") != 0;
}

bool page_refuse(const Question *question, const PageGuard *guard, Answer *ret)
{
    if (!token_shown(&guard->token, question->authorization) && !is_open(question, guard))
        refuse(ret, 401, "who asks must send the token of --http-token: Authorization: Bearer TOKEN\n");
    else if (is_rebound(question, guard))
        refuse(ret, 403,
               "a request that shows no token must call this machine localhost, or by its address in digits (Host "
               "header); use such an address, or the token of --http-token\n");
    else if (strcmp(question->method, "GET") != 0 && strcmp(question->method, "HEAD") != 0)
        refuse(ret, 405, "this is only to be looked at, with GET or HEAD; commands go over the control socket\n");
    else if (question->body) refuse(ret, 400, "nothing can be sent here: leave out the body\n");
    else if (!find(question->path))
        refuse(ret, 404, "there is no such page; there are /metrics, /healthz and /readyz\n");
    else if (has_wrong_parameter(question))
        refuse(ret, 400,
               "/readyz takes one parameter, run=loaded, which asks whether a run is loaded and not in FAULT\n");
    else return false;
    return true;
}

void page_make(const Question *question, const View *view, Answer *ret)
{
    find(question->path)->make(question, view, ret);
}
