/* SPDX-License-Identifier: BSD-3-Clause */
/* meniscus completion: scripts that let a shell finish command lines, written from the tables by which those are parsed. What is not in
 * the tables, as names of daemons, the scripts ask this command for. */
#include "client/cli/completion.h"
#include "client/cli/command.h"
#include "client/cli/output.h"
#include "common/case/file.h"
#include "common/case/find.h"
#include "common/case/name.h"
#include <dirent.h>
#include <fnmatch.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* --- what a word may be --------------------------------------------------------------------------------------------------- */

static const struct {
    const char *begins, *kinds;
} meanings[] = {
    {"CASE", "@cases @files"},         {"CHECKPOINT", "@checkpoints"}, {"COMMAND", "@commands"},
    {"DIR", "@directories"},           {"ENDPOINT", "@daemons"},       {"FILE", "@files"},
    {"PATH=VALUE...", "@assignments"}, /* of `set`, while it runs */
    {"PATH=VALUE", "@overrides"},      /* of a case that is loaded */
    {"PATH", "@parameters"},           {"SNAPSHOT", "@files"},
};

static void append(char *ret, size_t size, const char *text, size_t length)
{
    const size_t n = strlen(ret);
    snprintf(ret + n, size - n, "%s%.*s", n ? " " : "", (int)length, text);
}

static bool has_word(const char *list, const char *word)
{
    const size_t n = strlen(word);
    for (const char *at = list; (at = strstr(at, word)); at += n)
        if ((at == list || at[-1] == ' ') && (!at[n] || at[n] == ' ')) return true;
    return false;
}

/* Names that follow the first word of one alternative, as in "at FIELD X,Y": which one was given, scripts do not look at. */
static void append_names(char *ret, size_t size, const char *text, size_t length)
{
    static const char *const names[][2] = {{"FIELD", "@fields"}, {"PROBE", "@probes"}};
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        const char *found = strstr(text, names[k][0]);
        if (found && found < text + length && !has_word(ret, names[k][1]))
            append(ret, size, names[k][1], strlen(names[k][1]));
    }
}

/* The first word of one alternative, as in "at FIELD X,Y". */
static void append_word(char *ret, size_t size, const char *word)
{
    static const char lower[] = "abcdefghijklmnopqrstuvwxyz-";
    const size_t n = strspn(word, lower);
    if (n && word[0] != '-' && (!word[n] || strchr(" |]", word[n]))) append(ret, size, word, n);
    else if (n && word[n] == '=') append(ret, size, word, n + 1);
    for (size_t k = 0; k < sizeof meanings / sizeof *meanings; k++) {
        const size_t length = strlen(meanings[k].begins);
        if (strncmp(word, meanings[k].begins, length) != 0) continue;
        append(ret, size, meanings[k].kinds, strlen(meanings[k].kinds));
        return;
    }
}

void completion_kinds(const char *text, char *ret, size_t size)
{
    *ret = 0;
    while (text && *text) {
        text += strspn(text, " [|");
        append_word(ret, size, text);
        append_names(ret, size, text, strcspn(text, "|"));
        text += strcspn(text, "|");
    }
}

/* --- bash ----------------------------------------------------------------------------------------------------------------- */

/* The daemon and the dashboard have tables of their own, which their help shows. */
static const char bash_end[] =
    "\n"
    "# Of meniscusd and meniscus-dashboard, by what their help says.\n"
    "_meniscus_service()\n"
    "{\n"
    "    local current=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} line words='' value=''\n"
    "    local option='^ +(-(.), )?(--[a-z-]+)([= ]([^ ]+))?'\n"
    "    COMPREPLY=()\n"
    "    if [ \"$current\" = = ]; then\n"
    "        current=''\n"
    "    elif [ \"$before\" = = ]; then\n"
    "        before=${COMP_WORDS[COMP_CWORD - 2]}\n"
    "    fi\n"
    "    while IFS= read -r line; do\n"
    "        if ! [[ $line =~ $option ]]; then continue; fi\n"
    "        words+=\" ${BASH_REMATCH[3]}\"\n"
    "        case $before in \"-${BASH_REMATCH[2]}\" | \"${BASH_REMATCH[3]}\") value=${BASH_REMATCH[5]} ;; esac\n"
    "    done <<<\"$(\"${COMP_WORDS[0]}\" --help 2>/dev/null)\"\n"
    "    case $value in\n"
    "    '') ;;\n"
    "    CASE) words='@cases @files' ;;\n"
    "    DIR) words=@directories ;;\n"
    "    FILE) words=@files ;;\n"
    "    PATH=VALUE) words=@overrides ;;\n"
    "    *ENDPOINT) words=@daemons ;;\n"
    "    LEVEL) words='error warning notice info debug' ;;\n"
    "    auto | json) words=$value ;;\n"
    "    *) words='' ;;\n"
    "    esac\n"
    "    # shellcheck disable=SC2086 # words\n"
    "    _meniscus_offer \"$current\" $words\n"
    "}\n"
    "complete -F _meniscus_service meniscusd meniscus-dashboard\n";

