/* SPDX-License-Identifier: BSD-3-Clause */
/* Help, made from the tables of commands and options. */
#include "client/cli/command.h"
#include "client/cli/output.h"
#include <stdio.h>

static void print_options(unsigned options)
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
    puts("Usage: meniscus [OPTION]... COMMAND ...\nSteer, watch and question multiphase particle "
         "simulations.\n\nCommands:");
    for (const Command *command = command_table; command->name; command++)
        printf("  %-13s %s\n", command->name, command->help);
    puts("\nOptions of every command that talks to a daemon:");
    print_options(OPTIONS_GLOBAL);
    puts("\nExit codes: 0 done, 1 refused or failed, 2 wrong usage, 65 bad case, 69 no daemon answers, 70 diverged,\n"
         "74 file not read or written, 75 stopped, run again, 124 timed out.\n"
         "`meniscus help COMMAND` explains a command.");
}

void help_print(const Command *command)
{
    if (!command) {
        print_all();
        return;
    }
    if (command->raw) {
        char help[] = "--help", *argv[] = {(char *)command->name, help, NULL};
        fflush(stdout);
        command->raw(2, argv);
        return;
    }
    const char *arguments = command->arguments ? command->arguments : "";
    printf("Usage: meniscus %s [OPTION]... %s\n%s.\n\n", command->name, arguments, command->help);
    print_options(command->options | OPTIONS_GLOBAL);
}

static json_t *options_json(unsigned options)
{
    json_t *list = json_array();
    for (int k = 0; k < OPTION_COUNT; k++)
        if (options & OPTION(k))
            json_array_append_new(list, json_pack("{ss ss? ss}", "name", option_table[k].name, "value",
                                                  option_table[k].value, "help", option_table[k].help));
    return list;
}

/* The table of commands, for programs that wrap this one. */
static json_t *table_json(void)
{
    json_t *list = json_array();
    for (const Command *command = command_table; command->name; command++)
        json_array_append_new(list, json_pack("{ss ss? ss ss? so}", "name", command->name, "arguments",
                                              command->arguments, "help", command->help, "request", command->request,
                                              "options", options_json(command->options)));
    return json_pack("{so so}", "commands", list, "options", options_json(OPTIONS_GLOBAL));
}

MnsStatus command_help(Invocation *in, MnsError *error)
{
    const Command *command = NULL;
    if (in->json) return output_json(table_json(), error);
    if (in->options.n_words) {
        const MnsStatus status = command_usage(in, command_find(in->options.words[0], &command, error));
        if (status != MNS_OK) return status;
    }
    help_print(command);
    return MNS_OK;
}
