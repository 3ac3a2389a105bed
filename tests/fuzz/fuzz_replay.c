/* SPDX-License-Identifier: BSD-3-Clause */
/* Journals that are whole and tell of anything: commands in any order, cases that do not fit, steps that go back, moments that never come. A replay of
 * one agrees, or says in a sentence why not. Input: a list of records, made of its bytes; a state to go back to is in the directory. */
#include "batch/replay.h"
#include "common/case/file.h"
#include "io/checkpoint.h"
#include "io/journal.h"
#include "journal.pb-c.h"
#include "run/document.h"
#include "tests/fuzz/scratch.h"
#include <math.h>
#include <meniscus/exit.h>
#include <stdbool.h>

enum { RECORDS = 12, AGAIN = 3, LAST_STEP = 24, KEPT_STEP = 2 };

static const char case_text[] =
    "{dimensions: 2, resolution: 4, domain: {min: [0, 0], max: [2, 1]}, gravity: [0, -1], end_time: 10, threads: 1, "
    "fluids: [{name: water, density: 1000, sound_speed: 20, shape: [{box: {min: [0, 0], max: [1, 0.5]}}]}], "
    "walls: [{name: tank, shape: [{outside: true, box: {min: [0, 0], max: [2, 1]}}]}]}";

static CaseFile *file;
static FILE *nowhere;
static char checkpoint_path[4096];
static Meniscus__Case *whole; /* a case */
static Meniscus__Case bare = MENISCUS__CASE__INIT;

static void write_checkpoint(void)
{
    MnsSim *sim;
    MnsCapture *state;
    Document *document;
    PROMISE(!document_new(whole, "a", &document, NULL) && !mns_sim_new(document->c, &sim, NULL));
    for (int k = 0; k < KEPT_STEP; k++) PROMISE(!mns_sim_step(sim, 1, NULL));
    PROMISE(!mns_sim_capture(sim, mns_sim_state_fields(sim), &state, NULL));
    const FileMeta meta = {.c = document->c, .case_name = document->name, .case_text = document->text};
    PROMISE(!checkpoint_write(scratch_home, state, &meta, document->blob, document->size, 1, checkpoint_path, NULL));
    mns_capture_free(state);
    mns_sim_free(sim);
    document_leave(document);
}

static void remove_all(void)
{
    unlink(checkpoint_path);
    scratch_end();
}

int LLVMFuzzerInitialize(int *argc, char ***argv);

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
    (void)argc, (void)argv;
    scratch_begin("journal");
    nowhere = fopen("/dev/null", "we");
    PROMISE(nowhere && freopen("/dev/null", "w", stdout));
    PROMISE(!case_file_parse("case", case_text, strlen(case_text), &file, NULL));
    whole = (Meniscus__Case *)case_file_message(file);
    write_checkpoint();
    atexit(remove_all);
    return 0;
}

/* --- records --------------------------------------------------------------------------------------------------------------- */

typedef struct Script {
    const uint8_t *at, *end;
} Script;

static unsigned draw(Script *script)
{
    return script->at < script->end ? *script->at++ : 0;
}

/* What one record is made of. */
typedef struct Parts {
    Meniscus__Request request, again_request[AGAIN];
    Meniscus__Again again[AGAIN], *agains[AGAIN];
    Meniscus__Reply reply;
    union Command {
        Meniscus__Load load;
        Meniscus__Step step;
        Meniscus__RunUntil until;
        Meniscus__Set set;
        Meniscus__Rollback rollback;
        Meniscus__Reset reset;
        Meniscus__Restore restore;
        Meniscus__Pause pause;
        Meniscus__SetBreakpoint point;
        Meniscus__Lease lease;
    } command[1 + AGAIN];
    Meniscus__Assignment assignment[1 + AGAIN], *assignments[1 + AGAIN];
    uint8_t id[1 + AGAIN];
} Parts;

static double draw_time(Script *script)
{
    static const double some[] = {0, -1, 1e-300, 1e300, INFINITY, NAN, 10, 0.01};
    const unsigned kind = draw(script);
    return kind < 192 ? kind * 1e-3 : some[kind % 8];
}

static uint64_t draw_step(Script *script, uint64_t now)
{
    const unsigned kind = draw(script);
    const uint64_t step = kind < 128   ? now + kind % 4
                          : kind < 192 ? kind % 4
                          : kind < 240 ? KEPT_STEP
                                       : kind % LAST_STEP;
    return step < LAST_STEP ? step : LAST_STEP;
}

static Meniscus__Case *draw_case(Script *script)
{
    const unsigned kind = draw(script);
    return kind < 128 ? whole : kind < 192 ? &bare : NULL;
}

static void draw_set(Script *script, Meniscus__Set *set, Meniscus__Assignment *one, Meniscus__Assignment **list)
{
    static const char *const paths[] = {"gravity",
                                        "end_time",
                                        "threads",
                                        "resolution",
                                        "fluids.water.viscosity",
                                        "scheme.cfl",
                                        "output.checkpoint_interval",
                                        "dimensions",
                                        "no",
                                        ""};
    static const char *const values[] = {"[0, -2]", "[1e300, 0]", "0.01", "1e-300", "5", "nan", "", "0", "-1", "[0"};
    meniscus__set__init(set);
    meniscus__assignment__init(one);
    one->path = (char *)paths[draw(script) % (sizeof paths / sizeof *paths)];
    one->value = (char *)values[draw(script) % (sizeof values / sizeof *values)];
    *list = one;
    set->assignments = list;
    set->n_assignments = draw(script) < 240;
}

static void draw_load(Script *script, Meniscus__Load *load)
{
    const unsigned kind = draw(script);
    meniscus__load__init(load);
    load->case_ = kind % 2 ? whole : NULL;
    load->has_resume = load->resume = kind < 64;
}

