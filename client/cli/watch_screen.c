/* SPDX-License-Identifier: BSD-3-Clause */
/* The picture that `meniscus watch` shows. */
#include "client/cli/watch_screen.h"
#include "client/cli/output.h"
#include "common/host/screen.h"
#include "common/host/text.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#define HIDE_CURSOR  "\033[?25l"
#define SHOW_CURSOR  "\033[?25h"
#define CLEAR_TO_END "\033[J"
#define CLEAR_LINE   "\033[K"

enum { STEP_SIZE = 48 };

void screen_init(Screen *screen, bool may_redraw)
{
    *screen = (Screen){.is_terminal = may_redraw && isatty(STDOUT_FILENO),
                       .has_blocks = terminal_has_blocks(),
                       .time = NAN,
                       .sampled = NAN,
                       .end_time = NAN,
                       .eta_s = NAN,
                       .steps_per_second = NAN};
    if (!screen->is_terminal) return;
    screen_pass();
    fputs(HIDE_CURSOR, stdout);
}

void screen_take_info(Screen *screen, const MnsRunInfo *info)
{
    snprintf(screen->title, sizeof screen->title, "%s%s%s", info->case_name, *info->title ? ": " : "",
             text_shown(info->title));
    screen->state = info->state;
    screen->time = info->time;
    screen->end_time = info->end_time;
    screen->eta_s = info->eta_s;
    screen->steps_per_second = info->steps_per_second;
    screen->step = info->step;
    screen->recovery_step = info->recovery_step;
}

/* The same moment may be told again, as when the run stands still; one that lies before begins another time line. */
static void take_values(Screen *screen, size_t n, const MnsValue *values)
{
    const bool is_new = screen->time != screen->sampled, is_back = screen->time < screen->sampled;
    screen->sampled = screen->time;
    screen->n = n < SCREEN_MAX_PROBES ? n : SCREEN_MAX_PROBES;
    for (size_t k = 0; k < screen->n; k++) {
        Reading *probe = &screen->probes[k];
        if (is_back || strncmp(probe->name, values[k].name, sizeof probe->name - 1) != 0) probe->history.n = 0;
        if (is_new || !probe->history.n) sparkline_add(&probe->history, values[k].number);
        snprintf(probe->name, sizeof probe->name, "%s", values[k].name);
        snprintf(probe->unit, sizeof probe->unit, "%s", output_unit(values[k].unit));
        probe->value = values[k].number;
    }
}

/* They are of the moment of the reply, some steps after the status that was asked for before. */
void screen_take_reply(Screen *screen, const MnsReply *probes)
{
    screen->step = probes->step;
    screen->time = probes->time;
    take_values(screen, probes->n_values, probes->values);
}

void screen_take(Screen *screen, const MnsTelemetry *telemetry)
{
    screen->lost += telemetry->lost;
    if (telemetry->topic & (MNS_TOPIC_PROBE | MNS_TOPIC_PROGRESS)) { /* whoever joins late hears an old event first */
        screen->step = telemetry->step;
        screen->time = telemetry->time;
    }
    switch (telemetry->topic) {
    case MNS_TOPIC_PROBE: take_values(screen, telemetry->n_values, telemetry->values); break;
    case MNS_TOPIC_EVENT:
        screen->state = telemetry->state;
        snprintf(screen->news, sizeof screen->news, "%s%s%s", telemetry->what,
                 *telemetry->what && *telemetry->text ? ": " : "", text_shown(telemetry->text));
        break;
    case MNS_TOPIC_PROGRESS:
        screen->state = telemetry->state;
        screen->eta_s = telemetry->eta_s;
        screen->end_time = telemetry->end_time;
        screen->steps_per_second = telemetry->steps_per_second;
        break;
    case MNS_TOPIC_LOG:
    case MNS_TOPIC_ALL: break;
    }
}

/* On its way back after a crash, and to which step is known. */
static bool comes_back(const Screen *screen)
{
    return screen->state == MNS_STATE_RECOVERING && screen->recovery_step != MNS_NO_STEP;
}

/* Of the run, or of its way back. */
static double fraction(const Screen *screen)
{
    const double done =
        comes_back(screen) ? (double)screen->step / (double)screen->recovery_step : screen->time / screen->end_time;
    return isfinite(done) ? fmin(1, fmax(0, done)) : 0;
}

/* "214", or "214 of 1256". */
static const char *step_text(const Screen *screen, char ret[static STEP_SIZE])
{
    const int n = snprintf(ret, STEP_SIZE, "%" PRIu64, screen->step);
    if (comes_back(screen)) snprintf(ret + n, STEP_SIZE - (size_t)n, " of %" PRIu64, screen->recovery_step);
    return ret;
}

static void print_eta(const Screen *screen)
{
    const double s = screen->eta_s;
    if (screen->state != MNS_STATE_RUNNING || !isfinite(s) || s < 0 || s > 1e8) return;
    const unsigned long whole = (unsigned long)(s + 0.5);
    if (whole >= 3600) printf("  ETA %lu:%02lu:%02lu", whole / 3600, whole / 60 % 60, whole % 60);
    else printf("  ETA %lu:%02lu", whole / 60, whole % 60);
}

static int terminal_width(void)
{
    struct winsize size;
    return ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col >= 20 ? size.ws_col : 80;
}

static int terminal_height(void)
{
    struct winsize size;
    return ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_row > 0 ? size.ws_row : 24;
}

