#!/usr/bin/env python3
"""Newton's method with moving boundaries: few iterations a step and no cuts, with stiff contact and in plastic flow.

Quick. Coarse forms of examples.
"""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import EXAMPLES, Test, example  # noqa: E402

SHORT = {"mpm_output_every": 0, "mpm_quiet": None}


def few(test, name, run, most):
    """No more than `most` iterations a step on average, and no cut."""
    test.check(f"{name}.newton_a_step", run.results.column("newton").mean(), None, most)
    test.check(f"{name}.cuts", run.results.column("cuts").sum(), None, 0)


with Test() as check:
    stiff = check.run(example("shallow_ironing"), mpm_grid_cells="48,18", mpm_time_end=1.6, mpm_boundary_die_penalty=500,
                      mpm_boundary_die_motion_table=EXAMPLES / "shallow_ironing" / "motion.csv", **SHORT)
    few(check, "stiff", stiff, 5.0)
    few(check, "pipe", check.run(example("pipe"), mpm_grid_cells="28,12", mpm_time_step=0.02, **SHORT), 3.8)
    few(check, "hertz", check.run(example("hertz"), mpm_grid_cells="44,44", **SHORT), 2.5)
