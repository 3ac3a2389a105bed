/* SPDX-License-Identifier: BSD-3-Clause */
/* Standard output and standard error behind streams that escape what is written. */
#include "common/host/screen.h"
#include "common/host/disk.h"
#include "common/host/text.h"
#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

/* Characters may be cut in two between two writes. */
typedef struct Guarded {
    int fd;
    bool passes;
    int error;                 /* errno of the first write that failed, or 0 */
    char rest[TEXT_CHARACTER]; /* the beginning of one */
    size_t n;
} Guarded;

static Guarded output = {.fd = STDOUT_FILENO}, errors = {.fd = STDERR_FILENO};

static bool write_all(int fd, const char *data, size_t size)
{
    for (size_t done = 0; done < size;) {
        const ssize_t n = write(fd, data + done, size - done);
        if (n < 0 && errno != EINTR) return false;
        done += n > 0 ? (size_t)n : 0;
    }
    return true;
}

enum {
    PIECE = BUFSIZ
}; /* a message is one write wherever it fits, so that those of threads and of processes do not mix */

static bool write_piece(Guarded *to, const char *data, size_t size)
{
    char in[TEXT_CHARACTER + PIECE + 1], out[(TEXT_CHARACTER + PIECE) * TEXT_ESCAPE];
    memcpy(in, to->rest, to->n);
    memcpy(in + to->n, data, size);
    size += to->n;
    in[size] = 0;
    to->n = text_cut(in, size);
    memcpy(to->rest, in + size - to->n, to->n);
    return write_all(to->fd, out, text_escape(in, size - to->n, true, out));
}

static bool write_pieces(Guarded *to, const char *data, size_t size)
{
    if (to->passes) return write_all(to->fd, data, size);
    for (size_t done = 0, n; done < size; done += n) {
        n = size - done < PIECE ? size - done : PIECE;
        if (!write_piece(to, data + done, n)) return false;
    }
    return true;
}

/* Called by the stream, which says 0 for an error. */
static ssize_t write_guarded(void *guarded, const char *data, size_t size)
{
    Guarded *to = guarded;
    if (write_pieces(to, data, size)) return (ssize_t)size;
    if (!to->error) to->error = errno;
    return 0;
}

static int close_guarded(void *guarded)
{
    return close(((Guarded *)guarded)->fd);
}

static FILE *guard(Guarded *guarded, FILE *before, int buffer)
{
    FILE *stream = fopencookie(guarded, "w", (cookie_io_functions_t){.write = write_guarded, .close = close_guarded});
    if (!stream) return before;
    setvbuf(stream, NULL, buffer, BUFSIZ);
    return stream;
}

void screen_guard(void)
{
    stdout = guard(&output, stdout, isatty(STDOUT_FILENO) ? _IOLBF : _IOFBF);
    stderr = guard(&errors, stderr, _IONBF);
}

void screen_pass(void)
{
    fflush(stdout);
    output.passes = true;
}

MnsStatus screen_fail(int number, MnsError *error)
{
    return mns_fail(error, disk_status(number), "cannot write to standard output: %s; %s", strerror(number),
                    mns_refusal_hint(number));
}

MnsStatus screen_flush(MnsError *error)
{
    if (!fflush(stdout) && !ferror(stdout)) return MNS_OK;
    return screen_fail(output.error ? output.error : errno, error);
}

/* Some file systems tell of a full disk when the file is closed. */
int screen_end(void)
{
    const bool failed = ferror(stdout);
    if (!fclose(stdout) && !failed) return 0;
    return output.error ? output.error : errno;
}
