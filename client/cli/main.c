/* SPDX-License-Identifier: BSD-3-Clause */
/* meniscus: steer, watch and question simulations from the command line. */
#include "client/cli/command.h"

int main(int argc, char **argv)
{
    return command_main(argc, argv);
}
