#!/usr/bin/env python3
"""A strip footing on soil that dilates as it flows: with F-bar the load stays at its limit, on any number of ranks and with
any form of the Jacobian; with plain F-bar it rises beyond.

A short version of examples/footing_drained, whose README has all factors on finer grids.
"""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference, example  # noqa: E402

EXACT = 30.14  # Nc at 30 degrees
QUICK = {"mpm_quiet": None, "mpm_output_every": 0}
SHORT = {**QUICK, "mpm_time_end": 0.5, "mpm_grid_upper": "10,1", "mpm_grid_cells": "20,12", "mpm_body_ground_upper": "10,0",
         "mpm_bc_side_lower": "10,-5", "mpm_bc_side_upper": "10,1"}  # h = B/4


def limits(test):
    """h = B/8: 3.7 % below the exact factor, since the width is counted to half a cell beyond the last node."""
    run = test.run(example("footing_drained"), mpm_quiet=None, mpm_output_every=100)
    factor = test.check_example("fbar", run, "footing_drained")["Nc"]
    test.check("fbar.factor", factor / EXACT, 0.95, 0.975)
    test.check("fbar.cuts", run.results.summary["step_cuts"], None, 0)
    test.check("fbar.newton_iterations", run.results.summary["newton_iterations"], None, 240)
    run = test.run(example("footing_drained"), mpm_quiet=None, mpm_output_every=100, mpm_stabilization_fbar="plain")
    locked = test.check_example("plain", run, "footing_drained")
    test.check("plain.factor", locked["Nc"] / factor, 1.08)
    test.check("plain.rises", locked["growth"], 0.002)


def same(test):
    """The same on two ranks, and with the Jacobian by colours."""
    first = test.run(example("footing_drained"), **SHORT)
    for label, ranks, options in (("ranks", 2, {}), ("coloring", 1, {"mpm_jacobian": "coloring"})):
        run = test.run(example("footing_drained"), ranks=ranks, **SHORT, **options)
        test.check(f"same.{label}", difference(*(results.column("reaction_footing_y") for results in (first.results, run.results))),
                   None, 1e-6)


with Test() as test:
    limits(test)
    same(test)
