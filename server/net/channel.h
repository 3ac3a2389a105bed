/* SPDX-License-Identifier: BSD-3-Clause */
/* What falls due for all who asked for the same: one feed of the run, and one item, which the newest replaces. */
#ifndef NET_CHANNEL_H
#define NET_CHANNEL_H

#include "net/stream.h"

/* One more who asks for this, with its `spec` and `generation`: an existing channel becomes its `channel`, or a new one. MNS_E_MEMORY; MNS_E_STATE if the
 * case has changed meanwhile. */
MnsStatus channel_join(Channel **list, Tap *tap, const Meniscus__Subscribe *asked, Stream *stream, MnsError *error);

/* One fewer; without any its channel is gone. */
void channel_leave(Channel **list, Tap *tap, Stream *stream);

/* Another item takes the place of the newest. */
void channel_put(Channel *channel, StreamItem *item, uint64_t number);

#endif
