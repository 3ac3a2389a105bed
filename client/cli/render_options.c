/* SPDX-License-Identifier: BSD-3-Clause */
/* The command line of `meniscus render`. */
#include "client/cli/render_options.h"
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SMALLEST = 160, LARGEST = 8192, MOST_PIXELS = 24000000 };

const char *render_usage(void)
{
    return "Usage: meniscus render [SNAPSHOT.hdf | --daemon NAME] [OPTION]...  -o FILE.png\n"
           "Draw the particles of a snapshot, or of a daemon while it runs, as a PNG picture.\n"
           "\n"
           "  -f, --field NAME         phase (default), pressure, velocity, density or any other field\n"
           "  -r, --range LO,HI        ends of the colour bar in the field's SI unit (default: nearly all values)\n"
           "  -c, --colours NAME       viridis (default), magma, cividis, coolwarm (0 in its middle) or grey\n"
           "      --cut AXIS[=AT[,D]]  3D: a cut normal to x, y or z, AT that place [m], of thickness D [m]\n"
           "                           (default: through the middle of the thinnest extent)\n"
           "      --project AXIS       3D: look at the surface of the heaviest fluid along x, y or z\n"
           "      --fluid NAME[,NAME]  draw these fluids only\n"
           "  -w, --walls              draw wall particles in grey\n"
           "  -b, --box X0,Y0,X1,Y1    part of the plane to draw [m]\n"
           "  -t, --title TEXT         instead of the title of the case\n"
           "  -s, --size WxH           in pixels (default: 1600x900)\n"
           "  -d, --daemon NAME        draw what this daemon is computing (default, without a snapshot:\n"
           "                           $MENISCUS_DAEMON, or the one named default)\n"
           "  -o, --out FILE.png       where the picture goes\n"
           "  -o json                  besides, say on standard output what was drawn, as JSON\n";
}

static MnsStatus bad(MnsError *error, const char *option, const char *found, const char *wanted)
{
    return mns_fail_at(error, MNS_E_INVALID, option, "%s is \"%s\", but must be %s.", option, found, wanted);
}

/* n finite numbers with commas between them and nothing else. Commas in numbers are no concern: the locale is "C". */
static bool parse_numbers(const char *text, int n, double *ret)
{
    for (int k = 0; k < n; k++) {
        char *end;
        ret[k] = strtod(text, &end);
        if (end == text || !isfinite(ret[k]) || *end != (k + 1 < n ? ',' : '\0')) return false;
        text = end + 1;
    }
    return true;
}

static MnsStatus parse_range(const char *text, RenderOptions *o, MnsError *error)
{
    if (!parse_numbers(text, 2, o->range) || !(o->range[0] < o->range[1]))
        return bad(error, "--range", text, "two numbers LO,HI with LO below HI");
    o->has_range = true;
    return MNS_OK;
}

static MnsStatus parse_box(const char *text, RenderOptions *o, MnsError *error)
{
    const double *b = o->view.box;
    if (!parse_numbers(text, 4, o->view.box) || !(b[0] < b[2]) || !(b[1] < b[3]))
        return bad(error, "--box", text, "four numbers X0,Y0,X1,Y1 with X0 below X1 and Y0 below Y1");
    o->view.has_box = true;
    return MNS_OK;
}

static MnsStatus parse_size(const char *text, RenderOptions *o, MnsError *error)
{
    char *end;
    const long w = strtol(text, &end, 10);
    const long h = *end == 'x' ? strtol(end + 1, &end, 10) : 0;
    if (*end || w <= 0 || h <= 0) return bad(error, "--size", text, "pixels as in 1600x900");
    if (w < SMALLEST || h < SMALLEST || w > LARGEST || h > LARGEST || w * h > MOST_PIXELS)
        return mns_fail_at(error, MNS_E_LIMIT, "--size",
                           "--size is %ldx%ld, but must be %d to %d pixels each way and at most %d million altogether.",
                           w, h, SMALLEST, LARGEST, MOST_PIXELS / 1000000);
    o->width = (int)w;
    o->height = (int)h;
    return MNS_OK;
}

static bool parse_axis(char letter, int *ret)
{
    const char *at = letter ? strchr("xyz", letter) : NULL;
    if (at) *ret = (int)(at - "xyz");
    return at != NULL;
}

static MnsStatus parse_cut(const char *text, RenderOptions *o, MnsError *error)
{
    double number[2] = {NAN, 0};
    bool good = parse_axis(text[0], &o->view.axis);
    if (good && text[1])
        good = text[1] == '=' && (parse_numbers(text + 2, 1, number) || parse_numbers(text + 2, 2, number));
    if (!good || number[1] < 0)
        return bad(error, "--cut", text, "an axis, a place and a thickness as in z, z=0.5 or z=0.5,0.02");
    o->view.kind = VIEW_CUT;
    o->view.at = number[0];
    o->view.thickness = number[1];
    return MNS_OK;
}

