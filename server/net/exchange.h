/* SPDX-License-Identifier: BSD-3-Clause */
/* A request and its reply, on their way through the daemon: an order that remembers who asked and what for. */
#ifndef NET_EXCHANGE_H
#define NET_EXCHANGE_H

#include "http/traffic.h"
#include "meniscus.pb-c.h"
#include "run/run.h"

enum { EXCHANGE_ARRAYS = MNS_MAX_FIELDS, EXCHANGE_IDENTITY = 256, EXCHANGE_SENDERS = 4 };

/* A client's connection. */
typedef struct Sender {
    uint8_t identity[EXCHANGE_IDENTITY];
    size_t size;
    Who who;
    double came;  /* [s] when the request came, of clock_now() */
    bool no_wait; /* it wants to know when a command is scheduled, and not what comes of it */
} Sender;

struct Handler;

typedef struct Exchange {
    Order order; /* first, so that an order that comes back is an exchange */
    const struct Handler *handler;
    Meniscus__Request *request;
    uint64_t command;                 /* hash of what the request asks for and when, whatever its id and deadline */
    Meniscus__Reply *reply;           /* the result goes here; all in it from malloc */
    void *arrays[EXCHANGE_ARRAYS];    /* [reply->n_arrays] raw frames, from malloc */
    size_t sizes[EXCHANGE_ARRAYS];    /* [bytes] */
    bool at_step;                     /* it takes effect between two steps */
    bool sealed;                      /* the reply is complete             */
    bool scheduled;                   /* it waits for its moment, and would outlive a crash */
    uint64_t epoch;                   /* of the daemon                     */
    const StreamTraffic *streams;     /* the same; NULL: not counted       */
    unsigned allowed;                 /* if it was refused for the state: where it would be possible */
    Sender senders[EXCHANGE_SENDERS]; /* who has sent it, the latest last; each gets the reply */
    size_t n_senders;                 /* 0: nobody wants it                                    */
} Exchange;

/* Hash of what a request asks for and when, whatever its id, its deadline, who asks and whether they wait; 0 if there is no memory to find it. */
uint64_t exchange_command(const Meniscus__Request *request);

/* Takes over the request. NULL if there is no memory; then the request is freed. */
Exchange *exchange_new(Meniscus__Request *request, const Who *who);

/* NULL is fine. */
void exchange_free(Exchange *exchange);

/* Add a raw frame to the reply: takes over data, from malloc.
 *  type   as numpy writes it, "<f8"
 *  shape  [n_shape] */
MnsStatus exchange_add(Exchange *exchange, const char *name, const char *type, const char *unit, const uint64_t *shape,
                       size_t n_shape, void *data, size_t size, MnsError *error);

/* Complete the reply from the order's answer; once more if that has become a failure since. */
void exchange_seal(Exchange *exchange);

/* A value for the reply: text if not NULL, else a number unless it is NAN. NULL if there is no memory. */
Meniscus__Value *exchange_value(const char *name, double number, const char *text, const char *unit);

/* Make values the result, all of them complete. n_values may be fewer than asked for if there was no memory. */
MnsStatus exchange_values(Exchange *exchange, Meniscus__Value **values, size_t n, MnsError *error);

#endif
