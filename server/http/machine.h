/* SPDX-License-Identifier: BSD-3-Clause */
/* What the operating system says of this process and of its disk. */
#ifndef HTTP_MACHINE_H
#define HTTP_MACHINE_H

/* NAN where it does not say. */
typedef struct ProcessFigures {
    double cpu;               /* time of all threads [s] */
    double resident, virtual; /* [bytes]                 */
    double fds, max_fds;      /* open files and sockets  */
} ProcessFigures;

typedef struct DiskFigures {
    double size, free; /* [bytes]; free: for this user, NAN both if it is not known */
    int refused;       /* why nothing can be written there, an errno; 0: it can     */
} DiskFigures;

void process_look(ProcessFigures *ret);

/* Of the disk that a directory is on, and of whether files can be made in it. */
void disk_look(const char *directory, DiskFigures *ret);

#endif
