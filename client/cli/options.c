/* SPDX-License-Identifier: BSD-3-Clause */
/* Options of the command line, by getopt_long(), with its complaints in our words. */
#include "client/cli/options.h"
#include "common/case/words.h"
#include <getopt.h>
#include <stdio.h>
#include <string.h>

const OptionInfo option_table[] = {
    [OPT_DAEMON] = {"daemon", 'd', "NAME|ENDPOINT", "which daemon; default $MENISCUS_DAEMON, or the one named default"},
    [OPT_KEY] = {"key", 0, "FILE", "our key, for a daemon at tcp://HOST:PORT; default $MENISCUS_KEY"},
    [OPT_SERVER_KEY] = {"server-key", 0, "KEY",
                        "the daemon's public key; default $MENISCUS_SERVER_KEY, or that in FILE"},
    [OPT_OUTPUT] = {"output", 'o', "text|json", "how to print results"},
    [OPT_TIMEOUT] = {"timeout", 0, "SECONDS", "give up after this long (exit code 124)"},
    [OPT_ID] = {"id", 0, "32 HEX DIGITS", "id of the request: repeated with the same id, a command happens once"},
    [OPT_HELP] = {"help", 'h', NULL, "explain the command"},
    [OPT_VERSION] = {"version", 'V', NULL, "print the version"},
    [OPT_LEASE] = {"lease", 0, "EPOCH",
                   "of the lease under which the command is sent; default: $MENISCUS_LEASE, or none"},
    [OPT_IF_STEP] = {"if-step", 0, "N", "do nothing unless the run is at this step when the command would begin"},
    [OPT_IF_VERSION] = {"if-version", 0, "N", "do nothing unless the case is at this version then"},
    [OPT_WAIT_STEP] = {"at-step", 0, "N", "do it when the run is at this step, and answer then"},
    [OPT_WAIT_TIME] = {"at-time", 0, "T", "do it at this simulated time [s], at which a step ends; answer then"},
    [OPT_NO_WAIT] = {"no-wait", 0, NULL,
                     "with --at-step or --at-time: answer when it is scheduled, not when it is done"},
    [OPT_TTL] = {"ttl", 0, "SECONDS", "for which the lease lives; default 30"},
    [OPT_HOLDER] = {"holder", 0, "NAME", "what others are told; default: user@host"},
    [OPT_SET] = {"set", 0, "PATH=VALUE", "override an entry of the case; may be repeated"},
    [OPT_START] = {"start", 0, NULL, "start the run when the case is loaded"},
    [OPT_RESUME] = {"resume", 0, NULL, "go on from the newest checkpoint of the run, if there is one"},
    [OPT_NAME] = {"name", 0, "NAME", "of the run directory; default: that of the case"},
    [OPT_CHECKPOINT] = {"checkpoint", 0, NULL, "write a checkpoint first"},
    [OPT_FIELDS] = {"fields", 0, "FIELD[,FIELD]", "which fields; may be repeated"},
    [OPT_LIMIT] = {"limit", 0, "N", "refuse if there are more particles; default 100000"},
    [OPT_WALLS] = {"walls", 0, NULL, "wall particles too"},
    [OPT_FOLLOW] = {"follow", 0, NULL, "go on when the run ends"},
    [OPT_FOR] = {"for", 0, "state=S|time=T|step=N", "what to wait for; repeated: whichever comes first"},
    [OPT_AT_TIME] = {"time", 0, "T", "pause at the first step boundary from this simulated time on [s]"},
    [OPT_AT_STEP] = {"step", 0, "N", "pause at this step"},
    [OPT_CONDITION] = {"when", 0, "FORMULA",
                       "pause when this formula of probes, t and step is true, as in \"P1 > 2e3\""},
    [OPT_REMOVE] = {"remove", 0, NULL, "take the breakpoint away"},
    [OPT_WHOLE_STEPS] = {"whole-steps", 0, NULL, "end with the step that passes the time, instead of shortening it"},
    [OPT_DIRECTORY] = {"out", 0, "DIR", "run directory; default: ./CASE.run"},
    [OPT_UNTIL] = {"until", 0, "T", "stop with a checkpoint at the first step at or after this time [s]"},
    [OPT_OVERWRITE] = {"overwrite", 0, NULL, "delete the files of the run that is in the directory"},
    [OPT_RESUME_AUTO] = {"resume", 0, "auto", "go on from the newest whole checkpoint in the run directory, if any"},
    [OPT_THREADS] = {"threads", 0, "N", "threads of the solver, 0 for all it may use; default: as the case says"},
    [OPT_VERIFY] = {"verify", 0, NULL, "compare, and say whether all is as it was"},
    [OPT_LOG_LEVEL] = {"log-level", 0, "LEVEL", "error, warning (default), notice, info or debug"},
    [OPT_PICTURE] = {"out", 0, "FILE.png", "where the picture goes; must be given"},
    [OPT_FIELD] = {"field", 'f', "FIELD", "phase (default), pressure, velocity, density or any other field"},
    [OPT_RANGE] = {"range", 'r', "LO,HI", "ends of the colour bar, in the field's SI unit; default: see above"},
    [OPT_COLOURS] = {"colours", 'c', "viridis|magma|cividis|coolwarm|grey",
                     "of a field: viridis is the default, coolwarm has 0 in its middle"},
    [OPT_CUT] = {"cut", 0, "AXIS[=AT[,D]]", "3D: a slab normal to x, y or z at AT [m], of thickness D [m]"},
    [OPT_PROJECT] = {"project", 0, "AXIS", "3D: look at the surface of the heaviest fluid along x, y or z"},
    [OPT_FLUID] = {"fluid", 0, "NAME[,NAME]", "draw these fluids only"},
    [OPT_BOX] = {"box", 'b', "X0,Y0,X1,Y1", "part of the plane to draw [m]; default: the domain"},
    [OPT_TITLE] = {"title", 't', "TEXT", "instead of the title of the case"},
    [OPT_SIZE] = {"size", 's', "W[xH]", "in pixels; without H as high as the plot needs; default: 1600"},
    [OPT_ROLE] = {"role", 0, "viewer|operator|admin",
                  "viewer: asks and listens; operator: steers too; admin: also loads and shuts down"},
    [OPT_KEYS] = {"keys", 0, "DIR", "where the keys are; default $MENISCUS_KEYS, or ~/.config/meniscus/keys"},
    [OPT_FROM] = {"from", 0, "CASE", "begin with this case, its comments and all; default: a small one of two fluids"},
    [OPT_STATE_DIR] = {"state-dir", 0, "DIR", "where the daemon keeps its runs; default: as `meniscusd` chooses it"},
    [OPT_EXPORT] = {"out", 0, "FILE",
                    "where the table goes: a name that ends with .csv or .vtk; default: CSV on standard output"},
    [OPT_ONCE] = {"once", 0, NULL, "look once; where the output is no terminal and no JSON, that is so anyhow"},
    [OPT_EVERY_STEPS] = {"every-steps", 0, "N", "at steps that are multiples of N"},
    [OPT_INTERVAL] = {"interval", 0, "T", "at multiples of this simulated time [s]"},
    [OPT_MAX_HZ] = {"max-hz", 0, "HZ", "not more often than this, by the clock on the wall"},
    [OPT_FIRST] = {"first", 0, NULL, "one item at once, also if the run stands still"},
    [OPT_EXACT] =
        {"exact", 0, "f32|BOUND|FIELD=BOUND",
         "numbers of four bytes, or off by less than BOUND, in the SI unit; default: as computed; may be repeated"},
    [OPT_PACK] = {"pack", 0, "none|lz4|zstd", "how bytes are packed on the way; default: none"},
    [OPT_WITHIN] = {"box", 0, "X0,Y0[,Z0],X1,Y1[,Z1]", "the particles between two corners [m]"},
    [OPT_EVERY] = {"every", 0, "N", "about one particle in N, always the same ones"},
    [OPT_COUNT] = {"count", 0, "N", "end after N items; default: go on until Ctrl-C"},
    [OPT_CSV] = {"csv", 0, NULL, "lines of values with commas between them"},
    [OPT_TO] = {"to", 0, "DIR", "write files there: NAME-STEP.npy for each field, or the snapshots"},
};

