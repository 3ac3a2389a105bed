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

MnsStatus channel_join(Channel **list, Tap *tap, const Meniscus__Subscribe *asked, const StreamSpec *spec,
                       uint64_t generation, Channel **ret, MnsError *error)
{
    size_t size;
    uint8_t *key = key_of(asked, &size);
    Channel *channel = key ? find(*list, key, size, generation) : NULL;
    if (channel) {
        free(key);
        channel->users++;
        *ret = channel;
        return MNS_OK;
    }
    channel = key ? calloc(1, sizeof *channel) : NULL;
    const bool fed = spec->kind != STREAM_EVENTS;
    if (channel && fed) channel->feed = tap_open(tap, generation, &spec->wish);
    if (!channel || (fed && !channel->feed)) {
        free(channel);
        free(key);
        return mns_fail(error, channel ? MNS_E_STATE : MNS_E_MEMORY,
                        channel ? "another case was loaded just now; ask again" : "no memory for another stream");
    }
    channel->spec = *spec;
    channel->key = key;
    channel->key_size = size;
    channel->users = 1;
    channel->generation = generation;
    channel->next = *list;
    *list = channel;
    *ret = channel;
    return MNS_OK;
}

void channel_leave(Channel **list, Tap *tap, Channel *channel)
{
    if (--channel->users) return;
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
