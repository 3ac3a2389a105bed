#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Toe of the inviscid, incompressible 2D dam break at early times, by boundary elements.

Water 0<x<2, 0<y<1 (H=g=1) at rest, gate removed at t=0, p=0 on the whole free surface, slip
floor y=0, slip wall x=0.  Mixed Eulerian-Lagrangian: floor and wall enter by images, so only
the free surface is discretised (top + face, one curve).  dphi/dn from the direct boundary
integral with linear elements, every segment integral exact; tangential derivatives by cubic
splines; RK4; regridding every step on a least-squares cubic spline (which removes grid-scale
modes), nodes graded by curvature and by distance from the toe.

The toe is a corner only because the image gravity has a kink, -|y|.  It is rounded,
|y| -> sqrt(y^2+eps^2), eps = max(eps0, c t^2), which makes the toe a smooth point of a symmetric
curve; the top corner is rounded with radius rc.  Results are taken at three (eps0, c), each half
of the last, and extrapolated to eps=0.  R multiplies the number of nodes.  c > 0 changes the
potential energy in time, so dE/KE is a check of the scheme only with c=0 (then < 1e-4).

Checked, at t = 0.5, by halving eps (differences halve), 1 to 3 times the nodes (1e-5), half the step (1e-5), and by a Lagrangian
finite-element computation without potential or boundary integral (0.3143 at 1/333 to 0.3145 here). The toe then is 9.5 % ahead
of the finite-volume computation at H/95, which is not converged so early (0.2743 at H/48, 0.2847 at H/95).

