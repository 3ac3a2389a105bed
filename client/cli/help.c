/* SPDX-License-Identifier: BSD-3-Clause */
/* Help, made from the tables of commands and options. */
#include "client/cli/command.h"
#include "client/cli/output.h"
#include <ctype.h>
#include <meniscus/exit.h>
#include <stdio.h>
#include <string.h>

/* Exit codes: those of every command, of every command that talks to a daemon, and of some. */
static const struct {
    MnsExit code;
    unsigned exits; /* 0: of every command */
    bool of_daemon;
    const char *meaning;
} exit_table[] = {
    {MNS_EXIT_DONE, 0, false, "done"},
    {MNS_EXIT_FAILED, 0, false, "refused or failed"},
    {MNS_EXIT_USAGE, 0, false, "wrong usage"},
    {MNS_EXIT_BAD_CASE, EXIT_BAD_CASE, false,
     "bad case: standard error begins with FILE:LINE:COLUMN or the --set, or says where it was looked for"},
    {MNS_EXIT_UNREACHABLE, 0, true, "no daemon answers"},
    {MNS_EXIT_DIVERGED, EXIT_DIVERGED, false, "the simulation has diverged"},
    {MNS_EXIT_IO, EXIT_IO, false, "a file could not be read or written"},
    {MNS_EXIT_AGAIN, EXIT_AGAIN, false,
     "stopped before it was done, or another run has the directory: run the same command again with --resume auto"},
    {MNS_EXIT_DENIED, 0, true, "our key is not let in, or lacks the role that this takes"},
    {MNS_EXIT_TIMEOUT, 0, true, "timed out"},
};

/* What the program is for, and what to type first. */
static const char about[] =
    "Compute flows of several fluids with particles, and steer, watch and question them while they run.";
static const char beginning[] =
    "To begin with, a dam break to its end, with its files in ./dam:\n"
    "    meniscus run dambreak2d --set resolution=20 --out dam\n"
    "or in a daemon, which takes commands while it computes:\n"
    "    meniscusd --state-dir runs &\n"
    "    meniscus load dambreak2d --start\n"
    "    meniscus watch                                      Ctrl-C ends the watching, not the run\n"
    "    meniscus render --field pressure --out dam.png\n"
    "    meniscus shutdown";

/* Whether a command may end with row k of the table; NULL: any command. */
static bool may_exit(size_t k, const Command *command)
{
    const bool of_daemon = !exit_table[k].of_daemon || !command || !command->is_alone;
    return of_daemon && (!exit_table[k].exits || !command || command->exits & exit_table[k].exits);
}

static void print_exits(const Command *command)
{
    puts("\nExit codes:");
    for (size_t k = 0; k < sizeof exit_table / sizeof *exit_table; k++)
        if (may_exit(k, command)) printf("  %-4d %s\n", exit_table[k].code, exit_table[k].meaning);
}

static void print_options(OptionSet options)
{
    for (int k = 0; k < OPTION_COUNT; k++) {
        const OptionInfo *info = &option_table[k];
        char text[64], letter[8] = "    ";
        if (!(options & OPTION(k))) continue;
        if (info->letter) snprintf(letter, sizeof letter, "-%c, ", info->letter);
        snprintf(text, sizeof text, "--%s%s%s", info->name, info->value ? " " : "", info->value ? info->value : "");
        printf("  %s%-31s %s\n", letter, text, info->help);
    }
}

static void print_all(void)
{
    printf("Usage: meniscus COMMAND [OPTION]... [WORD]...\n%s\n\n%s\n", about, beginning);
    for (const Command *command = command_table; command->name; command++) {
        if (command->group) printf("\n%s:\n", command->group);
        printf("  %-13s %s\n", command->name, command->help);
    }
    puts("\nOptions of every command that talks to a daemon:");
    print_options(OPTIONS_GLOBAL);
    print_exits(NULL);
    puts("\n`meniscus help COMMAND` explains a command; -o json makes each print one JSON object, failures too.");
}

/* Lines are broken between words; those that begin with a space are examples and stay as they are. */
static void print_wrapped(const char *text)
{
    enum { WIDTH = 100 };
    for (size_t column = 0; *text;) {
        const size_t length = *text == ' ' && column == 0 ? strcspn(text, "\n") : strcspn(text, " \n");
        if (column > 0 && column + 1 + length > WIDTH) {
            putchar('\n');
            column = 0;
        }
        printf("%s%.*s", column > 0 ? " " : "", (int)length, text);
        column += length + (column > 0);
        text += length;
        if (*text == '\n') {
            putchar('\n');
            column = 0;
        }
        if (*text) text++;
    }
    putchar('\n');
}

void help_print(const Command *command)
{
    if (!command) {
        print_all();
        return;
    }
    const char *arguments = command->arguments ? command->arguments : "";
    printf("Usage: meniscus %s [OPTION]...%s%s\n", command->name, *arguments ? " " : "", arguments);
    printf("%c%s.\n", toupper((unsigned char)command->help[0]), command->help + 1);
    if (command->details) {
        putchar('\n');
        print_wrapped(command->details);
    }
    puts("\nOptions:");
    print_options(command->options);
    print_options(command_options(command) & ~command->options);
    print_exits(command);
}

static json_t *options_json(OptionSet options)
{
    json_t *list = json_array();
    for (int k = 0; k < OPTION_COUNT; k++)
        if (options & OPTION(k))
            json_array_append_new(
                list, json_pack("{ss so ss? ss}", "name", option_table[k].name, "letter",
                                option_table[k].letter ? json_stringn(&option_table[k].letter, 1) : json_null(),
                                "value", option_table[k].value, "help", option_table[k].help));
    return list;
}

static json_t *exits_json(const Command *command)
{
    json_t *list = json_array();
    for (size_t k = 0; k < sizeof exit_table / sizeof *exit_table; k++)
        if (may_exit(k, command))
            json_array_append_new(
                list, json_pack("{si ss}", "code", (int)exit_table[k].code, "meaning", exit_table[k].meaning));
    return list;
}

json_t *help_json(void)
{
    json_t *list = json_array();
    for (const Command *command = command_table; command->name; command++)
        json_array_append_new(list, json_pack("{ss ss? ss? ss ss? ss? so so}", "name", command->name, "group",
                                              command->group, "arguments", command->arguments, "help", command->help,
                                              "details", command->details, "request", command->request, "options",
                                              options_json(command->options), "exit_codes", exits_json(command)));
    return json_pack("{ss ss ss so so so}", "version", MENISCUS_VERSION, "about", about, "beginning", beginning,
                     "commands", list, "options", options_json(OPTIONS_GLOBAL), "exit_codes", exits_json(NULL));
}

MnsStatus command_help(Invocation *in, MnsError *error)
{
    const Command *command = NULL;
    if (in->options.n_words) {
        const MnsStatus status = command_usage(in, command_find(in->options.words[0], &command, error));
        if (status != MNS_OK) return status;
    }
    if (in->json) return output_json(help_json(), error);
    help_print(command);
    return MNS_OK;
}
