/* SPDX-License-Identifier: BSD-3-Clause */
/* What the tests of output files share: scratch directories, captures full of noise, disks that are full. */
#include "tests/support/io_fixture.h"
#include "tests/support/draw.h"

#include <dirent.h>
#include <fcntl.h>
#include <ftw.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

/* A test cannot go on without its fixture. */
static void *need(void *made, const char *what)
{
    if (made) return made;
    perror(what);
    exit(1);
}

char *scratch_new(void)
{
    char *dir = need(strdup("/tmp/meniscus-test-XXXXXX"), "strdup");
    return need(mkdtemp(dir), "mkdtemp");
}

static int remove_one(const char *path, const struct stat *about, int kind, struct FTW *walk)
{
    (void)about, (void)kind, (void)walk;
    return remove(path);
}

void scratch_free(char *dir)
{
    nftw(dir, remove_one, 16, FTW_DEPTH | FTW_PHYS | FTW_MOUNT);
    free(dir);
}

int scratch_begin(void **state)
{
    *state = scratch_new();
    return 0;
}

int scratch_end(void **state)
{
    limit_files(SIZE_MAX);
    scratch_free(*state);
    return 0;
}

char *path_in(const char *dir, const char *name)
{
    char *path = need(malloc(4096), "malloc");
    snprintf(path, 4096, "%s/%s", dir, name);
    return path;
}

static size_t size_of(MnsType type)
{
    return type == MNS_F64 ? 8 : type == MNS_U32 ? 4 : 1;
}

MnsCapture *noise_capture(int dim, size_t n, size_t n_fluid, uint64_t seed)
{
    uint64_t all = 0;
    for (int k = 0; mns_fields()[k].name; k++) all |= UINT64_C(1) << k;
    MnsCapture *c = need(mns_capture_new(dim, n, n_fluid, all), "mns_capture_new");
    for (int k = 0; mns_fields()[k].name; k++)
        for (int d = 0; d < 3 && c->data[k][d]; d++)
            for (size_t i = 0; i < n; i++) {
                const size_t size = size_of(mns_fields()[k].type);
                const double odd[] = {-0.0, NAN, 5e-324};
                const uint64_t bits = draw(&seed);
                memcpy((char *)c->data[k][d] + i * size, i < 3 && size == 8 ? (const void *)&odd[i] : &bits, size);
            }
    c->spacing = 0.0125;
    c->progress =
        (MnsProgress){.t = 0.1 + 0.2, .dt = 1e-5 / 3, .dt_first = 2e-5 / 3, .step = 4711, .rebuilds = 99, .guarded = 3};
    return c;
}

bool same_values(const MnsCapture *a, const MnsCapture *b, uint64_t fields)
{
    if (a->dim != b->dim || a->n != b->n || a->n_fluid != b->n_fluid) return false;
    for (int k = 0; mns_fields()[k].name; k++) {
        if (!(fields >> k & 1)) continue;
        const int width = mns_fields()[k].components > 1 ? a->dim : 1;
        for (int d = 0; d < width; d++)
            if (!b->data[k][d] || memcmp(a->data[k][d], b->data[k][d], a->n * size_of(mns_fields()[k].type)) != 0)
                return false;
    }
    return memcmp(&a->spacing, &b->spacing, sizeof a->spacing) == 0;
}

bool same_progress(const MnsProgress *a, const MnsProgress *b)
{
    return memcmp(&a->t, &b->t, sizeof a->t) == 0 && memcmp(&a->dt, &b->dt, sizeof a->dt) == 0 &&
           memcmp(&a->dt_first, &b->dt_first, sizeof a->dt_first) == 0 && a->step == b->step &&
           a->rebuilds == b->rebuilds && a->guarded == b->guarded;
}

FileMeta noise_meta(void)
{
    static MnsFluid fluids[] = {{.name = "water"}, {.name = "air"}};
    static MnsWall walls[] = {{.name = "tank"}};
    static MnsProbe probe_list[] = {{.name = "P1", .kind = MNS_PROBE_PRESSURE},
                                    {.name = "front", .kind = MNS_PROBE_FRONT}};
    static const MnsCase run = {.title = "Noise",
                                .dim = 2,
                                .n_fluids = 2,
                                .fluids = fluids,
                                .n_walls = 1,
                                .walls = walls,
                                .scheme = {.name = "riemann"},
                                .n_probes = 2,
                                .probes = probe_list,
                                .output = {.walls = true}};
    return (FileMeta){.c = &run, .case_name = "noise", .case_text = "title: Noise\n"};
}

unsigned char *bytes_of(const char *path, size_t *ret_size)
{
    FILE *stream = need(fopen(path, "rb"), path);
    fseek(stream, 0, SEEK_END);
    *ret_size = (size_t)ftell(stream);
    rewind(stream);
    unsigned char *bytes = need(malloc(*ret_size + 1), "malloc");
    if (fread(bytes, 1, *ret_size, stream) != *ret_size) need(NULL, path);
    fclose(stream);
    return bytes;
}

/* A new file each time: some file systems wait for the disk when a file is cut to nothing and written again. */
void put_bytes(const char *path, const void *bytes, size_t size)
{
    remove(path);
    FILE *stream = need(fopen(path, "wb"), path);
    if (fwrite(bytes, 1, size, stream) != size || fclose(stream) != 0) need(NULL, path);
}

void put_date(const char *path, time_t second)
{
    const struct timespec moment = {.tv_sec = second};
    if (utimensat(AT_FDCWD, path, (const struct timespec[]){moment, moment}, 0)) need(NULL, path);
}

void put_file(const char *root, const char *name, const char *text)
{
    char *path = path_in(root, name);
    for (char *slash = path + strlen(root) + 1; (slash = strchr(slash, '/')); *slash++ = '/') {
        *slash = 0;
        mkdir(path, 0777);
    }
    put_bytes(path, text, strlen(text));
    free(path);
}

bool exists(const char *path)
{
    return access(path, F_OK) == 0;
}

void limit_files(size_t bytes)
{
    struct rlimit limit;
    signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &limit);
    limit.rlim_cur = bytes < limit.rlim_max ? bytes : limit.rlim_max;
    setrlimit(RLIMIT_FSIZE, &limit);
}

bool holds(const char *dir, const char *end)
{
    DIR *stream = need(opendir(dir), dir);
    bool found = false;
    for (const struct dirent *e; !found && (e = readdir(stream));) {
        const size_t length = strlen(e->d_name), wanted = strlen(end);
        found = length >= wanted && strcmp(e->d_name + length - wanted, end) == 0;
    }
    closedir(stream);
    return found;
}
