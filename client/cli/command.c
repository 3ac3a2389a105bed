/* SPDX-License-Identifier: BSD-3-Clause */
/* The table of commands. */
#include "client/cli/command.h"
#include "common/case/words.h"
#include <string.h>

const Command command_table[] = {
    {.group = "Without a daemon",
     .name = "init",
     .arguments = "[FILE]",
     .help = "write a case file to begin with",
     .details = "    meniscus init                            case.yaml: water falls under air, each entry explained\n"
                "    meniscus init my.yaml --from dambreak2d  a case that came along, or a file, with its comments\n"
                "Without FILE it is case.yaml here, with --from the name of that case and .yaml; - is standard output. "
                "A file that is there "
                "already stays as it is: exit code 74.",
     .options = OPTION(OPT_FROM),
     .exits = EXIT_BAD_CASE | EXIT_IO,
     .is_alone = true,
     .max_words = 1,
     .run = command_init},
    {.name = "run",
     .arguments = "CASE",
     .help = "run a case to its end without a daemon",
     .details =
         "CASE is a file, or the name of one of the cases that came along. Progress goes to standard error; at "
         "the end the state, the probes and the files are listed. SIGTERM, Ctrl-C and a terminal that closes end the "
         "run with a "
         "checkpoint and exit code 75: the same command with --resume auto goes on from there to the last bit, "
         "with everything that was set: "
         "where the file says otherwise by then, only --set changes it. Without it a run in a directory that has "
         "one begins anew, and the files that were there go to `abandoned` in it, or are deleted with --overwrite, "
         "which leaves alone what is in `abandoned` already. "
         "A formula that fails on the way ends it with exit code 70, as a divergence does.",
     .options = OPTION(OPT_SET) | OPTION(OPT_DIRECTORY) | OPTION(OPT_OVERWRITE) | OPTION(OPT_UNTIL) |
                OPTION(OPT_RESUME_AUTO) | OPTION(OPT_THREADS) | OPTION(OPT_LOG_LEVEL),
     .exits = EXIT_BAD_CASE | EXIT_DIVERGED | EXIT_IO | EXIT_AGAIN,
     .is_alone = true,
     .min_words = 1,
     .max_words = 1,
     .run = command_run},
    {.name = "check",
     .arguments = "CASE",
     .help = "read and lay out a case, without running it",
     .details = "CASE is as of `meniscus run`, and so is --set. Prints how many particles there are, how much memory "
                "the run takes, "
                "how long it will take to its end on this machine, from a few steps that are tried, and what is "
                "doubtful in the "
                "case. Nothing is written. The first error ends it with exit code 65, also that the case takes more "
                "memory than "
                "there is; a limit on the size of files (`ulimit -f`) that the state would pass with 74, as it ends a "
                "run.",
     .options = OPTION(OPT_SET) | OPTION(OPT_THREADS),
     .exits = EXIT_BAD_CASE | EXIT_DIVERGED | EXIT_IO,
     .is_alone = true,
     .min_words = 1,
     .max_words = 1,
     .run = command_check},
    {.name = "render",
     .arguments = "[SNAPSHOT.hdf]",
     .help = "draw a snapshot or a daemon's particles as a PNG",
     .details =
         "Without a snapshot file, what the daemon computes at this moment is drawn. A picture of a field takes "
         "its colours from 99 % of each fluid's particles that are seen, so that a few wild ones do not pale "
         "all others; points at the ends of the colour bar say that there are values beyond. A thin "
         "white line is the interface between fluids. In 3D a cut through the middle of the thinnest extent is drawn "
         "unless --cut or --project says otherwise.",
     .options = OPTION(OPT_PICTURE) | OPTION(OPT_FIELD) | OPTION(OPT_RANGE) | OPTION(OPT_COLOURS) | OPTION(OPT_CUT) |
                OPTION(OPT_PROJECT) | OPTION(OPT_FLUID) | OPTION(OPT_WALLS) | OPTION(OPT_BOX) | OPTION(OPT_TITLE) |
                OPTION(OPT_SIZE),
     .exits = EXIT_IO,
     .max_words = 1,
     .run = command_render},
    {.name = "export",
     .arguments = "FILE.hdf",
     .help = "write a snapshot, or the series of the probes, as CSV or VTK",
     .details = "    meniscus export probes.hdf                          step, time and all probes, as CSV on standard "
                "output\n"
                "    meniscus export snapshot-0000000100.hdf --out a.vtk  particles and their fields\n"
                "Headings of CSV have units, as in `pressure [Pa]`; a cell is empty where there was nothing to "
                "measure. ParaView, "
                "and whatever else reads VTKHDF, opens snapshots as they are.",
     .options = OPTION(OPT_EXPORT),
     .exits = EXIT_IO,
     .is_alone = true,
     .min_words = 1,
     .max_words = 1,
     .run = command_export},
    {.name = "log",
     .arguments = "DIR",
     .help = "print the journal of a run directory: who changed what, and when",
     .details =
         "Every command that changed something, with its step, the values before and after, and what was answered. "
         "With --verify only whether the journal is whole: a changed byte is named with its record, and so is an "
         "end that was cut off before the newest checkpoint; exit code 74.",
     .options = OPTION(OPT_VERIFY),
     .exits = EXIT_IO,
     .is_alone = true,
     .min_words = 1,
     .max_words = 1,
     .run = command_log},
    {.name = "replay",
     .arguments = "DIR --verify",
     .help = "do a run again from its journal, and compare the states",
     .details =
         "The case is executed with all that was commanded, without a daemon and without writing anything, and every "
         "hash of the state that the journal has, of each 100 steps and wherever the run stood still, must come "
         "out again, with any number of threads. The first step that differs is named; exit code 1.",
     .options = OPTION(OPT_VERIFY) | OPTION(OPT_THREADS),
     .exits = EXIT_IO,
     .is_alone = true,
     .min_words = 1,
     .max_words = 1,
     .run = command_replay},
    {.name = "schemes", .help = "print the schemes and their equations", .is_alone = true, .run = command_schemes},
    {.name = "keys",
     .arguments = "new NAME | list | remove NAME",
     .help = "make, list and remove keys for connections from afar",
     .details =
         "A daemon with --listen lets in whoever has one of its keys, and nobody else:\n"
         "    meniscus keys new ada --role operator    on the daemon's machine, as its user\n"
         "    meniscusd --listen tcp://192.0.2.7:5555\n"
         "Give the file that is written, ada.key, to ada, over a way that is safe; there it must have mode 0600:\n"
         "    meniscus --key ada.key --daemon tcp://192.0.2.7:5555 status\n"
         "A daemon that runs takes note of a new key at once, and cuts off a key that is removed. Whoever can open the "
         "sockets on the daemon's machine, which its user can, needs no key and is an admin.",
     .options = OPTION(OPT_ROLE) | OPTION(OPT_KEYS),
     .exits = EXIT_IO,
     .is_alone = true,
     .min_words = 1,
     .max_words = 2,
     .run = command_keys},
    {.name = "doctor",
     .help = "look whether all is well here, and say what to do",
     .details =
         "One line for each thing: instructions, threads, memory, the versions of the programs, cases, the "
         "directory of sockets, the daemon, where its runs keep their files, keys, and what only some need. Each is "
         "ok, "
         "a warning, or a problem with what to do; exit code 1 if there is a problem. That no daemon runs is none.",
     .options =
         OPTION(OPT_DAEMON) | OPTION(OPT_KEY) | OPTION(OPT_SERVER_KEY) | OPTION(OPT_KEYS) | OPTION(OPT_STATE_DIR),
     .is_alone = true,
     .run = command_doctor},
    {.name = "completion",
     .arguments = "bash|zsh",
     .help = "print what makes a shell finish command lines of meniscus",
     .details = "`make install` puts it where shells look for it. Elsewhere:\n"
                "    source <(meniscus completion bash)       in ~/.bashrc\n"
                "    source <(meniscus completion zsh)        in ~/.zshrc, after compinit\n"
                "It offers commands, options, cases and their entries, daemons, what of a run can be set, and its "
                "checkpoints.",
     .is_alone = true,
     .min_words = 1,
     .max_words = 1,
     .run = command_completion},
    {.name = "help",
     .arguments = "[COMMAND]",
     .help = "explain a command, or list all",
     .details = "With -o json: the tables of commands and options, for programs.",
     .is_alone = true,
     .max_words = 1,
     .run = command_help},
    {.group = "Begin and end", .name = "ls", .help = "list the daemons of this host", .run = command_ls},
    {.name = "top",
     .help = "show the daemons of this host, and what they do, each second",
     .details =
         "State, case, share of the end time, speed, time to go, clients besides this one, memory and faults, until "
         "Ctrl-C. With -o json one object each second, or with --once a single one. Colours only on terminals, "
         "and not if NO_COLOR is set.",
     .options = OPTION(OPT_ONCE),
     .is_alone = true,
     .run = command_top},
    {.name = "load",
     .arguments = "CASE",
     .help = "load a case, by name or file",
     .details = "CASE is a file, or the name of one of the cases that came along. It replaces what was loaded, whose "
                "files stay; a running case must be paused first. The state is READY then, or RUNNING with --start. "
                "With --resume it goes on as it was steered: where the file says otherwise, only --set changes it.",
     .request = "load",
     .options = OPTION(OPT_IF_STEP) | OPTION(OPT_SET) | OPTION(OPT_START) | OPTION(OPT_RESUME) | OPTION(OPT_NAME),
     .exits = EXIT_BAD_CASE | EXIT_IO,
     .min_words = 1,
     .max_words = 1,
     .is_long = true,
     .run = command_load},
    {.name = "stop",
     .help = "end the run; its files stay",
     .details = "The state is EMPTY then.",
     .request = "stop",
     .options = OPTION(OPT_IF_STEP) | OPTION(OPT_CHECKPOINT),
     .exits = EXIT_IO,
     .is_long = true,
     .run = command_stop},
    {.name = "shutdown",
     .help = "end the daemon",
     .request = "shutdown",
     .options = OPTION(OPT_IF_STEP) | OPTION(OPT_CHECKPOINT),
     .exits = EXIT_IO,
     .is_long = true,
     .run = command_shutdown},
    {.group = "Set in motion and halt",
     .name = "start",
     .help = "start the run",
     .details = "Possible in READY.",
     .request = "start",
     .options = OPTION(OPT_IF_STEP) | OPTION(OPT_IF_VERSION),
     .call = mns_client_start,
     .run = command_simple},
    {.name = "pause",
     .help = "pause at the next step boundary",
     .details = "Answers when the solver stands still. Possible in RUNNING, READY and PAUSED.",
     .request = "pause",
     .options = OPTION(OPT_IF_STEP) | OPTIONS_MOMENT,
     .call = mns_client_pause,
     .run = command_simple},
    {.name = "resume",
     .help = "go on after a pause",
     .details = "Possible in PAUSED, and in FAULT after an output failed: then the output is tried again.",
     .request = "resume",
     .options = OPTION(OPT_IF_STEP) | OPTION(OPT_IF_VERSION),
     .call = mns_client_resume,
     .run = command_simple},
    {.name = "step",
     .arguments = "[COUNT]",
     .help = "do COUNT time steps (1)",
     .details = "Answers when they are done; the state is PAUSED then. Possible in READY and PAUSED.",
     .request = "step",
     .options = OPTION(OPT_IF_STEP) | OPTION(OPT_IF_VERSION),
     .exits = EXIT_DIVERGED | EXIT_IO | EXIT_AGAIN,
     .max_words = 1,
     .is_long = true,
     .run = command_step},
    {.name = "run-until",
     .arguments = "TIME",
     .help = "run until a simulated time [s], exactly",
     .details =
         "Answers when it is there; the state is PAUSED then, or DONE at the end time, beyond which no TIME may lie. "
         "Possible in READY and PAUSED.",
     .request = "run_until",
     .options = OPTION(OPT_IF_STEP) | OPTION(OPT_IF_VERSION) | OPTION(OPT_WHOLE_STEPS),
     .exits = EXIT_DIVERGED | EXIT_IO | EXIT_AGAIN,
     .min_words = 1,
     .max_words = 1,
     .is_long = true,
     .run = command_run_until},
    {.name = "wait",
     .help = "wait for a state, a time or a step",
     .details = "Without --for, for the end of the run: state=DONE. A time or a step that the run can no longer reach, "
                "as it is DONE, ends the wait with exit code 1; a run in FAULT ends every wait for something else, "
                "with the code of its cause. States: EMPTY, LOADING, READY, RUNNING, PAUSED, DONE, FAULT, STOPPING, "
                "RECOVERING.",
     .request = "wait",
     .options = OPTION(OPT_IF_STEP) | OPTION(OPT_FOR),
     .exits = EXIT_DIVERGED | EXIT_IO | EXIT_AGAIN,
     .is_long = true,
     .run = command_wait},
    {.name = "cancel",
     .arguments = "ID",
     .help = "end a pending step, run-until or wait that was given --id ID",
     .details = "The command that is ended has exit code 75.",
     .request = "cancel",
     .options = OPTION(OPT_IF_STEP),
     .min_words = 1,
     .max_words = 1,
     .run = command_cancel},
    {.name = "breakpoint",
     .arguments = "NAME",
     .help = "pause at a time, a step or a condition",
     .details = "Exactly one of the options says when, or that the breakpoint goes away; one of the same name is "
                "replaced. `meniscus status` lists them.",
     .request = "breakpoint",
     .options = OPTION(OPT_IF_STEP) | OPTION(OPT_IF_VERSION) | OPTION(OPT_AT_TIME) | OPTION(OPT_AT_STEP) |
                OPTION(OPT_CONDITION) | OPTION(OPT_REMOVE),
     .min_words = 1,
     .max_words = 1,
     .run = command_breakpoint},
    {.group = "Look and ask",
     .name = "status",
     .help = "print what the daemon is doing",
     .request = "status",
     .run = command_status},
    {.name = "watch",
     .help = "show progress and probes while it runs",
     .details =
         "Until the run ends, or Ctrl-C: that ends the watching, not the run. A terminal shows the newest values "
         "of each probe as a chart, from the least to the greatest of them. With -o json one object for each "
         "message of the daemon. --timeout ends it with exit code 124 if the run has not ended by then.",
     .options = OPTION(OPT_FOLLOW),
     .exits = EXIT_DIVERGED | EXIT_IO,
     .is_long = true,
     .run = command_watch},
    {.name = "stream",
     .arguments = "[probes [PROBE...] | fields FIELD... | events | series [PROBE...] | snapshots]",
     .help = "take data of a run at your own pace",
     .details =
         "    meniscus stream --max-hz 10              the newest values of all probes\n"
         "    meniscus stream fields position pressure --first --count 1 --csv\n"
         "    meniscus stream fields velocity --interval 0.1 --exact 0.01 --pack lz4 --to DIR\n"
         "    meniscus stream series front --csv       every row of the series, from the beginning on, once it is on "
         "the "
         "disk\n"
         "    meniscus stream snapshots --to DIR       the snapshot files, byte for byte\n"
         "Probes, fields and events are the newest: what is due while the one before is still printed is skipped. "
         "Series "
         "and snapshots are whole. Rows begin with step and time. When the connection is lost it is made anew, and the "
         "stream goes on where it was. With -o json one object for each item. Until Ctrl-C, --count or --timeout, "
         "which "
         "ends it with exit code 124.",
     .options = OPTION(OPT_EVERY_STEPS) | OPTION(OPT_INTERVAL) | OPTION(OPT_MAX_HZ) | OPTION(OPT_FIRST) |
                OPTION(OPT_EXACT) | OPTION(OPT_PACK) | OPTION(OPT_WITHIN) | OPTION(OPT_EVERY) | OPTION(OPT_WALLS) |
                OPTION(OPT_COUNT) | OPTION(OPT_CSV) | OPTION(OPT_TO),
     .exits = EXIT_IO,
     .max_words = MAX_WORDS,
     .is_long = true,
     .run = command_stream},
    {.name = "query",
     .arguments = "[probes [PROBE...] | at FIELD X,Y[,Z]... | box [MIN MAX]]",
     .help = "print probes, a field at points, or the particles of a box",
     .details =
         "    meniscus query                           all probes\n"
         "    meniscus query probes front P05          these probes\n"
         "    meniscus query at pressure 1,0.2 2,0.2   a field at points [m], averaged over the fluid near them\n"
         "    meniscus query box 0,0 0.5,0.2           the particles between two corners [m]\n"
         "--fields, --limit and --walls go with box.",
     .request = "query",
     .options = OPTION(OPT_IF_STEP) | OPTION(OPT_FIELDS) | OPTION(OPT_LIMIT) | OPTION(OPT_WALLS),
     .max_words = MAX_WORDS,
     .run = command_query},
    {.name = "get",
     .arguments = "[PATH...]",
     .help = "print entries of the case; default: all that can be set",
     .details = "PATH as in `gravity`, `scheme.cfl` or `fluids[0].density`.",
     .request = "get",
     .max_words = MAX_WORDS,
     .run = command_get},
    {.name = "capabilities",
     .help = "print parameters, fields, probes and schemes",
     .request = "capabilities",
     .run = command_capabilities},
    {.group = "Change and keep",
     .name = "set",
     .arguments = "PATH=VALUE...",
     .help = "change entries of the running case, all or none",
     .details =
         "    meniscus set end_time=3 gravity='[0, -2]'\n"
         "Answers with the step at which it took effect. `meniscus get` lists what can be set, `meniscus "
         "capabilities` with units and bounds.\n"
         "    meniscus set gravity='[0, -2]' --at-step 5000 --no-wait\n"
         "schedules it, as pause, rollback, checkpoint and snapshot can be. It is checked at once, and again when "
         "it takes effect. `meniscus status` lists what is scheduled, `meniscus cancel` of its id calls it off, and "
         "so does a load, reset, restore or stop; a crash of the daemon does not. The command given again with the "
         "same --id and without --no-wait waits for it. A --timeout is for its effect.",
     .request = "set",
     .options = OPTION(OPT_IF_STEP) | OPTION(OPT_IF_VERSION) | OPTIONS_MOMENT,
     .min_words = 1,
     .max_words = MAX_WORDS,
     .run = command_set},
    {.name = "rollback",
     .arguments = "VERSION",
     .help = "change the case back to what it was at a version",
     .details = "Versions are counted: 1 when the case is loaded, one more with every change of it, a rollback too. "
                "`meniscus status` "
                "tells the present one, every reply that of its time. The last 256 are kept, and none from before a "
                "load, reset or "
                "restore. It takes effect at the next step boundary, all or nothing.",
     .request = "rollback",
     .options = OPTION(OPT_IF_STEP) | OPTION(OPT_IF_VERSION) | OPTIONS_MOMENT,
     .min_words = 1,
     .max_words = 1,
     .run = command_rollback},
    {.name = "lease",
     .arguments = "[take|renew|release]",
     .help = "be the only one to change the run, for a while",
     .details = "    export MENISCUS_LEASE=$(meniscus lease --ttl 60)\n"
                "    meniscus set end_time=3\n"
                "    meniscus lease release\n"
                "take (default) prints the epoch of the lease, a number that rises with every new one. While it lives, "
                "only commands "
                "that come with it change the run; all others are refused, and told who holds it. renew and release "
                "are for the lease "
                "of --lease. Pause, stop and shutdown need none. What was sent under a lease that is over is refused, "
                "however late it "
                "comes.",
     .request = "lease",
     .options = OPTION(OPT_TTL) | OPTION(OPT_HOLDER),
     .max_words = 1,
     .run = command_lease},
    {.name = "snapshot",
     .help = "write a snapshot now",
     .details = "Fields for people and for ParaView; answers with the path when the file is whole. --fields: besides "
                "those that the case names.",
     .request = "snapshot",
     .options = OPTION(OPT_IF_STEP) | OPTION(OPT_FIELDS) | OPTIONS_MOMENT,
     .exits = EXIT_IO,
     .is_long = true,
     .run = command_snapshot},
    {.name = "checkpoint",
     .help = "write a checkpoint now",
     .details = "The whole state, to go on from; answers with the path when the file is whole.",
     .request = "checkpoint",
     .options = OPTION(OPT_IF_STEP) | OPTIONS_MOMENT,
     .exits = EXIT_IO,
     .is_long = true,
     .run = command_checkpoint},
    {.name = "restore",
     .arguments = "[CHECKPOINT]",
     .help = "put a checkpoint of the run back; default: the newest",
     .details =
         "CHECKPOINT is a name in the run directory, as in checkpoint-0000000100.hdf. The state is READY then; "
         "files of later steps move to abandoned/ there. A checkpoint of another case is refused. Not possible while "
         "RUNNING: pause first.",
     .request = "restore",
     .options = OPTION(OPT_IF_STEP) | OPTION(OPT_IF_VERSION),
     .exits = EXIT_IO,
     .max_words = 1,
     .is_long = true,
     .run = command_restore},
    {.name = "reset",
     .help = "go back to the beginning of the case",
     .details = "The state is READY then, and the case as it was loaded: what was set since is undone, breakpoints are "
                "gone. Files move to abandoned/ in the run directory. Not possible while RUNNING: pause first.",
     .request = "reset",
     .options = OPTION(OPT_IF_STEP) | OPTION(OPT_IF_VERSION),
     .is_long = true,
     .call = mns_client_reset,
     .run = command_simple},
    {0},
};

OptionSet command_options(const Command *command)
{
    const OptionSet global = command->is_alone ? OPTION(OPT_OUTPUT) | OPTION(OPT_HELP) : OPTIONS_GLOBAL;
    return global | command->options;
}

MnsStatus command_find(const char *name, const Command **ret, MnsError *error)
{
    const char *names[sizeof command_table / sizeof *command_table];
    char text[450];
    size_t n = 0;
    for (const Command *command = command_table; command->name; command++) {
        names[n++] = command->name;
        if (strcmp(command->name, name) != 0) continue;
        *ret = command;
        return MNS_OK;
    }
    words_suggest(names, n, name, "`meniscus help`", text, sizeof text);
    return mns_fail(error, MNS_E_INVALID, "there is no command \"%.40s\"; %s", name, text);
}
