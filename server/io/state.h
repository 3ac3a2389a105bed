/* SPDX-License-Identifier: BSD-3-Clause */
/* The group /state of a checkpoint: a capture, bit for bit, each part with its checksum.
 *
 *  /state        attributes dim, n, n_fluid, spacing, t, dt, dt_first, step, rebuilds, guarded; xxh64 of these
 *  /state/FIELD  [components][n] in storage order; attributes unit, meaning, xxh64 of the values
 *  /energy       the account of energy, of runs that have one: attributes start, work, excess, scale, potential, power, gravity_x to gravity_z; xxh64 of
 *                these. Files from before there was one do without, and the account begins anew. */
#ifndef IO_STATE_H
#define IO_STATE_H

#include "io/h5.h"

void state_put(H5 *h, const MnsCapture *state);

/* Raises MNS_E_CORRUPT if a checksum does not match, MNS_E_VERSION if the fields are not those of this program.
 * @return the capture, yours; NULL after a failure. */
MnsCapture *state_get(H5 *h);

#endif
