/* SPDX-License-Identifier: BSD-3-Clause */
/* The door. A connection is known by its public key, not by its name, and what the key may do is looked up anew for each request: so a
 * change of the file holds for connections that are open. */
#include "net/access.h"

#include "base/clock.h"
#include "base/log.h"
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/inotify.h>
#include <sys/stat.h>
#include <unistd.h>

/* Domains, of which ZeroMQ says on which kind of endpoint somebody knocks. */
static const char LOCAL[] = "local", GATE[] = "gate", REMOTE[] = "remote";

/* A handshake takes two round trips; a connection that has not completed its own by then is ended. On this machine the daemon may be the slow one: it answers
 * nothing while it starts. */
enum { HANDSHAKE_S = 3, HANDSHAKE_LOCAL_S = 10 };

struct Access {
    void *socket; /* REP: ZeroMQ asks, we answer                */
    char directory[KEYS_PATH];
    KeyPair own;
    pthread_mutex_t lock; /* of the keys, as who sent a frame is asked for by other threads too */
    Keys keys;
    size_t counts[ROLE_ADMIN + 1]; /* of them, by role */
    struct stat seen;              /* of the file that the keys are from        */
    int watch;                     /* inotify of the directory, or -1           */
    bool tells;                    /* of the keys, in the log                   */
    double told;                   /* clock_now() when a refusal was last logged */
    unsigned long refused;
};

/* --- making ---------------------------------------------------------------------------------------------------------------- */

static void watch_directory(Access *access)
{
    const uint32_t events = IN_MOVED_TO | IN_MOVED_FROM | IN_CLOSE_WRITE | IN_DELETE | IN_ATTRIB;
    access->watch = inotify_init1(IN_CLOEXEC | IN_NONBLOCK);
    if (access->watch >= 0 && inotify_add_watch(access->watch, access->directory, events) >= 0) return;
    log_line(LOG_WARNING, "changes of the keys are noticed late, as %s cannot be watched: %s", access->directory,
             strerror(errno));
    if (access->watch >= 0) close(access->watch);
    access->watch = -1;
}

static MnsStatus read_own(Access *access, MnsError *error)
{
    char path[KEYS_PATH];
    key_path(access->directory, KEYS_DAEMON, path);
    const MnsStatus status = key_file_read(path, &access->own, error);
    if (status != MNS_E_NOT_FOUND) return status;
    return mns_fail(error, status,
                    "--listen takes keys, and there are none in %s: make one for whoever shall connect with `meniscus "
                    "keys new NAME --role operator`",
                    access->directory);
}

MnsStatus access_new(void *context, const char *keys, bool tells, Access **ret, MnsError *error)
{
    Access *access = calloc(1, sizeof *access);
    if (!access) return mns_fail(error, MNS_E_MEMORY, "no memory for the access control");
    *access = (Access){.watch = -1, .tells = tells, .told = -INFINITY};
    pthread_mutex_init(&access->lock, NULL);
    const int none = 0;
    MnsStatus status = MNS_OK;
    access->socket = zmq_socket(context, ZMQ_REP);
    if (access->socket) zmq_setsockopt(access->socket, ZMQ_LINGER, &none, sizeof none);
    if (!access->socket || zmq_bind(access->socket, "inproc://zeromq.zap.01"))
        status = mns_fail(error, MNS_E_MEMORY, "cannot make the socket of the access control: %s",
                          zmq_strerror(zmq_errno()));
    if (!status && keys && *keys) {
        snprintf(access->directory, sizeof access->directory, "%s", keys);
        status = read_own(access, error);
        if (!status) watch_directory(access);
        if (!status) access_refresh(access);
    }
    if (status) access_free(access);
    else *ret = access;
    return status;
}

void access_free(Access *access)
{
    if (!access) return;
    if (access->socket) zmq_close(access->socket);
    if (access->watch >= 0) close(access->watch);
    keys_done(&access->keys);
    pthread_mutex_destroy(&access->lock);
    explicit_bzero(&access->own, sizeof access->own);
    free(access);
}

void access_guard_local(const Access *access, void *socket)
{
    (void)access;
    const int patience = 1000 * HANDSHAKE_LOCAL_S;
    zmq_setsockopt(socket, ZMQ_ZAP_DOMAIN, LOCAL, strlen(LOCAL));
    zmq_setsockopt(socket, ZMQ_HANDSHAKE_IVL, &patience, sizeof patience);
}

/* Connections from the gate have a thread of ZeroMQ of their own, so that those from afar keep nobody on this machine waiting. They break only where one of
 * the two ends, and so nobody asks whether the other is there. */
