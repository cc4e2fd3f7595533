#!/usr/bin/env python3
"""Mandel's problem with shapes without a domain: the plate presses on the ends of the material, not on its points, so that the pressure
rises and falls as theory has it and is the same over the height.

Quick.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, example  # noqa: E402

PRESSURE, FORCE = 0.5494, 10e3  # p(0) a/F at T = 0.05; N/m


with Test() as test:
    for shape in ("linear", "bspline2", "bspline3"):
        run = test.run(example("mandel"), mpm_shape=shape, mpm_time_end=450, mpm_output_every=50)
        x = run.results.initial["position0"][:, 0]
        middle = run.table("pressure")[x < x.min() + 1e-9] / FORCE
        test.near(f"{shape}.pressure", np.mean(middle), PRESSURE, 0.01)
        test.check(f"{shape}.spread", np.ptp(middle), None, 2e-3)
        test.check(f"{shape}.force", np.max(np.abs(np.abs(run.results.column("reaction_plate_y")) / FORCE - 1.0)), None, 1e-8)
