#!/usr/bin/env python3
"""A strip that nothing but the friction of two turning rollers holds: rolled thinner, on any number of ranks and over a restart.

Quick. A coarse form of examples/rollers.
"""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import EXAMPLES, Test, difference, example  # noqa: E402

COARSE = {"mpm_grid_cells": "52,8", "mpm_quiet": None,
          **{f"mpm_boundary_{roller}_motion_table": EXAMPLES / "rollers" / f"{roller}.csv" for roller in ("upper", "lower")}}
SHORT = {**COARSE, "mpm_stage_roll_time_end": 0.1, "mpm_output_every": 0}
COLUMNS = ("reaction_upper_y", "reaction_lower_y", "moment_upper_z")


def rolled(test):
    run = test.run(example("rollers"), mpm_stage_roll_time_end=0.5, **COARSE)
    test.check_example("rolled", run, "rollers")


def same(test):
    alone = test.run(example("rollers"), mpm_checkpoint_every=25, **SHORT)
    half = alone.folder / "rollers_checkpoint_000025.h5"
    runs = [(f"on_{ranks}", test.run(example("rollers"), ranks=ranks, **SHORT)) for ranks in (2, 3)]
    runs.append(("again", test.run(example("rollers"), mpm_restart=half, mpm_output_prefix="again", **SHORT)))
    runs.append(("again_on_2", test.run(example("rollers"), ranks=2, mpm_restart=half, mpm_output_prefix="other", **SHORT)))
    for name, run in runs:
        for column in COLUMNS:
            test.check(f"{name}.{column}", difference(alone.results.column(column)[-1:], run.results.column(column)[-1:]), None, 1e-9)


def stuck(test):
    """As rough as the metal bears: its own strength holds it, and no step is cut."""
    run = test.run(example("rollers"), mpm_boundary_upper_friction="stick", mpm_boundary_lower_friction="stick", **SHORT)
    test.check("stuck.cuts", sum(run.results.column("cuts")), None, 0)
    test.near("stuck.balance", -run.results.column("reaction_upper_y")[-1], run.results.column("reaction_lower_y")[-1], relative=1e-6)


def second(test):
    """An element of order 2 presses back as gimp does on twice as many cells an axis: its nodes have a patch each."""
    run = test.run(example("rollers"), mpm_stages="press", mpm_shape="gimp_element", mpm_order=2, mpm_output_every=0, **COARSE)
    test.near("second.press", run.results.column("reaction_upper_y")[-1], -7.261e6, relative=0.02)
    run = test.run(Path(__file__).parent / "pressed_strip.yaml", ranks=3, mpm_shape="gimp_element", mpm_order=2, mpm_grid_cells="20,12")
    test.near("second.bodies", run.results.column("force_ab_y")[-1], 6.747e6, relative=0.08)  # gimp on 80 x 48 cells


with Test() as check:
    rolled(check)
    second(check)
    same(check)
    stuck(check)
