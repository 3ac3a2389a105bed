/* SPDX-License-Identifier: BSD-3-Clause */
/* What this program would compute with on this machine. */
#include "batch/machine.h"
#include <jansson.h>
#include <meniscus/exit.h>
#include <meniscus/sim.h>
#include <stdio.h>

int machine_print(bool json)
{
    if (json) {
        json_t *all =
            json_pack("{ss ss ss}", "version", MENISCUS_VERSION, "level", mns_level(), "arithmetic", mns_arithmetic());
        json_dumpf(all, stdout, JSON_COMPACT);
        putchar('\n');
        json_decref(all);
    } else {
        printf("meniscusd %s, instructions %s, %s products and sums\n", MENISCUS_VERSION, mns_level(),
               mns_arithmetic());
    }
    return MNS_EXIT_DONE;
}
