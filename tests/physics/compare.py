#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Run the same cases under every scheme, and lay what comes out side by side.

Writes tests/physics/COMPARISON.md: a table for each case with a row for each scheme, its accuracy, its noise and what it takes. A
scheme that cannot do a case has the solver's own words for why. A run that is already in the build directory, made by the same
program from the same case, is not run again, unless it did not come to its end.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from validation import bubbles, dam_breaks, differences, drops, incompressible, interfaces, jobs, rest, sloshing
from validation.common import NEAR, grain
from validation.metrics import Metric, commit
from validation.runs import ROOT, Run, Snapshot, load, run, told

REPORT = Path(__file__).parent / "COMPARISON.md"
COST = ("particles", "steps", "ns per particle and step", "processor s", "wall s", "verdict")


# --- what is asked of the cases ---------------------------------------------------------------------------------------------


def at_rest(case: str, r: Run) -> Iterator[Metric]:
    yield from rest.score_rest(case, r)
    yield Metric(case, "grain of the water's pressure / (rho g H)", grain(r.last(), 0) / (1000 * 9.81 * 0.5))


def dam_break(case: str, r: Run) -> Iterator[Metric]:
    yield Metric(case, "largest toe error", dam_breaks.largest_toe_error(r))
    t, toe, reference = dam_breaks.toes(r)[-1]
    yield Metric(case, f"toe / H at t* = {t}", toe, reference)
    yield from dam_breaks.mean_pressures(case, r, 0.12)
    yield Metric(case, "roughness of P19, 3 < t* < 5.5", dam_breaks.roughness(r, "P19"))


def largest_errors(metrics: Sequence[Metric]) -> tuple[float, float]:
    """Of the metrics with a reference: of those with a relative tolerance, in parts of it, and of the others."""
    known = [m for m in metrics if m.reference is not None]
    return (max(abs(m.value / m.reference - 1) for m in known if m.relative),
            max(abs(m.value - m.reference) for m in known if not m.relative))


def layer(case: str, r: Run) -> Iterator[Metric]:
    *crests, theory = sloshing.score_one_layer(case, r, full=False)
    height, time = largest_errors(crests)
    yield Metric(case, "largest error of the height of a crest or trough", height)
    yield Metric(case, "largest error of its time [s]", time)
    yield theory
    yield Metric(case, "grain of the pressure / (rho g h)", grain(r.last(1), 0) / (1000 * 9.81 * sloshing.STILL))


def static_drop(case: str, r: Run) -> Iterator[Metric]:
    yield from drops.score_static(case, r, 0.2 / 50)


def hysing(case: str, r: Run) -> Iterator[Metric]:
    yield from bubbles.score_hysing(case, r, full=False)
    yield Metric(case, "grain of the liquid's pressure [Pa]", grain(r.last(), 0))


def rayleigh_taylor(case: str, r: Run) -> Iterator[Metric]:
    yield Metric(case, "largest error of the highest point, t = 1, 2, 3", interfaces.largest_tip_error(r))
    yield from (m for m in interfaces.score_tips(case, r, full=False) if m.name.endswith("t = 5"))
    yield Metric(case, "grain of the heavy fluid's pressure [Pa]", grain(r.last(), 0))


def spikes(case: str, r: Run) -> Iterator[Metric]:
    yield from interfaces.score_spikes(case, 0.5, r, full=False)


def fronts(case: str, r: Run) -> Iterator[Metric]:
    yield from interfaces.score_fronts(case, interfaces.front_speeds(r), full=False)


def flat(case: str, r: Run) -> Iterator[Metric]:
    yield from rest.score_flat(case, r, 0.2 / 50)
    yield Metric(case, "grain of the liquid's pressure / (rho g H)", grain(r.last(), 0) / (1000 * 9.81 * 0.1))


def drift(case: str, r: Run) -> Iterator[Metric]:
    yield from rest.score_drift(case, r)
    energy = r.probes["kinetic"]
    yield Metric(case, "kinetic energy: largest change / start", float(abs(energy / energy[0] - 1).max()))
    yield Metric(case, "grain of the drop's pressure [Pa]", grain(r.last(), 0))


def three_layers(case: str, r: Run) -> Iterator[Metric]:
    height, time = largest_errors(list(sloshing.score_layers_slice(case, r, full=False)))
    yield Metric(case, "largest error of the height of a crest", height)
    yield Metric(case, "largest error of its time [s]", time)
    yield Metric(case, "grain of the water's pressure / (rho g h)", grain(r.last(3), 1) / (1000 * 9.81 * sloshing.REST["fs"]))