static const char bash_begin[] =
    "# Completion of meniscus for bash, written by `meniscus completion bash`.\n"
    "# Adds those of the lines read that begin with the first word. They are no -W of compgen, which runs what stands "
    "in them.\n"
    "_meniscus_match()\n"
    "{\n"
    "    local word\n"
    "    while IFS= read -r word; do\n"
    "        case $word in '') ;; \"$1\"*) COMPREPLY+=(\"$word${2-}\") ;; esac\n"
    "    done\n"
    "}\n"
    "\n"
    "_meniscus_offer()\n"
    "{\n"
    "    local kind current=$1 program=${COMP_WORDS[0]} found=''\n"
    "    case $program in *meniscusd | *meniscus-dashboard) program=${program%meniscus*}meniscus ;; esac\n"
    "    shift\n"
    "    for kind; do\n"
    "        case $kind in\n"
    "        @files) found=$(compgen -f -- \"$current\") ;;\n"
    "        @directories) found=$(compgen -d -- \"$current\") ;;\n"
    "        @assignments) _meniscus_match \"$current\" = <<<\"$(\"$program\" completion parameters 2>/dev/null)\" ;;\n"
    "        @overrides) _meniscus_match \"$current\" = <<<\"$(\"$program\" completion entries 2>/dev/null)\" ;;\n"
    "        @*) _meniscus_match \"$current\" <<<\"$(\"$program\" completion \"${kind#@}\" 2>/dev/null)\" ;;\n"
    "        *) _meniscus_match \"$current\" <<<\"$kind\" ;;\n"
    "        esac\n"
    "        case $kind in @files | @directories) compopt -o filenames 2>/dev/null ;; *) continue ;; esac\n"
    "        if [ -n \"$found\" ]; then mapfile -t -O ${#COMPREPLY[@]} COMPREPLY <<<\"$found\"; fi\n"
    "    done\n"
    "    case ${COMPREPLY[0]-} in *=) compopt -o nospace 2>/dev/null ;; esac\n"
    "}\n"
    "\n"
    "_meniscus()\n"
    "{\n"
    "    local current=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} command='' options='' words='' "
    "value='' k\n"
    "    local of_state='--for state =( ([^ ]*))?$' of_daemon=' (-d|--daemon)( =)? ([^ ]+) '\n"
    "    COMPREPLY=()\n"
    "    # Whose names are asked for.\n"
    "    if [[ \"${COMP_WORDS[*]:0:COMP_CWORD} \" =~ $of_daemon ]]; then local -x MENISCUS_DAEMON=${BASH_REMATCH[3]}; "
    "fi\n"
    "    if [[ \"${COMP_WORDS[*]:1:COMP_CWORD}\" =~ $of_state ]]; then\n"
    "        _meniscus_offer \"${BASH_REMATCH[2]}\" @states\n"
    "        return\n"
    "    fi\n"
    "    # bash takes --option=value apart into three words.\n"
    "    if [ \"$current\" = = ]; then\n"
    "        current=''\n"
    "    elif [ \"$before\" = = ]; then\n"
    "        before=${COMP_WORDS[COMP_CWORD - 2]}\n"
    "        case $before in -*) ;; *) return ;; esac\n"
    "    fi\n"
    "    for ((k = 1; k < COMP_CWORD; k++)); do\n"
    "        case ${COMP_WORDS[k]} in\n";

static void print_names(FILE *out, OptionSet options, const char *between, bool with_value)
{
    const char *gap = "";
    for (int k = 0; k < OPTION_COUNT; k++) {
        const OptionInfo *info = &option_table[k];
        if (!(options & OPTION(k)) || (with_value && !info->value)) continue;
        fprintf(out, "%s--%s", gap, info->name);
        gap = between;
        if (info->letter) fprintf(out, "%s-%c", gap, info->letter);
    }
}

