/* SPDX-License-Identifier: BSD-3-Clause */
/* Colours for numbers and for fluids that colour-blind readers and grey printers can tell apart. */
#ifndef CLI_RENDER_COLOUR_H
#define CLI_RENDER_COLOUR_H

#include <stdbool.h>
#include <stddef.h>

typedef struct Colour {
    double r, g, b; /* sRGB, 0 to 1 */
} Colour;

typedef struct ColourMap ColourMap;

/* Colour map k, from 0; NULL if there are no more. */
const ColourMap *colour_map(size_t k);

/* The map of that name; NULL if there is none. */
const ColourMap *colour_map_find(const char *name);

const char *colour_map_name(const ColourMap *map);

/* Whether the middle of the map means zero. */
bool colour_map_diverges(const ColourMap *map);

/* Colour at s between 0 and 1; what is outside gets the colour of that end. */
Colour colour_at(const ColourMap *map, double s);

/* Colours of n fluids: by what their names say (water is blue, gases are pale), then by what is left; no two are the
 * same for up to 16 fluids. */
void colour_fluids(size_t n, const char *const names[], Colour colours[]);

/* CIE lightness of a colour, 0 (black) to 100 (white). */
double colour_lightness(Colour colour);

Colour colour_mix(Colour a, Colour b, double share_of_b);

#endif
