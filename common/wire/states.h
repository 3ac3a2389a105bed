/* SPDX-License-Identifier: BSD-3-Clause */
/* States go over the wire by number; whoever has an enum of them for itself checks it against the protocol's here. */
#ifndef COMMON_WIRE_STATES_H
#define COMMON_WIRE_STATES_H

#include "meniscus.pb-c.h"

#define STATE_HAS_ITS_NUMBER(PREFIX, STATE)                                                                            \
    _Static_assert((int)PREFIX##STATE == (int)MENISCUS__STATE__##STATE, "a state has one number here and in the "      \
                                                                        "protocol")

/* For constants named PREFIX and the state; a declaration, so at file scope. */
#define STATES_HAVE_THE_NUMBERS_OF_THE_PROTOCOL(PREFIX)                                                                \
    STATE_HAS_ITS_NUMBER(PREFIX, EMPTY);                                                                               \
    STATE_HAS_ITS_NUMBER(PREFIX, LOADING);                                                                             \
    STATE_HAS_ITS_NUMBER(PREFIX, READY);                                                                               \
    STATE_HAS_ITS_NUMBER(PREFIX, RUNNING);                                                                             \
    STATE_HAS_ITS_NUMBER(PREFIX, PAUSED);                                                                              \
    STATE_HAS_ITS_NUMBER(PREFIX, DONE);                                                                                \
    STATE_HAS_ITS_NUMBER(PREFIX, FAULT);                                                                               \
    STATE_HAS_ITS_NUMBER(PREFIX, STOPPING);                                                                            \
    STATE_HAS_ITS_NUMBER(PREFIX, RECOVERING)

#endif
