#!/usr/bin/env python3
"""A penetrometer pushed into clay, on a coarse grid and on any number of ranks: its resistance against theory.

Quick. A coarse form of examples/cone_penetration; the first radius of examples/cone_penetration_axisymmetric, and all ten with --full.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import FULL, Test, difference, example  # noqa: E402

COARSE = {"mpm_grid_cells": "18,36", "mpm_body_clay_points_per_cell": "3,3", "mpm_output_every": 0, "mpm_quiet": None}

with Test() as test:
    test.check_example("pushed", test.run(example("cone_penetration"), **COARSE), "cone_penetration")
    runs = [test.run(example("cone_penetration"), ranks=ranks, mpm_time_end=0.2, **COARSE) for ranks in (1, 2, 3)]
    for ranks, run in zip((2, 3), runs[1:]):
        test.check(f"on_{ranks}.force", difference(runs[0].results.column("reaction_cone_y"), run.results.column("reaction_cone_y")), None,
                   1e-8)
    if FULL:
        test.check_example("round", test.run(example("cone_penetration_axisymmetric"), mpm_output_every=0), "cone_penetration_axisymmetric")
    ends = [test.run(example("cone_penetration_axisymmetric"), ranks=ranks, mpm_time_end=0.1, mpm_output_every=0).results.column("reaction_cone_y")
            for ranks in (1, 3)]
    test.near("round.first_radius", -ends[0][-1] / (np.pi * 0.25 * 10e3), 9.0, absolute=1.0)  # a program's number: on the way to 11.3
    test.check("round.on_3.force", difference(*ends), None, 1e-8)