/* The bar has the width that the text beside it leaves. */
static void draw_bar(const Screen *screen)
{
    const int width = (int)fmax(4, fmin(50, terminal_width() - 40));
    const int full = (int)(fraction(screen) * width + 0.5);
    printf("%-8s [", mns_state_name(screen->state));
    for (int k = 0; k < width; k++) putchar(k < full ? '#' : '.');
    printf("] %5.1f %%", 100 * fraction(screen));
    print_eta(screen);
    fputs(CLEAR_LINE "\n", stdout);
}

/* Columns of the probes' table, such that each is as wide as the widest of what is shown. */
typedef struct Columns {
    int name, unit, chart; /* chart: 0 if there is no room for one */
    bool has_range;
} Columns;

enum { VALUE_COLUMNS = 12, CHART_LEAST = 4, RANGE_COLUMNS = 22 };

static Columns lay_out(const Screen *screen, int shown, int width)
{
    Columns columns = {0};
    for (int k = 0; k < shown; k++) {
        columns.name = (int)fmax(columns.name, (double)strlen(screen->probes[k].name));
        columns.unit = (int)fmax(columns.unit, (double)strlen(screen->probes[k].unit));
    }
    const int free = width - 2 - columns.name - 1 - VALUE_COLUMNS - 1 - columns.unit - 2;
    columns.has_range = free >= 2 * CHART_LEAST + RANGE_COLUMNS;
    columns.chart = free - (columns.has_range ? RANGE_COLUMNS : 0);
    columns.chart = columns.chart < CHART_LEAST ? 0 : (int)fmin(columns.chart, HISTORY_SIZE);
    return columns;
}

static void print_chart(const Screen *screen, const Reading *probe, const Columns *columns)
{
    char chart[SPARKLINE_TEXT_SIZE];
    double least = NAN, greatest = NAN;
    const int n = (int)sparkline(&probe->history, (size_t)columns->chart, screen->has_blocks, chart, &least, &greatest);
    printf("%*s  %s", columns->unit - (int)strlen(probe->unit), "", chart);
    if (columns->has_range && isfinite(least)) printf("%*s  %.3g..%.3g", columns->chart - n, "", least, greatest);
}

static void print_probe(const Screen *screen, const Reading *probe, const Columns *columns, int width)
{
    char line[160];
    snprintf(line, sizeof line, "  %-*s %*.6g %s", columns->name, probe->name, VALUE_COLUMNS, probe->value,
             probe->unit);
    printf("%.*s", width, line);
    if (columns->chart) print_chart(screen, probe, columns);
    fputs(CLEAR_LINE "\n", stdout);
}

/* What a low terminal has no line for; how many lines that takes. */
static int draw_rest(const Screen *screen, int shown, int width)
{
    char line[80];
    const size_t rest = screen->n - (size_t)shown;
    if (!rest) return 0;
    snprintf(line, sizeof line, "  and %zu more probe%s: no room for %s", rest, rest > 1 ? "s" : "",
             rest > 1 ? "them" : "it");
    printf("%.*s" CLEAR_LINE "\n", width, line);
    return 1;
}

/* Back to our first line, then all of it again: each line cleared as it is written, so nothing flickers. A line that
 * wraps would be two lines, so none may be wider than the terminal. */
static void draw_terminal(Screen *screen)
{
    const int width = terminal_width() - 1;
    const int room = (int)fmax(1, terminal_height() - 5);
    const int shown = (int)screen->n <= room ? (int)screen->n : room - 1;
    if (screen->drawn) printf("\033[%dA\r", screen->drawn);
    printf("%.*s" CLEAR_LINE "\n", width, screen->title);
    draw_bar(screen);
    char line[160], step[STEP_SIZE], speed[40] = "";
    if (isfinite(screen->steps_per_second)) snprintf(speed, sizeof speed, "   %.4g steps/s", screen->steps_per_second);
    if (screen->state == MNS_STATE_EMPTY) snprintf(line, sizeof line, "no case");
    else
        snprintf(line, sizeof line, "t = %.6g s of %.6g s   step %s%s   lost %" PRIu64, screen->time, screen->end_time,
                 step_text(screen, step), speed, screen->lost);
    printf("%.*s" CLEAR_LINE "\n", width, line);
    const Columns columns = lay_out(screen, shown, width);
    for (int k = 0; k < shown; k++) print_probe(screen, &screen->probes[k], &columns, width);
    screen->drawn = 3 + shown + draw_rest(screen, shown, width);
    fputs(CLEAR_TO_END, stdout);
    fflush(stdout);
}

static void draw_line(const Screen *screen)
{
    if (screen->state == MNS_STATE_EMPTY) {
        printf("%-8s no case\n", mns_state_name(screen->state));
        fflush(stdout);
        return;
    }
    char step[STEP_SIZE];
    printf("%-8s t = %.6g s  step %s  %5.1f %%", mns_state_name(screen->state), screen->time, step_text(screen, step),
           100 * fraction(screen));
    print_eta(screen);
    for (size_t k = 0; k < screen->n; k++)
        printf("  %s = %.5g%s%s", screen->probes[k].name, screen->probes[k].value, *screen->probes[k].unit ? " " : "",
               screen->probes[k].unit);
    putchar('\n');
    fflush(stdout);
}

void screen_draw(Screen *screen)
{
    if (screen->is_terminal) draw_terminal(screen);
    else draw_line(screen);
}

void screen_say(Screen *screen, const char *text)
{
    if (screen->drawn) printf("\033[%dA\r" CLEAR_TO_END, screen->drawn);
    screen->drawn = 0;
    puts(text);
    if (screen->is_terminal) draw_terminal(screen);
    else fflush(stdout);
}

void screen_done(Screen *screen)
{
    if (screen->is_terminal) fputs(SHOW_CURSOR, stdout);
    fflush(stdout);
    screen->drawn = 0;
}
