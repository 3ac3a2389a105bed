/* SPDX-License-Identifier: BSD-3-Clause */
/* meniscus init: a case file to begin with. It is never written over another file. */
#include "client/cli/command.h"
#include "client/cli/output.h"
#include "common/case/file.h"
#include "common/case/find.h"
#include "common/case/name.h"
#include "common/host/disk.h"
#include "common/host/screen.h"
#include <errno.h>
#include <meniscus/exit.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* A case for whoever has none: small, whole, of two fluids, with a word about each entry. */
static const char beginning[] =
    "# A column of water falls under air and strikes the far wall. Change what you like: a mistake is answered with "
    "line\n"
    "# and column. All quantities are in SI units; formulas of x, y and t may stand for numbers. Every entry, with its "
    "unit,\n"
    "# bounds and default, is in case-reference.md, which `man meniscus-case` shows too.\n"
    "#\n"
    "# 3,200 particles of fluids, less than a minute.\n"
    "title: A column of water falls under air\n"
    "\n"
    "dimensions: 2\n"
    "reference_length: 0.3            # depth of the water [m]\n"
    "resolution: 20                   # particles per reference_length: the number to change first\n"
    "domain: {min: [0, 0], max: [1.2, 0.6]}\n"
    "gravity: [0, -9.81]\n"
    "\n"
    "constants:                       # names for numbers, to be used in formulas\n"
    "  - {name: depth, value: 0.3}\n"
    "\n"
    "fluids:\n"
    "  - name: water\n"
    "    density: 1000\n"
    "    viscosity: 0.001\n"
    "    sound_speed: 35              # ten times the greatest speed, 2 sqrt(g depth)\n"
    "    shape:                       # boxes, balls, cylinders, plates and formulas, added up from first to last\n"
    "      - formula: x < 2*depth and y < depth\n"
    "  - name: air                    # without a shape: whatever is left\n"
    "    density: 1.2\n"
    "    viscosity: 1.8e-5\n"
    "    sound_speed: 35\n"
    "\n"
    "# What acts where two fluids meet: the schemes interfacial and incompressible have surface tension.\n"
    "# interfaces:\n"
    "#   - {between: [water, air], tension: 0.072}\n"
    "\n"
    "walls:\n"
    "  - name: tank\n"
    "    shape:\n"
    "      - outside: true            # the wall is what is outside of the box\n"
    "        box: {min: [0, 0], max: [1.2, 0.6]}\n"
    "\n"
    "scheme:\n"
    "  riemann: {}                    # `meniscus schemes` prints all of them, with their equations\n"
    "\n"
    "end_time: 1                      # [s]\n"
    "\n"
    "probes:                          # time series in probes.hdf, and what `meniscus query` and `watch` show\n"
    "  - {name: front, front: {fluid: water, axis: x}}\n"
    "  - {name: impact, pressure: {at: [1.2, 0.05]}}\n"
    "  - {name: energy, kinetic_energy: {}}\n"
    "\n"
    "output:\n"
    "  probe_interval: 0.01           # [s]\n"
    "  snapshot_interval: 0.1         # [s]; ParaView opens them, `meniscus render` draws them\n"
    "  fields: [velocity, pressure]\n";

/* The text of a file that the reader of cases has taken, so that it is a file and no larger than cases may be. */
static MnsStatus read_text(const char *path, char **ret, size_t *ret_size, MnsError *error)
{
    char *text = NULL;
    size_t size = 0;
    FILE *file = disk_open(path, "r");
    if (!file)
        return mns_fail(error, MNS_E_IO, "cannot read %s: %s; %s", path, strerror(errno), mns_refusal_hint(errno));
    FILE *memory = open_memstream(&text, &size);
    for (int c; memory && (c = getc(file)) != EOF;) putc(c, memory);
    const bool unread = ferror(file);
    bool full = !memory || ferror(memory);
    if (memory && fclose(memory)) full = true;
    fclose(file);
    if (!unread && !full) {
        *ret = text;
        *ret_size = size;
        return MNS_OK;
    }
    free(text);
    if (full) return mns_fail(error, MNS_E_MEMORY, "no memory for the text of %s", path);
    return mns_fail(error, MNS_E_IO, "cannot read %s to its end", path);
}

/* A case that others have made, comments and all; it must be one. */
static MnsStatus copy_case(Invocation *in, const char *name, char path[static 4096], char **ret, size_t *ret_size,
                           MnsError *error)
{
    CaseFile *file = NULL;
    MnsStatus status = case_find(name, path, error);
    if (!status) status = case_file_read(path, &file, error);
    case_file_free(file);
    if (status) in->code = command_exit_code(status, true);
    return status ? status : read_text(path, ret, ret_size, error);
}

static MnsStatus write_new(const char *path, const char *text, size_t size, MnsError *error)
{
    FILE *file = fopen(path, "wxe"); /* x: not if there is one */
    if (!file && errno == EEXIST)
        return mns_fail(error, MNS_E_IO, "%.300s is there already, and stays as it is: meniscus init OTHER.yaml", path);
    if (!file)
        return mns_fail(error, MNS_E_IO, "cannot write %.300s: %s; %s", path, strerror(errno), mns_refusal_hint(errno));
    const bool written = fwrite(text, 1, size, file) == size;
    if (!fclose(file) && written) return MNS_OK;
    const int cause = errno;
    unlink(path);
    return mns_fail(error, disk_status(cause), "cannot write %.300s: %s; %s", path, strerror(cause),
                    mns_refusal_hint(cause));
}

static MnsStatus tell(const Invocation *in, const char *path, const char *from, MnsError *error)
{
    char run[4200], load[4200];
    snprintf(run, sizeof run, "meniscus run %s", path);
    snprintf(load, sizeof load, "meniscus load %s --start", path);
    if (in->json)
        return output_json(json_pack("{so so s[oo]}", "file", output_text(path), "from", output_text(from), "next",
                                     output_text(run), output_text(load)),
                           error);
    printf("%s is written. Change what you like in it, then run it to its end\n    %s\nor in a daemon, which "
           "`meniscusd &` "
           "starts\n    %s\n",
           path, run, load);
    return MNS_OK;
}

MnsStatus command_init(Invocation *in, MnsError *error)
{
    const char *from = options_get(&in->options, OPT_FROM);
    const char *given = in->options.n_words ? in->options.words[0] : NULL;
    char source[4096], name[CASE_NAME_SIZE] = "case", path[4096];
    char *copy = NULL;
    size_t size = strlen(beginning);
    MnsStatus status = MNS_OK;
    if (given && (!*given || strlen(given) >= sizeof path))
        return command_usage(in,
                             mns_fail(error, MNS_E_INVALID, "init needs the name of a file; found \"%.40s\"", given));
    if (in->json && given && !strcmp(given, "-"))
        return command_usage(in, mns_fail_at(error, MNS_E_INVALID, "--output",
                                             "with -o json a file must be given: standard output is for the object"));
    if (from) status = copy_case(in, from, source, &copy, &size, error);
    if (status) return status;
    if (from) case_name_from_path(source, name);
    if (given) snprintf(path, sizeof path, "%s", given);
    else snprintf(path, sizeof path, "%s.yaml", name);
    if (!strcmp(path, "-")) {
        const char *text = copy ? copy : beginning;
        screen_pass();
        fwrite(text, 1, size, stdout);
        free(copy);
        return screen_flush(error);
    }
    status = write_new(path, copy ? copy : beginning, size, error);
    free(copy);
    return status ? status : tell(in, path, from ? source : NULL, error);
}
