/* SPDX-License-Identifier: BSD-3-Clause */
/* The daemon over HTTP, seen from outside, byte by byte: what it tells agrees with the status, in every state, and clients that say
 * nothing, too little, too much or never read are in nobody's way. tests/system/test_http.py asks as Prometheus does. */
#include "tests/support/check.h"
#include "tests/support/steer.h"
#include <arpa/inet.h>
#include <netinet/in.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

enum { ANSWER_MAX = 1 << 17, CROWD = 300 };

static in_port_t port; /* of the daemon of this test, in network order */

static int connect_http(void)
{
    const struct sockaddr_in where = {
        .sin_family = AF_INET, .sin_port = port, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    const struct timeval patience = {.tv_sec = 60};
    const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_true(fd >= 0);
    assert_int_equal(setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience), 0);
    assert_int_equal(connect(fd, (const struct sockaddr *)&where, sizeof where), 0);
    return fd;
}

static void say(int fd, const char *text)
{
    assert_int_equal(send(fd, text, strlen(text), MSG_NOSIGNAL), strlen(text));
}

/* All that comes until the other side hangs up; freed with free(). */
static char *hear(int fd)
{
    char *text = calloc(1, ANSWER_MAX);
    size_t size = 0;
    for (ssize_t n; (n = recv(fd, text + size, ANSWER_MAX - 1 - size, 0)) != 0; size += (size_t)n)
        if (n < 0) fail_msg("no answer, or no end of it, within 20 s: %.200s", text);
    close(fd);
    return text;
}

static char *get(const char *path)
{
    char request[256];
    const int fd = connect_http();
    snprintf(request, sizeof request, "GET %s HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n", path);
    say(fd, request);
    return hear(fd);
}

static int code_of(const char *answer)
{
    int code = 0;
    assert_int_equal(sscanf(answer, "HTTP/1.1 %d", &code), 1);
    return code;
}

/* The answer to these words has this code, and this in it. */
static void answers(const char *words, int code, const char *part)
{
    const int fd = connect_http();
    say(fd, words);
    char *answer = hear(fd);
    assert_int_equal(code_of(answer), code);
    if (!strstr(answer, part)) fail_msg("no \"%s\" in: %s", part, answer);
    free(answer);
}

static void shows(const char *path, int code, const char *part)
{
    char *answer = get(path);
    assert_int_equal(code_of(answer), code);
    if (!strstr(answer, part)) fail_msg("no \"%s\" in: %s", part, answer);
    free(answer);
}

/* The value of a metric, as in "meniscus_run_step"; NAN if it is not there. */
static double metric(const char *name)
{
    char line[128], *answer = get("/metrics");
    assert_int_equal(code_of(answer), 200);
    snprintf(line, sizeof line, "\n%s ", name);
    const char *at = strstr(answer, line);
    const double value = at ? strtod(at + strlen(line), NULL) : NAN;
    free(answer);
    return value;
}

/* --- a daemon for each test --------------------------------------------------------------------------------------------- */

static in_port_t free_port(void)
{
    struct sockaddr_in where = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    socklen_t size = sizeof where;
    const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_int_equal(bind(fd, (const struct sockaddr *)&where, sizeof where), 0);
    assert_int_equal(getsockname(fd, (struct sockaddr *)&where, &size), 0);
    close(fd);
    return where.sin_port;
}

static int begin(void **state)
{
    char text[16];
    port = free_port();
    snprintf(text, sizeof text, "%u", (unsigned)ntohs(port));
    Dialogue *dialogue = calloc(1, sizeof *dialogue);
    dialogue_begin(dialogue, (const char *const[]){"--http", text, NULL});
    *state = dialogue;
    return 0;
}

/* --- tests ------------------------------------------------------------------------------------------------------------- */

