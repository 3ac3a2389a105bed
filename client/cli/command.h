/* SPDX-License-Identifier: BSD-3-Clause */
/* The commands of `meniscus`: what each is called, takes and does. */
#ifndef CLI_COMMAND_H
#define CLI_COMMAND_H

#include "client/cli/options.h"
#include <jansson.h>
#include <meniscus/client.h>

typedef struct Command Command;

/* One call of the program. */
typedef struct Invocation {
    const Command *command;
    Options options;
    bool json;
    double timeout; /* [s]; negative: none */
    bool has_id;
    uint8_t id[MNS_REQUEST_ID_SIZE];
    bool has_if_step;
    uint64_t if_step;
    uint64_t if_version; /* 0: whichever */
    uint64_t lease;      /* epoch; 0: none */
    bool has_at_step, has_at_time;
    uint64_t at_step;
    double at_time;    /* [s] */
    MnsClient *client; /* NULL until command_connect() */
    int code;          /* exit code that the command wants, whatever its status; 0: none */
} Invocation;

struct Command {
    const char *group; /* heading of the commands from here on; NULL: the same as before */
    const char *name, *arguments, *help;
    const char *details; /* what `meniscus help NAME` says besides; wrapped where it is printed */
    OptionSet options;   /* those it takes besides the global ones */
    bool is_alone;       /* talks to no daemon: of the global options it takes --output and --help */
    unsigned exits;      /* EXIT_ bits of the codes it may end with besides the common ones */
    unsigned min_words, max_words;
    bool is_long;        /* may rightly take hours, so that no time limit is set by itself */
    const char *request; /* entry of the protocol's Request that it sends; NULL: none, or several */
    MnsStatus (*call)(MnsClient *client, MnsReply **ret_reply, MnsError *error); /* for command_simple() */
    MnsStatus (*run)(Invocation *in, MnsError *error);
};

/* Bits of Command.exits. */
enum { EXIT_BAD_CASE = 1, EXIT_DIVERGED = 2, EXIT_IO = 4, EXIT_AGAIN = 8, EXIT_TIMEOUT = 16 };

/* All options of a command. */
OptionSet command_options(const Command *command);

/* All commands; ends with a NULL name. */
extern const Command command_table[];

/* MNS_E_INVALID with a suggestion if there is none of that name. */
MnsStatus command_find(const char *name, const Command **ret, MnsError *error);

/* The whole program: parse, connect, run, print. Returns the exit code. */
int command_main(int argc, char **argv);

/* Exit code of <meniscus/exit.h> for a failure. `is_load`: the case is to blame for invalid input. */
int command_exit_code(MnsStatus status, bool is_load);

/* A clock that nobody puts back [s]. */
double command_clock(void);

/* Connect to the daemon that the options name. A command does this when its words are understood. */
MnsStatus command_connect(Invocation *in, MnsError *error);

/* Why the run of the daemon stopped in FAULT, as a failure of this command. */
MnsStatus command_fault(Invocation *in, MnsError *error);

/* Pass a status through; a failure becomes one of usage. */
MnsStatus command_usage(Invocation *in, MnsStatus status);

/* --- what they do ------------------------------------------------------------------------------------------------- */

MnsStatus command_simple(Invocation *in, MnsError *error); /* a request without particulars */
MnsStatus command_load(Invocation *in, MnsError *error);
MnsStatus command_step(Invocation *in, MnsError *error);
MnsStatus command_run_until(Invocation *in, MnsError *error);
MnsStatus command_stop(Invocation *in, MnsError *error);
MnsStatus command_restore(Invocation *in, MnsError *error);
MnsStatus command_snapshot(Invocation *in, MnsError *error);
MnsStatus command_checkpoint(Invocation *in, MnsError *error);
MnsStatus command_breakpoint(Invocation *in, MnsError *error);
MnsStatus command_cancel(Invocation *in, MnsError *error);
MnsStatus command_shutdown(Invocation *in, MnsError *error);
MnsStatus command_set(Invocation *in, MnsError *error);
MnsStatus command_rollback(Invocation *in, MnsError *error);
MnsStatus command_lease(Invocation *in, MnsError *error);
MnsStatus command_get(Invocation *in, MnsError *error);
MnsStatus command_query(Invocation *in, MnsError *error);
MnsStatus command_wait(Invocation *in, MnsError *error);
MnsStatus command_watch(Invocation *in, MnsError *error);
MnsStatus command_stream(Invocation *in, MnsError *error);
MnsStatus command_status(Invocation *in, MnsError *error);
MnsStatus command_capabilities(Invocation *in, MnsError *error);
MnsStatus command_schemes(Invocation *in, MnsError *error);
MnsStatus command_ls(Invocation *in, MnsError *error);
MnsStatus command_completion(Invocation *in, MnsError *error);
MnsStatus command_doctor(Invocation *in, MnsError *error);
MnsStatus command_export(Invocation *in, MnsError *error);
MnsStatus command_init(Invocation *in, MnsError *error);
MnsStatus command_top(Invocation *in, MnsError *error);
MnsStatus command_keys(Invocation *in, MnsError *error);
MnsStatus command_help(Invocation *in, MnsError *error);
MnsStatus command_render(Invocation *in, MnsError *error);
MnsStatus command_run(Invocation *in, MnsError *error);
MnsStatus command_check(Invocation *in, MnsError *error);
MnsStatus command_log(Invocation *in, MnsError *error);
MnsStatus command_replay(Invocation *in, MnsError *error);

/* Help for one command, or for all with NULL, as text on standard output. */
void help_print(const Command *command);

/* The tables of commands and options, for programs that wrap this one. */
json_t *help_json(void);

/* Split the values of --fields at their commas. ret[MAX_WORDS] are yours, as is the one block `*ret_text` they lie in.
 * MNS_E_LIMIT; MNS_E_MEMORY. */
MnsStatus command_fields(const Invocation *in, const char **ret, size_t *ret_n, char **ret_text, MnsError *error);

#endif
