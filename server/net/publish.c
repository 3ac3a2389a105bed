/* SPDX-License-Identifier: BSD-3-Clause */
/* Telemetry. */
#include "net/publish.h"

#include "base/clock.h"
#include "meniscus.pb-c.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <zmq.h>

enum { TOPICS = TRAFFIC_TOPICS };

typedef struct Topic {
    uint64_t sequence;
    uint8_t *last; /* [size] the last message, packed; NULL before the first */
    bool welcome;  /* somebody has subscribed since it was sent               */
    bool held;     /* it was not sent yet, as they are very many              */
    double sent;   /* clock_now() of the last that was [s]                    */
    size_t size;
} Topic;

struct Publisher {
    void *socket;
    uint64_t epoch;
    TopicTraffic *traffic;
    double interval; /* [s] between two live messages of a topic, at least */
    Topic topics[TOPICS];
};

/* From so many on what is live is spread. Fewer get each message at once: at five a second it takes few percent of a processor. */
enum { CROWD = 200, CROWD_MAX = 1000 };
static const double SPREAD = 1e-3; /* [s] for each of a crowd */

static const char *const topic_names[TOPICS + 1] = {"event", "log", "progress", "probe"};

const char *const *publisher_topics(void)
{
    return topic_names;
}

static int topic_of(NoteKind kind)
{
    switch (kind) {
    case NOTE_EVENT: return TRAFFIC_EVENT;
    case NOTE_LOG: return TRAFFIC_LOG;
    case NOTE_PROGRESS: return TRAFFIC_PROGRESS;
    case NOTE_PROBES: return TRAFFIC_PROBE;
    default: return -1;
    }
}

static bool is_live(NoteKind kind)
{
    return kind == NOTE_PROGRESS || kind == NOTE_PROBES;
}

Publisher *publisher_new(void *socket, uint64_t epoch, TopicTraffic *traffic)
{
    Publisher *publisher = calloc(1, sizeof *publisher);
    if (!publisher) return NULL;
    publisher->socket = socket;
    publisher->epoch = epoch;
    publisher->traffic = traffic;
    for (int k = 0; k < TOPICS; k++) traffic[k].name = topic_names[k];
    return publisher;
}

void publisher_free(Publisher *publisher)
{
    for (int k = 0; publisher && k < TOPICS; k++) free(publisher->topics[k].last);
    free(publisher);
}

/* False if there is no memory; then there is nothing to close. */
static bool copy_to(zmq_msg_t *part, const void *data, size_t size)
{
    if (zmq_msg_init_size(part, size)) return false;
    memcpy(zmq_msg_data(part), data, size);
    return true;
}

/* Both parts are there before the first is sent: a message that is begun is ended. */
static void send_last(const Publisher *publisher, int k)
{
    const Topic *topic = &publisher->topics[k];
    zmq_msg_t name, body;
    if (!copy_to(&name, topic_names[k], strlen(topic_names[k]))) return;
    if (copy_to(&body, topic->last, topic->size)) {
        if (zmq_msg_send(&name, publisher->socket, ZMQ_SNDMORE | ZMQ_DONTWAIT) >= 0)
            zmq_msg_send(&body, publisher->socket, ZMQ_DONTWAIT);
        zmq_msg_close(&body); /* empty if it was sent */
    }
    zmq_msg_close(&name);
}

void publisher_welcome(Publisher *publisher, const char *prefix, size_t size)
{
    for (int k = 0; k < TOPICS; k++) {
        const size_t n = strlen(topic_names[k]);
        if (size <= n && !memcmp(topic_names[k], prefix, size)) publisher->topics[k].welcome = true;
    }
}

void publisher_greet(Publisher *publisher)
{
    for (int k = 0; k < TOPICS; k++) {
        if (publisher->topics[k].welcome && publisher->topics[k].last) send_last(publisher, k);
        publisher->topics[k].welcome = false;
    }
}

void publisher_crowd(Publisher *publisher, long n)
{
    publisher->interval = n > CROWD ? SPREAD * (double)(n < CROWD_MAX ? n : CROWD_MAX) : 0;
}

static void send_kept(Publisher *publisher, int k)
{
    Topic *topic = &publisher->topics[k];
    topic->held = false;
    topic->sent = clock_now();
    publisher->traffic[k].messages++;
    publisher->traffic[k].bytes += topic->size;
    send_last(publisher, k);
}

double publisher_flush(Publisher *publisher)
{
    double next = INFINITY;
    for (int k = 0; k < TOPICS; k++) {
        const Topic *topic = &publisher->topics[k];
        if (topic->held && clock_now() >= topic->sent + publisher->interval) send_kept(publisher, k);
        if (topic->held) next = fmin(next, topic->sent + publisher->interval);
    }
    return next;
}