static void numbers_agree_with_the_status(void **state)
{
    Dialogue *dialogue = *state;
    shows("/healthz", 200, "\"status\":\"ok\"");
    shows("/readyz", 200, "\"state\":\"EMPTY\"");
    shows("/readyz?run=loaded", 503, "meniscus load CASE");
    assert_true(isnan(metric("meniscus_run_step")));
    dialogue_load(dialogue, NULL);
    shows("/readyz?run=loaded", 200, "\"state\":\"READY\"");
    steer_go(dialogue, 7);
    Meniscus__Reply *reply = steer_status(dialogue);
    const Meniscus__Status *status = reply->status;
    assert_close(metric("meniscus_run_step"), 7, 0);
    assert_close(metric("meniscus_steps_total"), 7, 0);
    assert_close(metric("meniscus_run_time_seconds"), status->time, 0);
    assert_close(metric("meniscus_run_time_step_seconds"), status->time_step, 0);
    assert_close(metric("meniscus_run_end_time_seconds"), status->end_time, 0);
    assert_close(metric("meniscus_solver_memory_bytes"), (double)status->memory_bytes, 0);
    assert_close(metric("meniscus_control_clients"), 1, 0);
    assert_close(metric("meniscus_particles{kind=\"fluid\",phase=\"water\"}") +
                     metric("meniscus_particles{kind=\"fluid\",phase=\"air\"}"),
                 (double)status->fluid_particles, 0);
    assert_close(metric("meniscus_particles{kind=\"wall\",phase=\"tank\"}"),
                 (double)(status->particles - status->fluid_particles), 0);
    for (size_t k = 0; k < status->n_timers; k++) {
        char name[128];
        snprintf(name, sizeof name, "meniscus_solver_pass_seconds_total{pass=\"%s\"}", status->timers[k]->name);
        assert_close(metric(name), status->timers[k]->seconds, 0);
    }
    meniscus__reply__free_unpacked(reply, NULL);
    assert_int_equal(steer_code(dialogue, dialogue_checkpoint()), MENISCUS__CODE__OK);
    assert_close(metric("meniscus_output_files_total{kind=\"checkpoint\"}"), 1, 0);
    assert_int_equal(steer_code(dialogue, dialogue_stop()), MENISCUS__CODE__OK);
    shows("/readyz?run=loaded", 503, "\"state\":\"EMPTY\"");
    assert_true(isnan(metric("meniscus_run_step")));
    assert_close(metric("meniscus_steps_total"), 7, 0);
}

static void a_run_is_watched_while_it_moves_and_its_case_changes(void **state)
{
    Dialogue *dialogue = *state;
    double steps = 0;
    for (int k = 0; k < 5; k++) {
        dialogue_load(dialogue, NULL);
        assert_int_equal(steer_code(dialogue, dialogue_start()), MENISCUS__CODE__OK);
        for (int m = 0; m < 20; m++) {
            const double now = metric("meniscus_steps_total");
            assert_true(now >= steps);
            steps = now;
        }
        assert_int_equal(steer_code(dialogue, dialogue_pause()), MENISCUS__CODE__OK);
    }
    assert_true(steps > 0);
}

static void a_fault_is_counted_and_its_reason_told(void **state)
{
    static const char *const settings[] = {"limits.density_max=1.0001", "gravity=[0, -100]", NULL};
    Dialogue *dialogue = *state;
    dialogue_load(dialogue, settings);
    assert_close(metric("meniscus_faults_total{reason=\"diverged\"}"), 0, 0);
    assert_int_equal(steer_code(dialogue, dialogue_start()), MENISCUS__CODE__OK);
    steer_wait_for(dialogue, MENISCUS__STATE__FAULT);
    assert_close(metric("meniscus_faults_total{reason=\"diverged\"}"), 1, 0);
    assert_close(metric("meniscus_run_state{state=\"FAULT\"}"), 1, 0);
    shows("/readyz", 200, "\"fault_reason\":\"diverged\"");
    shows("/readyz?run=loaded", 503, "\"fault_reason\":\"diverged\"");
    shows("/healthz", 200, "ok");
}

static void a_state_directory_that_is_gone_is_told(void **state)
{
    Dialogue *dialogue = *state;
    char here[256], away[256];
    dialogue_load(dialogue, NULL);
    shows("/readyz", 200, "\"ready\":true");
    snprintf(here, sizeof here, "%s/state", dialogue->home);
    snprintf(away, sizeof away, "%s/gone", dialogue->home);
    assert_int_equal(rename(here, away), 0);
    shows("/readyz", 503, "No such file or directory");
    assert_int_equal(rename(away, here), 0);
    shows("/readyz", 200, "\"ready\":true");
}

