#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The steady flow of two layers between plates that operators of diffusion have on a lattice, for P5/poiseuille_rows.csv.

L u = -1 by P5's operators as sums over the rows of an endless lattice, 40 or more between the plates, of the quintic spline with
h = 0.9 dx; u is exact in the rows beyond. P5/poiseuille_steady_flow_error.csv has the same in a square whose sides hold the exact
flow as well, which halves the error or more; on rectangles 1, 2 and 4 wide (h = dx/1.2) that of div tau is 0.019, 0.031, 0.043 and here
0.055."""

from pathlib import Path

import numpy as np

H = 0.9
REACH = 3


def kernel(q: np.ndarray) -> np.ndarray:
    return sum(c * np.maximum(a - q, 0) ** 5 for c, a in ((1, 3), (-6, 2), (15, 1)))


def exact(ratio: float, y: np.ndarray) -> np.ndarray:
    slope = (ratio - 1) / (2 * (ratio + 1))
    return (slope * y - y**2 / 2) / np.where(y < 0, ratio, 1) + 1 / (1 + ratio)


def errors(ratio: float, rows: int) -> dict[str, float]:
    dx = 2 / rows
    k = np.arange(-2 * REACH, rows + 2 * REACH)
    y = -1 + (k + 0.5) * dx
    across = np.subtract.outer(y, y)  # of row i and row j
    x = np.arange(-REACH, REACH + 1) * dx
    r = np.sqrt(across[..., None] ** 2 + x**2)
    W = kernel(r / (H * dx))
    self_weight = W * (r < 1e-9)
    near = (W - self_weight).sum(-1)
    share = (W.sum(-1) * (y < 0)).sum(1) / W.sum(-1).sum(1)
    mu = 1 + (ratio - 1) * share
    laplacian = 4 * near / ((W * r**2).sum((1, 2)))[:, None]
    gradient = -near * across / (near * across**2).sum(1)[:, None]  # times u_j - u_i
    mean = 2 * np.multiply.outer(mu, mu) / np.add.outer(mu, mu)
    slope = (ratio - 1) * (gradient * (share[None, :] - share[:, None])).sum(1)
    operators = {"harmonic": laplacian * mean, "divtau": laplacian * mu[:, None] + slope[:, None] * gradient}
    fluid = (k >= 0) & (k < rows)
    u = exact(ratio, y)
    found = {}
    for name, of in operators.items():
        matrix = of - np.diag(of.sum(1))
        v = np.linalg.solve(matrix[np.ix_(fluid, fluid)], -1 - matrix[np.ix_(fluid, ~fluid)] @ u[~fluid])
        found[name] = float(np.sqrt(np.mean((v - u[fluid]) ** 2) / np.mean(u[fluid] ** 2)))
    return found


def write(name: str, head: list[str], columns: str, rows: list[tuple[float, int]]) -> None:
    head = [f"# {line}" for line in (*head, "source: poiseuille_rows.py")]
    lines = [*head, columns]
    for ratio, n in rows:
        found = errors(ratio, n)
        first = f"{ratio:g},{n}" if "rows" in columns else f"{ratio:g}"
        lines.append(f"{first},{found['harmonic']:.5g},{found['divtau']:.5g}")
    (Path(__file__).parent / name).write_text("\n".join(lines) + "\n", encoding="utf-8")


def main() -> None:
    what = "quantity: relative L2 error of the steady velocity of two layers between plates, by operators of diffusion on a lattice"
    units = "units: [-]; X: ratio of viscosities; harmonic: P5 eq. 12; divtau: P5 eq. 19"
    write("P5/poiseuille_rows.csv", [what, units], "X,harmonic,divtau", [(x, 40) for x in (1, 1.3, 2, 5, 10, 20, 50, 100)])
    write("P5/poiseuille_rows_refined.csv", [what, f"{units}; rows: between the plates"], "X,rows,harmonic,divtau",
          [(x, n) for x in (1.3, 2, 5, 100) for n in (20, 40, 80, 160, 320)])


if __name__ == "__main__":
    main()