def between_plates(case: str, r: Run) -> Iterator[Metric]:
    s = r.last()
    yield Metric(case, "error of the profile", differences.profile_error(5, s))
    for k, name in enumerate(("thick", "thin")):
        own = s.phase == k
        yield Metric(case, f"the same in the {name} layer", differences.profile_error(5, replace(s, x=s.x[own], velocity=s.velocity[own])))


def kicked(case: str, r: Run) -> Iterator[Metric]:
    yield from incompressible.score_quarter(case, r, paper=False)
    yield Metric(case, "grain of the drop's pressure / Laplace's jump", grain(r.last(), 0) / (1 / 0.1875))


def vortices(case: str, r: Run) -> Iterator[Metric]:
    yield Metric(case, "L_inf error of the greatest speed", incompressible.decay_error(r))
    for t in (1, 2, 4):
        exact = 0.25 * np.exp(-16 * np.pi**2 * 0.01 * t)
        yield Metric(case, f"kinetic energy at t = {t} [J/m]", r.at("kinetic", t), exact, 0.1, relative=True)
    yield Metric(case, "density, least to greatest, over its mean", float(r.at("density_greatest", 2) - r.at("density_least", 2)))


# --- the cases, and how each scheme is told to do them ----------------------------------------------------------------------


@dataclass
class Comparison:
    """A case, and the schemes with the options that it takes; kernel and smoothing are each scheme's own."""

    case: str
    settings: tuple[str, ...]
    schemes: tuple[tuple[str, str], ...]  # name, options
    score: Callable[[str, Run], Iterator[Metric]]
    needs: float = np.inf  # time to which a run must have come for its metrics [s]; to its end, if not said


@dataclass
class Ladder:
    """Two comparisons of one case that differ in resolution, coarse and fine. Their first metric is an error."""

    coarse: str
    fine: str


# What all schemes can be asked for; the speed of sound is for those that have one, ten times the fastest.
VORTICES = ("fluids[0].sound_speed=10", "probes=[{name: speed, extremum: {field: velocity}}, {name: kinetic, kinetic_energy: {}},"
            " {name: density_least, extremum: {field: density, which: min}}, {name: density_greatest, extremum: {field: density}}]")

KICKED = ("probes=[{name: x_q, mass_centre: {fluid: drop, axis: x, within: {min: [0.5, 0.5], max: [1, 1]}}},"
          " {name: kinetic, kinetic_energy: {}}, {name: speed, extremum: {field: velocity}}]")

# The gauge of the other schemes: no pressure at the lid.
AIR_IS_ZERO = "zero_pressure: [0.5, 1]"

PRESSED = "background_pressure: 1"  # as its case has it

# All schemes start from the same lattice, as it is: P4 would move back what was moved.
UNMOVED_2D = ('domain.displacement=["0", "0"]', 'fluids[1].shape=[{formula: "y < 1 - 0.150001*sin(2*pi*x)"}]')
UNMOVED_3D = ('domain.displacement=["0", "0", "0"]', 'fluids[1].shape=[{formula: "z > 2 + 0.05*(cos(2*pi*x) + cos(2*pi*y))"}]')

