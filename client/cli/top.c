/* SPDX-License-Identifier: BSD-3-Clause */
/* meniscus top: the daemons of this machine in a table that is made anew each second. */
#include "client/cli/command.h"
#include "client/cli/glance.h"
#include "client/cli/output.h"
#include "common/host/screen.h"
#include "common/host/text.h"
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>

static const long every_s = 1;

/* --- what there is -------------------------------------------------------------------------------------------------------- */

/* A daemon that does not answer has no status. */
static json_t *describe(const char *name, const char *endpoint, const Glance *glance)
{
    static const MnsRunInfo none = {
        .state = MNS_STATE_EMPTY, .case_name = "", .fault = "", .recovery_step = MNS_NO_STEP};
    const bool alive = glance->info;
    const MnsRunInfo *at = alive ? glance->info : &none;
    const bool loaded = at->state != MNS_STATE_EMPTY;
    json_t *row =
        json_pack("{ss so sb sb ss? so so}", "name", name, "endpoint", output_text(endpoint), "alive", alive, "silent",
                  glance->is_silent, "state", alive ? mns_state_name(at->state) : NULL, "case",
                  output_text(loaded ? at->case_name : NULL), "fault", output_text(*at->fault ? at->fault : NULL));
    json_object_set_new(row, "time", output_number(loaded ? at->time : (double)NAN));
    json_object_set_new(row, "end_time", output_number(loaded ? at->end_time : (double)NAN));
    json_object_set_new(row, "step", loaded ? json_integer((json_int_t)at->step) : json_null());
    json_object_set_new(row, "recovery_step",
                        loaded && at->recovery_step != MNS_NO_STEP ? json_integer((json_int_t)at->recovery_step)
                                                                   : json_null());
    json_object_set_new(row, "steps_per_second", output_number(loaded ? at->steps_per_second : (double)NAN));
    json_object_set_new(row, "eta_s", output_number(loaded ? at->eta_s : (double)NAN));
    json_object_set_new(row, "memory_bytes", alive ? json_integer((json_int_t)at->memory_bytes) : json_null());
    json_object_set_new(row, "clients", glance->clients >= 0 ? json_integer(glance->clients) : json_null());
    const uint64_t n = at->streams ? at->streams->latest + at->streams->lossless : 0;
    json_object_set_new(row, "streams", at->streams ? json_integer((json_int_t)n) : json_null());
    return row;
}

/* Is a signal on hold? They are where the table is made anew. */
static bool is_interrupted(void)
{
    sigset_t signals;
    return sigpending(&signals) == 0 &&
           (sigismember(&signals, SIGINT) || sigismember(&signals, SIGTERM) || sigismember(&signals, SIGHUP));
}

/* Each that hangs takes a moment, so signals are looked at in between. */
static bool visit(void *arg, const char *name, const char *endpoint)
{
    Glance glance = glance_at(endpoint);
    json_array_append_new(arg, describe(name, endpoint, &glance));
    glance_done(&glance);
    return !is_interrupted();
}

static json_t *look(void)
{
    json_t *daemons = json_array();
    if (daemons) mns_daemon_list(visit, daemons);
    return daemons;
}

/* --- the table ------------------------------------------------------------------------------------------------------------ */

enum { NAME = 16, CASE = 20, OTHERS = 54, SHORT = 10, INDENT = 2, WIDE = OTHERS + NAME + CASE + SHORT };

typedef struct Table {
    bool is_terminal, has_colour;
    int width;       /* no line of a terminal may be wider, as it would be two */
    int name, case_; /* columns; the others have OTHERS, and a fault the rest, or a line of its own if that is SHORT */
    size_t room;     /* lines for daemons: what is above the terminal cannot be drawn again */
    int drawn;       /* lines that are ours */
} Table;

static double number(const json_t *row, const char *name)
{
    const json_t *value = json_object_get(row, name);
    return json_is_number(value) ? json_number_value(value) : (double)NAN;
}

static const char *text(const json_t *row, const char *name, const char *otherwise)
{
    const char *value = json_string_value(json_object_get(row, name));
    return value ? text_shown(value) : otherwise;
}

