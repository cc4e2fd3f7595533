#!/usr/bin/env python3
"""Ground that loses its equilibrium ends the run, and the last line says what slides and where; what stands goes on. Quick."""
import re
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, example  # noqa: E402

FOLDER = Path(__file__).resolve().parent
LINE = re.compile(r"the ground slides: (\w+), ([\d.e+-]+) m (?:a step whatever the step|in steps far out of proportion to their loads), fastest at \(([\d.]+), ([\d.]+)\)")


def slides(test, label, scene, body, box, **options):
    """Status 3, and the line, with a place in a box of x and y."""
    run = test.run(scene, status=3, mpm_quiet=None, mpm_output_every=0, **options)
    found = LINE.search(run.errors)
    test.check(f"{label}.line", float(found is not None and found.group(1) == body), 1, 1)
    if found:
        test.check(f"{label}.x", float(found.group(3)), *box[0])
        test.check(f"{label}.y", float(found.group(4)), *box[1])
    test.check(f"{label}.summary", float("the ground slides" in run.results.summary["status"]), 1, 1)
    return run


def trench(test):
    """It cannot stand: told whatever the step, before the wall has moved far."""
    for step, ranks in ((1.0, 1), (0.1, 1), (0.1, 3), (0.025, 1)):
        slides(test, f"trench.{step}.{ranks}", FOLDER / "trench.yaml", "ground", ((2.0, 7.0), (2.0, 6.0)),
               mpm_stage_dig_time_step=step, ranks=ranks)
    stands = test.run(FOLDER / "trench.yaml", mpm_material_sand_cohesion=11e3, mpm_stage_dig_time_step=0.25)
    test.check("trench.stands", float("jumps" in stands.output), 0, 0)


def block(test):
    for step in (0.1, 0.05):
        slides(test, f"block.{step}", FOLDER / "pulled_block.yaml", "high", ((1.9, 3.3), (0.9, 2.1)), mpm_time_step=step)
    held = test.run(FOLDER / "pulled_block.yaml", mpm_load_pull_value="4e3,0")
    test.check("block.held", np.abs(held.results.column("track_b_ux")).max(), None, 0.03)


def stands(test):
    """What moves far on a path of equilibrium is none: a cantilever in large steps."""
    run = test.run(example("cantilever"), mpm_time_step=0.2, mpm_output_every=0)
    test.check("cantilever.jumps", float("jumps" in run.output), 0, 0)


def geostatic(test):
    """A state of rest that is not found: collapse, in iterations or as loads grow, and slow convergence."""
    cut = {"mpm_grid_cells": "26,18", "mpm_quiet": None}
    k0 = {"mpm_stage_rest_geostatic_method": "k0", "mpm_stage_rest_geostatic_k0": 0.9}
    for label, strength, options, line in (("collapse", 80e3, {}, "the ground collapses under its loads"),
                                           ("k0", 75e3, k0, "under its loads|no equilibrium under the loads"),
                                           ("growth", 40e3, {}, r"the ground collapses under its loads: it bears 0\.[3-6]"),
                                           ("slow", 90e3, {"mpm_stage_rest_geostatic_iterations": 3}, "it converges slowly")):
        run = test.run(FOLDER / "vertical_cut.yaml", status=3, mpm_material_clay_yield_stress=strength, **cut, **options)
        test.check(f"geostatic.{label}", float(re.search(line, run.errors) is not None), 1, 1)
        if label == "growth":
            test.check("geostatic.where", float("N out of balance at (" in run.errors and "% of the points flow" in run.errors), 1, 1)


with Test() as test:
    trench(test)
    block(test)
    stands(test)
    geostatic(test)
