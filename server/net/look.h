/* SPDX-License-Identifier: BSD-3-Clause */
/* Questions about the simulation between two steps: probes, fields at points, particles of a box. */
#ifndef NET_LOOK_H
#define NET_LOOK_H

#include "net/exchange.h"

/* A reply's arrays; coordinates of the points of one question, which fit into a request. */
enum { LOOK_BYTES = 64 << 20, LOOK_COORDINATES = 114000 };

/* Put the result into the exchange. MNS_OK; MNS_E_INVALID, MNS_E_NOT_FOUND, MNS_E_LIMIT, MNS_E_MEMORY. */
MnsStatus look_probes(const MnsSim *sim, const Meniscus__ProbeQuery *query, Exchange *exchange, MnsError *error);
MnsStatus look_points(const MnsSim *sim, const Meniscus__PointQuery *query, Exchange *exchange, MnsError *error);
MnsStatus look_particles(const MnsSim *sim, const Meniscus__ParticleQuery *query, Exchange *exchange, MnsError *error);

#endif
