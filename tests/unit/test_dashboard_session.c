/* SPDX-License-Identifier: BSD-3-Clause */
/* What waits for a browser at the dashboard's gateway, and what it gives up when that is slow. */
#include "client/dashboard/session.h"
#include "tests/support/check.h"
#include <jansson.h>
#include <stdlib.h>
#include <string.h>

static const double places[] = {0, 1, 2, 3, 4, 5}, values[] = {3, 4, 0, 0, -5, 12};
static const uint8_t phases[] = {0, 1, 2};

static Frame *picture(const Wish *wish, uint64_t step)
{
    const MnsArray arrays[] = {
        {.name = "position", .type = "<f8", .unit = "m", .n_dims = 2, .shape = {3, 2}, .data = places},
        {.name = "velocity", .type = "<f8", .unit = "m/s", .n_dims = 2, .shape = {3, 2}, .data = values},
        {.name = "phase", .type = "|u1", .unit = "1", .n_dims = 1, .shape = {3}, .data = phases},
    };
    const MnsReply reply = {.step = step, .time = 0.5, .n_arrays = 3, .arrays = arrays};
    Frame *frame;
    assert_int_equal(frame_new(wish, (FrameKey){1, step}, 2, 6, &reply, &frame, NULL), MNS_OK);
    frame->users = 1;
    return frame;
}

static float float_at(const unsigned char *bytes)
{
    float value;
    memcpy(&value, bytes, sizeof value);
    return value;
}

static void a_picture_is_laid_out_as_the_manual_says(void **state)
{
    (void)state;
    const Wish wish = {.field = "velocity", .limit = 3};
    Frame *frame = picture(&wish, 41);
    frame_set_skipped(frame, 258);
    const unsigned char *bytes = frame->bytes + FRAME_HEADROOM;
    const size_t length = bytes[0] + 256u * bytes[1];
    assert_int_equal(length % 4, 0);
    assert_int_equal(bytes[4] + 256 * bytes[5], 258);
    json_t *header = json_loadb((const char *)bytes + 8, length, 0, NULL);
    assert_int_equal(json_integer_value(json_object_get(header, "step")), 41);
    assert_int_equal(json_integer_value(json_object_get(header, "particles")), 3);
    assert_int_equal(json_integer_value(json_object_get(header, "all")), 6);
    assert_int_equal(json_integer_value(json_object_get(header, "dimensions")), 2);
    assert_true(json_is_true(json_object_get(header, "magnitude")));
    json_decref(header);
    const unsigned char *data = bytes + 8 + length;
    for (size_t k = 0; k < 6; k++) assert_close(float_at(data + 4 * k), places[k], 0);
    assert_close(float_at(data + 24), 5, 0);
    assert_close(float_at(data + 32), 13, 0);
    assert_memory_equal(data + 36, phases, 3);
    assert_int_equal(frame->size, 8 + length + 39);
    frame_release(frame);
}

static void an_answer_without_what_was_asked_is_no_picture(void **state)
{
    (void)state;
    const MnsArray place = {
        .name = "position", .type = "<f8", .unit = "m", .n_dims = 2, .shape = {3, 2}, .data = places};
    const MnsReply reply = {.n_arrays = 1, .arrays = &place}, nothing = {0};
    Frame *frame;
    assert_int_equal(frame_new(&(Wish){.field = "phase"}, (FrameKey){0}, 1, 3, &reply, &frame, NULL), MNS_E_CORRUPT);
    assert_int_equal(frame_new(&(Wish){.field = "phase"}, (FrameKey){0}, 1, 3, &nothing, &frame, NULL), MNS_E_CORRUPT);
}

static void numbers_of_a_type_that_fields_have_not_are_no_picture(void **state)
{
    (void)state;
    static const char *const good[] = {"<f8", "<u4", "|u1"}, *const bad[] = {"<f4", "<u8", "<i4", "|i1", ">f8", ""};
    MnsArray arrays[] = {{.name = "position", .type = "<f8", .unit = "m", .n_dims = 2, .shape = {3, 2}, .data = places},
                         {.name = "phase", .type = "|u1", .unit = "", .n_dims = 1, .shape = {3}, .data = phases},
                         {.name = "pressure", .type = "<f8", .unit = "Pa", .n_dims = 1, .shape = {3}, .data = places}};
    const MnsReply reply = {.n_arrays = 3, .arrays = arrays};
    const Wish wish = {.field = "pressure"};
    for (size_t k = 0; k < sizeof good / sizeof *good; k++) {
        Frame *frame = NULL;
        arrays[2].type = good[k];
        assert_int_equal(frame_new(&wish, (FrameKey){0}, 1, 3, &reply, &frame, NULL), MNS_OK);
        frame_free(frame);
    }
    arrays[2].type = "<f8";
    for (size_t a = 0; a < 3; a++) {
        const char *was = arrays[a].type;
        for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
            Frame *frame = NULL;
            MnsError error = {0};
            arrays[a].type = bad[k];
            assert_int_equal(frame_new(&wish, (FrameKey){0}, 1, 3, &reply, &frame, &error), MNS_E_CORRUPT);
            assert_string_equal(error.path, arrays[a].name);
        }
        arrays[a].type = was;
    }
}