static MnsStatus parse_projection(const char *text, RenderOptions *o, MnsError *error)
{
    if (!parse_axis(text[0], &o->view.axis) || text[1]) return bad(error, "--project", text, "x, y or z");
    o->view.kind = VIEW_PROJECTION;
    return MNS_OK;
}

static MnsStatus parse_colours(const char *text, RenderOptions *o, MnsError *error)
{
    o->map = colour_map_find(text);
    return o->map ? MNS_OK : bad(error, "--colours", text, "viridis, magma, cividis, coolwarm or grey");
}

/* "json" and "text" choose what goes to standard output, as in every command; anything else is the picture. */
static MnsStatus parse_out(const char *text, RenderOptions *o, MnsError *error)
{
    const size_t length = strlen(text);
    if (!strcmp(text, "json") || !strcmp(text, "text")) {
        o->json = text[0] == 'j';
        return MNS_OK;
    }
    if (length < 5 || strcmp(text + length - 4, ".png") != 0)
        return bad(error, "--out", text, "a file name that ends with .png");
    o->out = text;
    return MNS_OK;
}

static MnsStatus parse_one(int letter, const char *text, RenderOptions *o, MnsError *error)
{
    switch (letter) {
    case 'f': o->field = text; return MNS_OK;
    case 'r': return parse_range(text, o, error);
    case 'c': return parse_colours(text, o, error);
    case 'C': return parse_cut(text, o, error);
    case 'P': return parse_projection(text, o, error);
    case 'F': o->view.fluids = text; return MNS_OK;
    case 'w': o->view.walls = true; return MNS_OK;
    case 'b': return parse_box(text, o, error);
    case 't': o->title = text; return MNS_OK;
    case 's': return parse_size(text, o, error);
    case 'd': o->daemon = text; return MNS_OK;
    case 'o': return parse_out(text, o, error);
    default: o->help = true; return MNS_OK;
    }
}

static MnsStatus check_whole(int argc, char **argv, RenderOptions *o, MnsError *error)
{
    if (o->help) return MNS_OK;
    if (optind < argc) o->snapshot = argv[optind++];
    if (optind < argc)
        return mns_fail(error, MNS_E_INVALID, "There is nothing to do with \"%s\": one snapshot makes one picture.",
                        argv[optind]);
    if (o->snapshot && o->daemon)
        return mns_fail(error, MNS_E_INVALID, "Say what to draw: either a snapshot file or --daemon NAME, not both.");
    if (!o->out) return mns_fail_at(error, MNS_E_INVALID, "--out", "Say where the picture goes: -o FILE.png.");
    return MNS_OK;
}

MnsStatus render_options_parse(int argc, char **argv, RenderOptions *ret, MnsError *error)
{
    static const struct option known[] = {
        {"field", required_argument, NULL, 'f'},
        {"range", required_argument, NULL, 'r'},
        {"colours", required_argument, NULL, 'c'},
        {"colors", required_argument, NULL, 'c'},
        {"cut", required_argument, NULL, 'C'},
        {"project", required_argument, NULL, 'P'},
        {"fluid", required_argument, NULL, 'F'},
        {"walls", no_argument, NULL, 'w'},
        {"box", required_argument, NULL, 'b'},
        {"title", required_argument, NULL, 't'},
        {"size", required_argument, NULL, 's'},
        {"daemon", required_argument, NULL, 'd'},
        {"out", required_argument, NULL, 'o'},
        {"help", no_argument, NULL, 'h'},
        {NULL, 0, NULL, 0},
    };
    RenderOptions o = {.field = "phase", .width = 1600, .height = 900, .map = colour_map(0), .view.at = NAN};
    MnsStatus status = MNS_OK;
    opterr = 0;
    optind = 0; /* another command may have used getopt before */
    for (int letter; !status && (letter = getopt_long(argc, argv, ":f:r:c:wb:t:s:d:o:h", known, NULL)) != -1;) {
        if (letter == '?' || letter == ':')
            return mns_fail_at(error, MNS_E_INVALID, argv[optind - 1],
                               letter == '?' ? "There is no option %s." : "The option %s needs a value.",
                               argv[optind - 1]);
        status = parse_one(letter, optarg, &o, error);
    }
    if (!status) status = check_whole(argc, argv, &o, error);
    if (!status) *ret = o;
    return status;
}
