/* SPDX-License-Identifier: BSD-3-Clause */
/* What the runner has to say. */
#include "run/note.h"

#include <stdlib.h>

Note *note_new(NoteKind kind, size_t n)
{
    Note *note = calloc(1, sizeof *note + n * sizeof *note->values);
    if (!note) return NULL;
    note->kind = kind;
    note->values = (double *)(note + 1);
    return note;
}

void note_free(Note *note)
{
    if (!note || note->kind == NOTE_ANSWER || note->kind == NOTE_SCHEDULED) return;
    document_leave(note->document);
    free(note);
}
