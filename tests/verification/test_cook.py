#!/usr/bin/env python3
"""Cook's membrane: with F-bar the corner is where high-order finite elements put it, at any nu; without, it locks.

Quick.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, example  # noqa: E402

SIZE = np.array([52, 64])  # m: the grid
REACH = 0.02  # relative


def corner(test, label, shape, h, **options):
    """The corner's displacement over the reference."""
    cells = ",".join(map(str, np.rint(SIZE / h).astype(int)))
    run = test.run(example("cook"), mpm_shape=shape, mpm_grid_cells=cells, mpm_quiet=None, **options)
    values = test.check_example(label, run, "cook")
    test.check(f"{label}.newton", run.newton.max(), None, 3)
    return values["corner_over_reference"]


with Test() as test:
    for shape in ("linear", "gimp"):
        ratios = {h: corner(test, f"{shape}_h={h:g}", shape, h) for h in (2.0, 1.0, 0.5)}
        for h in (1.0, 0.5):  # a check.py that judges nothing would not show it
            test.near(f"{shape}_h={h:g}.corner", ratios[h], 1.0, relative=REACH)
            order = np.log2(abs(ratios[2.0 * h] - 1.0) / abs(ratios[h] - 1.0))
            test.check(f"{shape}_h={h:g}.order", order, 0.8)  # 1: the slanted edges are staircases
        closer = corner(test, f"{shape}_nu=0.4999", shape, 1.0, mpm_material_panel_nu=0.4999)
        test.near(f"{shape}_nu=0.4999.corner", closer, ratios[1.0], absolute=1e-3)

    for ratio, most in ((0.499, 0.97), (0.4999, 0.9)):
        locked = corner(test, f"without_nu={ratio:g}", "gimp", 0.5, mpm_stabilization_fbar="false",
                        mpm_material_panel_nu=ratio)
        test.check(f"without_nu={ratio:g}.corner", locked, 0.5, most)
