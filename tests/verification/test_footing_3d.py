#!/usr/bin/env python3
"""A rigid footing that is pressed into an elastic block and lifted again, on a grid that goes with it: balance, lift-off without
tension, and no jumps where the ground at its edge comes to its sides.

A short version of examples/footing_3d, whose README has forces on finer grids.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import EXAMPLES, Test, difference, example  # noqa: E402

COARSE = {"mpm_quiet": None, "mpm_output_every": 0, "mpm_grid_cells": "5,5,6"}


def loading(test):
    """25 steps down, 13 up: the table's force, and back along the same curve."""
    run = test.run(example("footing_3d"), **COARSE)
    quantities = test.check_example("h=1", run, "footing_3d")
    test.check("h=1.judged", "force_at_0.5_m" in quantities, 1)


def same(test):
    """The same on two ranks, across the turn."""
    short = {**COARSE, "mpm_boundary_footing_ramp": "0:0,0.12:0.12,0.2:0.04", "mpm_time_end": 0.2}
    runs = [test.run(example("footing_3d"), ranks=ranks, **short) for ranks in (1, 2)]
    forces = [run.results.column("reaction_footing_z") for run in runs]
    test.check("ranks", difference(*forces), None, 1e-8)


def edge(test):
    """A strip footing: where its edge lies in a cell, cells and penalty hardly matter, and its side comes to bear by and by."""
    forces, sides = {}, {}
    for name, cells, penalty in (("coarse", "20,24", 500), ("fine", "40,48", 500), ("off", "21,24", 500), ("soft", "20,24", 250)):
        run = test.run(Path(__file__).resolve().parent / "strip_footing.yaml", mpm_quiet=None, mpm_grid_cells=cells,
                       mpm_boundary_footing_penalty=penalty)
        sides[name], forces[name] = (run.results.column(f"reaction_footing_{axis}") for axis in "xy")
        test.check(f"edge.{name}.newton_per_step", run.newton.mean(), None, 6.0)
    force = -forces["fine"]
    test.near("edge.cells", forces["coarse"][-1], -force[-1], relative=0.015)
    test.near("edge.place_in_cell", forces["off"][-1], -force[-1], relative=0.015)
    test.near("edge.penalty", forces["soft"][-1], forces["coarse"][-1], relative=0.003)
    test.check("edge.side", sides["fine"][-1] / force[-1], 0.05, 0.15)
    test.check("edge.side_falls", np.max(-np.diff(sides["fine"])) / force[-1], None, 0.006)


def saturated(test):
    """On saturated ground: balance and no tension, and the same by blocks of fields on two ranks."""
    scene = EXAMPLES / "footing_3d" / "saturated.yaml"
    run = test.run(scene, **COARSE)
    test.check_example("saturated", run, "footing_3d")
    blocks = test.run(scene, ranks=2, mpm_solver="poro-fieldsplit", mpm_time_end=0.5, **COARSE)
    forces = [of.results.column("reaction_footing_z")[:5] for of in (run, blocks)]
    test.check("saturated.blocks", difference(*forces), None, 1e-6)


with Test() as test:
    loading(test)
    saturated(test)
    same(test)
    edge(test)
