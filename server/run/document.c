/* SPDX-License-Identifier: BSD-3-Clause */
/* A case in all the forms its users need: message, plain values, text, bytes. */
#include "run/document.h"

#include "cases/translate.h"
#include "common/case/file.h"
#include "common/case/name.h"
#include <stdlib.h>
#include <string.h>

static void destroy(Document *document)
{
    meniscus__case__free_unpacked(document->message, NULL);
    mns_case_free(document->c);
    free(document->name);
    free(document->text);
    free(document->blob);
    free(document);
}

/* The name becomes that of a directory: no slash, and nothing that hides it or climbs out of it. */
static MnsStatus check_name(const char *name, MnsError *error)
{
    if (is_name(name)) return MNS_OK;
    return mns_fail_at(error, MNS_E_INVALID, "name",
                       "the name of a case has 1 to 100 letters, digits, dots, dashes and underscores, and begins with "
                       "none of '.' and '-'; found \"%.60s\"",
                       name);
}

static MnsStatus translate(Document *document, MnsError *error)
{
    MnsStatus status = case_message_check(document->message, error);
    if (!status) status = case_translate(document->message, &document->c, error);
    if (status) return status;
    document->text = case_message_print(document->message);
    if (document->text) return MNS_OK;
    return mns_fail(error, MNS_E_INVALID, "the case cannot be written as text: its strings must be UTF-8");
}

MnsStatus document_unpack(const void *blob, size_t size, const char *name, Document **ret, MnsError *error)
{
    const MnsStatus named = check_name(name, error);
    if (named) return named;
    Document *document = calloc(1, sizeof *document);
    if (!document) return mns_fail(error, MNS_E_MEMORY, "no memory for the case");
    document->references = 1;
    document->name = strdup(name);
    document->blob = malloc(size + 1); /* an empty message packs to nothing */
    document->size = size;
    document->message = meniscus__case__unpack(NULL, size, blob);
    MnsStatus status;
    if (!document->name || !document->blob) status = mns_fail(error, MNS_E_MEMORY, "no memory for the case");
    else if (!document->message)
        status = mns_fail(error, MNS_E_CORRUPT, "the stored case is no message of this version");
    else status = translate(document, error);
    if (status) {
        destroy(document);
        return status;
    }
    memcpy(document->blob, blob, size);
    *ret = document;
    return MNS_OK;
}

MnsStatus document_new(const Meniscus__Case *message, const char *name, Document **ret, MnsError *error)
{
    const size_t size = meniscus__case__get_packed_size(message);
    uint8_t *blob = malloc(size + 1);
    if (!blob) return mns_fail(error, MNS_E_MEMORY, "no memory for the case");
    meniscus__case__pack(message, blob);
    const MnsStatus status = document_unpack(blob, size, name, ret, error);
    free(blob);
    return status;
}

MnsStatus document_assign(const Meniscus__Case *old, const Meniscus__Set *set, Meniscus__Case **ret, MnsError *error)
{
    Meniscus__Case *last = NULL;
    for (size_t k = 0; k < set->n_assignments; k++) {
        const Meniscus__Assignment *made = set->assignments[k];
        Meniscus__Case *next;
        const MnsStatus status = made->path && made->value
                                     ? case_message_set(last ? last : old, made->path, made->value, &next, error)
                                     : mns_fail(error, MNS_E_INVALID, "an assignment needs a path and a value");
        if (last) meniscus__case__free_unpacked(last, NULL);
        if (status) return status;
        last = next;
    }
    *ret = last;
    return last ? MNS_OK : mns_fail(error, MNS_E_INVALID, "there is nothing to set: give at least one path=value");
}

MnsStatus document_set(const Document *old, const Meniscus__Set *set, Document **ret, MnsError *error)
{
    Meniscus__Case *message;
    MnsStatus status = MNS_OK;
    for (size_t k = 0; k < set->n_assignments && !status; k++)
        if (set->assignments[k]->path) status = case_message_steers(old->message, set->assignments[k]->path, error);
    if (!status) status = document_assign(old->message, set, &message, error);
    if (status) return status;
    status = case_message_steerable(old->message, message, error);
    if (!status) status = document_new(message, old->name, ret, error);
    meniscus__case__free_unpacked(message, NULL);
    return status;
}

Document *document_share(Document *document)
{
    if (document) document->references++;
    return document;
}

void document_leave(Document *document)
{
    if (document && --document->references == 0) destroy(document);
}
