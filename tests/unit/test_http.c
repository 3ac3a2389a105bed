/* SPDX-License-Identifier: BSD-3-Clause */
/* Where HTTP is served and to whom: addresses, tokens, refusals, and who must go when too many come. */
#include "common/wire/address.h"
#include "http/guests.h"
#include "http/page.h"
#include "tests/support/check.h"
#include <arpa/inet.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* --- addresses --------------------------------------------------------------------------------------------------------- */

static void assert_address(const char *text, const char *where, bool loopback)
{
    Address address;
    char host[INET6_ADDRSTRLEN] = "", whole[64];
    assert_int_equal(address_parse(text, &address, NULL), MNS_OK);
    const struct sockaddr_in *v4 = (const struct sockaddr_in *)&address.where;
    const struct sockaddr_in6 *v6 = (const struct sockaddr_in6 *)&address.where;
    if (address.where.ss_family == AF_INET6) inet_ntop(AF_INET6, &v6->sin6_addr, host, sizeof host);
    else inet_ntop(AF_INET, &v4->sin_addr, host, sizeof host);
    snprintf(whole, sizeof whole, "%s %u", host,
             ntohs(address.where.ss_family == AF_INET6 ? v6->sin6_port : v4->sin_port));
    assert_string_equal(whole, where);
    assert_int_equal(address.loopback, loopback);
}

static void addresses_are_of_this_machine_unless_they_say_otherwise(void **state)
{
    (void)state;
    assert_address("9464", "127.0.0.1 9464", true);
    assert_address("0", "127.0.0.1 0", true);
    assert_address("localhost:80", "127.0.0.1 80", true);
    assert_address("LOCALHOST.:80", "127.0.0.1 80", true);
    assert_address("ip6-localhost:80", "::1 80", true);
    assert_address("127.3.2.1:65535", "127.3.2.1 65535", true);
    assert_address("[::1]:9464", "::1 9464", true);
    assert_address("[::ffff:127.0.0.1]:1", "::ffff:127.0.0.1 1", true);
    assert_address("0.0.0.0:9464", "0.0.0.0 9464", false);
    assert_address("192.168.1.7:9464", "192.168.1.7 9464", false);
    assert_address("[::]:9464", ":: 9464", false);
    assert_address("[2001:db8::7]:9464", "2001:db8::7 9464", false);
    assert_address("[::ffff:10.0.0.1]:1", "::ffff:10.0.0.1 1", false);
}

static void what_is_no_address_is_refused_with_what_is_allowed(void **state)
{
    (void)state;
    static const char *const bad[] = {"",
                                      ":",
                                      ":80",
                                      "x",
                                      "-1",
                                      "65536",
                                      "80 ",
                                      "+80",
                                      "127.0.0.1",
                                      "::1",
                                      "::1:80",
                                      "[::1]",
                                      "[::1]80",
                                      "[]:80",
                                      "[127.0.0.1]:80",
                                      "host:80",
                                      "127.0.0.1:",
                                      "1.2.3:80",
                                      "[::1:80",
                                      "::1]:80",
                                      "99999999999999999999",
                                      "1111111111111111111111111111111111111111111111111111111111111111:80"};
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        Address address = {.size = 77};
        MnsError error;
        assert_int_equal(address_parse(bad[k], &address, &error), MNS_E_INVALID);
        assert_int_equal(address.size, 77);
        assert_non_null(strstr(error.text, "127.0.0.1:9464"));
        assert_string_equal(error.path, "http");
    }
}

static void a_port_that_is_taken_is_not_taken_away(void **state)
{
    (void)state;
    Address address;
    MnsError error;
    int fd, other = -1;
    char where[64];
    assert_int_equal(address_parse("0", &address, NULL), MNS_OK);
    assert_int_equal(address_listen(&address, &fd, NULL), MNS_OK);
    address_of(fd, where);
    assert_int_equal(strncmp(where, "127.0.0.1:", 10), 0);
    assert_true(atoi(where + 10) > 0);
    assert_int_equal(address_parse(where, &address, NULL), MNS_OK);
    assert_int_equal(address_listen(&address, &other, &error), MNS_E_IO);
    assert_int_equal(other, -1);
    assert_non_null(strstr(error.text, "Address already in use"));
    close(fd);
}

/* --- tokens ------------------------------------------------------------------------------------------------------------ */

static const char word[] = "abcdefghij0123456789-._~+/=";

/* A file of this text and mode, as an argument of token_read(). */
static MnsStatus read_of(const char *text, mode_t mode, Token *ret, MnsError *error)
{
    char path[] = "/tmp/mns-token-XXXXXX";
    const int fd = mkstemp(path);
    assert_true(fd >= 0);
    assert_int_equal(write(fd, text, strlen(text)), strlen(text));
    assert_int_equal(fchmod(fd, mode), 0);
    close(fd);
    const MnsStatus status = token_read(path, ret, error);
    unlink(path);
    return status;
}

