/* SPDX-License-Identifier: BSD-3-Clause */
/* Options of the command line: one table of all of them, and which of them a command takes. */
#ifndef CLI_OPTIONS_H
#define CLI_OPTIONS_H

#include <meniscus/client.h>

typedef enum OptionId {
    OPT_DAEMON,
    OPT_KEY,
    OPT_SERVER_KEY,
    OPT_OUTPUT,
    OPT_TIMEOUT,
    OPT_ID,
    OPT_HELP,
    OPT_VERSION,
    OPT_LEASE,
    OPT_IF_STEP,
    OPT_IF_VERSION,
    OPT_WAIT_STEP,
    OPT_WAIT_TIME,
    OPT_NO_WAIT,
    OPT_TTL,
    OPT_HOLDER,
    OPT_SET,
    OPT_START,
    OPT_RESUME,
    OPT_NAME,
    OPT_CHECKPOINT,
    OPT_FIELDS,
    OPT_LIMIT,
    OPT_WALLS,
    OPT_FOLLOW,
    OPT_FOR,
    OPT_AT_TIME,
    OPT_AT_STEP,
    OPT_CONDITION,
    OPT_REMOVE,
    OPT_WHOLE_STEPS,
    OPT_DIRECTORY,
    OPT_UNTIL,
    OPT_OVERWRITE,
    OPT_RESUME_AUTO,
    OPT_THREADS,
    OPT_VERIFY,
    OPT_LOG_LEVEL,
    OPT_PICTURE,
    OPT_FIELD,
    OPT_RANGE,
    OPT_COLOURS,
    OPT_CUT,
    OPT_PROJECT,
    OPT_FLUID,
    OPT_BOX,
    OPT_TITLE,
    OPT_SIZE,
    OPT_ROLE,
    OPT_KEYS,
    OPT_FROM,
    OPT_STATE_DIR,
    OPT_ONCE,
    OPT_EXPORT,
    OPT_EVERY_STEPS,
    OPT_INTERVAL,
    OPT_MAX_HZ,
    OPT_FIRST,
    OPT_EXACT,
    OPT_PACK,
    OPT_WITHIN,
    OPT_EVERY,
    OPT_COUNT,
    OPT_CSV,
    OPT_TO,
    OPTION_COUNT
} OptionId;

/* Options as a set. */
typedef unsigned __int128 OptionSet;
_Static_assert(OPTION_COUNT <= 128, "a set of options has 128 bits");
#define OPTION(id) ((OptionSet)1 << (id))
#define OPTIONS_MOMENT                                                                                                 \
    (OPTION(OPT_WAIT_STEP) | OPTION(OPT_WAIT_TIME) | OPTION(OPT_NO_WAIT)) /* of what can be scheduled */
#define OPTIONS_GLOBAL (OPTION(OPT_LEASE + 1) - 1)
enum { MAX_WORDS = 1024 };

typedef struct OptionInfo {
    const char *name;
    char letter;       /* 0: none */
    const char *value; /* what follows it, as in "NAME"; NULL: nothing */
    const char *help;
} OptionInfo;

/* [OPTION_COUNT] */
extern const OptionInfo option_table[];

/* A command line, taken apart. Text is borrowed from argv. */
typedef struct Options {
    struct {
        OptionId id;
        const char *value; /* "" if it takes none */
    } given[MAX_WORDS];
    size_t n_given;
    const char *words[MAX_WORDS]; /* what is no option */
    size_t n_words;
} Options;

/* Add argv[1..argc-1] to what is there. With `leading`, stop at the first word that is no option; else words and
 * options may mix, words that begin like a negative number are no options, and "--" ends the options. *ret_used: words
 * of argv looked at. MNS_E_INVALID: unknown (with a suggestion), without its value, too many. */
MnsStatus options_parse(Options *options, int argc, char **argv, OptionSet allowed, bool leading, int *ret_used,
                        MnsError *error);

/* The last value given; NULL if none was. */
const char *options_get(const Options *options, OptionId id);

/* All values of an option, in order, into ret[MAX_WORDS]; their number. */
size_t options_all(const Options *options, OptionId id, const char **ret);

/* The value of an option, or text of that name, as a finite number. MNS_E_INVALID. */
MnsStatus parse_number(const char *name, const char *text, double *ret, MnsError *error);

/* A whole number from 0 on. MNS_E_INVALID. */
MnsStatus parse_count(const char *name, const char *text, uint64_t *ret, MnsError *error);

/* Up to `most` numbers with commas between them; *ret_n of them. MNS_E_INVALID. */
MnsStatus parse_numbers(const char *name, const char *text, size_t most, double *ret, size_t *ret_n, MnsError *error);

/* The id of a request: 32 hex digits. MNS_E_INVALID. */
MnsStatus parse_id(const char *name, const char *text, uint8_t id[MNS_REQUEST_ID_SIZE], MnsError *error);

#endif