/* A number, or a dash where it is not known. */
static const char *cell(char ret[static 32], double value, const char *unit)
{
    if (!isfinite(value)) return strcpy(ret, "-");
    if (fabs(value) < 10) snprintf(ret, 32, "%.3g%s", value, unit);
    else snprintf(ret, 32, "%.0f%s", fmin(value, 1e15), unit);
    return ret;
}

static const char *duration(char ret[static 32], double s)
{
    if (!isfinite(s) || s < 0 || s > 1e8) return strcpy(ret, "-");
    const unsigned long whole = (unsigned long)(s + 0.5);
    if (whole >= 3600) snprintf(ret, 32, "%lu:%02lu:%02lu", whole / 3600, whole / 60 % 60, whole % 60);
    else snprintf(ret, 32, "%lu:%02lu", whole / 60, whole % 60);
    return ret;
}

static const char *colour_of(const char *state)
{
    static const struct {
        const char *state, *colour;
    } colours[] = {{"RUNNING", "\033[32m"},
                   {"FAULT", "\033[31m"},
                   {"dead", "\033[31m"},
                   {"silent", "\033[31m"},
                   {"PAUSED", "\033[33m"}};
    for (size_t k = 0; k < sizeof colours / sizeof *colours; k++)
        if (strcmp(colours[k].state, state) == 0) return colours[k].colour;
    return "";
}

static void print_line(const Table *table, const char *colour, const char *line)
{
    if (!table->is_terminal) puts(line);
    else
        printf("%s%.*s%s\033[K\n", table->has_colour ? colour : "", table->width, line,
               table->has_colour && *colour ? "\033[0m" : "");
}

static bool is_narrow(const Table *table)
{
    return table->is_terminal && table->width < WIDE;
}

/* Lines that a text takes beside an indentation. */
static size_t lines_for(const Table *table, size_t length)
{
    const size_t each = (size_t)(table->width - INDENT);
    return (length + each - 1) / each;
}

static size_t lines_of(const Table *table, const json_t *row)
{
    const char *fault = text(row, "fault", "");
    return is_narrow(table) && *fault ? 1 + lines_for(table, strlen("FAULT: ") + strlen(fault)) : 1;
}

/* One line of cells, the last of which is the fault. */
static void print_cells(const Table *table, const char *colour, const char *const cells[9])
{
    enum { LONGEST = 60 };
    char line[900];
    const bool narrow = is_narrow(table);
    snprintf(line, sizeof line, "%-*.*s %-10s %-*.*s %5s %7s %8s %7s %8s  %.500s", table->name,
             narrow ? table->name : LONGEST, cells[0], cells[1], table->case_, narrow ? table->case_ : LONGEST,
             cells[2], cells[3], cells[4], cells[5], cells[6], cells[7], narrow ? "" : cells[8]);
    for (size_t n = strlen(line); n && line[n - 1] == ' '; n--) line[n - 1] = 0;
    print_line(table, colour, line);
}

/* As many letters in each line as there is room for: whoever has a narrow terminal is told as much as others. */
static void print_wrapped(const Table *table, const char *colour, const char *fault)
{
    char all[600], line[600];
    const int n = snprintf(all, sizeof all, "FAULT: %.500s", fault), each = table->width - INDENT;
    for (int k = 0; k < n; k += each) {
        snprintf(line, sizeof line, "%*s%.*s", INDENT, "", each, all + k);
        print_line(table, colour, line);
    }
}

/* [%] Of the run, or of its way back after a crash, as `meniscus watch` has it. */
static double share(const json_t *row)
{
    const double goal = number(row, "recovery_step");
    const double done =
        isfinite(goal) ? fmin(1, number(row, "step") / goal) : number(row, "time") / number(row, "end_time");
    return round(1000 * done) / 10;
}

static void print_row(const Table *table, const json_t *row)
{
    char done[32], speed[32], eta[32], clients[32], memory[32];
    const char *state = text(row, "state", json_is_true(json_object_get(row, "silent")) ? "silent" : "dead");
    const char *fault = text(row, "fault", "");
    print_cells(table, colour_of(state),
                (const char *const[9]){text(row, "name", ""), state, text(row, "case", "-"),
                                       cell(done, share(row), "%"), cell(speed, number(row, "steps_per_second"), ""),
                                       duration(eta, number(row, "eta_s")), cell(clients, number(row, "clients"), ""),
                                       cell(memory, number(row, "memory_bytes") / (1 << 20), " MiB"), fault});
    if (lines_of(table, row) == 1) return;
    print_wrapped(table, colour_of(state), fault);
}