# At a ratio of 1000 dissipation averages by density: with arithmetic averages it takes four times the steps.
COMPARISONS = {
    **{f"Taylor-Green vortices, {n} particles a side": Comparison(
        "taylor-green2d", (f"resolution={n}", "domain.disorder=0", *VORTICES),
        (("riemann", ""), ("dissipation", "background_pressure: 2"), ("dissipation", "background_pressure: 2, gradient_correction: true"),
         ("interfacial", "background_pressure: 2"), ("interfacial", "background_pressure: 2, gradient_correction: true"),
         ("incompressible", "reference_speed: 1, gauge: mean"), ("differences", "reference_speed: 1")), vortices) for n in (30, 60)},
    "Water under air at rest, ratio 1000": Comparison(
        "hydrostatic", ("resolution=40",),
        (("riemann", ""), ("dissipation", "pair_average: density"), ("interfacial", ""), ("incompressible", ""), ("differences", AIR_IS_ZERO),
         ("differences", f"{AIR_IS_ZERO}, shift_across_interfaces: false")), at_rest),
    "Water under a liquid at rest, ratio 10": Comparison(
        "hydrostatic", ("resolution=40", "fluids[1].density=100", "constants[3].value=100"),
        (("riemann", ""), ("dissipation", ""), ("dissipation", "pair_average: density"), ("interfacial", ""),
         ("incompressible", ""), ("differences", AIR_IS_ZERO),
         ("differences", f"{AIR_IS_ZERO}, shift_across_interfaces: false")), at_rest),
    "A flat interface with tension, ratio 1000": Comparison(
        "flat-interface2d", ("resolution=50",),
        (("riemann", ""), ("dissipation", "pair_average: density, background_pressure: 70, repulsion: 0"),
         ("interfacial", "background_pressure: 70"), ("incompressible", ""), ("differences", "zero_pressure: [0.1, 0.2]")), flat),
    "A drop at rest under its tension, ratio 1000": Comparison(
        "static-drop2d", ("resolution=50",),
        (("riemann", ""), ("dissipation", "pair_average: density, background_pressure: 35, repulsion: 0"),
         ("interfacial", "background_pressure: 35"), ("incompressible", "reference_speed: 0.2"),
         ("differences", "reference_speed: 0.2"), ("differences", "reference_speed: 0.2, shift_across_interfaces: false")), static_drop),
    "A drop that drifts, without tension, ratio 1000": Comparison(
        "drop-periodic2d", ("resolution=40",),
        (("riemann", ""), ("dissipation", "pair_average: density"), ("interfacial", ""), ("incompressible", "reference_speed: 1"),
         ("differences", "reference_speed: 1")), drift),
    "A dam break under air, ratio 1000": Comparison(
        "dambreak2d", ("resolution=20", "output.probe_interval=0.005"),
        (("riemann", ""), ("dissipation", "pair_average: density, background_pressure: 0.05"), ("interfacial", ""), ("interfacial", "delta: 2"), ("incompressible", ""),
         ("differences", "zero_pressure: [2.683, 2]")), dam_break, needs=5.5),
    "Sloshing with a free surface": Comparison(
        "sloshing2d-single", ("resolution=20",),
        (("riemann", ""), ("dissipation", "repulsion: 0"), ("interfacial", ""), ("incompressible", ""), ("differences", "")), layer),
    "Three layers that slosh, with a free surface": Comparison(
        "sloshing2d-three-layers", ("end_time=2.1",),
        (("riemann", ""), ("dissipation", "repulsion: 0"), ("interfacial", ""), ("incompressible", ""), ("differences", "")), three_layers),
    "A lock exchange, ratio 1.5": Comparison(
        "lock-exchange2d", ("resolution=20",),
        (("riemann", ""), ("dissipation", "repulsion: 0, background_pressure: 500"),
         ("dissipation", "repulsion: 0, background_pressure: 500, gradient_correction: true"), ("interfacial", "background_pressure: 500"),
         ("interfacial", "background_pressure: 500, gradient_correction: true"), ("incompressible", ""), ("differences", "")), fronts),
    "Rayleigh-Taylor instability, ratio 1.8": Comparison(
        "rayleigh-taylor2d", ("resolution=50", *UNMOVED_2D),
        (("riemann", ""), ("dissipation", "background_pressure: 2"), ("dissipation", "background_pressure: 2, gradient_correction: true"),
         ("interfacial", "background_pressure: 2"), ("interfacial", "background_pressure: 2, gradient_correction: true"),
         ("incompressible", ""), ("differences", "")), rayleigh_taylor),
    "Rayleigh-Taylor instability in space, ratio 3": Comparison(
        "rayleigh-taylor3d", ("resolution=16", "end_time=2.55", *interfaces.CORNER, *UNMOVED_3D, f"fluids[0].density={interfaces.LIGHT[0.5]}"),
        (("riemann", ""), ("dissipation", f"repulsion: 0, {PRESSED}"), ("dissipation", f"repulsion: 0, {PRESSED}, gradient_correction: true"),
         ("interfacial", PRESSED), ("interfacial", f"{PRESSED}, gradient_correction: true"), ("incompressible", ""), ("differences", "")), spikes),
    "Two layers between plates, viscosities 5 : 1": Comparison(
        "poiseuille-two-phase", ("fluids[0].sound_speed=5", "fluids[1].sound_speed=5"),
        (("riemann", ""), ("dissipation", "repulsion: 0, background_pressure: 0.5"),
         ("dissipation", "repulsion: 0, background_pressure: 0.5, gradient_correction: true"), ("interfacial", "background_pressure: 0.5"),
         ("interfacial", "background_pressure: 0.5, gradient_correction: true"), ("incompressible", "reference_speed: 0.5"),
         *(("differences", f"reference_speed: 0.5, diffusion: {operator}") for operator in differences.OPERATORS)), between_plates),
    "A drop that swings in a liquid like itself": Comparison(
        "droplet-oscillation2d", ("fluids[0].sound_speed=20", "fluids[1].sound_speed=20", KICKED),
        (("riemann", ""), ("dissipation", "background_pressure: 8"), ("dissipation", "background_pressure: 8, gradient_correction: true"),
         ("interfacial", "background_pressure: 8"), ("interfacial", "background_pressure: 8, gradient_correction: true"),
         ("incompressible", "reference_speed: 1"), ("differences", "reference_speed: 1")), kicked),
    "A bubble that rises, ratio 10": Comparison(
        "bubble2d-hysing1", ("resolution=25",),
        (("riemann", ""), ("dissipation", "background_pressure: 800"),
         ("interfacial", "background_pressure: 800"),
         ("interfacial", "background_pressure: 800, gradient_correction: true"), ("incompressible", ""), ("differences", ""),
         ("differences", "shift_across_interfaces: false")), hysing),
}