Prints dam_break_early.csv; about a minute and a half. Needs python3-numpy and python3-scipy.
"""
import sys

import numpy as np
from scipy.interpolate import CubicSpline, make_lsq_spline
from scipy.linalg import solve

TIMES = (0.1, 0.2, 0.3, 0.4, 0.5, 0.75, 1.0)
HEIGHTS = (1/160, 1/80, 1/40, 1/20, 1/10)
W = 2.0
EVEN, ODD = (1, 0.0), (2, 0.0)     # spline end conditions about a symmetry line


def matrices(z):
    """S q = int ln(r) q ds, D f = int d ln(r)/dn f ds, with the images in x=0 and y=0"""
    n = len(z)
    dz = np.diff(z)
    L = np.abs(dz)
    e = dz/L
    s = L[None, :]
    S0, S1, D0, D1 = (np.zeros((n, n-1)) for _ in range(4))
    for p in (z, z.conj(), -z, -z.conj()):
        w = (p[:, None] - z[None, :-1])/e[None, :]       # local frame of the segment, 0..L
        v = w - s
        at1, at2 = np.abs(w) < 1e-13, np.abs(v) < 1e-13
        lw, lv = np.log(np.where(at1, 1, w)), np.log(np.where(at2, 1, v))
        K0 = lw - lv
        K1 = w*K0 - s
        end = at1 | at2
        D0 += np.where(end, 0, K0.imag)
        D1 += np.where(end, 0, K1.imag)
        S0 += (w*lw - v*lv).real - s
        S1 += ((s*s - w*w)*lv/2 + w*w*lw/2 - w*s/2).real - s*s/4
    S, D = np.zeros((n, n)), np.zeros((n, n))
    S[:, :-1] += S0 - S1/s
    S[:, 1:] += S1/s
    D[:, :-1] += D0 - D1/s
    D[:, 1:] += D1/s
    return S, D


def arc(z):
    return np.concatenate(([0], np.cumsum(np.abs(np.diff(z)))))


def splines(z, phi):
    s = arc(z)
    return (s, CubicSpline(s, z.real, bc_type=(ODD, EVEN)), CubicSpline(s, z.imag, bc_type=(EVEN, ODD)),
            CubicSpline(s, phi, bc_type=(EVEN, EVEN)))


def velocity(z, phi):
    """complex velocity u+iv of the nodes and dphi/dn"""
    s, X, Y, P = splines(z, phi)
    d = X(s, 1) + 1j*Y(s, 1)
    m = np.abs(d)
    S, D = matrices(z)
    q = solve(S, D@phi - D.sum(1)*phi, check_finite=False)
    u = d/m*(P(s, 1)/m + 1j*q)
    u[0] = 1j*u[0].imag
    u[-1] = u[-1].real
    return u, q


def integrals(z, phi, q, eps):
    """area, potential energy, kinetic energy"""
    s, X, Y, _ = splines(z, phi)
    h = np.diff(s)
    g, wg = np.polynomial.legendre.leggauss(4)
    x = s[:-1, None] + h[:, None]*(g+1)/2
    w = h[:, None]*wg/2*X(x, 1)
    y = Y(x)
    f = CubicSpline(s, phi*q)
    return (np.sum(w*y), np.sum(w*(y*np.sqrt(y*y+eps*eps) + eps*eps*np.arcsinh(y/eps))/2),
            0.5*f.integrate(0, s[-1]))


class Grid:
    def __init__(self, R=1.0, eps=2e-3, c=0.0, kcurv=0.2, grow=0.12, hmax=0.06, toe=0.03):
        self.R, self.e0, self.c, self.kcurv, self.grow, self.hmax, self.toe = R, eps, c, kcurv, grow, hmax, toe

    def eps(self, t):
        return max(self.e0, self.c*t*t)

    def nodes(self, t, s, kappa, hmin):
        """arclength positions of the nodes; s, kappa sample the curve finely"""
        S = s[-1]
        cap = min(max(self.eps(t)/3, self.toe*t*t), 0.01)
        xs = np.unique(np.r_[np.linspace(0, S, 3000), S*(1 - np.geomspace(1e-6, 0.3, 1000)), s[::2], S])
        k = np.interp(xs, s, kappa)
        h = np.minimum(np.minimum(self.hmax, cap + self.grow*(S-xs)),
                       np.maximum(self.kcurv/np.maximum(k, 1e-9), hmin))
        dx = self.grow*np.diff(xs)
        for i in range(len(dx)):
            h[i+1] = min(h[i+1], h[i] + dx[i])
        for i in range(len(dx)-1, -1, -1):
            h[i] = min(h[i], h[i+1] + dx[i])
        f = self.R/h
        c = np.concatenate(([0], np.cumsum((f[1:]+f[:-1])/2*np.diff(xs))))
        if not c[-1] < 3000:
            raise RuntimeError("surface lost (%g nodes)" % c[-1])
        n = int(np.ceil(c[-1]))
        x = np.interp(np.arange(n+1)*c[-1]/n, c, xs)
        x[0], x[-1] = 0, S
        return x


def lsq(f, stride=2):
    n = len(f)
    m = int(round((n-1)/stride))
    return make_lsq_spline(np.arange(n, dtype=float), f, np.r_[[0]*3, np.linspace(0, n-1, m+1), [n-1]*3], 3)


def regrid(z, phi, t, G):
    n = len(z)
    # continue both ends by symmetry; m extra nodes are enough
    m = min(n-1, 24)
    z2 = np.r_[-np.conj(z[m:0:-1]), z, np.conj(z[-2:-m-2:-1])]
    p2 = np.r_[phi[m:0:-1], phi, phi[-2:-m-2:-1]]
    X, Y, P = lsq(z2.real), lsq(z2.imag), lsq(p2)
    xi = np.linspace(m, m+n-1, 8*(n-1)+1)
    s = arc(X(xi) + 1j*Y(xi))
    d1, d2 = X(xi, 1) + 1j*Y(xi, 1), X(xi, 2) + 1j*Y(xi, 2)
    xn = CubicSpline(s, xi)(G.nodes(t, s, np.abs((np.conj(d1)*d2).imag)/np.abs(d1)**3, G.eps(t)/10))
    zn, pn = X(xn) + 1j*Y(xn), P(xn)
    zn[0] = 1j*zn[0].imag
    zn[-1] = zn[-1].real
    return zn, pn


def start(G, rc):
    """rectangle with the top corner rounded"""
    s = np.linspace(0, W + 1 - 2*rc + np.pi/2*rc, 40001)
    a, b = W - rc, W - rc + np.pi/2*rc
    th = (s-a)/rc
    z = np.where(s < a, s + 1j, np.where(s < b, a + rc*np.sin(th) + 1j*(1 - rc + rc*np.cos(th)),
                                         W + 1j*(1 - rc - (s-b))))
    x = G.nodes(0.0, s, np.where((s > a) & (s < b), 1/rc, 0.0), G.e0/10)
    z = np.interp(x, s, z.real) + 1j*np.interp(x, s, z.imag)
    z[-1] = W
    return z


def run(R=1.0, eps=2e-3, c=0.0, tend=1.0, rc=0.02, cfl=0.4, times=TIMES, G=None, verbose=True, each=None):
    G = G or Grid(R, eps, c)
    z = start(G, rc)
    phi = np.zeros(len(z))
    A0, V0, _ = integrals(z, phi, phi, G.eps(0))
    todo = [t for t in times if t <= tend + 1e-9]
    out = []
    t, k = 0.0, 0

    def rate(z, p, t):
        u, q = velocity(z, p)
        return u, 0.5*np.abs(u)**2 - np.sqrt(z.imag**2 + G.eps(t)**2)
    while todo:
        h = np.min(np.abs(np.diff(z)))
        acc = 1 + 0.64*np.log(1/max(G.eps(t), 0.1*t*t))            # estimate of |grad p| at the toe
        dt = min(0.02/R, cfl*2.8*np.sqrt(h/(np.pi*acc)))
        hit = t + dt*1.001 >= todo[0]
        if hit:
            dt = todo[0] - t
        elif t + 2*dt > todo[0]:
            dt = (todo[0] - t)/2
        k1 = rate(z, phi, t)
        k2 = rate(z + dt/2*k1[0], phi + dt/2*k1[1], t + dt/2)
        k3 = rate(z + dt/2*k2[0], phi + dt/2*k2[1], t + dt/2)
        k4 = rate(z + dt*k3[0], phi + dt*k3[1], t + dt)
        z = z + dt/6*(k1[0] + 2*k2[0] + 2*k3[0] + k4[0])
        phi = phi + dt/6*(k1[1] + 2*k2[1] + 2*k3[1] + k4[1])
        t += dt
        k += 1
        if each:
            each(t, z, phi)
        if hit:
            t = todo.pop(0)
            u, q = velocity(z, phi)
            A, V, K = integrals(z, phi, q, G.eps(t))
            s, X, Y, _ = splines(z, phi)
            ss = np.unique(np.r_[np.linspace(0, s[-1], 20001), s])
            xx, yy = X(ss), Y(ss)
            xs = []
            for h in HEIGHTS:                   # foremost place where the surface is at height h
                j = np.nonzero((yy[:-1]-h)*(yy[1:]-h) <= 0)[0]
                xs.append(np.max(xx[j] + (h-yy[j])/(yy[j+1]-yy[j])*(xx[j+1]-xx[j])) - W)
            out.append(dict(t=t, toe=z[-1].real-W, u=u[-1].real, dA=A/A0-1, dE=(K+V-V0)/K, xs=xs,
                            n=len(z), steps=k, z=z.copy()))
            if verbose:
                o = out[-1]
                print("  t=%.2f toe=%.5f u=%.4f dA/A=%.0e dE/KE=%.0e N=%d steps=%d"
                      % (t, o['toe'], o['u'], o['dA'], o['dE'], o['n'], k), file=sys.stderr, flush=True)
        z, phi = regrid(z, phi, t, G)
    return out


HEAD = """\
# quantity: toe of the dam break, column 2H x H, inviscid and incompressible, vacuum outside, slip floor; potential flow, exact
# units: H=1, g=1: t sqrt(g/H); toe = (x_toe - 2H)/H on the floor; h_N = (x - 2H)/H where the layer is H/N thick, what particles of spacing H/N can show
# source: tests/reference/dam_break_bem.py; uncertainty 0.3 % to t = 0.75, 0.4 % at t = 1"""


def main():
    runs = []
    for R, eps, c in ((1.5, 4e-3, 0.02), (1.5, 2e-3, 0.01), (1.5, 1e-3, 0.005)):
        print("R=%g eps=max(%g, %g t^2)" % (R, eps, c), file=sys.stderr)
        rows = run(R, eps, c)
        runs.append(np.array([np.r_[o['toe'], o['xs']] for o in rows]))
    a, b, c = runs
    limit = 2*c - b                                   # first order in eps
    ratio = np.clip((c[:, 0]-b[:, 0])/(b[:, 0]-a[:, 0]), 0.5, 0.65)
    limit[:, 0] = c[:, 0] + (c[:, 0]-b[:, 0])*ratio/(1-ratio)
    print(HEAD)
    print("t,toe," + ",".join("h_%d" % round(1/h) for h in HEIGHTS))
    for o, x in zip(rows, limit):
        print("%g," % o['t'] + ",".join("%.4f" % value for value in x))


if __name__ == "__main__":
    main()
