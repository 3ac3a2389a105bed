/* SPDX-License-Identifier: BSD-3-Clause */
/* The books of one stream: what was granted, what is under way, what was skipped. No socket, no memory of its own. */
#ifndef NET_SUBSCRIPTION_H
#define NET_SUBSCRIPTION_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

static const uint64_t CREDIT_MOST = UINT64_C(1) << 30; /* bytes: more than any window, and sums do not overflow */

typedef struct Subscription {
    uint64_t credit;       /* bytes that may still be sent                                  */
    size_t chunk;          /* bytes of the item in one message at most                      */
    uint64_t sequence;     /* of the item begun last                                        */
    uint64_t taken;        /* its number among those that were due in the feed              */
    uint64_t offset, size; /* of the item begun last: bytes sent, and all                   */
    bool under_way;        /* the rest of it is still to be sent                            */
    bool opened;           /* the first message of it is, which tells what it is            */
    uint64_t before;       /* `taken` as it was before                                      */
    uint64_t counted;      /* up to here, those skipped are counted: subscription_skips()   */
} Subscription;

/* taken: how many have been due in the feed so far: they are none of its business. */
void subscription_begin(Subscription *s, size_t chunk, uint64_t credit, uint64_t taken);

void subscription_grant(Subscription *s, uint64_t bytes);

/* Is the newest of the feed, of this number, one that this stream has not had? */
bool subscription_wants(const Subscription *s, uint64_t number);

/* Begin an item. number: in the feed; 0: one outside of it. Returns how many that were due are skipped with it. */
uint64_t subscription_take(Subscription *s, uint64_t number, uint64_t size);

/* None of it is sent yet, and a newer one may come: as if it had not been begun. skipped: what taking it returned. */
void subscription_put_back(Subscription *s, uint64_t skipped);

/* How many more will never be sent than when this was last asked, whether or not this stream ever gets to hear of it.
 *  newest  number of the one that may still be sent; 0: there is none; one more than `due`: no other will be
 *  due     of the last that was due in the feed: it may still be in the making */
uint64_t subscription_skips(Subscription *s, uint64_t newest, uint64_t due);

/* Bytes of the item in the next message. */
size_t subscription_next(const Subscription *s);

/* Pay for a message with so many bytes in all; false, and nothing is done, if the credit does not cover it. */
bool subscription_pay(Subscription *s, size_t cost);

/* So many bytes of the item are sent. True if it is whole with them. */
bool subscription_sent(Subscription *s, size_t n);

/* Give up what is under way; sequence 0: whatever it is. False if that is not under way. */
bool subscription_cancel(Subscription *s, uint64_t sequence);

/* Go back to where the bytes ended that came. False if that is not within the item begun last. */
bool subscription_resume(Subscription *s, uint64_t sequence, uint64_t offset);

#endif