LADDERS = {
    "Taylor-Green vortices, at equal cost": Ladder(*(f"Taylor-Green vortices, {n} particles a side" for n in (30, 60))),
}
FINE = {ladder.fine: title for title, ladder in LADDERS.items()}
ORDER = [one for title in COMPARISONS for one in (title, FINE.get(title)) if one]


# --- runs and tables --------------------------------------------------------------------------------------------------------


@dataclass
class Row:
    """What came of a case under a scheme."""

    scheme: str
    summary: dict
    metrics: list[Metric]  # none of a run that did not come far enough
    found: str = ""  # of a run that did not come to its end, what was found there

    @property
    def reason(self) -> str:
        """The first sentence of what the solver says, with the names of files as in the repository, and what was found."""
        message = self.summary["error"]["message"].replace(f"{ROOT}/", "")
        return re.split(r"\. (?=[A-Z])", message)[0] + self.found

    @property
    def verdict(self) -> str:
        code = self.summary.get("exit_code")
        if code == 0:
            return "done"
        if code == 70:
            return f"diverged at t = {self.summary['t']:.3g} of {self.summary['end_time']:.3g}"
        return "failed" if self.summary.get("steps") else "refused"

    def cost(self) -> list[str]:
        """What it took, as far as it came."""
        s = self.summary
        if not s.get("steps"):
            return ["-"] * (len(COST) - 1)
        each = 1e9 * s["cpu_s"] / (s["particles"] * s["steps"])
        return [str(s["particles"]), str(s["steps"]), f"{each:.0f}", f"{s['cpu_s']:.1f}", f"{s['wall_s']:.1f}"]


def densities(first: Snapshot, last: Snapshot) -> str:
    """What became of each fluid's, over what it was."""
    spans = []
    for k in np.unique(first.phase):
        span = last.density[last.phase == k] / np.mean(first.density[first.phase == k])
        spans.append(f"{np.nanmin(span):.3g} to {np.nanmax(span):.3g}")
    return "; densities over those of the start, fluid by fluid: " + "; ".join(spans)


def row(comparison: Comparison, scheme: str, options: str) -> Row:
    """One run. Its time is to be compared, so it has one thread, whatever goes on beside."""
    label = f"{scheme}, {options}" if options else scheme
    try:
        r = run(comparison.case, *comparison.settings, "threads=1", f"scheme={{{scheme}: {{{options}}}}}")
    except subprocess.CalledProcessError as error:
        summary = told(error)
        if not summary.get("steps"):
            return Row(label, summary, [])
        r = load(Path(summary["run_directory"]), summary)
        metrics = list(comparison.score(comparison.case, r)) if r.t[-1] >= comparison.needs else []
        shots = r.snapshots()
        return Row(label, summary, metrics, densities(shots[0], shots[-1]))
    return Row(label, r.summary, list(comparison.score(comparison.case, r)))


def section(title: str, comparison: Comparison, rows: Sequence[Row]) -> str:
    """The table of a case, and why there are gaps in it."""
    metrics = next((r.metrics for r in rows if r.metrics), [])
    references = ["-" if m.reference is None else f"{m.reference:.4g}" for m in metrics]
    lines = [["scheme", *(m.name for m in metrics), *COST], ["---"] * (1 + len(metrics) + len(COST))]
    if any(m.reference is not None for m in metrics):
        lines.append(["reference", *references, *[""] * len(COST)])
    for r in rows:
        values = [f"{m.value:.4g}" for m in r.metrics] or ["-"] * len(metrics)
        lines.append([r.scheme, *values, *r.cost(), r.verdict])
    reasons = [f"- {r.scheme}: {r.reason}" for r in rows if r.verdict != "done"]
    how = f"`{comparison.case}` with `{', '.join(comparison.settings)}`, commit {commit()}."
    table = "\n".join(f"| {' | '.join(line)} |" for line in lines)
    return "\n\n".join([f"## {title}", how, table, *(["\n".join(reasons)] if reasons else [])])


