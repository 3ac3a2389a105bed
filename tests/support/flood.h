/* SPDX-License-Identifier: BSD-3-Clause */
/* Whoever begins handshakes and ends none, as fast as a machine can. */
#ifndef SUPPORT_FLOOD_H
#define SUPPORT_FLOOD_H

/* Connections to a port of this machine that say how they would like to be secured, and then no more, at this rate [1/s] for so many
 * seconds. The oldest are forgotten. @return how many were begun. */
unsigned long flood_handshakes(int port, double rate, double seconds);

#endif
