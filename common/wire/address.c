/* SPDX-License-Identifier: BSD-3-Clause */
/* Where HTTP is served, and which hosts are this machine. */
#include "common/wire/address.h"

#include <arpa/inet.h>
#include <errno.h>
#include <netdb.h>
#include <netinet/in.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

static MnsStatus complain(const char *text, MnsError *error)
{
    return mns_fail_at(error, MNS_E_INVALID, "http",
                       "--http takes a port from 0 (any free one) to 65535, as in 9464, or an address before it, as in "
                       "127.0.0.1:9464 or [::1]:9464; found \"%.80s\"",
                       text);
}

static bool read_port(const char *digits, in_port_t *ret)
{
    char *end;
    const long port = strtol(digits, &end, 10);
    if (*digits < '0' || *digits > '9' || *end || port > 65535) return false;
    *ret = htons((in_port_t)port);
    return true;
}

bool address_is_loopback(const struct sockaddr *where)
{
    if (where->sa_family == AF_INET6) {
        const struct in6_addr *six = &((const struct sockaddr_in6 *)(const void *)where)->sin6_addr;
        return IN6_IS_ADDR_LOOPBACK(six) || (IN6_IS_ADDR_V4MAPPED(six) && six->s6_addr[12] == IN_LOOPBACKNET);
    }
    if (where->sa_family != AF_INET) return false;
    return ntohl(((const struct sockaddr_in *)(const void *)where)->sin_addr.s_addr) >> 24 == IN_LOOPBACKNET;
}

const char *address_of_localhost(const char *name)
{
    static const char *const names[][2] = {{"localhost", "127.0.0.1"},
                                           {"localhost.", "127.0.0.1"}, /* the whole of it, for resolvers */
                                           {"ip6-localhost", "[::1]"},
                                           {"ip6-loopback", "[::1]"}};
    for (size_t k = 0; k < sizeof names / sizeof *names; k++)
        if (!strcasecmp(name, names[k][0])) return names[k][1];
    return NULL;
}

/* Without the brackets. */
static bool read_six(const char *host, struct sockaddr_in6 *ret)
{
    char digits[INET6_ADDRSTRLEN] = "";
    const size_t size = strlen(host);
    *ret = (struct sockaddr_in6){.sin6_family = AF_INET6};
    if (size < 3 || size - 2 >= sizeof digits || host[0] != '[' || host[size - 1] != ']') return false;
    memcpy(digits, host + 1, size - 2);
    return inet_pton(AF_INET6, digits, &ret->sin6_addr) == 1;
}

bool address_of_near_number(const char *host, char ret[static ADDRESS_HOST])
{
    struct sockaddr_in6 six;
    struct sockaddr_in four = {.sin_family = AF_INET};
    char digits[INET_ADDRSTRLEN];
    const bool is_six = read_six(host, &six);
    if (is_six && !address_is_loopback((const struct sockaddr *)&six)) return false;
    if (is_six && IN6_IS_ADDR_LOOPBACK(&six.sin6_addr)) return strcpy(ret, "[::1]");
    if (is_six) memcpy(&four.sin_addr, &six.sin6_addr.s6_addr[12], sizeof four.sin_addr);
    else if (!inet_aton(host, &four.sin_addr) || !address_is_loopback((const struct sockaddr *)&four)) return false;
    if (!inet_ntop(AF_INET, &four.sin_addr, digits, sizeof digits)) return false;
    return strcpy(ret, digits);
}

bool address_is_all(const char *host)
{
    struct sockaddr_in6 six;
    struct in_addr four;
    if (!read_six(host, &six))
        return !strcmp(host, "*") || (inet_aton(host, &four) && four.s_addr == htonl(INADDR_ANY));
    memcpy(&four, &six.sin6_addr.s6_addr[12], sizeof four);
    return IN6_IS_ADDR_UNSPECIFIED(&six.sin6_addr) ||
           (IN6_IS_ADDR_V4MAPPED(&six.sin6_addr) && four.s_addr == htonl(INADDR_ANY));
}

/* Whatever /etc/hosts says of it, --tcp of a daemon is at 127.0.0.1. */
static bool is_own_name(const char *host)
{
    char own[256] = "";
    struct addrinfo *found = NULL, *at;
    const struct addrinfo wanted = {.ai_family = AF_INET, .ai_socktype = SOCK_STREAM};
    if (gethostname(own, sizeof own - 1) || strcasecmp(own, host) || getaddrinfo(own, NULL, &wanted, &found))
        return false;
    for (at = found; at && address_is_loopback(at->ai_addr);) at = at->ai_next;
    freeaddrinfo(found);
    return !at;
}

