/* SPDX-License-Identifier: BSD-3-Clause */
/* Where the threads that talk to the daemon meet the one that serves browsers. */
#include "client/dashboard/hub.h"
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { LATEST = TELL_EVENT, FRAMES = HUB_BROWSERS, PATIENCE_MS = 500 };

typedef struct Letter Letter;
struct Letter {
    Letter *next;
    uint64_t browser;
    Text *text;
};

struct Hub {
    const char *daemon;
    void (*wake)(void *arg);
    void *arg;
    pthread_mutex_t lock;
    pthread_cond_t wanted;
    uint64_t generation;
    char *latest[LATEST];
    char *events[HUB_EVENTS]; /* a ring */
    size_t n_events;          /* ever */
    History history;
    Letter *first, *last;
    Frame *frames[FRAMES]; /* one of each wish, not taken yet */
    size_t n_frames;
    Demand demands[HUB_BROWSERS];
    size_t n_demands, commands;
    char directory[4096];
};

Hub *hub_new(const char *daemon)
{
    Hub *hub = calloc(1, sizeof *hub);
    if (!hub) return NULL;
    pthread_condattr_t clock;
    pthread_condattr_init(&clock);
    pthread_condattr_setclock(&clock, CLOCK_MONOTONIC);
    pthread_cond_init(&hub->wanted, &clock);
    pthread_condattr_destroy(&clock);
    pthread_mutex_init(&hub->lock, NULL);
    history_init(&hub->history);
    hub->daemon = daemon;
    return hub;
}

const char *hub_daemon(const Hub *hub)
{
    return hub->daemon;
}

bool hub_is_far(const Hub *hub)
{
    return !strncmp(hub->daemon, "tcp://", strlen("tcp://"));
}

void hub_set_wake(Hub *hub, void (*wake)(void *arg), void *arg)
{
    hub->arg = arg;
    hub->wake = wake;
}

/* --- texts ------------------------------------------------------------------------------------------------------------- */

/* With the lock. Without memory the letter is lost, as the next one says as much. */
static void post(Hub *hub, uint64_t browser, const char *words, bool lossy)
{
    Letter *letter = calloc(1, sizeof *letter);
    if (letter) letter->text = text_new(words, lossy);
    if (!letter || !letter->text) {
        free(letter);
        return;
    }
    letter->browser = browser;
    if (hub->last) hub->last->next = letter;
    else hub->first = letter;
    hub->last = letter;
}

/* With the lock; takes the words. */
static void keep(Hub *hub, TellKind kind, char *words)
{
    char **place = NULL;
    if (kind < TELL_EVENT) place = &hub->latest[kind];
    else if (kind == TELL_EVENT) place = &hub->events[hub->n_events++ % HUB_EVENTS];
    if (!place) {
        free(words);
        return;
    }
    free(*place);
    *place = words;
}

static char *words_of(json_t *object)
{
    char *words = object ? json_dumps(object, JSON_COMPACT | JSON_REAL_PRECISION(17)) : NULL;
    json_decref(object);
    return words;
}

void hub_tell(Hub *hub, TellKind kind, json_t *object)
{
    char *words = words_of(object);
    if (!words) return;
    pthread_mutex_lock(&hub->lock);
    post(hub, 0, words, kind >= TELL_SAMPLES || kind == TELL_PROGRESS || kind == TELL_STATUS);
    keep(hub, kind, words);
    pthread_mutex_unlock(&hub->lock);
    hub->wake(hub->arg);
}

void hub_answer(Hub *hub, uint64_t browser, json_t *object)
{
    char *words = words_of(object);
    if (!words) return;
    pthread_mutex_lock(&hub->lock);
    post(hub, browser, words, false);
    pthread_mutex_unlock(&hub->lock);
    free(words);
    hub->wake(hub->arg);
}

Text *hub_take_text(Hub *hub, uint64_t *ret_browser)
{
    pthread_mutex_lock(&hub->lock);
    Letter *letter = hub->first;
    if (letter) hub->first = letter->next;
    if (!hub->first) hub->last = NULL;
    pthread_mutex_unlock(&hub->lock);
    if (!letter) return NULL;
    Text *text = letter->text;
    *ret_browser = letter->browser;
    free(letter);
    return text;
}

/* --- what is remembered ------------------------------------------------------------------------------------------------ */

void hub_sample(Hub *hub, double t, size_t n, const MnsValue *values)
{
    pthread_mutex_lock(&hub->lock);
    history_add(&hub->history, t, n, values);
    pthread_mutex_unlock(&hub->lock);
}

uint64_t hub_history_version(Hub *hub)
{
    pthread_mutex_lock(&hub->lock);
    const uint64_t version = hub->history.version;
    pthread_mutex_unlock(&hub->lock);
    return version;
}

void hub_precede(Hub *hub, uint64_t version, History *past)
{
    pthread_mutex_lock(&hub->lock);
    if (hub->history.version == version) history_precede(&hub->history, past);
    pthread_mutex_unlock(&hub->lock);
    hub->wake(hub->arg);
}

void hub_forget(Hub *hub)
{
    pthread_mutex_lock(&hub->lock);
    history_clear(&hub->history);
    for (size_t k = TELL_ABOUT; k < LATEST; k++) {
        free(hub->latest[k]);
        hub->latest[k] = NULL;
    }
    hub->generation++;
    pthread_mutex_unlock(&hub->lock);
}

