/* SPDX-License-Identifier: BSD-3-Clause */
/* meniscus: steer, watch and question simulations from the command line. */
#include "client/cli/command.h"
#include "common/host/process.h"

int main(int argc, char **argv)
{
    process_main(argc, argv, command_main);
}
