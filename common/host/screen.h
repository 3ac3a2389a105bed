/* SPDX-License-Identifier: BSD-3-Clause */
/* Standard output and standard error as people read them. */
#ifndef COMMON_HOST_SCREEN_H
#define COMMON_HOST_SCREEN_H

#include <meniscus/status.h>

/* From here on, what a terminal would obey or would not show is written as text_escaped() does, but for the ends of lines and tabs: whatever part of
 * a message, of this program or of a library, came from a command line, a path or another machine. */
void screen_guard(void);

/* Standard output passes as it is: for programs that move the cursor, and for copies of files. They escape what comes from outside by text_shown(). */
void screen_pass(void);

/* Have what was printed so far where it goes. MNS_E_NO_SPACE, MNS_E_IO: that, or something before it, could not be written. */
MnsStatus screen_flush(MnsError *error);

/* The same, for an errno that is known. */
MnsStatus screen_fail(int number, MnsError *error);

/* Close standard output. 0, or errno of the first write that failed. */
int screen_end(void);

#endif