void hub_renew(Hub *hub)
{
    pthread_mutex_lock(&hub->lock);
    hub->generation++;
    pthread_cond_signal(&hub->wanted);
    pthread_mutex_unlock(&hub->lock);
}

uint64_t hub_generation(Hub *hub)
{
    pthread_mutex_lock(&hub->lock);
    const uint64_t generation = hub->generation;
    pthread_mutex_unlock(&hub->lock);
    return generation;
}

/* The text that waits now; NULL if it does not. */
static const Text *queue(Session *session, const char *words)
{
    Text *text = words ? text_new(words, false) : NULL;
    if (!text) return NULL;
    text->users++;
    const bool sent = session_send(session, text);
    text_release(text);
    return sent ? text : NULL;
}

static bool send_words(Session *session, const char *words)
{
    return !words || queue(session, words);
}

/* With the lock. Pieces wait behind what was told before them, and what is told after them goes on where they end. */
static bool send_piece(Hub *hub, Session *session)
{
    const History *history = &hub->history;
    Past *past = &session->past;
    const bool first = !past->next, last = past->next + 1 >= history->n;
    char *words = words_of(json_pack("{ss sb sb so}", "topic", "history", "first", (int)first, "last", (int)last,
                                     "probes", history_json(history, past->next)));
    past->piece = queue(session, words);
    past->due = !last;
    past->next++;
    free(words);
    return past->piece;
}

bool hub_recall(Hub *hub, Session *session)
{
    bool sent = true;
    pthread_mutex_lock(&hub->lock);
    for (size_t k = 0; k < LATEST; k++) sent = sent && send_words(session, hub->latest[k]);
    const size_t from = hub->n_events > HUB_EVENTS ? hub->n_events - HUB_EVENTS : 0;
    for (size_t k = from; k < hub->n_events; k++) sent = sent && send_words(session, hub->events[k % HUB_EVENTS]);
    pthread_mutex_unlock(&hub->lock);
    return sent && hub_recall_history(hub, session);
}

bool hub_recall_history(Hub *hub, Session *session)
{
    if (!session->past.due)
        session->past = (Past){.due = true, .version = session->past.version, .piece = session->past.piece};
    return hub_recall_more(hub, session);
}

bool hub_recall_more(Hub *hub, Session *session)
{
    Past *past = &session->past;
    if (!session->welcome) return true;
    pthread_mutex_lock(&hub->lock);
    const uint64_t version = hub->history.version;
    if (past->version != version) *past = (Past){.due = true, .version = version, .piece = past->piece};
    const bool sent = !past->due || past->piece || send_piece(hub, session);
    pthread_mutex_unlock(&hub->lock);
    return sent;
}

void hub_set_directory(Hub *hub, const char *directory)
{
    pthread_mutex_lock(&hub->lock);
    snprintf(hub->directory, sizeof hub->directory, "%s", directory);
    pthread_mutex_unlock(&hub->lock);
}

void hub_directory(Hub *hub, char ret[static 4096])
{
    pthread_mutex_lock(&hub->lock);
    memcpy(ret, hub->directory, sizeof hub->directory);
    pthread_mutex_unlock(&hub->lock);
}

/* --- frames ------------------------------------------------------------------------------------------------------------ */

void hub_show(Hub *hub, Frame *frame)
{
    pthread_mutex_lock(&hub->lock);
    size_t k = 0;
    while (k < hub->n_frames && !wish_equal(&hub->frames[k]->wish, &frame->wish)) k++;
    if (k == FRAMES) k = 0;
    if (k < hub->n_frames) frame_free(hub->frames[k]);
    else hub->n_frames++;
    hub->frames[k] = frame;
    pthread_mutex_unlock(&hub->lock);
    hub->wake(hub->arg);
}

Frame *hub_take_frame(Hub *hub)
{
    pthread_mutex_lock(&hub->lock);
    Frame *frame = hub->n_frames ? hub->frames[--hub->n_frames] : NULL;
    pthread_mutex_unlock(&hub->lock);
    return frame;
}

void hub_set_demands(Hub *hub, size_t n, const Demand *demands)
{
    pthread_mutex_lock(&hub->lock);
    memcpy(hub->demands, demands, n * sizeof *demands);
    hub->n_demands = n;
    if (n) pthread_cond_signal(&hub->wanted);
    pthread_mutex_unlock(&hub->lock);
}

size_t hub_await_demands(Hub *hub, Demand ret[static HUB_BROWSERS])
{
    struct timespec until;
    clock_gettime(CLOCK_MONOTONIC, &until);
    until.tv_nsec += PATIENCE_MS * 1000000L;
    until.tv_sec += until.tv_nsec / 1000000000L;
    until.tv_nsec %= 1000000000L;
    pthread_mutex_lock(&hub->lock);
    int waited = 0;
    while (!hub->n_demands && !waited) waited = pthread_cond_timedwait(&hub->wanted, &hub->lock, &until);
    const size_t n = hub->n_demands;
    memcpy(ret, hub->demands, n * sizeof *ret);
    pthread_mutex_unlock(&hub->lock);
    return n;
}

/* --- commands ---------------------------------------------------------------------------------------------------------- */

bool hub_begin_command(Hub *hub)
{
    pthread_mutex_lock(&hub->lock);
    const bool may = hub->commands < HUB_COMMANDS;
    if (may) hub->commands++;
    pthread_mutex_unlock(&hub->lock);
    return may;
}

void hub_end_command(Hub *hub)
{
    pthread_mutex_lock(&hub->lock);
    hub->commands--;
    pthread_mutex_unlock(&hub->lock);
}
