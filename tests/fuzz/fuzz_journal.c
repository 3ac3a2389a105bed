/* SPDX-License-Identifier: BSD-3-Clause */
/* The bytes of a journal, as `meniscus log` and a daemon that comes back read them: no changed record is taken for a whole one, and a complaint says
 * where. Then again with checksums made right, for what is behind them: the printed history, and the way back to where the run was. */
#include "batch/history_print.h"
#include "common/wire/frame.h"
#include "io/journal_frame.h"
#include "net/comeback.h"
#include "run/document.h"
#include "tests/fuzz/scratch.h"

enum { FRAME = sizeof(JournalFrame), LARGEST = 1 << 16, FEW = 8 };

int LLVMFuzzerInitialize(int *argc, char ***argv);

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
    (void)argc, (void)argv;
    scratch_begin("journal");
    PROMISE(freopen("/dev/null", "w", stdout));
    return 0;
}

/* --- what is whole, found out in another way ------------------------------------------------------------------------------ */

static void chain_of(const uint8_t before[static JOURNAL_CHAIN], const uint8_t *record, size_t size,
                     uint8_t ret[static JOURNAL_CHAIN])
{
    static uint8_t all[JOURNAL_CHAIN + LARGEST];
    XXH128_canonical_t canonical;
    memcpy(all, before, JOURNAL_CHAIN);
    memcpy(all + JOURNAL_CHAIN, record, 16);
    memcpy(all + JOURNAL_CHAIN + 16, record + FRAME, size);
    XXH128_canonicalFromHash(&canonical, XXH3_128bits(all, JOURNAL_CHAIN + 16 + size));
    memcpy(ret, canonical.digest, JOURNAL_CHAIN);
}

static bool is_whole(const uint8_t *record, size_t left, uint64_t number, const uint8_t chain[static JOURNAL_CHAIN])
{
    JournalFrame frame;
    uint8_t wanted[JOURNAL_CHAIN];
    if (left < FRAME) return false;
    memcpy(&frame, record, FRAME);
    if (frame.mark != htole32(journal_mark) || frame.number != htole64(number) || le32toh(frame.size) > left - FRAME)
        return false;
    chain_of(chain, record, le32toh(frame.size), wanted);
    return frame.check == htole64(XXH64(record, 16, 0)) && !memcmp(wanted, frame.chain, JOURNAL_CHAIN);
}

/* ret_end: of the last whole one. */
static uint64_t count_whole(const uint8_t *data, size_t size, size_t *ret_end)
{
    uint8_t chain[JOURNAL_CHAIN] = {0};
    uint64_t n = 0;
    *ret_end = 0;
    if (size < JOURNAL_HEAD || memcmp(data, journal_magic, JOURNAL_HEAD) != 0) return 0;
    for (*ret_end = JOURNAL_HEAD; is_whole(data + *ret_end, size - *ret_end, n + 1, chain); n++) {
        JournalFrame frame;
        memcpy(&frame, data + *ret_end, FRAME);
        memcpy(chain, frame.chain, JOURNAL_CHAIN);
        *ret_end += FRAME + le32toh(frame.size);
    }
    return n;
}

/* --- who reads it --------------------------------------------------------------------------------------------------------- */

static void assert_place(const MnsError *error, MnsStatus status)
{
    PROMISE(status == MNS_E_CORRUPT && error->status == status);
    PROMISE((strstr(error->text, "record ") && strstr(error->text, "at byte ")) ||
            strstr(error->text, "its first 8 bytes are others"));
}

/* A daemon cuts off what was torn, and goes on behind it. */
static void go_on(uint64_t whole)
{
    Journal *journal = NULL;
    JournalReport report, after;
    MnsError error;
    PROMISE(!journal_open(scratch_path, &journal, &report, &error) && report.records == whole);
    PROMISE(!journal_add(journal, "", 0, &error) && !journal_commit(journal, &error));
    journal_free(journal);
    PROMISE(!journal_read(scratch_path, NULL, NULL, &after, &error));
    PROMISE(after.records == whole + 1 && !after.torn);
}

static bool is_set(const Meniscus__Request *request)
{
    return request && request->command_case == MENISCUS__REQUEST__COMMAND_SET;
}

