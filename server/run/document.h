/* SPDX-License-Identifier: BSD-3-Clause */
/* A case in all the forms its users need, made once, never changed, shared by counting references. */
#ifndef RUN_DOCUMENT_H
#define RUN_DOCUMENT_H

#include "meniscus.pb-c.h"
#include <meniscus/case.h>

typedef struct Document {
    _Atomic unsigned references;
    Meniscus__Case *message;
    MnsCase *c;
    char *name; /* "dambreak2d": letters, digits, dot, dash and underscore */
    char *text; /* YAML                                                    */
    void *blob; /* the packed message                                      */
    size_t size;
} Document;

/* Check and translate a message; it is copied. MNS_OK, or what case_message_check() and case_translate() return;
 * MNS_E_INVALID if the name cannot be that of a directory. */
MnsStatus document_new(const Meniscus__Case *message, const char *name, Document **ret, MnsError *error);

/* The same from a packed message, as a checkpoint keeps it. */
MnsStatus document_unpack(const void *blob, size_t size, const char *name, Document **ret, MnsError *error);

/* Message with all assignments made, yours: only what is written where is looked at. */
MnsStatus document_assign(const Meniscus__Case *old, const Meniscus__Set *set, Meniscus__Case **ret, MnsError *error);

/* As a set leaves the case of a run under way: all assignments made, one after the other. MNS_E_INVALID; MNS_E_STATE if something would
 * change that cannot. */
MnsStatus document_set(const Document *old, const Meniscus__Set *set, Document **ret, MnsError *error);

/* One more, one fewer user; NULL is fine for both. Any thread. */
Document *document_share(Document *document);
void document_leave(Document *document);

#endif
