#!/usr/bin/env python3
"""A body whose faces lie on cell faces: domains that reach the next cell by rounding only must not bring its nodes in."""
import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test  # noqa: E402

SCENE = Path(__file__).resolve().parent / "aligned.yaml"
UNKNOWNS = 3 * 5 * 3 * 3  # the nodes of 4 x 2 x 2 cells
TOLERANCE = 1e-9

with Test() as test:
    for shape in ("linear", "gimp"):
        for count in range(2, 9):
            label = f"{shape}_{count}"
            run = test.run(SCENE, status=None, mpm_shape=shape, mpm_body_beam_points_per_cell=f"{count},{count},{count}",
                           snes_monitor=None, snes_rtol=TOLERANCE)
            test.check(f"{label}.status", run.status, 0, 0)
            if run.status:
                continue
            summary, norms = run.results.summary, re.findall(r"SNES Function norm (\S+)", run.output)
            test.check(f"{label}.unknowns", summary["active_dofs_max"], UNKNOWNS, UNKNOWNS)
            test.check(f"{label}.residual_drop", float(norms[-1]) / float(norms[0]), None, TOLERANCE)
            test.check(f"{label}.tip", run.results.column("track_tip_uz")[-1], -0.025, -0.01)
