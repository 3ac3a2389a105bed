/* SPDX-License-Identifier: BSD-3-Clause */
/* Colours for numbers and for fluids that colour-blind readers and grey printers can tell apart. */
#include "client/cli/render_colour.h"
#include <math.h>
#include <stdint.h>
#include <string.h>
#include <strings.h>

enum { STOPS = 9, PALETTE = 16 };

struct ColourMap {
    const char *name;
    bool diverges;
    uint32_t stops[STOPS]; /* 0xRRGGBB at equal distances */
};

/* Nine published points of each map. viridis and magma: N. Smith and S. van der Walt, matplotlib 1.5 (CC0). cividis:
 * J. Nunez, C. Anderton, R. Renslow, PLoS ONE 13 (2018) e0199239. coolwarm: K. Moreland, "Diverging color maps for
 * scientific visualization", ISVC 2009. */
static const ColourMap maps[] = {
    {"viridis", false, {0x440154, 0x472d7b, 0x3b528b, 0x2c728e, 0x21918c, 0x27ad81, 0x5cc863, 0xaadc32, 0xfde725}},
    {"magma", false, {0x000004, 0x1d1147, 0x51127c, 0x832681, 0xb73779, 0xe55064, 0xfb8761, 0xfec287, 0xfcfdbf}},
    {"cividis", false, {0x00224e, 0x1a386f, 0x434e6c, 0x61656f, 0x7d7c78, 0x9a9376, 0xbbad6d, 0xddc858, 0xfee838}},
    {"coolwarm", true, {0x3b4cc0, 0x6282ea, 0x8db0fe, 0xb9d0f9, 0xdddcdc, 0xf4c5ad, 0xf49a7b, 0xde614d, 0xb40426}},
    {"grey", false, {0x202020, 0x383838, 0x505050, 0x696969, 0x838383, 0x9d9d9d, 0xb8b8b8, 0xd3d3d3, 0xf0f0f0}},
};

/* Fluids that are not known by name take these in turn: the set of M. Okabe and K. Ito (2008), reordered so that the
 * first two differ most in lightness, then darker and lighter relatives of it. */
static const uint32_t palette[PALETTE] = {
    0x1f78b4, 0xe69f00, 0x009e73, 0xcc79a7, 0xd55e00, 0xf0e442, 0x56b4e9, 0x7f7f7f,
    0x0b3c5d, 0x8c6100, 0x00563f, 0x7a3b5f, 0x7a3600, 0xa89f1f, 0xa6d8f5, 0x404040,
};

/* Names that carry a colour in every reader's mind; the first match wins. */
static const struct {
    const char *word;
    uint32_t colour;
} known[] = {
    {"water", 0x1f78b4}, {"air", 0xf1ece1}, {"gas", 0xf1ece1},     {"vapour", 0xe4e9ee}, {"steam", 0xe4e9ee},
    {"oil", 0xe69f00},   {"mud", 0x8c6100}, {"mercury", 0x7f7f7f}, {"brine", 0x009e73},  {"salt", 0x009e73},
};

static Colour from_hex(uint32_t hex)
{
    return (Colour){(double)(hex >> 16 & 255) / 255, (double)(hex >> 8 & 255) / 255, (double)(hex & 255) / 255};
}

const ColourMap *colour_map(size_t k)
{
    return k < sizeof maps / sizeof *maps ? &maps[k] : NULL;
}

const ColourMap *colour_map_find(const char *name)
{
    for (size_t k = 0; colour_map(k); k++)
        if (!strcmp(maps[k].name, name)) return &maps[k];
    return NULL;
}

const char *colour_map_name(const ColourMap *map)
{
    return map->name;
}

bool colour_map_diverges(const ColourMap *map)
{
    return map->diverges;
}

Colour colour_mix(Colour a, Colour b, double share)
{
    return (Colour){a.r + share * (b.r - a.r), a.g + share * (b.g - a.g), a.b + share * (b.b - a.b)};
}

Colour colour_at(const ColourMap *map, double s)
{
    const double place = fmin(fmax(s, 0), 1) * (STOPS - 1);
    const int k = place < STOPS - 1 ? (int)place : STOPS - 2;
    return colour_mix(from_hex(map->stops[k]), from_hex(map->stops[k + 1]), place - k);
}

static double linear(double c)
{
    return c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
}

double colour_lightness(Colour colour)
{
    const double y = 0.2126 * linear(colour.r) + 0.7152 * linear(colour.g) + 0.0722 * linear(colour.b);
    return y > 216.0 / 24389 ? 116 * cbrt(y) - 16 : y * 24389 / 27;
}

static bool same(Colour a, Colour b)
{
    return a.r == b.r && a.g == b.g && a.b == b.b;
}

static bool taken(Colour colour, size_t n, const Colour colours[], const bool has[])
{
    for (size_t k = 0; k < n; k++)
        if (has[k] && same(colours[k], colour)) return true;
    return false;
}

/* Whether the word occurs as a whole: "air" is in "hot-air" and in "air2", not in "dairy". */
static bool says(const char *name, const char *word)
{
    const size_t length = strlen(word);
    for (const char *at = name; (at = strcasestr(at, word)); at++) {
        const bool begins = at == name || !strchr("abcdefghijklmnopqrstuvwxyz", at[-1] | 32);
        const bool ends = !at[length] || !strchr("abcdefghijklmnopqrstuvwxyz", at[length] | 32);
        if (begins && ends) return true;
    }
    return false;
}

void colour_fluids(size_t n, const char *const names[], Colour colours[])
{
    enum { MOST = 64 };
    bool has[MOST] = {false};
    if (n > MOST) n = MOST;
    for (size_t k = 0; k < n; k++)
        for (size_t w = 0; w < sizeof known / sizeof *known && !has[k]; w++) {
            const Colour wanted = from_hex(known[w].colour);
            if (!says(names[k], known[w].word) || taken(wanted, n, colours, has)) continue;
            colours[k] = wanted;
            has[k] = true;
        }
    for (size_t k = 0, next = 0; k < n; k++) {
        if (has[k]) continue;
        while (next < PALETTE && taken(from_hex(palette[next]), n, colours, has)) next++;
        colours[k] = from_hex(palette[next < PALETTE ? next : k % PALETTE]);
        has[k] = true;
    }
}
