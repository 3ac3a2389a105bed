/* SPDX-License-Identifier: BSD-3-Clause */
/* Handshakes that are begun and not ended: usage: half_open PORT RATE SECONDS. Prints how many, as a JSON line. */
#include "tests/support/flood.h"
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/prctl.h>

int main(int argc, char **argv)
{
    if (argc != 4) {
        fputs("usage: half_open PORT RATE SECONDS\n", stderr);
        return 2;
    }
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    printf("{\"begun\": %lu}\n", flood_handshakes(atoi(argv[1]), atof(argv[2]), atof(argv[3])));
    return 0;
}