void access_guard_gate(const Access *access, void *socket)
{
    (void)access;
    const int server = 1, never = 0;
    const uint64_t second_thread = 2;
    zmq_setsockopt(socket, ZMQ_AFFINITY, &second_thread, sizeof second_thread);
    zmq_setsockopt(socket, ZMQ_HEARTBEAT_IVL, &never, sizeof never);
    zmq_setsockopt(socket, ZMQ_ZAP_DOMAIN, GATE, strlen(GATE));
    zmq_setsockopt(socket, ZMQ_PLAIN_SERVER, &server, sizeof server);
}

/* There is no secret in it: the gate has made sure of the key, and nobody else can open the socket. */
void access_introduce(void *socket, const char *public_key)
{
    zmq_setsockopt(socket, ZMQ_PLAIN_USERNAME, public_key, strlen(public_key));
    zmq_setsockopt(socket, ZMQ_PLAIN_PASSWORD, GATE, strlen(GATE));
}

void access_guard_remote(const Access *access, void *socket)
{
    const int server = 1, patience = 1000 * HANDSHAKE_S;
    zmq_setsockopt(socket, ZMQ_ZAP_DOMAIN, REMOTE, strlen(REMOTE));
    zmq_setsockopt(socket, ZMQ_CURVE_SERVER, &server, sizeof server);
    zmq_setsockopt(socket, ZMQ_CURVE_SECRETKEY, access->own.secret_key, KEY_TEXT);
    zmq_setsockopt(socket, ZMQ_HANDSHAKE_IVL, &patience, sizeof patience);
}

void *access_socket(const Access *access)
{
    return access->socket;
}

int access_watch(const Access *access)
{
    return access->watch;
}

/* --- the file of keys ------------------------------------------------------------------------------------------------------- */

static bool same_time(struct timespec a, struct timespec b)
{
    return a.tv_sec == b.tv_sec && a.tv_nsec == b.tv_nsec;
}

static bool same_file(const struct stat *a, const struct stat *b)
{
    return a->st_dev == b->st_dev && a->st_ino == b->st_ino && a->st_size == b->st_size &&
           same_time(a->st_mtim, b->st_mtim) && same_time(a->st_ctim, b->st_ctim);
}

static bool is_one_gone(const Keys *before, const Keys *now)
{
    for (size_t k = 0; k < before->n; k++)
        if (!keys_find(now, before->keys[k].public_key)) return true;
    return false;
}

static bool same_keys(const Keys *a, const Keys *b)
{
    bool same = a->n == b->n;
    for (size_t k = 0; same && k < a->n; k++) {
        const Key *x = &a->keys[k], *y = &b->keys[k];
        same = x->role == y->role && !strcmp(x->name, y->name) && !strcmp(x->public_key, y->public_key);
    }
    return same;
}

/* Has something happened in the directory? */
static bool take_news(const Access *access)
{
    char events[4096];
    bool news = false;
    while (access->watch >= 0 && read(access->watch, events, sizeof events) > 0) news = true;
    return news;
}

static void tell_keys(const Access *access, const Keys *keys, const char *path)
{
    if (!access->tells || (same_keys(&access->keys, keys) && keys->n)) return;
    if (keys->n) log_line(LOG_INFORMATION, "%zu key%s let in from afar", keys->n, keys->n == 1 ? " is" : "s are");
    else
        log_line(LOG_WARNING, "nobody is let in from afar: there are no keys in %s; `meniscus keys new` makes one",
                 path);
}

/* The keys that are let in: none while others have access to what they are told from, or to our own. */
static MnsStatus read_keys(const Access *access, Keys *ret, MnsError *error)
{
    char own[KEYS_PATH];
    key_path(access->directory, KEYS_DAEMON, own);
    const MnsStatus status = key_file_check(own, error);
    return status ? status : keys_read(access->directory, ret, error);
}

/* What is looked at is told by its times, and read again on news too: within a tick of the file system's clock it may change and look
 * the same. */
bool access_refresh(Access *access)
{
    char path[KEYS_PATH + 16];
    struct stat info;
    Keys keys = {0};
    MnsError error;
    if (!access->directory[0]) return false;
    const bool news = take_news(access);
    snprintf(path, sizeof path, "%s/" KEYS_AUTHORIZED, access->directory);
    if (stat(path, &info)) info = (struct stat){.st_size = -1};
    if (!news && same_file(&info, &access->seen)) return false;
    access->seen = info; /* looked at before it is read: a change in between is another one */
    if (!read_keys(access, &keys, &error)) tell_keys(access, &keys, path);
    else if (access->tells) log_line(LOG_ERROR, "nobody is let in from afar: %s", error.text);
    const bool gone = is_one_gone(&access->keys, &keys);
    pthread_mutex_lock(&access->lock);
    keys_done(&access->keys);
    access->keys = keys;
    pthread_mutex_unlock(&access->lock);
    memset(access->counts, 0, sizeof access->counts);
    for (size_t k = 0; k < keys.n; k++) access->counts[keys.keys[k].role]++;
    return gone;
}

