/* SPDX-License-Identifier: BSD-3-Clause */
/* The text of a case file: a case, or a complaint that has a place. */
#include "cases/translate.h"
#include "common/case/file.h"
#include "tests/fuzz/fuzz.h"
#include <meniscus/case.h>
#include <string.h>

static void assert_place(const MnsError *error)
{
    PROMISE(strncmp(error->text, "a.yaml:", 7) == 0);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    CaseFile *file = NULL;
    MnsCase *c = NULL;
    MnsError error = {0};
    if (case_file_parse("a.yaml", (const char *)data, size, &file, &error)) {
        assert_place(&error);
        return 0;
    }
    const MnsStatus status = case_translate(case_file_message(file), &c, &error);
    case_file_locate(file, &error);
    if (status) assert_place(&error);
    mns_case_free(c);
    case_file_free(file);
    return 0;
}