/* The head of the table, and the line that the cursor is left in, have theirs too. */
static void measure(Table *table)
{
    struct winsize size;
    const bool known = table->is_terminal && !ioctl(STDOUT_FILENO, TIOCGWINSZ, &size);
    table->width = known && size.ws_col >= 20 ? size.ws_col - 1 : 80;
    table->room = !table->is_terminal ? SIZE_MAX : known && size.ws_row >= 4 ? size.ws_row - 2u : 22;
    table->name = NAME;
    table->case_ = CASE;
    if (!is_narrow(table)) return;
    const int both = table->width - OTHERS < NAME + CASE ? table->width - OTHERS : NAME + CASE;
    table->name = both / 2 > SHORT ? both / 2 < NAME ? both / 2 : NAME : SHORT;
    table->case_ = both - table->name > SHORT ? both - table->name : SHORT;
}

/* How many of the first fit, with a line that tells of the others. */
static size_t fitting(const Table *table, const json_t *daemons)
{
    const size_t n = json_array_size(daemons);
    size_t lines = 0, fit = 0;
    for (size_t k = 0; k < n; k++) {
        lines += lines_of(table, json_array_get(daemons, k));
        if (lines <= table->room - (k + 1 < n)) fit = k + 1;
    }
    return fit;
}

static void draw(Table *table, const json_t *daemons)
{
    char line[160];
    const size_t n = json_array_size(daemons);
    const int before = table->drawn;
    measure(table);
    const size_t shown = fitting(table, daemons);
    if (before) printf("\033[%dA\r", before);
    table->drawn = 1 + (shown < n);
    if (n)
        print_cells(
            table, "\033[1m",
            (const char *const[9]){"NAME", "STATE", "CASE", "DONE", "STEPS/S", "ETA", "CLIENTS", "MEMORY", "FAULT"});
    else print_line(table, "\033[1m", "no daemon on this host; start one with `meniscusd`");
    for (size_t k = 0; k < shown; k++) {
        print_row(table, json_array_get(daemons, k));
        table->drawn += (int)lines_of(table, json_array_get(daemons, k));
    }
    snprintf(line, sizeof line, "... %zu more", n - shown);
    if (shown < n) print_line(table, "", line);
    if (table->is_terminal) fputs("\033[J", stdout);
    fflush(stdout);
}

static MnsStatus show(const Invocation *in, Table *table, MnsError *error)
{
    json_t *daemons = look();
    if (is_interrupted()) { /* it is not whole */
        json_decref(daemons);
        return MNS_OK;
    }
    if (in->json) return output_json(json_pack("{so}", "daemons", daemons), error);
    draw(table, daemons);
    json_decref(daemons);
    return screen_flush(error);
}

/* Until a signal comes, which takes effect between two daemons, and not while a table is drawn. */
static MnsStatus repeat(const Invocation *in, Table *table, MnsError *error)
{
    const struct timespec pause = {.tv_sec = every_s};
    sigset_t signals;
    int signal = -1;
    MnsStatus status = MNS_OK;
    sigemptyset(&signals);
    sigaddset(&signals, SIGINT);
    sigaddset(&signals, SIGTERM);
    sigaddset(&signals, SIGHUP);
    sigprocmask(SIG_BLOCK, &signals, NULL);
    while (!status && signal <= 0) {
        status = show(in, table, error);
        if (!status) signal = sigtimedwait(&signals, NULL, &pause);
    }
    sigprocmask(SIG_UNBLOCK, &signals, NULL);
    if (signal > 0) raise(signal);
    return status;
}

MnsStatus command_top(Invocation *in, MnsError *error)
{
    const char *none = getenv("NO_COLOR"), *kind = getenv("TERM");
    Table table = {.is_terminal = isatty(STDOUT_FILENO)};
    const bool once = options_get(&in->options, OPT_ONCE) || !(table.is_terminal || in->json);
    table.is_terminal = table.is_terminal && !once;
    if (table.is_terminal) screen_pass();
    table.has_colour = !(none && *none) && kind && strcmp(kind, "dumb") != 0;
    return once ? show(in, &table, error) : repeat(in, &table, error);
}
