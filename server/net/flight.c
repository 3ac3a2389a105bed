/* SPDX-License-Identifier: BSD-3-Clause */
/* Bytes on their way. */
#include "net/flight.h"

#include <stdlib.h>

Flight *flight_new(void)
{
    Flight *flight = calloc(1, sizeof *flight);
    if (flight) flight->users = 1;
    return flight;
}

void flight_begin(Flight *flight, size_t bytes)
{
    flight->users++;
    flight->bytes += bytes;
}

void flight_end(Flight *flight, size_t bytes)
{
    flight->bytes -= bytes;
    flight_leave(flight);
}

void flight_leave(Flight *flight)
{
    if (flight && !--flight->users) free(flight);
}