static void one_in_so_many_that_about_the_limit_is_left(void **state)
{
    (void)state;
    assert_int_equal(frame_every(100, 100), 1);
    assert_int_equal(frame_every(149, 100), 1);
    assert_int_equal(frame_every(150, 100), 2);
    assert_int_equal(frame_every(1200000, 100000), 12);
    assert_int_equal(frame_every(0, 100), 1);
}

static Session watching(const Wish *wish)
{
    Session session;
    session_init(&session, 1);
    session.welcome = session.shows = true;
    session.wish = *wish;
    return session;
}

static void only_the_newest_picture_waits_and_the_others_are_counted(void **state)
{
    (void)state;
    const Wish wish = {.field = "velocity", .limit = 3}, other = {.field = "velocity", .limit = 4};
    Session session = watching(&wish);
    Text *text;
    Frame *frame, *frames[4], *foreign = picture(&other, 9);
    session_offer(&session, foreign);
    assert_false(session_has_next(&session));
    for (uint64_t k = 0; k < 4; k++) session_offer(&session, frames[k] = picture(&wish, k));
    session_next(&session, &text, &frame);
    assert_null(text);
    assert_ptr_equal(frame, frames[3]);
    assert_int_equal(session.skipped, 3);
    assert_int_equal(frame->bytes[FRAME_HEADROOM + 4], 3);
    frame_release(frame);
    /* It has seen this one. */
    session_offer(&session, frames[3]);
    assert_false(session_has_next(&session));
    for (size_t k = 0; k < 4; k++) frame_release(frames[k]);
    frame_release(foreign);
    session_done(&session);
}

static void a_browser_that_does_not_draw_gets_no_more(void **state)
{
    (void)state;
    const Wish wish = {.field = "velocity", .limit = 3};
    Session session = watching(&wish);
    Text *text;
    Frame *frame;
    for (uint64_t k = 0; k < SESSION_AHEAD + 1; k++) {
        Frame *next = picture(&wish, k);
        session_offer(&session, next);
        frame_release(next);
        session_next(&session, &text, &frame);
        assert_int_equal(frame != NULL, k < SESSION_AHEAD);
        if (frame) frame_release(frame);
    }
    assert_false(session_has_room(&session));
    session_drawn(&session, 1);
    session_next(&session, &text, &frame);
    assert_non_null(frame);
    frame_release(frame);
    /* However much it says it has drawn. */
    session_drawn(&session, UINT64_MAX);
    assert_int_equal(session.ahead, 0);
    session_done(&session);
}

static Text *text_of(size_t size, bool lossy)
{
    char *words = malloc(size + 1);
    memset(words, 'x', size);
    words[size] = 0;
    Text *text = text_new(words, lossy);
    free(words);
    text->users = 1;
    return text;
}

static void what_waits_for_a_slow_browser_is_bounded(void **state)
{
    (void)state;
    Session session;
    session_init(&session, 1);
    Text *sample = text_of(1 << 20, true), *news = text_of(1 << 20, false), *got;
    Frame *frame;
    for (int k = 0; k < 10; k++) assert_true(session_send(&session, sample));
    assert_int_equal(session.waiting_bytes, SESSION_LOSSY_BYTES);
    assert_int_equal(session.lost, 6);
    for (int k = 0; k < 12; k++) assert_true(session_send(&session, news));
    assert_int_equal(session.waiting_bytes, SESSION_MOST_BYTES);
    assert_false(session_send(&session, news));
    while (session_has_next(&session)) {
        session_next(&session, &got, &frame);
        text_release(got);
    }
    assert_int_equal(session.waiting_bytes, 0);
    /* When there is room again it is told how many were lost. */
    assert_true(session_send(&session, sample));
    session_next(&session, &got, &frame);
    const char lost[] = "{\"topic\":\"lost\",\"messages\":6}";
    assert_memory_equal(got->bytes + FRAME_HEADROOM, lost, sizeof lost - 1);
    text_release(got);
    text_release(news);
    session_done(&session);
    assert_int_equal(sample->users, 1);
    text_release(sample);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_picture_is_laid_out_as_the_manual_says),
        cmocka_unit_test(an_answer_without_what_was_asked_is_no_picture),
        cmocka_unit_test(numbers_of_a_type_that_fields_have_not_are_no_picture),
        cmocka_unit_test(one_in_so_many_that_about_the_limit_is_left),
        cmocka_unit_test(only_the_newest_picture_waits_and_the_others_are_counted),
        cmocka_unit_test(a_browser_that_does_not_draw_gets_no_more),
        cmocka_unit_test(what_waits_for_a_slow_browser_is_bounded),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
