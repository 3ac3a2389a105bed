/* SPDX-License-Identifier: BSD-3-Clause */
/* What there is to draw: particles of one moment, wherever they came from. */
#ifndef CLI_RENDER_FRAME_H
#define CLI_RENDER_FRAME_H

#include <meniscus/client.h>
#include <stdbool.h>
#include <stddef.h>

enum { FRAME_MAX_FLUIDS = 16, FRAME_NAME = 64 };

typedef struct Frame {
    char title[256];
    double time, spacing; /* [s], [m] */
    int dim;              /* 2 or 3 */
    size_t n, n_fluid;    /* fluid particles first, walls behind */
    size_t n_fluids;
    char fluids[FRAME_MAX_FLUIDS][FRAME_NAME];
    double (*x)[3]; /* [n], m */
    int *phase;     /* [n]: index of the fluid; n_fluids and above for walls */
    double *value;  /* [n]: the field, of a vector its magnitude; NULL when only phases are drawn */
    double *weight; /* [n]: density, to tell heavy from light fluids; NULL if unknown */
    char field[FRAME_NAME], unit[FRAME_NAME];
    bool is_magnitude;
    bool has_domain;
    double domain[2][3]; /* corners of the case's domain [m], if it is known */
    double gravity[3];   /* of the case, where it is a number [m/s^2]; 0 if it is not known */
} Frame;

/* Read a snapshot. field: its name, or "phase" for none but the phases. MNS_E_NOT_FOUND if there is no such file or
 * field: the sentence lists the fields there are; MNS_E_CORRUPT if the file is not a snapshot. On failure *ret needs
 * no frame_done(). */
MnsStatus frame_read_file(const char *path, const char *field, Frame *ret, MnsError *error);

/* Ask a daemon. MNS_E_UNAVAILABLE if nobody answers. */
MnsStatus frame_read_daemon(MnsClient *client, const char *field, bool walls, Frame *ret, MnsError *error);

/* Room for n particles; value and weight are left to those who have them. */
MnsStatus frame_init(Frame *frame, size_t n, MnsError *error);

void frame_done(Frame *frame);

/* Magnitudes of n vectors, or the numbers themselves if there is one component. */
void frame_magnitude(size_t n, int components, const double *vectors, double *values);

/* "[0, -9.81]", as the case has it, as numbers; of a formula the number it begins with. How many there were, at most 3. */
int frame_vector(const char *text, double ret[3]);

/* The first `dim` coordinates of the domain's corners, unless they make no sense. */
void frame_take_domain(Frame *frame, const double min[3], const double max[3]);

/* Index of the fluid of largest mean density; the first fluid if densities are unknown. */
size_t frame_heaviest(const Frame *frame);

#endif
