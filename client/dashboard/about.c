/* SPDX-License-Identifier: BSD-3-Clause */
/* What must be known of a case to show it. */
#include "client/dashboard/about.h"
#include "client/cli/output.h"
#include "client/cli/render_colour.h"
#include "common/case/find.h"
#include "common/case/name.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { MOST_PHASES = 64, STOPS = 32 };

static json_t *colour_json(Colour colour)
{
    char text[16];
    snprintf(text, sizeof text, "#%02x%02x%02x", (unsigned)lround(255 * colour.r), (unsigned)lround(255 * colour.g),
             (unsigned)lround(255 * colour.b));
    return json_string(text);
}

/* The same colours as in pictures of `meniscus render`. */
static json_t *maps_json(void)
{
    json_t *maps = json_array();
    for (size_t k = 0; colour_map(k); k++) {
        json_t *stops = json_array();
        for (int s = 0; s < STOPS; s++)
            json_array_append_new(stops, colour_json(colour_at(colour_map(k), s / (STOPS - 1.0))));
        json_array_append_new(maps, json_pack("{ss sb so}", "name", colour_map_name(colour_map(k)), "diverges",
                                              (int)colour_map_diverges(colour_map(k)), "stops", stops));
    }
    return maps;
}

typedef char Names[MOST_PHASES][CASE_NAME_SIZE];

/* Names of the fluids, or the walls, one by one until the daemon says that there are no more. */
static MnsStatus ask_names(MnsClient *client, const char *list, Names names, size_t *ret_n, MnsError *error)
{
    MnsError why = {0};
    MnsStatus status = MNS_OK;
    size_t n = 0;
    while (n < MOST_PHASES) {
        char path[64];
        MnsReply *reply = NULL;
        snprintf(path, sizeof path, "%s[%zu].name", list, n);
        status = mns_client_get(client, 1, (const char *const[]){path}, &reply, &why);
        if (status) break;
        const char *name = reply->n_values == 1 && reply->values[0].text ? reply->values[0].text : list;
        snprintf(names[n++], CASE_NAME_SIZE, "%s", name);
        mns_reply_free(reply);
    }
    if (status && status != MNS_E_NOT_FOUND) {
        if (error) *error = why;
        return status;
    }
    *ret_n = n;
    return MNS_OK;
}

static MnsStatus ask_fluids(MnsClient *client, json_t *about, MnsError *error)
{
    Names names;
    const char *list[MOST_PHASES];
    Colour colours[MOST_PHASES];
    size_t n;
    const MnsStatus status = ask_names(client, "fluids", names, &n, error);
    if (status) return status;
    json_t *fluids = json_array();
    for (size_t k = 0; k < n; k++) list[k] = names[k];
    colour_fluids(n, list, colours);
    for (size_t k = 0; k < n; k++)
        json_array_append_new(fluids, json_pack("{ss so}", "name", names[k], "colour", colour_json(colours[k])));
    json_object_set_new(about, "fluids", fluids);
    return MNS_OK;
}

static MnsStatus ask_walls(MnsClient *client, json_t *about, MnsError *error)
{
    Names names;
    size_t n;
    const MnsStatus status = ask_names(client, "walls", names, &n, error);
    if (status) return status;
    json_t *walls = json_array();
    for (size_t k = 0; k < n; k++) json_array_append_new(walls, json_string(names[k]));
    json_object_set_new(about, "walls", walls);
    return MNS_OK;
}

/* All of the case or, where it goes away meanwhile, nothing. */
static MnsStatus ask_case(MnsClient *client, json_t *about, MnsError *error)
{
    static const char *const paths[] = {"dimensions", "reference_length", "resolution",
                                        "domain.min", "domain.max",       "gravity"};
    MnsReply *reply = NULL;
    MnsStatus status = mns_client_get(client, sizeof paths / sizeof *paths, paths, &reply, error);
    if (status) return status;
    json_t *found = json_pack("{so}", "case", output_values(reply->n_values, reply->values));
    mns_reply_free(reply);
    status = ask_fluids(client, found, error);
    if (!status) status = ask_walls(client, found, error);
    if (!status) json_object_update(about, found);
    json_decref(found);
    return status;
}

static void append_case(void *arg, const char *name, const char *folder)
{
    (void)folder;
    json_array_append_new(arg, json_string(name));
}

/* Those that a name is enough for, where this program is. */
static json_t *cases_json(void)
{
    json_t *cases = json_array();
    if (cases) case_list(append_case, cases);
    return cases;
}

MnsStatus about_ask(MnsClient *client, const MnsReply *status, json_t **ret, MnsError *error)
{
    MnsReply *reply = NULL;
    MnsStatus failed = mns_client_capabilities(client, &reply, error);
    if (!failed && !reply->capabilities) failed = mns_fail(error, MNS_E_VERSION, "the daemon's capabilities are empty");
    if (failed) {
        mns_reply_free(reply);
        return failed;
    }
    json_t *about =
        json_pack("{ss so so so}", "topic", "about", "capabilities", output_capabilities(reply->capabilities),
                  "colour_maps", maps_json(), "cases", cases_json());
    mns_reply_free(reply);
    const MnsState state = status->state;
    /* While a case is being loaded there is none to ask about: it is asked when the state changes. */
    if (state != MNS_STATE_EMPTY && state != MNS_STATE_LOADING && state != MNS_STATE_STOPPING)
        failed = ask_case(client, about, error);
    if (failed == MNS_E_STATE) failed = MNS_OK;
    if (failed) json_decref(about);
    else *ret = about;
    return failed;
}
