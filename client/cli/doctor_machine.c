/* SPDX-License-Identifier: BSD-3-Clause */
/* What this machine has: programs, instructions, processors, memory, cases. */
#include "client/cli/beside.h"
#include "client/cli/doctor.h"
#include "client/cli/program.h"
#include "common/case/find.h"
#include "common/host/processors.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* --- programs, and the solver's instructions ------------------------------------------------------------------------------ */

static void check_version(Doctor *doctor, const char *version)
{
    if (strcmp(version, MENISCUS_VERSION) == 0)
        doctor_say(doctor, WELL, "programs", NULL, "meniscus and meniscusd are %s", version);
    else
        doctor_say(doctor, PROBLEM, "programs", "install both from one build, and see `type -a meniscus meniscusd`",
                   "meniscus is " MENISCUS_VERSION ", meniscusd is %s", version);
}

static void check_level(Doctor *doctor, const char *level, const char *arithmetic)
{
    const char *asked = getenv("MENISCUS_LEVEL");
    const bool fused = strcmp(arithmetic, "fused") == 0;
    if (asked && *asked) doctor_say(doctor, WELL, "instructions", NULL, "%s, as MENISCUS_LEVEL says", level);
    else if (fused) doctor_say(doctor, WELL, "instructions", NULL, "%s", level);
    else
        doctor_say(doctor, WARNING, "instructions", "results agree to rounding; for speed take a machine since 2013",
                   "%s only, which cannot fuse a product with a sum: other bits than newer machines", level);
}

/* The daemon's program knows what the solver can do; we do not. */
void doctor_check_programs(Doctor *doctor)
{
    static const char *const arguments[] = {"--machine", "-o", "json", NULL};
    char text[1024];
    MnsError error = {0};
    const MnsStatus status = program_ask("meniscusd", arguments, text, sizeof text, &error);
    json_t *answer = status ? NULL : json_loads(text, 0, NULL);
    const char *version, *level, *arithmetic;
    if (status == MNS_E_NOT_FOUND)
        doctor_say(doctor, PROBLEM, "programs", "install it, or put its directory into $PATH", "%s", error.text);
    else if (!answer ||
             json_unpack(answer, "{ss ss ss}", "version", &version, "level", &level, "arithmetic", &arithmetic))
        doctor_say(doctor, PROBLEM, "programs", "unset MENISCUS_LEVEL, or install both programs from one build",
                   "meniscusd does not say what it computes with%s%s", status ? ": " : "", status ? error.text : "");
    else {
        check_version(doctor, version);
        check_level(doctor, level, arithmetic);
    }
    json_decref(answer);
}

/* --- processors and memory ------------------------------------------------------------------------------------------------ */

void doctor_check_threads(Doctor *doctor)
{
    const Processors all = processors_look("");
    const int ours = all.threads;
    double load[1] = {0};
    char quota[80] = "";
    if (isfinite(all.quota)) snprintf(quota, sizeof quota, "; its control group allows %.3g at a time", all.quota);
    if (getloadavg(load, 1) < 1) load[0] = 0;
    if (load[0] > 1.5 * ours)
        doctor_say(doctor, WARNING, "threads", "runs will be slow until the others are done",
                   "%d of %d processors, and %.0f programs that want them%s", ours, all.there, load[0], quota);
    else doctor_say(doctor, WELL, "threads", NULL, "%d of %d processors may be used%s", ours, all.there, quota);
}

/* A line of /proc/meminfo, in bytes; negative if there is none. */
static double meminfo(const char *name)
{
    char line[128];
    double bytes = -1;
    unsigned long kib;
    FILE *file = fopen("/proc/meminfo", "re");
    while (file && fgets(line, sizeof line, file)) {
        const size_t n = strlen(name);
        if (strncmp(line, name, n) == 0 && line[n] == ':' && (kib = strtoul(line + n + 1, NULL, 10)))
            bytes = 1024.0 * (double)kib;
    }
    if (file) fclose(file);
    return bytes;
}

