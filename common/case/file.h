/* SPDX-License-Identifier: BSD-3-Clause */
/* The case as text: YAML to message and back, by walking the descriptors of case.proto. No entry is named here. */
#ifndef COMMON_CASE_FILE_H
#define COMMON_CASE_FILE_H

#include "case.pb-c.h"
#include <meniscus/status.h>
#include <stdbool.h>

/* Where each entry stands in the file, so that a later complaint about a path can name line and column. */
typedef struct CaseFile CaseFile;

/* Read a file. On failure error->text begins "FILE:LINE:COLUMN: ". MNS_OK; MNS_E_NOT_FOUND, MNS_E_IO; MNS_E_INVALID:
 * no regular file, not YAML, unknown key (with a suggestion), wrong type, out of bounds, missing entry. */
MnsStatus case_file_read(const char *path, CaseFile **ret, MnsError *error);

/* The same, then override entries as case_file_set() does. Only the whole must be a case: several settings may make one entry, piece by piece, or
 * what the file lacks. */
MnsStatus case_file_read_with(const char *path, size_t n_settings, const char *const *settings, CaseFile **ret,
                              MnsError *error);

/* The same from memory; name stands for the file in complaints. */
MnsStatus case_file_parse(const char *name, const char *text, size_t size, CaseFile **ret, MnsError *error);

/* Override an entry: "output.snapshot_interval=0.1", "fluids[1].density=2", "gravity=[0, -1]"; the value is YAML. */
MnsStatus case_file_set(CaseFile *file, const char *assignment, MnsError *error);

/* The overrides so far, in order: false from k on if there are no more; borrowed. */
bool case_file_setting(const CaseFile *file, size_t k, const char **ret_path, const char **ret_yaml);

/* Borrow the message; owned by the file, changed by case_file_set(). */
const Meniscus__Case *case_file_message(const CaseFile *file);

/* Give error->text the prefix "FILE:LINE:COLUMN: " of the entry error->path, or of the nearest entry around it (or
 * "--set PATH=VALUE" if it came from there). Does nothing if the text has such a prefix. */
void case_file_locate(const CaseFile *file, MnsError *error);

void case_file_free(CaseFile *file);

/* --- on messages, wherever they come from ------------------------------------------------------------------------- */

/* Bounds, counts, required entries and names of enums as case.proto's comments say: for messages from a socket. */
MnsStatus case_message_check(const Meniscus__Case *message, MnsError *error);

/* Copy of message with one entry changed. case_message_put() leaves the check to the caller, who changes more. */
MnsStatus case_message_set(const Meniscus__Case *message, const char *path, const char *yaml, Meniscus__Case **ret,
                           MnsError *error);
MnsStatus case_message_put(const Meniscus__Case *message, const char *path, const char *yaml, Meniscus__Case **ret,
                           MnsError *error);

/* Value of an entry as one line of YAML (a default if it is not there), and its unit. ret_text is yours. */
MnsStatus case_message_get(const Meniscus__Case *message, const char *path, char **ret_text, const char **ret_unit,
                           MnsError *error);

/* The whole message as YAML that case_file_parse() reads back to the same message. Yours. */
char *case_message_print(const Meniscus__Case *message);

/* MNS_OK if b differs from a in steerable entries only; else MNS_E_INVALID with the path of the first other
 * difference. */
MnsStatus case_message_steerable(const Meniscus__Case *a, const Meniscus__Case *b, MnsError *error);

/* MNS_E_INVALID if an entry is of what this case has something else for, as of another scheme. */
MnsStatus case_message_steers(const Meniscus__Case *c, const char *path, MnsError *error);

/* Tell of each steerable entry that differs between a and b: its path and both values as YAML. */
void case_message_differences(const Meniscus__Case *a, const Meniscus__Case *b,
                              void (*tell)(void *arg, const char *path, const char *in_a, const char *in_b), void *arg);

/* A steerable entry of the schema, for `capabilities`. */
typedef struct CaseParameter {
    const char *path, *type, *unit, *range, *meaning;
} CaseParameter;
const CaseParameter *case_parameters(size_t *ret_n);

/* Tell of each entry that a case may have, by its path; of what is a list, or in one, of the list alone. */
void case_entries(void (*tell)(void *arg, const char *path), void *arg);

#endif
