/* SPDX-License-Identifier: BSD-3-Clause */
#include "tests/support/flood.h"

#include "base/clock.h"
#include <arpa/inet.h>
#include <stdint.h>
#include <sys/socket.h>
#include <unistd.h>

enum { OPEN = 2000, BREATH_US = 1000 };

static int begin(const struct sockaddr_in *to)
{
    static const uint8_t greeting[64] = "\xff\0\0\0\0\0\0\0\1\x7f\3\0CURVE";
    const int fd = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    (void)connect(fd, (const struct sockaddr *)to, sizeof *to);
    send(fd, greeting, sizeof greeting, MSG_NOSIGNAL);
    return fd;
}

unsigned long flood_handshakes(int port, double rate, double seconds)
{
    static int fds[OPEN];
    const struct sockaddr_in to = {
        .sin_family = AF_INET, .sin_port = htons((uint16_t)port), .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    const double began = clock_now();
    unsigned long n = 0;
    for (; clock_now() < began + seconds; n++) {
        if (n >= OPEN) close(fds[n % OPEN]);
        fds[n % OPEN] = begin(&to);
        while ((double)n > rate * (clock_now() - began)) usleep(BREATH_US);
    }
    for (unsigned long k = 0; k < n && k < OPEN; k++) close(fds[k]);
    return n;
}
