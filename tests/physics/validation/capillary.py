# SPDX-License-Identifier: BSD-3-Clause
"""Exact answers of small motions under tension."""

from __future__ import annotations

import numpy as np


def standing_wave(t: np.ndarray, k: float, nu: float, tension: float, below: float, above: float, height0: float = 1, speed0: float = 0) -> np.ndarray:
    """Height of a capillary wave between two deep liquids of one kinematic viscosity, which begins with this height [m] and speed [m/s], without vorticity.

    A. Prosperetti, Phys. Fluids 24 (1981) 1217, eq. 22. k [1/m], nu [m^2/s], tension [N/m], densities [kg/m^3].
    """
    from scipy.special import wofz  # python3-scipy

    beta, omega2, d = below * above / (below + above) ** 2, tension * k**3 / (below + above), nu * k * k
    z = np.roots([1, -4 * beta * np.sqrt(d), 2 * (1 - 6 * beta) * d, 4 * (1 - 3 * beta) * d**1.5, (1 - 4 * beta) * d * d + omega2])
    height = height0 * 4 * (1 - 4 * beta) * d * d / (8 * (1 - 4 * beta) * d * d + omega2) * erfc(np.sqrt(d * t), wofz) + 0j
    for i in range(4):
        others = np.prod([z[j] - z[i] for j in range(4) if j != i])
        # exp((z^2 - d) t) erfc(z sqrt t) = exp(-d t) w(i z sqrt t), which does not overflow
        height = height + z[i] / others * (omega2 * height0 / (z[i] ** 2 - d) - speed0) * np.exp(-d * t) * wofz(1j * z[i] * np.sqrt(t))
    return np.real(height)


def erfc(x: np.ndarray, wofz) -> np.ndarray:
    return np.real(np.exp(-x * x) * wofz(1j * x))


def drop_frequency(n: int, dim: int, R: float, tension: float, inside: float, outside: float) -> float:
    """Of the swing n of a drop in another fluid, without viscosity [1/s].  H. Lamb, Hydrodynamics, art. 275; in the plane n (n^2 - 1) over both densities."""
    if dim == 2:
        return float(np.sqrt(n * (n * n - 1) * tension / ((inside + outside) * R**3)))
    return float(np.sqrt(n * (n + 1) * (n - 1) * (n + 2) * tension / (((n + 1) * inside + n * outside) * R**3)))


def drop_damping(n: int, dim: int, nu: float, omega: float, outside: float) -> float:
    """Of the swing n of a drop of radius and density 1 in a fluid of this density and as kinematic a viscosity [1/s]: Lamb's, and what the boundary layer around it takes.
    A. Prosperetti, J. Fluid Mech. 100 (1980) 333, for small viscosities; in the plane from the same jump of the velocity along the surface, 2/n for 1/n + 1/(n + 1)."""
    inner, outer = np.sqrt(nu), outside * np.sqrt(nu)  # sqrt(mu rho)
    layer = np.sqrt(omega) * inner * outer / (inner + outer) / (2 * np.sqrt(2))
    if dim == 2:
        return float(2 * n * (n - 1) * nu + 4 * n * layer / (1 + outside))
    return float((n - 1) * (2 * n + 1) * nu + (2 * n + 1) ** 2 * layer / (n * outside + n + 1))