/* What follows `before`, where that is an option that takes a value. */
static void print_values(FILE *out, OptionSet options)
{
    char kinds[256];
    fputs("        case $before in\n", out);
    for (int k = 0; k < OPTION_COUNT; k++) {
        const OptionInfo *info = &option_table[k];
        if (!(options & OPTION(k)) || !info->value) continue;
        completion_kinds(info->value, kinds, sizeof kinds);
        fprintf(out, "        --%s", info->name);
        if (info->letter) fprintf(out, " | -%c", info->letter);
        fprintf(out, ") value=1 words='%s' ;;\n", kinds);
    }
    fputs("        esac\n        ;;\n", out);
}

static void print_bash(FILE *out)
{
    char kinds[256];
    fputs(bash_begin, out);
    fputs("        ", out);
    print_names(out, OPTIONS_GLOBAL, " | ", true);
    fputs(")\n"
          "            if [ \"${COMP_WORDS[k + 1]-}\" = = ]; then ((k++)); fi\n"
          "            ((k++))\n"
          "            ;;\n"
          "        -*) ;;\n"
          "        *)\n"
          "            command=${COMP_WORDS[k]}\n"
          "            break\n"
          "            ;;\n"
          "        esac\n"
          "    done\n"
          "    case $command in\n"
          "    '')\n"
          "        options='",
          out);
    print_names(out, OPTIONS_GLOBAL, " ", false);
    fputs("' words=@commands\n", out);
    print_values(out, OPTIONS_GLOBAL);
    for (const Command *command = command_table; command->name; command++) {
        completion_kinds(command->arguments, kinds, sizeof kinds);
        fprintf(out, "    %s)\n        options='", command->name);
        print_names(out, command_options(command), " ", false);
        fprintf(out, "' words='%s'\n", kinds);
        print_values(out, command_options(command));
    }
    fputs("    esac\n"
          "    if [ -z \"$value\" ]; then case $current in -*) words=$options ;; esac; fi\n"
          "    # shellcheck disable=SC2086 # words\n"
          "    _meniscus_offer \"$current\" $words\n"
          "}\n"
          "complete -F _meniscus meniscus\n",
          out);
    fputs(bash_end, out);
}

/* --- zsh ------------------------------------------------------------------------------------------------------------------ */

static const char zsh_begin[] =
    "#compdef meniscus meniscusd meniscus-dashboard\n"
    "# Completion of meniscus for zsh, written by `meniscus completion zsh`.\n"
    "_meniscus_offer()\n"
    "{\n"
    "    local kind\n"
    "    local -a found\n"
    "    for kind; do\n"
    "        case $kind in\n"
    "        @files) _files ;;\n"
    "        @directories) _files -/ ;;\n"
    "        @assignments | @overrides)\n"
    "            [[ $kind = @overrides ]] && kind=@entries || kind=@parameters\n"
    "            found=(${(f)\"$(_call_program names meniscus completion ${kind#@} 2>/dev/null)\"})\n"
    "            compadd -q -S = -a found\n"
    "            ;;\n"
    "        @*)\n"
    "            found=(${(f)\"$(_call_program names meniscus completion ${kind#@} 2>/dev/null)\"})\n"
    "            compadd -a found\n"
    "            ;;\n"
    "        state=)\n"
    "            if compset -P state=; then\n"
    "                _meniscus_offer @states\n"
    "                return\n"
    "            fi\n"
    "            compadd -S '' -- $kind\n"
    "            ;;\n"
    "        *=) compadd -S '' -- $kind ;;\n"
    "        *) compadd -- $kind ;;\n"
    "        esac\n"
    "    done\n"
    "}\n"
    "\n"
    "# Of meniscusd and meniscus-dashboard, by what their help says.\n"
    "_meniscus_service()\n"
    "{\n"
    "    local line kinds\n"
    "    local -a specs\n"
    "    for line in ${(f)\"$(_call_program options ${(q)words[1]} --help 2>/dev/null)\"}; do\n"
    "        [[ $line =~ '^ +(-(.), )?(--[a-z-]+)([= ]([^ ]+))?' ]] || continue\n"
    "        case $match[5] in\n"
    "        CASE) kinds='@cases @files' ;;\n"
    "        DIR) kinds=@directories ;;\n"
    "        FILE) kinds=@files ;;\n"
    "        PATH=VALUE) kinds=@overrides ;;\n"
    "        *ENDPOINT) kinds=@daemons ;;\n"
    "        LEVEL) kinds='error warning notice info debug' ;;\n"
    "        auto | json) kinds=$match[5] ;;\n"
    "        *) kinds='' ;;\n"
    "        esac\n"
    "        if [[ -z $match[5] ]]; then\n"
    "            specs+=(\"*$match[3]\")\n"
    "            continue\n"
    "        fi\n"
    "        specs+=(\"*$match[3]=:value: _meniscus_offer $kinds\")\n"
    "        if [[ -n $match[2] ]]; then specs+=(\"*-$match[2]+:value: _meniscus_offer $kinds\"); fi\n"
    "    done\n"
    "    _arguments $specs\n"
    "}\n"
    "\n"
    "_meniscus()\n"
    "{\n"
    "    local curcontext=$curcontext state line daemon\n"
    "    local -a commands\n"
    "    local -A opt_args\n"
    "    if [[ ${service-meniscus} != meniscus ]]; then\n"
    "        _meniscus_service\n"
    "        return\n"
    "    fi\n"
    "    commands=(\n";

