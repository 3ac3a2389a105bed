/* SPDX-License-Identifier: BSD-3-Clause */
/* Commands on their way from the dashboard's gateway. */
#include "client/dashboard/ask.h"
#include "client/dashboard/session.h"
#include "client/dashboard/watcher.h"
#include "tests/support/check.h"
#include "tests/support/memory.h"
#include <string.h>
#include <time.h>

static void nobody_wakes(void *arg)
{
    (void)arg;
}

static void why_a_command_cannot_begin_is_told(void **state)
{
    (void)state;
    static Hub *hub; /* lives as long as the process */
    MnsError error;
    hub = hub_new("nobody");
    if (memory_can_fail) {
        memory_is_gone(true);
        const MnsStatus status = worker_start(hub, 1, &(Ask){.kind = ASK_PAUSE}, &error);
        memory_is_gone(false);
        assert_int_equal(status, MNS_E_MEMORY);
        assert_non_null(strstr(error.text, "no memory"));
    }
    for (int k = 0; k < HUB_COMMANDS; k++) assert_true(hub_begin_command(hub)); /* what failed gave its place back */
    assert_int_equal(worker_start(hub, 1, &(Ask){.kind = ASK_PAUSE}, &error), MNS_E_LIMIT);
    assert_non_null(strstr(error.text, "16 commands are under way"));
}

/* What one browser is answered, when it comes. */
static json_t *answer_of(Hub *hub)
{
    Text *text = NULL;
    uint64_t browser;
    for (int k = 0; k < 2000 && !(text = hub_take_text(hub, &browser)); k++)
        nanosleep(&(struct timespec){.tv_nsec = 10000000}, NULL);
    assert_non_null(text);
    json_t *answer = json_loadb((const char *)text->bytes + FRAME_HEADROOM, text->size, 0, NULL);
    text->users++;
    text_release(text);
    assert_non_null(answer);
    return answer;
}

static void the_journal_of_another_machine_is_not_looked_for_on_this_one(void **state)
{
    (void)state;
    static Hub *hub; /* lives as long as the process */
    hub = hub_new("tcp://192.0.2.7:5555");
    hub_set_wake(hub, nobody_wakes, NULL);
    hub_set_directory(hub, "/tmp"); /* which is here too */
    assert_int_equal(worker_start(hub, 1, &(Ask){.kind = ASK_JOURNAL, .id = 7}, NULL), MNS_OK);
    json_t *answer = answer_of(hub);
    const char *message = json_string_value(json_object_get(json_object_get(answer, "error"), "message"));
    assert_non_null(message);
    assert_non_null(strstr(message, "the machine of the daemon"));
    assert_non_null(strstr(message, "meniscus log /tmp"));
    json_decref(answer);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(why_a_command_cannot_begin_is_told),
        cmocka_unit_test(the_journal_of_another_machine_is_not_looked_for_on_this_one),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
