/* SPDX-License-Identifier: BSD-3-Clause */
/* Notes on their way out: when nobody fetches them, old samples give way to new ones and all else stays. */
#include "run/outbox.h"
#include "tests/support/check.h"
#include <poll.h>

enum { MANY = 1500 };

static int begin(void **state)
{
    static Outbox box;
    *state = &box;
    return (int)outbox_init(&box, NULL);
}

static int end(void **state)
{
    outbox_done(*state);
    return 0;
}

static void put(Outbox *box, NoteKind kind, uint64_t step)
{
    Note *note = note_new(kind, 0);
    assert_non_null(note);
    note->step = step;
    outbox_put(box, note);
}

/* Step of the next note, which must be of this kind. */
static uint64_t take(Outbox *box, NoteKind kind)
{
    Note *note = outbox_take(box);
    assert_non_null(note);
    assert_int_equal(note->kind, kind);
    const uint64_t step = note->step;
    note_free(note);
    return step;
}

static void the_newest_samples_stay_and_the_others_are_counted(void **state)
{
    uint64_t dropped = 0, n = 0;
    put(*state, NOTE_EVENT, 0);
    for (uint64_t step = 1; step <= MANY; step++) put(*state, step % 2 ? NOTE_PROBES : NOTE_PROGRESS, step);
    dropped = outbox_dropped(*state);
    assert_in_range(dropped, 1, MANY - 1);
    assert_int_equal(take(*state, NOTE_EVENT), 0);
    for (uint64_t step = dropped + 1; step <= MANY; step++, n++)
        assert_int_equal(take(*state, step % 2 ? NOTE_PROBES : NOTE_PROGRESS), step);
    assert_int_equal(n + dropped, MANY);
    assert_null(outbox_take(*state));
}

static void answers_events_and_log_lines_always_stay(void **state)
{
    Order order = {.note = {.kind = NOTE_ANSWER, .order = &order}};
    put(*state, NOTE_LOG, 1);
    for (uint64_t step = 0; step < MANY; step++) {
        put(*state, NOTE_EVENT, step);
        put(*state, NOTE_PROBES, step);
    }
    outbox_put(*state, &order.note);
    uint64_t events = 0, samples = 0, logs = 0;
    for (Note *note; (note = outbox_take(*state)); note_free(note)) {
        logs += note->kind == NOTE_LOG;
        samples += note->kind == NOTE_PROBES;
        if (note->kind == NOTE_EVENT) assert_int_equal(note->step, events++);
        if (note->kind == NOTE_ANSWER) assert_ptr_equal(note->order, &order);
    }
    assert_int_equal(logs, 1);
    assert_int_equal(events, MANY);
    assert_int_equal(samples + outbox_dropped(*state), MANY);
}

/* As the last note may be one that is dropped. */
static void a_box_may_be_filled_and_emptied_again_and_again(void **state)
{
    for (int round = 0; round < 3; round++) {
        for (uint64_t step = 0; step < MANY; step++) put(*state, NOTE_PROBES, step);
        uint64_t last = 0;
        for (Note *note; (note = outbox_take(*state)); note_free(note)) last = note->step;
        assert_int_equal(last, MANY - 1);
        struct pollfd wake = {.fd = ((Outbox *)*state)->wake, .events = POLLIN};
        assert_int_equal(poll(&wake, 1, 0), 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(the_newest_samples_stay_and_the_others_are_counted, begin, end),
        cmocka_unit_test_setup_teardown(answers_events_and_log_lines_always_stay, begin, end),
        cmocka_unit_test_setup_teardown(a_box_may_be_filled_and_emptied_again_and_again, begin, end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