/* What a daemon makes of the case and of the commands that it does again. */
static void do_again(const Lineage *lineage, const Meniscus__Request *load)
{
    MnsError error;
    Document *document = NULL;
    const MnsStatus status = document_new(load->load->case_, load->load->name, &document, &error);
    PROMISE(!status || *error.text);
    for (size_t k = 0; k < lineage->n && k < FEW; k++) {
        const LineageEntry *entry = &lineage->entries[k];
        Document *next = NULL;
        if (entry->adopted) document_new(entry->adopted, load->load->name, &next, &error);
        else if (document && is_set(entry->request)) document_set(document, entry->request->set, &next, &error);
        document_leave(next);
    }
    document_leave(document);
}

static void come_back(Comeback *comeback)
{
    Meniscus__Request request, *resume, *rest;
    Meniscus__Load load;
    const Lineage *lineage = &comeback->lineage;
    comeback_request(comeback, &request, &load);
    resume = comeback_resume(comeback);
    rest = comeback_rest(comeback);
    for (size_t k = 0; k < lineage->n; k++) {
        lineage_needs(lineage, k, lineage->step / 2);
        PROMISE(lineage->entries[k].request || !lineage->entries[k].scheduled);
    }
    lineage_limit(lineage, lineage->step, 0);
    do_again(lineage, &request);
    request_free(resume);
    request_free(rest);
}

/* history_print() would read and complain of it once more. */
static void read_whole(Comeback *comeback)
{
    MnsError error = {0};
    char boot[HISTORY_BOOT] = "6f1c9a52-0000-0000-0000-000000000000";
    const MnsStatus status = lineage_of(&comeback->history, boot, &comeback->lineage, &error);
    PROMISE(!status || (status == MNS_E_STATE && *error.text));
    if (!status) come_back(comeback);
    lineage_done(&comeback->lineage);
    PROMISE(!history_print(scratch_home, false, false) && !history_print(scratch_home, false, true));
}

/* The status of it. */
static MnsStatus read_all(const uint8_t *data, size_t size)
{
    Comeback comeback = {.due = true};
    MnsError error = {0};
    size_t end;
    const uint64_t whole = count_whole(data, size, &end);
    scratch_put(data, size);
    const MnsStatus status = history_read(scratch_home, &comeback.history, &error);
    PROMISE(comeback.history.n == comeback.history.report.records && comeback.history.n <= whole);
    if (status) assert_place(&error, status);
    else {
        PROMISE(comeback.history.n == whole && comeback.history.report.torn == size - end);
        read_whole(&comeback);
        go_on(whole);
    }
    history_done(&comeback.history);
    return status;
}

/* --- checksums made right ------------------------------------------------------------------------------------------------- */

/* Every record as long as it says it is, the last one as there are bytes. */
static void seal(uint8_t *data, size_t size)
{
    uint8_t chain[JOURNAL_CHAIN] = {0};
    uint64_t number = 0;
    memcpy(data, journal_magic, JOURNAL_HEAD);
    for (size_t at = JOURNAL_HEAD; at + FRAME <= size;) {
        JournalFrame frame;
        const size_t left = size - at - FRAME;
        memcpy(&frame, data + at, FRAME);
        const size_t n = le32toh(frame.size) < left ? le32toh(frame.size) : left;
        frame =
            (JournalFrame){.mark = htole32(journal_mark), .size = htole32((uint32_t)n), .number = htole64(++number)};
        frame.check = htole64(XXH64(&frame, 16, 0));
        memcpy(data + at, &frame, FRAME);
        chain_of(chain, data + at, n, chain);
        memcpy(data + at + FRAME - JOURNAL_CHAIN, chain, JOURNAL_CHAIN);
        at += FRAME + n;
    }
}

/* One changed bit ends what is taken for whole before it, and is told of. */
static void change_one(uint8_t *data, size_t size)
{
    const uint64_t chance = XXH64(data, size, 0);
    const size_t at = chance % size;
    JournalReport report;
    MnsError error = {0};
    data[at] ^= (uint8_t)(1u << (chance >> 32) % 8);
    scratch_put(data, size);
    const MnsStatus status = journal_read(scratch_path, NULL, NULL, &report, &error);
    PROMISE(report.size <= at && (status || report.torn));
    if (status) assert_place(&error, status);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size > LARGEST) return 0;
    read_all(data, size);
    if (size < JOURNAL_HEAD + FRAME) return 0;
    uint8_t *sealed = malloc(size);
    PROMISE(sealed);
    memcpy(sealed, data, size);
    seal(sealed, size);
    read_all(sealed, size);
    change_one(sealed, size);
    free(sealed);
    return 0;
}