void doctor_check_memory(Doctor *doctor)
{
    static const double GIB = 1 << 30, little = 0.5;
    const double free_bytes = meminfo("MemAvailable"), all = meminfo("MemTotal");
    if (free_bytes < 0 || all < 0)
        doctor_say(doctor, WARNING, "memory", NULL, "/proc/meminfo does not say how much there is");
    else if (free_bytes < little * GIB)
        doctor_say(doctor, WARNING, "memory", "end what is not needed, or compute with fewer particles",
                   "only %.2f of %.1f GiB are free", free_bytes / GIB, all / GIB);
    else doctor_say(doctor, WELL, "memory", NULL, "%.1f of %.1f GiB are free", free_bytes / GIB, all / GIB);
}

/* --- cases ---------------------------------------------------------------------------------------------------------------- */

typedef struct Folder {
    size_t n;
    char path[4096];
} Folder;

static void count_case(void *arg, const char *name, const char *folder)
{
    Folder *cases = arg;
    (void)name;
    cases->n++;
    snprintf(cases->path, sizeof cases->path, "%s", folder);
}

void doctor_check_cases(Doctor *doctor)
{
    Folder cases = {.n = 0};
    case_list(count_case, &cases);
    if (cases.n) doctor_say(doctor, WELL, "cases", NULL, "%zu came along, in %.900s", cases.n, cases.path);
    else
        doctor_say(doctor, WARNING, "cases", "set MENISCUS_CASES to their folder; your own files need none",
                   "none of those that come along are here");
}

/* --- extras --------------------------------------------------------------------------------------------------------------- */

static bool in_path(const char *program, char *ret, size_t size)
{
    const char *path = getenv("PATH");
    for (size_t n; path && *path; path += n + (path[n] == ':')) {
        n = strcspn(path, ":");
        if (snprintf(ret, size, "%.*s/%s", (int)n, path, program) < (int)size && access(ret, X_OK) == 0) return true;
    }
    return false;
}

/* Whether a program in Python could use our package: `all`, `none` of it, or the module that is missing. */
static void check_python(Doctor *doctor)
{
    static const char *const arguments[] = {
        "-c",
        "import sys\n"
        "sys.path[:] = [place for place in sys.path if place]\n" /* not what lies in the working directory */
        "import importlib.util\n"
        "try:\n"
        "    found = importlib.util.find_spec('meniscus')\n"
        "    found = found and found.origin\n"
        "    if found: import meniscus\n"
        "    print('all' if found else 'none')\n"
        "except ImportError as error: print('module', error.name, 'in', sys.executable)\n",
        NULL};
    char text[256];
    if (program_ask("python3", arguments, text, sizeof text, &(MnsError){.status = MNS_OK}))
        doctor_say(doctor, WELL, "python", NULL, "is not here; only programs of your own need it");
    else if (strcmp(text, "all\n") == 0) doctor_say(doctor, WELL, "python", NULL, "python3 can import meniscus");
    else if (strcmp(text, "none\n") == 0)
        doctor_say(doctor, WELL, "python", NULL,
                   "python3 does not find the package meniscus, which only programs of your own need: PYTHONPATH names "
                   "its folder, build/python after `make`");
    else
        doctor_say(doctor, WARNING, "python",
                   "apt-get install python3-numpy python3-protobuf python3-xxhash python3-yaml python3-zmq",
                   "the package meniscus needs the %.*s, which is not there", (int)strcspn(text, "\n"), text);
}

void doctor_check_extras(Doctor *doctor)
{
    char path[PATH_MAX];
    check_python(doctor);
    if (in_path("paraview", path, sizeof path) || in_path("pvpython", path, sizeof path))
        doctor_say(doctor, WELL, "paraview", NULL, "%.900s, for snapshots", path);
    else
        doctor_say(
            doctor, WELL, "paraview", NULL,
            "is not here; snapshots open with it (apt-get install paraview), `meniscus render` draws them without");
    if (beside_find("meniscus-dashboard", path) || in_path("meniscus-dashboard", path, sizeof path))
        doctor_say(doctor, WELL, "dashboard", NULL, "%.900s, for browsers", path);
    else
        doctor_say(doctor, WELL, "dashboard", NULL,
                   "is not here; `make dashboard` builds it, and only browsers need it");
}