enum { LONG_ONLY = 256 };

/* The allowed part of the table, as getopt_long() wants it. */
static void tables(OptionSet allowed, struct option *longs, char *shorts)
{
    *shorts++ = '+';
    *shorts++ = ':';
    for (int k = 0; k < OPTION_COUNT; k++) {
        const OptionInfo *info = &option_table[k];
        if (!(allowed & OPTION(k))) continue;
        *longs++ = (struct option){info->name, info->value ? required_argument : no_argument, NULL, LONG_ONLY + k};
        if (!info->letter) continue;
        *shorts++ = info->letter;
        if (info->value) *shorts++ = ':';
    }
    *longs = (struct option){0};
    *shorts = 0;
}

static int option_of(int code)
{
    for (int k = 0; k < OPTION_COUNT; k++)
        if (code == LONG_ONLY + k || (option_table[k].letter && code == option_table[k].letter)) return k;
    return -1;
}

static MnsStatus complain(const char *word, OptionSet allowed, MnsError *error)
{
    char dashed[OPTION_COUNT][24], text[400];
    const char *names[OPTION_COUNT];
    size_t n = 0;
    for (int k = 0; k < OPTION_COUNT; k++) {
        if (!(allowed & OPTION(k))) continue;
        snprintf(dashed[n], sizeof dashed[n], "--%s", option_table[k].name);
        names[n] = dashed[n];
        n++;
    }
    const char *equals = strchr(word, '=');
    char bare[64];
    snprintf(bare, sizeof bare, "%.*s", equals ? (int)(equals - word) : (int)sizeof bare - 1, word);
    words_suggest(names, n, bare, NULL, text, sizeof text);
    return mns_fail(error, MNS_E_INVALID, "there is no option %s; %s", bare, text);
}

