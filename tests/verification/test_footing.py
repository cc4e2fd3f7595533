#!/usr/bin/env python3
"""A strip footing on undrained clay: Prandtl's 2 + pi with F-bar, reached at any nu; far beyond it without.

With --full: the example's own stiffness, two shapes.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import FULL, Test, example  # noqa: E402

LIMIT = 2.0 + np.pi
FINE, COARSE = "30,36", "15,18"  # cells of 1/6 m and 1/3 m
STIFF = {"mpm_material_clay_E": 100e6, "mpm_bc_footing_value": "0,-0.004"}  # the geometry hardly changes


def factor(test, label, cells, **options):
    """Mean pressure under the footing over the shear strength, at the end."""
    run = test.run(example("footing"), mpm_grid_cells=cells, mpm_quiet=None, mpm_output_every=50, **options)
    values = test.check_example(label, run, "footing")
    test.check(f"{label}.step_cuts", run.results.summary["step_cuts"], None, 0)
    return values["bearing_factor"]


with Test() as test:
    for shape in ("gimp", "linear") if FULL else ():
        test.near(f"{shape}.limit", factor(test, shape, FINE, mpm_shape=shape), LIMIT, relative=0.05)

    coarse, fine = (factor(test, f"stiff_{cells}", cells, **STIFF) for cells in (COARSE, FINE))
    test.near("stiff.limit", fine, LIMIT, relative=0.025)
    test.near("stiff.extrapolated", 2.0 * fine - coarse, LIMIT, relative=0.01)
    closer = factor(test, "stiff_nu=0.499", COARSE, mpm_material_clay_nu=0.499, **STIFF)
    test.near("stiff_nu=0.499.limit", closer, coarse, relative=0.005)

    locked = factor(test, "without", FINE, mpm_stabilization_fbar="false")
    test.check("without.limit", locked / LIMIT, 1.2, 1.5)

    # fine cells and steps as long as before: a line search that lets the slope grow needs a cut and 42 iterations here
    run = test.run(example("footing"), mpm_grid_refine=4, mpm_time_end=0.04, mpm_quiet=None, mpm_output_every=0)
    test.check("fine_cells.step_cuts", run.results.summary["step_cuts"], None, 0)
    test.check("fine_cells.newton_iterations", run.results.summary["newton_iterations"], None, 20)
