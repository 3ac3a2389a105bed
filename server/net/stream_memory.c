/* SPDX-License-Identifier: BSD-3-Clause */
/* Memory for items: who has to give way when it is short. What costs nobody anything goes first, then what waits for the slow, then what they do not
 * take, and at last the slow themselves. Those who take what comes notice none of it. */
#include "net/streams_inside.h"

#include "base/clock.h"

static const double WAITED_FOR = 1; /* [s] that an item waits before it may be let go       */
static const double STUCK_FOR = 1;  /* [s] without a byte taken, after which an item under way may be given up     */
static const double HUNG_FOR =
    10; /* [s] the same of a LOSSLESS stream, which is over then, as nothing of it may be left out */

static bool is_short(const Streams *streams, size_t needed)
{
    return streams->memory + needed > streams->limit;
}

static bool is_latest(const Stream *stream)
{
    return stream_is_latest(stream->spec.kind);
}

/* Has somebody not had the newest of the channel? */
static bool is_awaited(const Channel *channel)
{
    for (const Stream *s = channel->users; s; s = s->beside)
        if (s->books.taken < channel->newest->number) return true;
    return false;
}

static void drop_newest(Channel *channel)
{
    stream_item_leave(channel->newest);
    channel->newest = NULL;
}

/* Does somebody take what the channel has, as it comes? */
static bool is_lively(const Channel *channel, double now)
{
    for (const Stream *s = channel->users; s; s = s->beside) {
        if (s->gone) continue;
        if (s->books.under_way ? s->moved > now - STUCK_FOR : s->books.credit && !stream_is_blocked(s)) return true;
    }
    return false;
}

/* One that is whole, and kept for a resume alone: of who has not moved for longest. */
static bool drop_kept(Streams *streams)
{
    Stream *found = NULL;
    for (Stream *s = streams->first; s; s = s->next)
        if (s->item && !s->books.under_way && !(s->channel && s->channel->newest == s->item) &&
            (!found || s->moved < found->moved))
            found = s;
    if (found) stream_close_item(found);
    return found;
}

/* The newest of a channel from which all have had it. */
static bool drop_had(Streams *streams)
{
    for (Channel *c = streams->channels; c; c = c->next)
        if (c->newest && !is_awaited(c)) {
            drop_newest(c);
            return true;
        }
    return false;
}

/* The largest of those that wait: first for who takes nothing, then for who is slow. `skipped` tells of it with the next one. */
static bool drop_waiting(Streams *streams, double now)
{
    Channel *found = NULL;
    bool slow = false;
    for (Channel *c = streams->channels; c; c = c->next) {
        if (!c->newest || !c->feed) continue;
        const bool lively = is_lively(c, now);
        if (lively && (c->since > now - WAITED_FOR || (found && !slow))) continue;
        if (found && slow == lively && c->newest->held <= found->newest->held) continue;
        found = c;
        slow = lively;
    }
    if (!found) return false;
    drop_newest(found);
    streams->options.traffic->let_go++;
    return true;
}

/* The same of an item at once: it is asked for again. */
static bool drop_first(Streams *streams, double now)
{
    for (Stream *s = streams->first; s; s = s->next)
        if (s->head && s->looked <= now - WAITED_FOR) {
            stream_item_leave(s->head);
            s->head = NULL;
            streams_open_first(streams, s);
            s->looked = now;
            streams->options.traffic->let_go++;
            return true;
        }
    return false;
}

static Stream *find_stuck(const Streams *streams, bool latest, double since)
{
    Stream *found = NULL;
    for (Stream *s = streams->first; s; s = s->next)
        if (s->item && s->books.under_way && is_latest(s) == latest && s->moved <= since &&
            (!found || s->moved < found->moved))
            found = s;
    return found;
}

/* It is dropped later, as the streams are being walked over. */
static bool drop_stuck(Streams *streams, double now)
{
    Stream *stuck = find_stuck(streams, true, now - STUCK_FOR);
    if (!stuck) stuck = find_stuck(streams, false, now - HUNG_FOR);
    if (!stuck) return false;
    subscription_cancel(&stuck->books, 0);
    stuck->block = (StreamBlock){.is = true, .credit = stuck->books.credit, .flight = stuck->flight->bytes};
    stuck->too_slow = !is_latest(stuck);
    if (is_latest(stuck) && !stuck->gone)
        stream_post_end(&streams->post, stuck, false, MNS_E_LIMIT, "too slow",
                        "nothing of this item was taken for a while, and streams hold all the memory they may; the "
                        "next one comes when there is credit");
    stream_close_item(stuck);
    streams->options.traffic->too_slow++;
    return true;
}

bool streams_reclaim(Streams *streams, size_t needed, Channel *channel)
{
    const double now = clock_now();
    bool any = needed <= streams->limit;
    while (any && is_short(streams, needed)) {
        any = drop_kept(streams);
        if (!any && channel && channel->newest) {
            drop_newest(channel);
            any = true;
        }
        any = any || drop_had(streams) || drop_waiting(streams, now) || drop_first(streams, now) ||
              drop_stuck(streams, now);
    }
    return !is_short(streams, needed);
}

bool channel_is_lively(const Channel *channel)
{
    return is_lively(channel, clock_now());
}

/* What nobody takes gets what room there is, and that of the item whose place it takes. */
static bool make_room(Streams *streams, size_t needed, Channel *channel)
{
    if (!channel || channel_is_lively(channel)) return streams_reclaim(streams, needed, channel);
    const size_t own = channel->newest ? channel->newest->held : 0;
    if (own && !is_short(streams, needed - (own < needed ? own : needed))) drop_newest(channel);
    return !is_short(streams, needed);
}

MnsStatus streams_make(Streams *streams, const StreamSpec *spec, const Shot *shot, Channel *channel, StreamItem **ret)
{
    MnsStatus status = MNS_E_LIMIT;
    size_t needed = 0;
    for (int k = 0; k < 2 && status == MNS_E_LIMIT && (!k || make_room(streams, needed, channel)); k++) {
        const size_t held = streams->memory, left = held < streams->limit ? streams->limit - held : 0;
        status = stream_item_new(spec, shot, &streams->memory, left, &needed, ret, NULL);
    }
    if (status) streams->options.traffic->not_made++;
    return status;
}