size_t access_count(const Access *access, Role role)
{
    return access->counts[role];
}

/* --- who is who ------------------------------------------------------------------------------------------------------------- */

/* The frames of a question: RFC 27. What is longer than there is room for is nothing we could let in. */
typedef struct Question {
    char version[8], id[256], domain[8], address[64], identity[8], mechanism[8];
    char key[KEY_TEXT + 1]; /* 32 bytes of it, or its text */
    size_t id_size, key_size;
    int n;
} Question;

static bool receive(void *socket, Question *ret)
{
    struct {
        void *to;
        size_t room;
    } parts[] = {{ret->version, sizeof ret->version - 1},
                 {ret->id, sizeof ret->id - 1},
                 {ret->domain, sizeof ret->domain - 1},
                 {ret->address, sizeof ret->address - 1},
                 {ret->identity, sizeof ret->identity - 1},
                 {ret->mechanism, sizeof ret->mechanism - 1},
                 {ret->key, sizeof ret->key - 1}};
    enum { PARTS = sizeof parts / sizeof *parts };
    char surplus[8];
    int more = 1;
    size_t size = sizeof more;
    *ret = (Question){.n = 0};
    for (; more; ret->n++) {
        const bool known = ret->n < PARTS;
        const int got = zmq_recv(socket, known ? parts[ret->n].to : surplus,
                                 known ? parts[ret->n].room : sizeof surplus, ret->n ? 0 : ZMQ_DONTWAIT);
        if (got < 0) return false;
        if (ret->n == 1) ret->id_size = (size_t)got < sizeof ret->id ? (size_t)got : 0;
        if (ret->n == 6) ret->key_size = (size_t)got;
        zmq_getsockopt(socket, ZMQ_RCVMORE, &more, &size);
    }
    return true;
}

/* The user to note with all that comes over the connection; NULL: it is refused. */
static const char *judge(const Access *access, const Question *question)
{
    static char text[KEY_TEXT];
    if (strcmp(question->version, "1.0") != 0) return NULL;
    if (!strcmp(question->domain, LOCAL) && !strcmp(question->mechanism, "NULL")) return LOCAL;
    const bool gate = !strcmp(question->domain, GATE) && !strcmp(question->mechanism, "PLAIN");
    const bool remote = !strcmp(question->domain, REMOTE) && !strcmp(question->mechanism, "CURVE");
    if (!gate && !remote) return NULL;
    if (remote && (question->key_size != 32 || !zmq_z85_encode(text, (const uint8_t *)question->key, 32))) return NULL;
    const Key *key = keys_find(&access->keys, gate ? question->key : text);
    return key ? key->public_key : NULL;
}

/* Whoever tries keys must not fill the log. */
static void note_refusal(Access *access, const Question *question)
{
    const double now = clock_now();
    access->refused++;
    if (now < access->told + 1) return;
    access->told = now;
    log_line(LOG_WARNING,
             "refused a connection from %s: its key is not among those that are let in (%lu refused so far)",
             question->address, access->refused);
}

bool access_answer(Access *access)
{
    Question question;
    if (!receive(access->socket, &question)) return false;
    const char *user = judge(access, &question);
    if (!user) note_refusal(access, &question);
    zmq_send(access->socket, "1.0", 3, ZMQ_SNDMORE);
    zmq_send(access->socket, question.id, question.id_size, ZMQ_SNDMORE);
    zmq_send(access->socket, user ? "200" : "400", 3, ZMQ_SNDMORE);
    zmq_send(access->socket, "", 0, ZMQ_SNDMORE);
    zmq_send(access->socket, user ? user : "", user ? strlen(user) : 0, ZMQ_SNDMORE);
    zmq_send(access->socket, "", 0, 0);
    return true;
}

bool access_who(Access *access, zmq_msg_t *frame, Who *ret)
{
    const char *user = zmq_msg_gets(frame, "User-Id");
    if (!user) return false;
    if (!strcmp(user, LOCAL)) {
        *ret = (Who){WHO_LOCAL, ROLE_ADMIN};
        return true;
    }
    pthread_mutex_lock(&access->lock);
    const Key *key = keys_find(&access->keys, user);
    if (key) *ret = (Who){.role = key->role};
    if (key) memcpy(ret->name, key->name, sizeof ret->name);
    pthread_mutex_unlock(&access->lock);
    return key != NULL;
}