static void a_token_that_is_made_is_another_each_time(void **state)
{
    (void)state;
    Token one, other, read;
    assert_int_equal(token_make(&one, NULL), MNS_OK);
    assert_int_equal(token_make(&other, NULL), MNS_OK);
    assert_string_not_equal(one.text, other.text);
    assert_int_equal(strspn(one.text, "0123456789abcdef"), 32);
    assert_int_equal(read_of(one.text, 0600, &read, NULL), MNS_OK);
    assert_true(token_is(&one, read.text) && !token_is(&one, other.text));
}

static void a_token_is_one_line_that_only_its_owner_reads(void **state)
{
    (void)state;
    Token token;
    MnsError error;
    char text[TOKEN_LONGEST + 3];
    assert_int_equal(read_of(word, 0600, &token, NULL), MNS_OK);
    assert_string_equal(token.text, word);
    snprintf(text, sizeof text, "%s\n", word);
    assert_int_equal(read_of(text, 0400, &token, NULL), MNS_OK);
    assert_string_equal(token.text, word);
    assert_int_equal(read_of(word, 0640, &token, &error), MNS_E_INVALID);
    assert_non_null(strstr(error.text, "chmod 600"));
    assert_int_equal(read_of(word, 0604, &token, &error), MNS_E_INVALID);
    static const char *const bad[] = {"",
                                      "\n",
                                      "fifteen-letters",
                                      "sixteen letters!",
                                      "0123456789abcdef\n\n",
                                      "0123456789abcdef\n0123456789abcdef\n"};
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        assert_int_equal(read_of(bad[k], 0600, &token, &error), MNS_E_INVALID);
        assert_non_null(strstr(error.text, "openssl rand"));
    }
    memset(text, 'x', sizeof text);
    text[TOKEN_LONGEST] = 0;
    assert_int_equal(read_of(text, 0600, &token, NULL), MNS_OK);
    text[TOKEN_LONGEST] = 'x';
    text[TOKEN_LONGEST + 1] = 0;
    assert_int_equal(read_of(text, 0600, &token, NULL), MNS_E_INVALID);
    assert_int_equal(token_read("/nonexistent/token", &token, &error), MNS_E_IO);
    assert_int_equal(token_read("/tmp", &token, &error), MNS_E_INVALID);
}

static void only_the_whole_token_opens(void **state)
{
    (void)state;
    const Token token = {.text = "0123456789abcdef"}, none = {.text = ""};
    assert_true(token_shown(&token, "Bearer 0123456789abcdef"));
    assert_true(token_shown(&token, "bearer 0123456789abcdef"));
    static const char *const bad[] = {"",
                                      "Bearer",
                                      "Bearer ",
                                      "0123456789abcdef",
                                      "Bearer 0123456789abcde",
                                      "Bearer 0123456789abcdef0",
                                      "Bearer 0123456789abcdeF",
                                      "Basic 0123456789abcdef",
                                      "Bearer  0123456789abcdef"};
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) assert_false(token_shown(&token, bad[k]));
    assert_false(token_shown(&token, NULL));
    assert_true(token_shown(&none, NULL));
}

/* --- refusals ---------------------------------------------------------------------------------------------------------- */

/* The code of a refusal, 0 if there was none; it has one line that says this. */
static unsigned refusal_of(Question question, const char *token, bool liveness, const char *says)
{
    PageGuard guard = {.liveness = liveness};
    Answer answer;
    snprintf(guard.token.text, sizeof guard.token.text, "%s", token);
    if (!page_refuse(&question, &guard, &answer)) return 0;
    assert_non_null(strstr(answer.text, says));
    assert_ptr_equal(strchr(answer.text, '\n'), answer.text + answer.size - 1);
    free(answer.text);
    return answer.code;
}

static unsigned refusal(Question question, const char *token, const char *says)
{
    return refusal_of(question, token, false, says);
}

static void liveness_takes_no_token_from_this_machine_and_elsewhere_by_an_option(void **state)
{
    (void)state;
    static const char token[] = "0123456789abcdef";
    Question question = {.method = "GET", .path = "/healthz"};
    assert_int_equal(refusal_of(question, token, false, "--http-token"), 401);
    assert_int_equal(refusal_of(question, token, true, ""), 0);
    question.host = "machine.example:9464";
    assert_int_equal(refusal_of(question, token, true, ""), 0);
    question.near = true;
    assert_int_equal(refusal_of(question, token, false, "localhost"), 403); /* a page of another site */
    question.host = "localhost:9464";
    assert_int_equal(refusal_of(question, token, false, ""), 0);
    question.path = "/readyz";
    assert_int_equal(refusal_of(question, token, true, "--http-token"), 401);
}

static void readiness_takes_one_parameter(void **state)
{
    (void)state;
    Question question = {.method = "GET", .path = "/readyz", .n_parameters = 1, .run = "loaded"};
    assert_int_equal(refusal(question, "", ""), 0);
    question.run = "there";
    assert_int_equal(refusal(question, "", "run=loaded"), 400);
    question.run = NULL;
    assert_int_equal(refusal(question, "", "run=loaded"), 400);
    question.path = "/metrics"; /* scrapers may add what they like */
    assert_int_equal(refusal(question, "", ""), 0);
}