bool address_of_near(const char *host, char ret[static ADDRESS_HOST])
{
    const char *local = address_of_localhost(host);
    if (local) return strcpy(ret, local);
    return address_of_near_number(host, ret) || (is_own_name(host) && strcpy(ret, "127.0.0.1"));
}

/* host: as written, without the brackets that an address of IPv6 has in a URL. */
static bool read_host(const char *host, bool brackets, in_port_t port, Address *ret)
{
    struct sockaddr_in *v4 = (struct sockaddr_in *)&ret->where;
    struct sockaddr_in6 *v6 = (struct sockaddr_in6 *)&ret->where;
    *ret = (Address){.size = brackets ? sizeof *v6 : sizeof *v4};
    if (brackets) {
        *v6 = (struct sockaddr_in6){.sin6_family = AF_INET6, .sin6_port = port};
        if (inet_pton(AF_INET6, host, &v6->sin6_addr) != 1) return false;
        ret->loopback = address_is_loopback((const struct sockaddr *)v6);
        return true;
    }
    *v4 = (struct sockaddr_in){.sin_family = AF_INET, .sin_port = port};
    if (inet_pton(AF_INET, host, &v4->sin_addr) != 1) return false;
    ret->loopback = address_is_loopback((const struct sockaddr *)v4);
    return true;
}

MnsStatus address_parse(const char *text, Address *ret, MnsError *error)
{
    char host[INET6_ADDRSTRLEN + 2] = "127.0.0.1";
    in_port_t port;
    const char *colon = strrchr(text, ':');
    const size_t size = colon ? (size_t)(colon - text) : 0;
    if (size >= sizeof host || !read_port(colon ? colon + 1 : text, &port)) return complain(text, error);
    if (colon) snprintf(host, sizeof host, "%.*s", (int)size, text);
    const char *local = address_of_localhost(host);
    if (local) strcpy(host, local);
    const size_t n = strlen(host);
    const bool brackets = n > 2 && host[0] == '[' && host[n - 1] == ']';
    if (brackets) host[n - 1] = 0;
    Address address;
    if (!read_host(host + brackets, brackets, port, &address)) return complain(text, error);
    *ret = address;
    return MNS_OK;
}

MnsStatus address_listen(const Address *address, int *ret_fd, MnsError *error)
{
    const int on = 1;
    const struct sockaddr *where = (const struct sockaddr *)&address->where;
    const int fd = socket(where->sa_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    /* Connections of a daemon that has just ended must not keep the next one from the port. */
    const bool good = fd >= 0 && !setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) &&
                      !bind(fd, where, address->size) && !listen(fd, SOMAXCONN);
    if (good) {
        *ret_fd = fd;
        return MNS_OK;
    }
    const int why = errno;
    if (fd >= 0) close(fd);
    return mns_fail_at(error, MNS_E_IO, "http", "cannot listen for HTTP there: %s; choose another port for --http%s",
                       strerror(why), why == EADDRNOTAVAIL ? ", of an address that this machine has" : "");
}

void address_print(const Address *address, int port, char ret[static 64])
{
    const struct sockaddr_in *v4 = (const struct sockaddr_in *)&address->where;
    const struct sockaddr_in6 *v6 = (const struct sockaddr_in6 *)&address->where;
    char host[INET6_ADDRSTRLEN] = "";
    if (address->where.ss_family == AF_INET6) {
        inet_ntop(AF_INET6, &v6->sin6_addr, host, sizeof host);
        snprintf(ret, 64, "[%s]:%d", host, port);
    } else {
        inet_ntop(AF_INET, &v4->sin_addr, host, sizeof host);
        snprintf(ret, 64, "%s:%d", host, port);
    }
}

bool address_is_any(const Address *address)
{
    const struct sockaddr_in *v4 = (const struct sockaddr_in *)&address->where;
    const struct sockaddr_in6 *v6 = (const struct sockaddr_in6 *)&address->where;
    if (address->where.ss_family == AF_INET6) return IN6_IS_ADDR_UNSPECIFIED(&v6->sin6_addr);
    return v4->sin_addr.s_addr == htonl(INADDR_ANY);
}

void address_of(int fd, char ret[static 64])
{
    Address address = {.where.ss_family = AF_UNSPEC};
    socklen_t size = sizeof address.where;
    const struct sockaddr_in *v4 = (const struct sockaddr_in *)&address.where;
    const struct sockaddr_in6 *v6 = (const struct sockaddr_in6 *)&address.where;
    getsockname(fd, (struct sockaddr *)&address.where, &size);
    address_print(&address, ntohs(address.where.ss_family == AF_INET6 ? v6->sin6_port : v4->sin_port), ret);
}
