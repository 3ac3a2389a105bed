/* SPDX-License-Identifier: BSD-3-Clause */
/* What falls due for all who asked for the same. */
#include "net/channel.h"

#include "base/clock.h"
#include <stdlib.h>
#include <string.h>

/* What was asked, less what each has of its own: equal bytes are the same. NULL if there is no memory. */
static uint8_t *key_of(const Meniscus__Subscribe *asked, size_t *ret_size)
{
    Meniscus__Subscribe common = *asked;
    Meniscus__When when = MENISCUS__WHEN__INIT;
    if (asked->when) {
        when = *asked->when;
        when.has_first = false;
        common.when = &when;
    }
    common.has_credit = common.has_chunk_bytes = common.has_delivery = false;
    common.base.n_unknown_fields = 0;
    *ret_size = meniscus__subscribe__get_packed_size(&common);
    uint8_t *key = malloc(*ret_size + 1);
    if (key) meniscus__subscribe__pack(&common, key);
    return key;
}

static Channel *find(Channel *list, const uint8_t *key, size_t size, uint64_t generation)
{
    for (Channel *c = list; c; c = c->next)
        if (c->generation == generation && c->key_size == size && !memcmp(c->key, key, size)) return c;
    return NULL;
}

static MnsStatus open_channel(Channel **list, Tap *tap, const Stream *stream, uint8_t *key, size_t size,
                              MnsError *error)
{
    const StreamSpec *spec = &stream->spec;
    const bool fed = spec->kind != STREAM_EVENTS;
    Channel *channel = calloc(1, sizeof *channel);
    if (channel && fed) channel->feed = tap_open(tap, stream->generation, &spec->wish);
    if (!channel || (fed && !channel->feed)) {
        free(channel);
        return mns_fail(error, channel ? MNS_E_STATE : MNS_E_MEMORY,
                        channel ? "another case was loaded just now; ask again" : "no memory for another stream");
    }
    channel->spec = *spec;
    channel->key = key;
    channel->key_size = size;
    channel->generation = stream->generation;
    channel->next = *list;
    *list = channel;
    return MNS_OK;
}

MnsStatus channel_join(Channel **list, Tap *tap, const Meniscus__Subscribe *asked, Stream *stream, MnsError *error)
{
    size_t size;
    uint8_t *key = key_of(asked, &size);
    if (!key) return mns_fail(error, MNS_E_MEMORY, "no memory for another stream");
    Channel *channel = find(*list, key, size, stream->generation);
    const MnsStatus status = channel ? MNS_OK : open_channel(list, tap, stream, key, size, error);
    if (channel || status) free(key);
    if (status) return status;
    stream->channel = channel ? channel : *list;
    stream->beside = stream->channel->users;
    stream->channel->users = stream;
    return MNS_OK;
}

void channel_leave(Channel **list, Tap *tap, Stream *stream)
{
    Channel *channel = stream->channel;
    Stream **at = &channel->users;
    while (*at != stream) at = &(*at)->beside;
    *at = stream->beside;
    stream->channel = NULL;
    if (channel->users) return;
    while (*list != channel) list = &(*list)->next;
    *list = channel->next;
    if (channel->feed) tap_close(tap, channel->feed);
    stream_item_leave(channel->newest);
    free(channel->key);
    free(channel);
}

void channel_put(Channel *channel, StreamItem *item, uint64_t number)
{
    stream_item_leave(channel->newest);
    item->number = number;
    channel->newest = item;
    channel->since = clock_now();
}
