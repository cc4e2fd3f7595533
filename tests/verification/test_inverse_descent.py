#!/usr/bin/env python3
"""Stiffness under a plate by steepest descent, Gauss-Newton and BLMVM, in clay that drains wholly and in part.

Where elastic clay drains at once the force is proportional to E. Steps of a constant rate then shrink the distance from the
truth by a factor, 1 - 0.4 c^2, of which c = 1.356727 gives the path of a published analysis (GeoWarp, Zhao and Choo; 1000 to
10 000 kPa). In clay that drains in part the force has a time of its own, c_v t/h^2, and its derivative is little more than
half of F/E, the partial derivative of a plate whose penalty is proportional to E, at a frozen solution of the last step.
Descent is run with both, side by side.

Quick.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test  # noqa: E402

FOLDER = Path(__file__).resolve().parent
TRUTH, START = 10e6, 1e6  # Pa
SHRINK = 1.0 - 0.4 * 1.356727**2
PATH = [1000.0, 7626.55, 9374.08, 9834.94, 9956.47, 9988.52, 9996.97]  # kPa
SAME = {"mpm_quiet": None, "snes_rtol": 1e-12, "mpm_output_every": 0}


def ask(force, **inverse):
    return {"mpm_task": "inverse", "mpm_parameters": "E", "mpm_parameter_E_of": "clay.E", "mpm_parameter_E_start": START,
            "mpm_parameter_E_bounds": "1e5,1e9", "mpm_objectives": "force", "mpm_objective_force_column": "reaction_plate_y",
            "mpm_objective_force_target": repr(force), "mpm_objective_force_deviation": repr(abs(force) / 100),
            **{f"mpm_inverse_{key}": value for key, value in inverse.items()}}


def force(test, stiffness, **options):
    run = test.run(FOLDER / "plate_wet.yaml", **SAME, **options, mpm_material_clay_E=stiffness)
    return run.results.column("reaction_plate_y")[-1]


def table(run):
    lines = Path(f"{run.prefix}_inverse.csv").read_text().splitlines()
    column = lines[0].split(",").index("E")
    return np.array([float(line.split(",")[column]) for line in lines[1:]])


def check_drained(test):
    drained = {"mpm_material_clay_permeability": 1e-6}
    target = force(test, TRUTH, **drained)
    slope = 100.0 / TRUTH  # of the force over its deviation
    rate = (1.0 - SHRINK) / slope**2
    run = test.run(FOLDER / "plate_wet.yaml", **SAME, **drained, **ask(target, method="descent", rate=rate, iterations=6))
    found = table(run)
    test.check("drained.iterations", len(found), 7, 7)
    for n, (value, reference) in enumerate(zip(found, PATH)):
        test.near(f"drained.descent.{n}", value, 1e3 * reference, relative=1e-3)


def check_wet(test):
    target = force(test, TRUTH)
    for method, iterations in (("gauss_newton", 4), ("blmvm", 8)):
        found = table(test.run(FOLDER / "plate_wet.yaml", **SAME, **ask(target, method=method)))
        near = np.abs(found / TRUTH - 1.0) < 1e-6
        test.check(f"wet.{method}", int(np.argmax(near)) if near.any() else 99, 1, iterations)
    run = test.run(FOLDER / "plate_wet.yaml", **SAME, mpm_task="gradient", mpm_gradient_parameters="clay.E", mpm_objectives="f",
                   mpm_objective_f_column="reaction_plate_y", mpm_objective_f_kind="value")
    total = run.results.summary["gradient"][0] * TRUTH / target
    test.check("wet.total_over_partial", total, 0.5, 0.6)

    slope = 100.0 * total / TRUTH
    rate = (1.0 - SHRINK) / slope**2  # at the truth as above
    whole = table(test.run(FOLDER / "plate_wet.yaml", **SAME, **ask(target, method="descent", rate=rate, iterations=6)))
    partial = [START]
    for _ in range(6):
        here = force(test, partial[-1])
        step = rate * (here - target) * (here / partial[-1]) / (target / 100.0) ** 2
        partial.append(min(max(partial[-1] - step, 1e5), 1e9))
    for n, (one, other) in enumerate(zip(whole, partial)):
        print(f"descent {n}: total {one / 1e3:.2f} kPa, partial {other / 1e3:.2f} kPa")
    test.check("wet.descent", abs(whole[-1] / TRUTH - 1.0), 0.0, 1e-2)
    across = np.diff(np.sign(np.array(partial[3:]) - TRUTH))
    test.check("wet.partial_overshoots", np.count_nonzero(across), 3, 3)


with Test() as test:
    check_drained(test)
    check_wet(test)
