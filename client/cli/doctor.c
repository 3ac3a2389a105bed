/* SPDX-License-Identifier: BSD-3-Clause */
/* meniscus doctor: one line for each thing that must be right before a run can be. */
#include "client/cli/doctor.h"
#include "client/cli/output.h"
#include "common/host/text.h"
#include <meniscus/exit.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const verdicts[] = {[WELL] = "ok", [WARNING] = "warning", [PROBLEM] = "problem"};

void doctor_say(Doctor *doctor, Verdict verdict, const char *name, const char *remedy, const char *format, ...)
{
    char text[1200];
    va_list list;
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    doctor->counts[verdict]++;
    json_array_append_new(doctor->checks, json_pack("{ss ss so so}", "name", name, "status", verdicts[verdict], "text",
                                                    output_text(text), "remedy", output_text(remedy)));
    if (!doctor->in->json)
        printf("%-8s %-12s %s%s%s\n", verdicts[verdict], name, text_shown(text), remedy ? ": " : "",
               text_shown(remedy));
    fflush(stdout);
}

/* A daemon that is named by its address has no name that we know. */
static void find_name(Doctor *doctor)
{
    const char *given = options_get(&doctor->in->options, OPT_DAEMON);
    if (!given) given = getenv("MENISCUS_DAEMON");
    const bool named = given && *given && !strpbrk(given, ":/");
    snprintf(doctor->name, sizeof doctor->name, "%s", named ? given : "default");
}

static MnsStatus conclude(const Doctor *doctor, MnsError *error)
{
    const unsigned problems = doctor->counts[PROBLEM], warnings = doctor->counts[WARNING];
    if (doctor->in->json)
        return output_json(json_pack("{sO si si ss}", "checks", doctor->checks, "problems", (int)problems, "warnings",
                                     (int)warnings, "version", MENISCUS_VERSION),
                           error);
    printf("%u problem%s, %u warning%s\n", problems, problems == 1 ? "" : "s", warnings, warnings == 1 ? "" : "s");
    return MNS_OK;
}

MnsStatus command_doctor(Invocation *in, MnsError *error)
{
    Doctor doctor = {.in = in, .checks = json_array()};
    find_name(&doctor);
    doctor_check_programs(&doctor);
    doctor_check_threads(&doctor);
    doctor_check_memory(&doctor);
    doctor_check_cases(&doctor);
    doctor_check_sockets(&doctor);
    doctor_check_daemon(&doctor);
    doctor_check_state(&doctor);
    doctor_check_keys(&doctor);
    doctor_check_extras(&doctor);
    const MnsStatus status = conclude(&doctor, error);
    if (doctor.counts[PROBLEM]) in->code = MNS_EXIT_FAILED;
    json_decref(doctor.checks);
    return status;
}