def power(coarse: Row, fine: Row) -> tuple[float, float]:
    """Of error = a cost^b through two runs: a and b, cost in seconds of the processor."""
    costs, errors = zip(*((r.summary["cpu_s"], r.metrics[0].value) for r in (coarse, fine)), strict=True)
    b = np.log(errors[1] / errors[0]) / np.log(costs[1] / costs[0])
    return float(errors[0] / costs[0] ** b), float(b)


def seconds_for(error: float, coarse: Row, fine: Row) -> str:
    """Between the two runs; beyond them nothing is said but on which side it is."""
    if coarse.metrics[0].value < error:
        return f"under {coarse.summary['cpu_s']:.2g}"
    if fine.metrics[0].value > error:
        return f"over {fine.summary['cpu_s']:.2g}"
    a, b = power(coarse, fine)
    return f"{(error / a) ** (1 / b):.2g}"


def at_equal_cost(title: str, coarse: Sequence[Row], fine: Sequence[Row]) -> str:
    """What error each scheme has when all take the same time, and what time for the same error."""
    pairs = [pair for pair in zip(coarse, fine, strict=True) if all(r.metrics and r.verdict == "done" for r in pair)]
    cost = float(np.exp(np.mean([np.log(r.summary["cpu_s"]) for pair in pairs for r in pair])))
    error = float(np.exp(np.mean([np.log(r.metrics[0].value) for pair in pairs for r in pair])))
    lines = [["scheme", f"error in {cost:.2g} s", f"seconds for an error of {error:.2g}", "error falls as seconds to the power of"],
             ["---"] * 4]
    for one, other in pairs:
        a, b = power(one, other)
        lines.append([one.scheme, f"{a * cost**b:.2g}", seconds_for(error, one, other), f"{b:.2f}"])
    table = "\n".join(f"| {' | '.join(line)} |" for line in lines)
    how = (f"{pairs[0][0].metrics[0].name}, as the power of the cost that goes through the two tables above, at the geometric means of"
           " their costs and errors; seconds are of one processor.")
    return "\n\n".join([f"## {title}", how, table])


def merged(old: str, fresh: Mapping[str, str], order: Sequence[str]) -> list[str]:
    """The sections in their order: those that are fresh, and of the others those that were there."""
    kept = {part.split("\n", 1)[0][3:]: part.strip() for part in re.split(r"^(?=## )", old, flags=re.MULTILINE)[1:]}
    sections = kept | dict(fresh)
    return [sections[title] for title in order if title in sections]


HEAD = f"""# The schemes, side by side

Written by `make compare`. Each case was run under each scheme with the kernel and the smoothing length that are the scheme's own, and
the options beside its name, which are those that the case needs. Each run had one thread. Nanoseconds are of the processor, which
other programs lengthen less than the time on the wall. Particles are those of walls too.

The grain of a pressure is what of it changes from particle to particle: the rms distance of a particle's pressure in the last
snapshot from the linear field through its {NEAR} nearest of the same fluid. Roughness is the same in time: rms distance from the
moving mean over 0.2 at a gauge. Errors are against the references that `tests/physics/validate.py` has."""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--case", choices=sorted({c.case for c in COMPARISONS.values()}), help="this one only")
    jobs.add_option(parser)
    options = parser.parse_args()
    jobs.heed_signals()
    chosen = {title: c for title, c in COMPARISONS.items() if options.case in (None, c.case)}
    tasks = {(title, k): lambda c=c, scheme=scheme: row(c, *scheme)
             for title, c in chosen.items() for k, scheme in enumerate(c.schemes)}
    rows: dict[str, list[Row]] = {title: [] for title in chosen}
    fresh = {}
    for (title, _), made in jobs.at_once(options.jobs, tasks):
        rows[title].append(made)
        if len(rows[title]) == len(chosen[title].schemes):
            fresh[title] = section(title, chosen[title], rows[title])
            print(fresh[title] + "\n", flush=True)
    fresh |= {title: at_equal_cost(title, rows[ladder.coarse], rows[ladder.fine]) for title, ladder in LADDERS.items() if ladder.fine in rows}
    old = REPORT.read_text() if REPORT.exists() else ""
    REPORT.write_text("\n\n".join([HEAD, *merged(old, fresh, ORDER)]) + "\n")
    print(f"# {REPORT.relative_to(ROOT)}", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
