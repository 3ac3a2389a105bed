/* SPDX-License-Identifier: BSD-3-Clause */
/* Who is connected. */
#include "http/guests.h"

#include <stdlib.h>
#include <sys/socket.h>

static void show_out_first(Guests *guests)
{
    Guest *guest = guests->first;
    while (guest && guest->gone) guest = guest->next;
    if (!guest) return;
    shutdown(guest->fd, SHUT_RDWR);
    guest->gone = true;
    guests->n--;
    guests->crowded_out++;
}

Guest *guests_enter(Guests *guests, int fd)
{
    Guest *guest = malloc(sizeof *guest);
    if (!guest) return NULL;
    if (guests->n >= GUESTS) show_out_first(guests);
    *guest = (Guest){.fd = fd};
    if (guests->last) guests->last->next = guest;
    else guests->first = guest;
    guests->last = guest;
    guests->n++;
    return guest;
}

void guests_leave(Guests *guests, Guest *guest)
{
    Guest *before = NULL, *at = guests->first;
    if (!guest) return;
    for (; at != guest; at = at->next) before = at;
    if (before) before->next = guest->next;
    else guests->first = guest->next;
    if (guests->last == guest) guests->last = before;
    guests->n -= !guest->gone;
    free(guest);
}
