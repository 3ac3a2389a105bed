/* SPDX-License-Identifier: BSD-3-Clause */
/* The command line of `meniscus render`. */
#include "client/cli/render_options.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SMALLEST = 160, LARGEST = 8192, MOST_PIXELS = 24000000 };

static MnsStatus bad(MnsError *error, const char *option, const char *found, const char *wanted)
{
    return mns_fail_at(error, MNS_E_INVALID, option, "%s is \"%s\", but must be %s", option, found, wanted);
}

/* n finite numbers with commas between them and nothing else. */
static bool read_numbers(const char *text, size_t n, double *ret)
{
    size_t found;
    return parse_numbers("", text, n, ret, &found, NULL) == MNS_OK && found == n;
}

static MnsStatus read_range(const char *text, RenderOptions *o, MnsError *error)
{
    if (!read_numbers(text, 2, o->range) || !(o->range[0] < o->range[1]))
        return bad(error, "--range", text, "two numbers LO,HI with LO below HI");
    o->has_range = true;
    return MNS_OK;
}

static MnsStatus read_box(const char *text, RenderOptions *o, MnsError *error)
{
    const double *b = o->view.box;
    if (!read_numbers(text, 4, o->view.box) || !(b[0] < b[2]) || !(b[1] < b[3]))
        return bad(error, "--box", text, "four numbers X0,Y0,X1,Y1 with X0 below X1 and Y0 below Y1");
    o->view.has_box = true;
    return MNS_OK;
}

/* The height may be left to the plot. */
static MnsStatus read_size(const char *text, RenderOptions *o, MnsError *error)
{
    char *end;
    const long w = strtol(text, &end, 10);
    const bool fits = !*end;
    const long h = *end == 'x' ? strtol(end + 1, &end, 10) : 0;
    if (*end || w <= 0 || (h <= 0 && !fits)) return bad(error, "--size", text, "pixels as in 1600 or 1600x900");
    /* A page that fits its plot is at most twice as high as it is wide. */
    const long most = fits ? LARGEST / 2 : LARGEST, least = fits ? 0 : SMALLEST;
    const bool good = w >= SMALLEST && w <= most && h >= least && h <= LARGEST;
    if (!good || (fits ? 2 * w * w : w * h) > MOST_PIXELS)
        return mns_fail_at(error, MNS_E_LIMIT, "--size",
                           "--size is %.40s, but must be %d to %d pixels each way and at most %d million altogether",
                           text, SMALLEST, LARGEST, MOST_PIXELS / 1000000);
    o->width = (int)w;
    o->height = (int)h;
    return MNS_OK;
}

static bool read_axis(char letter, int *ret)
{
    const char *at = letter ? strchr("xyz", letter) : NULL;
    if (at) *ret = (int)(at - "xyz");
    return at != NULL;
}

static MnsStatus read_cut(const char *text, RenderOptions *o, MnsError *error)
{
    double number[2] = {NAN, 0};
    bool good = read_axis(text[0], &o->view.axis);
    if (good && text[1])
        good = text[1] == '=' && (read_numbers(text + 2, 1, number) || read_numbers(text + 2, 2, number));
    if (!good || number[1] < 0)
        return bad(error, "--cut", text, "an axis, a place and a thickness as in z, z=0.5 or z=0.5,0.02");
    o->view.kind = VIEW_CUT;
    o->view.at = number[0];
    o->view.thickness = number[1];
    return MNS_OK;
}

static MnsStatus read_projection(const char *text, RenderOptions *o, MnsError *error)
{
    if (!read_axis(text[0], &o->view.axis) || text[1]) return bad(error, "--project", text, "x, y or z");
    o->view.kind = VIEW_PROJECTION;
    return MNS_OK;
}

static MnsStatus read_colours(const char *text, RenderOptions *o, MnsError *error)
{
    o->map = colour_map_find(text);
    return o->map ? MNS_OK : bad(error, "--colours", text, "viridis, magma, cividis, coolwarm or grey");
}

static MnsStatus read_out(const char *text, RenderOptions *o, MnsError *error)
{
    const size_t length = strlen(text);
    if (length < 5 || strcmp(text + length - 4, ".png") != 0)
        return bad(error, "--out", text, "a file name that ends with .png");
    o->out = text;
    return MNS_OK;
}

static MnsStatus read_one(OptionId id, const char *text, RenderOptions *o, MnsError *error)
{
    switch (id) {
    case OPT_PICTURE: return read_out(text, o, error);
    case OPT_RANGE: return read_range(text, o, error);
    case OPT_COLOURS: return read_colours(text, o, error);
    case OPT_CUT: return read_cut(text, o, error);
    case OPT_PROJECT: return read_projection(text, o, error);
    case OPT_BOX: return read_box(text, o, error);
    case OPT_SIZE: return read_size(text, o, error);
    case OPT_FIELD: o->field = text; return MNS_OK;
    case OPT_FLUID: o->view.fluids = text; return MNS_OK;
    case OPT_TITLE: o->title = text; return MNS_OK;
    case OPT_WALLS: o->view.walls = true; return MNS_OK;
    default: return MNS_OK;
    }
}

MnsStatus render_options_read(const Options *options, RenderOptions *ret, MnsError *error)
{
    RenderOptions o = {.field = "phase", .width = 1600, .map = colour_map(0), .view.at = NAN};
    for (size_t k = 0; k < options->n_given; k++) {
        const MnsStatus status = read_one(options->given[k].id, options->given[k].value, &o, error);
        if (status) return status;
    }
    if (options->n_words) o.snapshot = options->words[0];
    if (options_get(options, OPT_CUT) && options_get(options, OPT_PROJECT))
        return mns_fail_at(error, MNS_E_INVALID, "--cut", "a picture is either of a --cut or a --project, not both");
    if (o.snapshot && options_get(options, OPT_DAEMON))
        return mns_fail(error, MNS_E_INVALID, "say what to draw: either a snapshot file or --daemon NAME, not both");
    if (!o.out) return mns_fail_at(error, MNS_E_INVALID, "--out", "say where the picture goes: --out FILE.png");
    *ret = o;
    return MNS_OK;
}