static void what_is_no_question_is_refused_in_a_line(void **state)
{
    (void)state;
    char words[12000];
    answers("GET / HTTP/1.0\r\n\r\n", 404, "there are /metrics, /healthz and /readyz");
    answers("DELETE /metrics HTTP/1.0\r\n\r\n", 405, "Allow: GET, HEAD");
    answers("POST /metrics HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1000000000\r\n\r\n", 405, "GET or HEAD");
    answers("GET /metrics HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n", 400,
            "leave out the body");
    answers("HEAD /metrics HTTP/1.0\r\n\r\n", 200, "Content-Type: text/plain; version=0.0.4");
    answers("GET /metrics HTTP/1.0\r\nAccept: application/openmetrics-text\r\n\r\n", 200, "# EOF\n");
    snprintf(words, sizeof words, "GET /metrics HTTP/1.1\r\nHost: localhost\r\nX: %09999d\r\n\r\n", 0);
    const int fd = connect_http();
    send(fd, words, strlen(words), MSG_NOSIGNAL); /* it may hang up before the end */
    char answer[64] = "";
    if (recv(fd, answer, sizeof answer - 1, 0) > 0) assert_int_equal(code_of(answer), 431);
    close(fd);
    shows("/healthz", 200, "ok");
}

static void a_connection_can_be_used_again(void **state)
{
    (void)state;
    const int fd = connect_http();
    char answer[4096];
    for (int k = 0; k < 3; k++) {
        say(fd, "GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n");
        const ssize_t n = recv(fd, answer, sizeof answer - 1, 0);
        assert_true(n > 0);
        answer[n] = 0;
        assert_int_equal(code_of(answer), 200);
    }
    close(fd);
}

/* Those who say nothing or half a request, and those who never read. None of them keeps whoever comes after, or the desk, waiting. */
static void a_crowd_is_in_nobodys_way(void **state)
{
    Dialogue *dialogue = *state;
    int fds[CROWD];
    dialogue_load(dialogue, NULL);
    assert_int_equal(steer_code(dialogue, dialogue_start()), MENISCUS__CODE__OK);
    for (int k = 0; k < CROWD; k++) {
        fds[k] = connect_http();
        if (k % 3 == 1) send(fds[k], "GET /metr", 9, MSG_NOSIGNAL);
        for (int m = 0; k % 3 == 2 && m < 20; m++)
            send(fds[k], "GET /metrics HTTP/1.1\r\nHost: localhost\r\n\r\n", 43, MSG_NOSIGNAL | MSG_DONTWAIT);
    }
    const double steps = metric("meniscus_steps_total");
    steer_step_now(dialogue);
    /* Connections were dropped for newer ones, not after the idle limit. There is no bound on the time: the HTTP thread has the lowest priority. */
    assert_true(metric("meniscus_http_crowded_out_total") > 0);
    assert_true(metric("meniscus_http_connections") <= 64);
    for (int k = 0; k < CROWD; k++) close(fds[k]);
    meniscus__reply__free_unpacked(steer_wait_step(dialogue, (uint64_t)steps + 5), NULL);
    assert_int_equal(steer_code(dialogue, dialogue_pause()), MENISCUS__CODE__OK);
}

static void who_says_nothing_is_shown_out_in_time(void **state)
{
    (void)state;
    char byte;
    const int fd = connect_http();
    const double before = steer_now();
    say(fd, "GET /metrics HTTP/1.1\r\n");
    const ssize_t n = recv(fd, &byte, 1, 0); /* -1: it was left connected for longer than anybody waits here */
    assert_true(n == 0 || (n == 1 && byte == 'H'));
    assert_true(steer_now() - before > 5);
    close(fd);
}

#define HTTP_TEST(name) cmocka_unit_test_setup_teardown(name, begin, steer_end)

int main(void)
{
    const struct CMUnitTest tests[] = {
        HTTP_TEST(numbers_agree_with_the_status),
        HTTP_TEST(a_run_is_watched_while_it_moves_and_its_case_changes),
        cmocka_unit_test_setup_teardown(a_fault_is_counted_and_its_reason_told, begin, steer_end_somehow),
        HTTP_TEST(a_state_directory_that_is_gone_is_told),
        HTTP_TEST(what_is_no_question_is_refused_in_a_line),
        HTTP_TEST(a_connection_can_be_used_again),
        HTTP_TEST(a_crowd_is_in_nobodys_way),
        HTTP_TEST(who_says_nothing_is_shown_out_in_time),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
