#!/usr/bin/env python3
"""A traction acts at the body's face with every shape: uniform tension is exact up to the end. Quick."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test  # noqa: E402

SCENE = Path(__file__).parent / "pulled_bar.yaml"
TRACTION, E = 1e3, 1e6

with Test() as test:
    for shape in ("linear", "bspline2", "gimp", "gimp_bspline2"):
        for points in ("2,2",) if shape == "bspline2" else ("2,2", "3,3"):  # three points a cell do not sum its splines exactly
            state = test.run(SCENE, mpm_quiet=None, mpm_shape=shape, mpm_body_b_points_per_cell=points).results.state()
            start = (state["position"] - state["displacement"])[:, 0]
            test.check(f"{shape}.{points[0]}.stress", np.max(np.abs(state["stress"][:, 0] / TRACTION - 1)), upper=1e-9)
            test.check(f"{shape}.{points[0]}.displacement", np.max(np.abs(state["displacement"][:, 0] * E / TRACTION / start - 1)), upper=1e-9)
    point = test.run(SCENE, mpm_quiet=None, mpm_load_pull_place="point").results.state()
    test.near("point.end", point["stress"][:, 0].min() / TRACTION, 0.75, absolute=0.01)  # a quarter of the last cell without the load
