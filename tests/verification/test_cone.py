#!/usr/bin/env python3
"""A penetrometer pushed into clay, on a coarse grid and on any number of ranks: its resistance against theory.

Quick. A coarse form of examples/cone_penetration.
"""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference, example  # noqa: E402

COARSE = {"mpm_grid_cells": "18,36", "mpm_body_clay_points_per_cell": "3,3", "mpm_output_every": 0, "mpm_quiet": None}

with Test() as test:
    test.check_example("pushed", test.run(example("cone_penetration"), **COARSE), "cone_penetration")
    runs = [test.run(example("cone_penetration"), ranks=ranks, mpm_time_end=0.2, **COARSE) for ranks in (1, 2, 3)]
    for ranks, run in zip((2, 3), runs[1:]):
        test.check(f"on_{ranks}.force", difference(runs[0].results.column("reaction_cone_y"), run.results.column("reaction_cone_y")), None,
                   1e-8)
