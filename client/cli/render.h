/* SPDX-License-Identifier: BSD-3-Clause */
/* Draw the particles of a snapshot file or of a live daemon as a PNG picture. */
#ifndef CLI_RENDER_H
#define CLI_RENDER_H

/* The command `meniscus render`: argv[0] is the word "render", then what follows it on the command line.
 * Returns an exit code of <meniscus/exit.h>; on failure the sentence has gone to standard error and no file is left. */
int command_render(int argc, char **argv);

#endif