static MnsStatus full(MnsError *error)
{
    return mns_fail(error, MNS_E_LIMIT, "more than %d words on the command line", (int)MAX_WORDS);
}

static MnsStatus take_option(Options *options, int code, const char *word, OptionSet allowed, MnsError *error)
{
    if (code == '?') return complain(word, allowed, error);
    if (code == ':') return mns_fail(error, MNS_E_INVALID, "option %s needs a value", word);
    if (options->n_given == MAX_WORDS) return full(error);
    options->given[options->n_given].id = (OptionId)option_of(code);
    options->given[options->n_given++].value = optarg ? optarg : "";
    return MNS_OK;
}

static bool is_negative_number(const char *word)
{
    return word[0] == '-' && word[1] && strchr("0123456789.", word[1]);
}

MnsStatus options_parse(Options *options, int argc, char **argv, OptionSet allowed, bool leading, int *ret_used,
                        MnsError *error)
{
    struct option longs[OPTION_COUNT + 1];
    char shorts[2 * OPTION_COUNT + 3];
    tables(allowed, longs, shorts);
    MnsStatus status = MNS_OK;
    bool only_words = false;
    opterr = 0;
    optind = 0; /* begin anew */
    int next = 1;
    while (status == MNS_OK && next < argc) {
        optarg = NULL;
        const bool is_word = only_words || is_negative_number(argv[next]);
        const int code = is_word ? -1 : getopt_long(argc, argv, shorts, longs, NULL);
        if (code != -1) {
            status = take_option(options, code, argv[next], allowed, error);
            next = optind;
            continue;
        }
        if (!is_word && strcmp(argv[next], "--") == 0 && !leading) {
            only_words = true;
            next++;
            continue;
        }
        if (leading) break;
        if (options->n_words == MAX_WORDS) return full(error);
        options->words[options->n_words++] = argv[next++];
        optind = next;
    }
    *ret_used = next;
    return status;
}

const char *options_get(const Options *options, OptionId id)
{
    for (size_t k = options->n_given; k-- > 0;)
        if (options->given[k].id == id) return options->given[k].value;
    return NULL;
}

size_t options_all(const Options *options, OptionId id, const char **ret)
{
    size_t n = 0;
    for (size_t k = 0; k < options->n_given; k++)
        if (options->given[k].id == id) ret[n++] = options->given[k].value;
    return n;
}