/* What a run comes to is told whole: the sample and the progress of where it stands before the event that says why. */
static void send_held(Publisher *publisher)
{
    for (int k = 0; k < TOPICS; k++)
        if (publisher->topics[k].held) send_kept(publisher, k);
}

/* Number, pack and keep a message, and send it unless it comes too soon for that. */
static void send_message(Publisher *publisher, int k, Meniscus__Telemetry *message, const Note *note)
{
    Topic *topic = &publisher->topics[k];
    message->has_daemon_epoch = message->has_sequence = message->has_step = message->has_time = true;
    message->daemon_epoch = publisher->epoch;
    message->sequence = ++topic->sequence;
    message->step = note->step;
    message->time = note->t;
    const size_t size = meniscus__telemetry__get_packed_size(message);
    uint8_t *packed = malloc(size + 1);
    if (!packed) return;
    meniscus__telemetry__pack(message, packed);
    free(topic->last);
    topic->last = packed;
    topic->size = size;
    publisher->traffic[k].thinned += topic->held;
    topic->held = is_live(note->kind) && clock_now() < topic->sent + publisher->interval;
    if (!topic->held) send_kept(publisher, k);
}

static void send_text(Publisher *publisher, int k, const Note *note)
{
    Meniscus__Telemetry message = MENISCUS__TELEMETRY__INIT;
    Meniscus__Event event = MENISCUS__EVENT__INIT;
    Meniscus__Log line = MENISCUS__LOG__INIT;
    if (note->kind == NOTE_EVENT) {
        event.has_state = true;
        event.state = (Meniscus__State)note->state;
        event.what = (char *)note->word;
        event.text = (char *)note->text;
        message.item_case = MENISCUS__TELEMETRY__ITEM_EVENT;
        message.event = &event;
    } else {
        line.has_level = true;
        line.level = (uint32_t)note->level;
        line.text = (char *)note->text;
        message.item_case = MENISCUS__TELEMETRY__ITEM_LOG;
        message.log = &line;
    }
    send_message(publisher, k, &message, note);
}

static void send_progress(Publisher *publisher, int k, const Note *note)
{
    Meniscus__Telemetry message = MENISCUS__TELEMETRY__INIT;
    Meniscus__Progress progress = MENISCUS__PROGRESS__INIT;
    progress.has_state = progress.has_fraction = progress.has_time_step = progress.has_end_time = true;
    progress.state = (Meniscus__State)note->state;
    progress.fraction = note->fraction;
    progress.time_step = note->dt;
    progress.end_time = note->end_time;
    progress.has_eta_s = isfinite(note->eta);
    progress.eta_s = note->eta;
    progress.has_steps_per_second = isfinite(note->steps_per_second);
    progress.steps_per_second = note->steps_per_second;
    message.item_case = MENISCUS__TELEMETRY__ITEM_PROGRESS;
    message.progress = &progress;
    send_message(publisher, k, &message, note);
}

static void send_probes(Publisher *publisher, int k, const Note *note)
{
    const MnsCase *c = note->document->c;
    Meniscus__Value values[MNS_MAX_PROBES], *pointers[MNS_MAX_PROBES];
    Meniscus__Telemetry message = MENISCUS__TELEMETRY__INIT;
    Meniscus__Values all = MENISCUS__VALUES__INIT;
    for (size_t p = 0; p < c->n_probes; p++) {
        meniscus__value__init(&values[p]);
        values[p].name = c->probes[p].name;
        values[p].has_number = !isnan(note->values[p]);
        values[p].number = note->values[p];
        values[p].unit = (char *)mns_probe_unit(&c->probes[p]);
        pointers[p] = &values[p];
    }
    all.n_values = c->n_probes;
    all.values = pointers;
    message.item_case = MENISCUS__TELEMETRY__ITEM_PROBES;
    message.probes = &all;
    send_message(publisher, k, &message, note);
}

static void forget(Topic *topic)
{
    free(topic->last);
    topic->last = NULL;
    topic->size = 0;
    topic->held = false;
}

/* In these states a run begins, anew or from a checkpoint, or there is none: what was heard last was of another time line, and whoever
 * comes now would take it for where the run is. */
static bool begins_anew(const Note *note)
{
    return note->state == RUN_EMPTY || note->state == RUN_LOADING || note->state == RUN_READY;
}

void publisher_send(Publisher *publisher, const Note *note)
{
    const int k = topic_of(note->kind);
    if (note->kind == NOTE_EVENT) send_held(publisher);
    if (note->kind == NOTE_EVENT && begins_anew(note)) {
        forget(&publisher->topics[TRAFFIC_PROGRESS]);
        forget(&publisher->topics[TRAFFIC_PROBE]);
    }
    if (note->kind == NOTE_EVENT || note->kind == NOTE_LOG) send_text(publisher, k, note);
    else if (note->kind == NOTE_PROGRESS) send_progress(publisher, k, note);
    else if (note->kind == NOTE_PROBES) send_probes(publisher, k, note);
}