static void draw_until(Script *script, Meniscus__RunUntil *until)
{
    meniscus__run_until__init(until);
    until->has_time = until->has_exact = true;
    until->time = draw_time(script);
    until->exact = draw(script) < 192;
}

/* Number k of the commands of this record. */
static void draw_request(Script *script, Parts *parts, Meniscus__Request *request, int k)
{
    union Command *command = &parts->command[k];
    meniscus__request__init(request);
    parts->id[k] = (uint8_t)(draw(script) % 4);
    request->has_id = true;
    request->id = (ProtobufCBinaryData){.len = parts->id[k] < 3, .data = &parts->id[k]};
    request->has_at_time = draw(script) < 96;
    if (request->has_at_time) request->at_time = draw_time(script);
    request->load = &command->load; /* whichever it is: they are a union there too */
    switch (draw(script) % 12) {
    case 0: draw_load(script, &command->load), request->command_case = MENISCUS__REQUEST__COMMAND_LOAD; break;
    case 1: meniscus__step__init(&command->step), request->command_case = MENISCUS__REQUEST__COMMAND_STEP; break;
    case 2: draw_until(script, &command->until), request->command_case = MENISCUS__REQUEST__COMMAND_RUN_UNTIL; break;
    case 3:
        meniscus__rollback__init(&command->rollback), request->command_case = MENISCUS__REQUEST__COMMAND_ROLLBACK;
        break;
    case 4: meniscus__reset__init(&command->reset), request->command_case = MENISCUS__REQUEST__COMMAND_RESET; break;
    case 5:
        meniscus__restore__init(&command->restore), request->command_case = MENISCUS__REQUEST__COMMAND_RESTORE;
        break;
    case 6: meniscus__pause__init(&command->pause), request->command_case = MENISCUS__REQUEST__COMMAND_PAUSE; break;
    case 7: meniscus__lease__init(&command->lease), request->command_case = MENISCUS__REQUEST__COMMAND_LEASE; break;
    case 8:
        meniscus__set_breakpoint__init(&command->point);
        request->command_case = MENISCUS__REQUEST__COMMAND_BREAKPOINT;
        break;
    case 9: request->load = NULL; break; /* of a later version */
    default:
        draw_set(script, &command->set, &parts->assignment[k], &parts->assignments[k]);
        request->command_case = MENISCUS__REQUEST__COMMAND_SET;
    }
}

static void draw_again(Script *script, Parts *parts, Meniscus__JournalRecord *record, uint64_t step)
{
    const unsigned n = draw(script);
    record->again = parts->agains;
    record->n_again = n < 160 ? 0 : n % (AGAIN + 1);
    for (size_t k = 0; k < record->n_again; k++) {
        Meniscus__Again *again = parts->agains[k] = &parts->again[k];
        const unsigned kind = draw(script);
        meniscus__again__init(again);
        again->has_step = true;
        again->step = draw_step(script, step);
        again->adopted = kind & 1 ? draw_case(script) : NULL;
        again->has_scheduled = again->scheduled = kind & 2;
        again->has_until_step = kind & 4;
        again->until_step = draw_step(script, step);
        if (kind < 224) {
            draw_request(script, parts, &parts->again_request[k], (int)k + 1);
            again->request = &parts->again_request[k];
        }
    }
}

/* Of one in eight the hash is there, and hardly right. */
static void add_record(Script *script, Journal *journal, bool first, uint64_t *step)
{
    static char *const arithmetics[] = {NULL, NULL, NULL, (char *)"fused", (char *)"separate", (char *)"?"};
    Parts parts;
    Meniscus__JournalRecord record = MENISCUS__JOURNAL_RECORD__INIT;
    record.has_kind = record.has_step = true;
    record.kind = first ? MENISCUS__JOURNAL_RECORD__KIND__COMMAND : (Meniscus__JournalRecord__Kind)(draw(script) % 6);
    record.step = *step = first ? 0 : draw_step(script, *step);
    record.has_state_hash = !first && draw(script) % 8 == 0;
    record.case_ = first ? whole : draw_case(script);
    record.arithmetic = arithmetics[draw(script) % 6];
    if (first || draw(script) < 240) {
        draw_request(script, &parts, &parts.request, 0);
        record.request = &parts.request;
    }
    if (draw(script) < 32) {
        meniscus__reply__init(&parts.reply);
        parts.reply.has_code = true;
        parts.reply.code = (Meniscus__Code)(draw(script) % 17);
        record.reply = &parts.reply;
    }
    draw_again(script, &parts, &record, *step);
    const size_t size = meniscus__journal_record__get_packed_size(&record);
    uint8_t *packed = malloc(size + 1);
    PROMISE(packed);
    meniscus__journal_record__pack(&record, packed);
    PROMISE(!journal_add(journal, packed, size, NULL));
    free(packed);
}

/* Without what it says, which is much. */
static int replay(bool json)
{
    FILE *const said = stderr;
    stderr = nowhere;
    const int code = replay_run(scratch_home, -1, json);
    stderr = said;
    return code;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    Script script = {data, data + size};
    Journal *journal;
    uint64_t step = 0;
    unlink(scratch_path);
    PROMISE(!journal_open(scratch_path, &journal, NULL, NULL));
    for (int k = 0; k < RECORDS && script.at < script.end; k++) add_record(&script, journal, k == 0, &step);
    PROMISE(!journal_write(journal, NULL));
    journal_free(journal);
    const int code = replay(size % 2);
    PROMISE(code == MNS_EXIT_DONE || code == MNS_EXIT_FAILED || code == MNS_EXIT_IO);
    return 0;
}
