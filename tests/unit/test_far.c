/* SPDX-License-Identifier: BSD-3-Clause */
/* Addresses for those from afar: numbers of either kind, all of them, and one that somebody else has. */
#include "net/far.h"
#include "tests/support/check.h"
#include <arpa/inet.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

/* A port that nobody has at this moment. */
static int free_port(void)
{
    struct sockaddr_in address = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    socklen_t size = sizeof address;
    const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_int_equal(bind(fd, (struct sockaddr *)&address, size), 0);
    assert_int_equal(getsockname(fd, (struct sockaddr *)&address, &size), 0);
    close(fd);
    return ntohs(address.sin_port);
}

static void assert_reached(const char *host, const char *at)
{
    struct sockaddr_in four = {.sin_family = AF_INET};
    struct sockaddr_in6 six = {.sin6_family = AF_INET6};
    char address[64];
    MnsError error;
    const int port = free_port();
    int listening;
    const bool is_six = strchr(at, ':') != NULL;
    four.sin_port = six.sin6_port = htons((uint16_t)port);
    assert_int_equal(
        inet_pton(is_six ? AF_INET6 : AF_INET, at, is_six ? (void *)&six.sin6_addr : (void *)&four.sin_addr), 1);
    snprintf(address, sizeof address, "tcp://%s:%d", host, port);
    if (far_listen(address, &listening, &error)) fail_msg("%s", error.text);
    assert_true(fcntl(listening, F_GETFD) & FD_CLOEXEC);
    const int guest = socket(is_six ? AF_INET6 : AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_int_equal(is_six ? connect(guest, (struct sockaddr *)&six, sizeof six)
                            : connect(guest, (struct sockaddr *)&four, sizeof four),
                     0);
    close(guest);
    close(listening);
}

static void an_address_is_a_number_of_either_kind_or_all(void **state)
{
    (void)state;
    assert_reached("127.0.0.1", "127.0.0.1");
    assert_reached("127.0.0.3", "127.0.0.3");
    assert_reached("*", "127.0.0.2");
    const int six = socket(AF_INET6, SOCK_STREAM | SOCK_CLOEXEC, 0);
    struct sockaddr_in6 here = {.sin6_family = AF_INET6, .sin6_addr = IN6ADDR_LOOPBACK_INIT};
    if (six >= 0 && !bind(six, (struct sockaddr *)&here, sizeof here)) {
        assert_reached("[::1]", "::1");
        assert_reached("[::]", "127.0.0.1");
    }
    if (six >= 0) close(six);
}

static void one_that_somebody_has_is_told(void **state)
{
    (void)state;
    MnsError error;
    char address[64];
    int first, second = -7;
    snprintf(address, sizeof address, "tcp://127.0.0.1:%d", free_port());
    assert_int_equal(far_listen(address, &first, &error), MNS_OK);
    assert_int_equal(far_listen(address, &second, &error), MNS_E_IO);
    assert_non_null(strstr(error.text, "Address already in use"));
    assert_non_null(strstr(error.text, address));
    assert_int_equal(second, -7);
    close(first);
}

static void one_of_another_machine_is_told(void **state)
{
    (void)state;
    MnsError error;
    int fd;
    assert_int_equal(far_listen("tcp://192.0.2.7:5555", &fd, &error), MNS_E_IO);
    assert_non_null(strstr(error.text, "192.0.2.7"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_address_is_a_number_of_either_kind_or_all),
        cmocka_unit_test(one_that_somebody_has_is_told),
        cmocka_unit_test(one_of_another_machine_is_told),
    };
    return cmocka_run_group_tests_name("far", tests, NULL, NULL);
}
