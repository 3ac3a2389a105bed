/* SPDX-License-Identifier: BSD-3-Clause */
/* Who is connected, and who must go when there are too many: the one that has been there longest. So whoever comes is answered,
 * whatever those say or do not say who came before. */
#ifndef HTTP_GUESTS_H
#define HTTP_GUESTS_H

#include <stdbool.h>
#include <stdint.h>

enum { GUESTS = 64 };

typedef struct Guest {
    struct Guest *next; /* who came after */
    int fd;
    bool gone; /* shown out, and not yet closed */
} Guest;

typedef struct Guests {
    Guest *first, *last;
    unsigned n; /* those that are not gone */
    uint64_t crowded_out;
} Guests;

/* A connection is there, by its socket, which stays whose it is. If there are GUESTS of them, the first is shut down, which its owner
 * hears of as if the other side had hung up. Returns what to give to guests_leave(); NULL if there is no memory to keep count. */
Guest *guests_enter(Guests *guests, int fd);

/* It is about to be closed. NULL is fine. */
void guests_leave(Guests *guests, Guest *guest);

#endif
