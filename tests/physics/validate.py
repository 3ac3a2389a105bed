#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Run the papers' cases and score them against their references.

One line per metric: case, metric, value, reference, tolerance, PASS or MISS; the same as Markdown in tests/physics/RESULTS.md
(RESULTS-paper.md at the papers' sizes). A run that is already in the build directory, made by the same program from the same
case, is not run again: so what was interrupted goes on. With --changed only those cases are run of which a run's state after
50 steps, or what scores it, is another than recorded (states.txt): what a change did not touch is not run.

References: tests/reference (computed, see the head of each file); experiments are cited beside their numbers.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from validation import bubbles, dam_breaks, differences, drops, frames, incompressible, interfaces, jobs, metamorphic, multigrid, rest, sloshing, states, tensions, vortices, waves
from validation.metrics import Metric, Report
from validation.runs import ROOT, SPENT, told


@dataclass
class Case:
    """What scores a case, and what its runs take on one processor: the reduced ones as they did (rows in RESULTS.md), those of the paper's size as estimated from
    particles and steps, with 0.5 microseconds for each of them in two dimensions, and 1.6 in three: 4.2 where a truncated Gaussian has 150 pairs."""

    score: Callable[[bool], Iterator[Metric]]
    reduced: float  # [s]
    paper: float  # [h]


CASES = {
    # At rest, and with nothing that acts from outside.
    "hydrostatic": Case(rest.hydrostatic, 2, 0.02),
    "hydrostatic4": Case(rest.hydrostatic4, 11, 0.08),
    "drop-periodic2d": Case(rest.drop_periodic, 1, 0.01),
    "flat-interface2d": Case(rest.flat_interface, 17, 0.05),
    "static-drop2d": Case(drops.static_drop2d, 290, 0.05),
    # Rezavand, Zhang and Hu 2020.
    "dambreak2d": Case(dam_breaks.dambreak2d, 100, 0.5),
    "sloshing2d": Case(sloshing.sloshing2d, 110, 2.1),
    "dambreak3d": Case(dam_breaks.dambreak3d, 240, 5),
    # Zheng and others.
    "sloshing2d-single": Case(sloshing.sloshing2d_single, 110, 0.25),
    "sloshing3d-single": Case(sloshing.sloshing3d_single, 220, 50),
    "sloshing2d-three-layers": Case(sloshing.sloshing2d_three_layers, 26, 0.04),
    "sloshing2d-three-layers-free": Case(sloshing.sloshing2d_three_layers_free, 49, 0.1),
    "sloshing2d-three-layers-resonance": Case(sloshing.sloshing2d_three_layers_resonance, 110, 0.2),
    "sloshing3d-three-layers": Case(sloshing.sloshing3d_three_layers, 110, 36),
    "sloshing3d-three-layers-linear": Case(sloshing.sloshing3d_three_layers_linear, 0, 0.5),
    "bubble2d-single": Case(bubbles.bubble2d_single, 220, 0.2),
    "bubble3d-single": Case(bubbles.bubble3d_single, 380, 31),
    "bubble3d-single-printed": Case(bubbles.bubble3d_single_printed, 0, 8),
    "bubble3d-single-printed-coarse": Case(bubbles.bubble3d_single_printed_coarse, 0, 0.07),
    "bubble3d-single-quarter": Case(bubbles.bubble3d_single_quarter, 0, 0.4),
    "bubble3d-double": Case(bubbles.bubble3d_double, 0, 31),
    "bubble3d-double-coarse": Case(bubbles.bubble3d_double_coarse, 0, 0.3),
    "bubble3d-double-half": Case(bubbles.bubble3d_double_half, 0, 0.8),
    "rayleigh-taylor3d": Case(interfaces.rayleigh_taylor3d, 300, 1300),
    "rayleigh-taylor3d-quarter": Case(interfaces.rayleigh_taylor3d_quarter, 0, 0.9),
    "rayleigh-taylor3d-fine": Case(interfaces.rayleigh_taylor3d_fine, 0, 0.9),
    "lock-exchange2d": Case(interfaces.lock_exchange2d, 210, 0.5),
    "lock-exchange3d": Case(interfaces.lock_exchange3d, 0, 150),
    "lock-exchange3d-narrow": Case(interfaces.lock_exchange3d_narrow, 0, 0.14),
    # Zhu and Zou 2020.
    "dambreak2d-interfacial": Case(dam_breaks.dambreak2d_interfacial, 200, 0.6),
    "dambreak2d-interfacial-square": Case(dam_breaks.dambreak2d_interfacial_square, 95, 0.1),
    "square-drop2d": Case(drops.square_drop2d, 160, 3.1),
    "cube-drop3d": Case(drops.cube_drop3d, 360, 0.6),
    "rayleigh-taylor2d": Case(interfaces.rayleigh_taylor2d, 81, 0.6),
    "rayleigh-taylor2d-linear": Case(interfaces.rayleigh_taylor2d_linear, 110, 0.1),
    "bubble2d-sussman": Case(bubbles.bubble2d_sussman, 190, 4.5),
    "bubble2d-sussman-printed": Case(bubbles.bubble2d_sussman_printed, 32, 0.3),
    "bubble2d-hysing1": Case(bubbles.bubble2d_hysing1, 120, 0.2),
    # Hu and Adams 2007; a step takes ten times as long as without a pressure to solve for.
    "hydrostatic-isph": Case(incompressible.hydrostatic_isph, 1, 0.01),
    "taylor-green2d": Case(incompressible.taylor_green2d, 45, 0.2),
    "droplet-oscillation2d": Case(incompressible.droplet_oscillation2d, 16, 0.1),
    "droplet-ellipse2d": Case(incompressible.droplet_ellipse2d, 41, 0.4),
    "drop-shear2d": Case(incompressible.drop_shear2d, 330, 9),
    "drop-shear2d-strip": Case(incompressible.drop_shear2d_strip, 0, 0.12),
    "drop-shear2d-one": Case(incompressible.drop_shear2d_one, 0, 0.4),
    "rayleigh-taylor2d-isph": Case(incompressible.rayleigh_taylor2d_isph, 110, 0.2),
    # Joubert, Wilke and Pizette.
    "taylor-green2d-differences": Case(differences.taylor_green2d, 1, 0.1),
    "franke-operators": Case(differences.franke_operators, 1, 0.01),
    "poiseuille-two-phase-operators": Case(differences.poiseuille_operators, 3, 0.01),
    "poiseuille-two-phase": Case(differences.poiseuille, 23, 0.1),
    "bubble3d-cylinder": Case(differences.bubble3d_cylinder, 130, 1.8),
    "bubble3d-cylinder-middle": Case(differences.bubble3d_cylinder_middle, 0, 0.3),
    "bubble3d-cylinder-fine": Case(differences.bubble3d_cylinder_fine, 0, 300),
    # What schemes make of viscosity.
    "cavity2d": Case(vortices.cavity2d, 500, 0.2),
    "taylor-green2d-damping": Case(vortices.taylor_green2d_damping, 7, 0.03),
    "poiseuille-schemes": Case(vortices.poiseuille_schemes, 20, 0.01),
    "free-disc": Case(waves.free_disc, 10, 0.01),
    "free-wave": Case(waves.free_wave, 60, 0.1),
    # What they make of tension.
    "curvature": Case(tensions.curvature, 10, 0.1),
    "drop-at-rest": Case(tensions.drop_at_rest, 300, 0.5),
    "drop-on-floor": Case(tensions.drop_on_floor, 60, 0.1),
    "lens": Case(tensions.lens, 40, 0.1),
    "static-drop2d-water": Case(drops.static_drop2d_water, 100, 0.3),
    "ripple": Case(tensions.ripple, 60, 1),
    "drop-that-swings": Case(tensions.drop_that_swings, 200, 2),
    "bubble3d-ten": Case(bubbles.bubble3d_ten, 500, 0.5),
    # What must not matter.
    "moving-frame": Case(frames.frames, 300, 0.3),
    "metamorphic": Case(metamorphic.metamorphic, 51, 0.04),
    # Both.
    "multigrid": Case(multigrid.multigrid, 240, 1),
}


def score(name: str, paper: bool) -> Iterator[Metric]:
    """The metrics of a case, and what its runs took, be it now or earlier. One whose run fails has one line, and the others go on."""
    SPENT.runs.clear()
    SPENT.own = 0
    try:
        yield from CASES[name].score(paper)
    except subprocess.CalledProcessError as error:
        why = told(error)["error"]["message"]
        sys.stderr.write(f"# {name}: `{' '.join(error.cmd[1:])}` ended with {error.returncode}: {why}\n")
        yield Metric(name, "runs that came to their end, of those needed", 0, low=1)
    if spent := SPENT.own + sum(SPENT.runs.values()):
        yield Metric(name, "processor time of its runs [s]", spent)


def scored(name: str, paper: bool) -> tuple[list[Metric], states.Of]:
    """The metrics, and of a reduced case what states.txt has of it."""
    metrics = list(score(name, paper))
    if paper or SPENT.own:
        return metrics, {}
    return metrics, {states.SCORING: states.scoring(CASES[name].score, SPENT.runs)} | {asked: states.state_after(asked) for asked in SPENT.runs}


def estimates() -> None:
    for name, case in CASES.items():
        print(f"{name}\t{case.reduced:.0f} s\t{case.paper:g} h")
    print(f"all\t{sum(case.reduced for case in CASES.values()):.0f} s\t{sum(case.paper for case in CASES.values()):.0f} h")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--case", choices=sorted(CASES), nargs="+", default=list(CASES), metavar="CASE", help="these only")
    parser.add_argument("--size", choices=("reduced", "paper"), default="reduced")
    parser.add_argument("--changed", action="store_true", help="of those, the cases whose states after 50 steps, or what scores them, are not as recorded")
    parser.add_argument("--list", action="store_true", help="print what the cases take on one processor, by estimate, and run none")
    jobs.add_option(parser)
    options = parser.parse_args()
    if options.list:
        estimates()
        return 0
    paper = options.size == "paper"
    jobs.heed_signals()
    takes = {name: 3600 * case.paper if paper else case.reduced for name, case in CASES.items()}
    report = Report(paper, Path(__file__).parent, takes)
    scores = {name: case.score for name, case in CASES.items()}
    chosen = states.changed(options.case, options.jobs, states.read(), scores) if options.changed else options.case
    if options.changed:
        print(f"# {len(options.case) - len(chosen)} of {len(options.case)} cases are in the states that were recorded", file=sys.stderr)
    longest_first = sorted(chosen, key=lambda name: -takes[name])  # so that none goes on alone for long
    tasks = {name: lambda name=name: scored(name, paper) for name in longest_first}
    with closing(jobs.at_once(options.jobs, tasks)) as results:
        for name, (metrics, reached) in results:
            for metric in metrics:
                report.add(metric)
            report.write()  # what there is so far is there if the rest is given up
            if not paper:
                states.note({name: reached}, list(CASES))
    print(f"# {report.path.relative_to(ROOT)}", file=sys.stderr)
    return 0 if all(m.passed for m in report.metrics) else 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit("# interrupted: the same command goes on, without the runs that are done")