/* Within single quotes, for _arguments and _describe. */
static void print_quoted(FILE *out, const char *text)
{
    for (; *text; text++) {
        if (*text == '\'') fputs("'\\'", out);
        else if (strchr("[]:$`\\", *text)) putc('\\', out);
        putc(*text, out);
    }
}

static void print_spec(FILE *out, const OptionInfo *info, bool letter)
{
    char kinds[256];
    if (letter) fprintf(out, "            '*-%c%s[", info->letter, info->value ? "+" : "");
    else fprintf(out, "            '*--%s%s[", info->name, info->value ? "=" : "");
    print_quoted(out, info->help);
    putc(']', out);
    if (info->value) {
        completion_kinds(info->value, kinds, sizeof kinds);
        putc(':', out);
        print_quoted(out, info->value);
        if (*kinds) fprintf(out, ": _meniscus_offer %s", kinds);
        else fputs(": ", out);
    }
    fputs("' \\\n", out);
}

static void print_specs(FILE *out, OptionSet options)
{
    for (int k = 0; k < OPTION_COUNT; k++) {
        if (!(options & OPTION(k))) continue;
        print_spec(out, &option_table[k], false);
        if (option_table[k].letter) print_spec(out, &option_table[k], true);
    }
}

static void print_zsh(FILE *out)
{
    char kinds[256];
    fputs(zsh_begin, out);
    for (const Command *command = command_table; command->name; command++) {
        fprintf(out, "        '%s:", command->name);
        print_quoted(out, command->help);
        fputs("'\n", out);
    }
    fputs("    )\n    _arguments -C \\\n", out);
    print_specs(out, OPTIONS_GLOBAL);
    fputs("            '1:command:->command' '*::argument:->argument'\n"
          "    # Whose names are asked for.\n"
          "    daemon=${opt_args[-d]:-${opt_args[--daemon]}}\n"
          "    if [[ -n $daemon ]]; then local -x MENISCUS_DAEMON=$daemon; fi\n"
          "    case $state in\n"
          "    command) _describe -t commands command commands ;;\n"
          "    argument)\n"
          "        case $words[1] in\n",
          out);
    for (const Command *command = command_table; command->name; command++) {
        completion_kinds(command->arguments, kinds, sizeof kinds);
        fprintf(out, "        %s)\n            _arguments \\\n", command->name);
        print_specs(out, command_options(command));
        if (*kinds) fprintf(out, "            '*:word: _meniscus_offer %s'\n            ;;\n", kinds);
        else fputs("            '*:word: '\n            ;;\n", out);
    }
    fputs("        esac\n        ;;\n    esac\n}\n\nif [ \"$funcstack[1]\" = _meniscus ]; then _meniscus \"$@\"; else "
          "compdef "
          "_meniscus meniscus meniscusd meniscus-dashboard; fi\n",
          out);
}

/* --- names that are not in the tables ------------------------------------------------------------------------------------- */

/* They end on a command line as they are: of a name that is none of ours, a shell would run what stands in it. */
static void tell(FILE *out, const char *name)
{
    if (is_name(name)) fprintf(out, "%s\n", name);
}

static void tell_case(void *arg, const char *name, const char *folder)
{
    (void)folder;
    tell(arg, name);
}

static void print_cases(FILE *out)
{
    case_list(tell_case, out);
}

