/* SPDX-License-Identifier: BSD-3-Clause */
/* What `meniscus doctor` looks at: each thing gets one verdict, one line, and where it is not well, what to do. */
#ifndef CLI_DOCTOR_H
#define CLI_DOCTOR_H

#include "client/cli/command.h"

typedef enum Verdict { WELL, WARNING, PROBLEM } Verdict;

typedef struct Doctor {
    const Invocation *in;
    json_t *checks; /* all that was said; printed at the end if JSON is asked for */
    unsigned counts[PROBLEM + 1];
    char name[128];       /* of the daemon that is looked for; "default" where only its address is known */
    char state_dir[4096]; /* where it keeps its runs; empty until somebody knows */
} Doctor;

/* `remedy`: what to do; NULL if nothing needs to be done. */
void doctor_say(Doctor *doctor, Verdict verdict, const char *name, const char *remedy, const char *format, ...)
    __attribute__((format(printf, 5, 6)));

/* Of the machine. */
void doctor_check_programs(Doctor *doctor); /* versions, and the instructions that the solver would use */
void doctor_check_threads(Doctor *doctor);
void doctor_check_memory(Doctor *doctor);
void doctor_check_cases(Doctor *doctor);
void doctor_check_extras(Doctor *doctor); /* what only some commands and people need */

/* Of what daemons share with their clients. */
void doctor_check_sockets(Doctor *doctor);
void doctor_check_daemon(Doctor *doctor); /* before the next, as it says where its files are */
void doctor_check_state(Doctor *doctor);
void doctor_check_keys(Doctor *doctor);

#endif