static void refusals_say_what_to_do(void **state)
{
    (void)state;
    static const char token[] = "0123456789abcdef", shown[] = "Bearer 0123456789abcdef";
    const Question good = {.method = "GET", .path = "/metrics"};
    Question question = good;
    assert_int_equal(refusal(good, "", ""), 0);
    assert_int_equal(refusal((Question){.method = "HEAD", .path = "/readyz"}, "", ""), 0);
    assert_int_equal(refusal((Question){.method = "POST", .path = "/metrics"}, "", "GET or HEAD"), 405);
    assert_int_equal(refusal((Question){.method = "OPTIONS", .path = "*"}, "", "GET or HEAD"), 405);
    assert_int_equal(refusal((Question){.method = "GET", .path = "/"}, "", "/metrics, /healthz and /readyz"), 404);
    assert_int_equal(refusal((Question){.method = "GET", .path = "/metrics/"}, "", "no such page"), 404);
    question.body = true;
    assert_int_equal(refusal(question, "", "leave out the body"), 400);
    assert_int_equal(refusal(good, token, "--http-token"), 401);
    assert_int_equal(refusal((Question){.method = "POST", .path = "/x"}, token, "--http-token"), 401);
    question = good;
    question.authorization = shown;
    assert_int_equal(refusal(question, token, ""), 0);
}

/* A browser says the name by which a page of another site has found us. */
static void a_name_that_somebody_else_can_point_here_is_refused_where_no_token_is_asked_for(void **state)
{
    (void)state;
    static const char *const good[] = {"localhost",     "localhost:9464", "LOCALHOST.:9464",
                                       "ip6-localhost", "127.0.0.1:9464", "[::1]:9464"};
    static const char *const bad[] = {"", "evil.example", "evil.example:9464", "127.0.0.1.evil.example",
                                      "localhost.evil.example"};
    Question question = {.method = "GET", .path = "/metrics"};
    for (size_t k = 0; k < sizeof good / sizeof *good; k++) {
        question.host = good[k];
        assert_int_equal(refusal(question, "", ""), 0);
    }
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        question.host = bad[k];
        assert_int_equal(refusal(question, "", "localhost"), 403);
    }
    question.authorization = "Bearer 0123456789abcdef";
    question.host = "machine.example:9464";
    assert_int_equal(refusal(question, "0123456789abcdef", ""), 0);
}

/* --- guests ------------------------------------------------------------------------------------------------------------ */

/* A socket whose other side tells whether it was shut down. */
static Guest *enter(Guests *guests, int pair[2])
{
    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, pair), 0);
    return guests_enter(guests, pair[0]);
}

static bool was_shown_out(const int pair[2])
{
    char byte;
    return read(pair[1], &byte, 1) == 0;
}

static void who_has_been_there_longest_goes_when_too_many_come(void **state)
{
    (void)state;
    enum { MANY = GUESTS + 3 };
    Guests guests = {.n = 0};
    Guest *who[MANY];
    int pairs[MANY][2];
    for (int k = 0; k < GUESTS; k++) who[k] = enter(&guests, pairs[k]);
    guests_leave(&guests, who[1]); /* by itself: the next one costs nobody the place */
    who[GUESTS] = enter(&guests, pairs[GUESTS]);
    for (int k = 0; k < GUESTS; k++) assert_false(was_shown_out(pairs[k]));
    who[GUESTS + 1] = enter(&guests, pairs[GUESTS + 1]);
    who[GUESTS + 2] = enter(&guests, pairs[GUESTS + 2]);
    assert_true(was_shown_out(pairs[0]));
    assert_true(was_shown_out(pairs[2])); /* the first is gone already, though it has not left */
    for (int k = 3; k < MANY; k++) assert_false(was_shown_out(pairs[k]));
    assert_int_equal(guests.n, GUESTS);
    assert_int_equal(guests.crowded_out, 2);
    for (int k = MANY - 1; k >= 0; k--) {
        if (k != 1) guests_leave(&guests, who[k]);
        close(pairs[k][0]);
        close(pairs[k][1]);
    }
    guests_leave(&guests, NULL);
    assert_int_equal(guests.n, 0);
    assert_null(guests.first);
    assert_null(guests.last);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(addresses_are_of_this_machine_unless_they_say_otherwise),
        cmocka_unit_test(what_is_no_address_is_refused_with_what_is_allowed),
        cmocka_unit_test(a_port_that_is_taken_is_not_taken_away),
        cmocka_unit_test(a_token_that_is_made_is_another_each_time),
        cmocka_unit_test(a_token_is_one_line_that_only_its_owner_reads),
        cmocka_unit_test(only_the_whole_token_opens),
        cmocka_unit_test(liveness_takes_no_token_from_this_machine_and_elsewhere_by_an_option),
        cmocka_unit_test(readiness_takes_one_parameter),
        cmocka_unit_test(refusals_say_what_to_do),
        cmocka_unit_test(a_name_that_somebody_else_can_point_here_is_refused_where_no_token_is_asked_for),
        cmocka_unit_test(who_has_been_there_longest_goes_when_too_many_come),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