static bool tell_daemon(void *arg, const char *name, const char *endpoint)
{
    (void)endpoint;
    tell(arg, name);
    return true;
}

static void print_daemons(FILE *out)
{
    mns_daemon_list(tell_daemon, out);
}

static void print_commands(FILE *out)
{
    for (const Command *command = command_table; command->name; command++) fprintf(out, "%s\n", command->name);
}

static void print_parameters(FILE *out)
{
    size_t n;
    const CaseParameter *parameters = case_parameters(&n);
    for (size_t k = 0; k < n; k++) fprintf(out, "%s\n", parameters[k].path);
}

static void tell_entry(void *arg, const char *path)
{
    fprintf(arg, "%s\n", path);
}

static void print_entries(FILE *out)
{
    case_entries(tell_entry, out);
}

/* What the daemon says, if there is one that answers at once: $MENISCUS_DAEMON, or the default. */
static MnsReply *ask(MnsStatus (*what)(MnsClient *client, MnsReply **ret_reply, MnsError *error))
{
    char endpoint[MNS_ENDPOINT_SIZE];
    MnsClient *client;
    MnsReply *reply = NULL;
    if (mns_daemon_endpoint(NULL, endpoint, NULL) || mns_client_open(endpoint, &client, NULL)) return NULL;
    mns_client_set_timeout(client, 1);
    what(client, &reply, NULL);
    mns_client_close(client);
    return reply;
}

static void print_fields(FILE *out)
{
    MnsReply *reply = ask(mns_client_capabilities);
    const MnsCapabilities *of = reply ? reply->capabilities : NULL;
    for (size_t k = 0; of && k < of->n_fields; k++) tell(out, of->fields[k].name);
    mns_reply_free(reply);
}

static void print_probes(FILE *out)
{
    MnsReply *reply = ask(mns_client_capabilities);
    const MnsCapabilities *of = reply ? reply->capabilities : NULL;
    for (size_t k = 0; of && k < of->n_probes; k++) tell(out, of->probes[k]);
    mns_reply_free(reply);
}

static int is_checkpoint(const struct dirent *entry)
{
    return fnmatch("checkpoint-*.hdf", entry->d_name, 0) == 0;
}

/* Those of the run, if they are on this machine, the oldest first. */
static void print_checkpoints(FILE *out)
{
    struct dirent **entries;
    MnsReply *reply = ask(mns_client_status);
    const int n = reply && reply->info ? scandir(reply->info->run_directory, &entries, is_checkpoint, alphasort) : -1;
    for (int k = 0; k < n; k++) {
        tell(out, entries[k]->d_name);
        free(entries[k]);
    }
    if (n >= 0) free(entries);
    mns_reply_free(reply);
}

static void print_states(FILE *out)
{
    for (int k = 0; k < MNS_STATE_COUNT; k++) fprintf(out, "%s\n", mns_state_name((MnsState)k));
}

static const struct {
    const char *name;
    void (*print)(FILE *out);
} texts[] = {{"bash", print_bash},         {"zsh", print_zsh},
             {"commands", print_commands}, {"cases", print_cases},
             {"daemons", print_daemons},   {"parameters", print_parameters},
             {"entries", print_entries},   {"checkpoints", print_checkpoints},
             {"states", print_states},     {"fields", print_fields},
             {"probes", print_probes}};

MnsStatus command_completion(Invocation *in, MnsError *error)
{
    const char *word = in->options.words[0];
    char *text = NULL;
    size_t size, k = 0;
    while (k < sizeof texts / sizeof *texts && strcmp(texts[k].name, word) != 0) k++;
    if (k == sizeof texts / sizeof *texts)
        return command_usage(in,
                             mns_fail(error, MNS_E_INVALID,
                                      "completion bash or completion zsh; for their scripts commands, cases, daemons, "
                                      "parameters, entries, states, fields, probes or checkpoints; found \"%.80s\"",
                                      word));
    FILE *out = open_memstream(&text, &size);
    if (out) texts[k].print(out);
    bool whole = out && !ferror(out);
    if (out && fclose(out)) whole = false;
    MnsStatus status = whole ? MNS_OK : mns_fail(error, MNS_E_MEMORY, "no memory for the completion");
    if (whole && in->json) status = output_json(json_pack("{ss ss}", "of", word, "text", text), error);
    else if (whole) fputs(text, stdout);
    free(text);
    return status;
}
