#!/usr/bin/env python3
"""A strip footing on ground with friction that keeps its water: without dilation the mean effective stress stays, and the limit load is
that of a cohesion c cos phi, Prandtl's 2 + pi times it, with F-bar; without F-bar it locks.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test  # noqa: E402

SCENE = Path(__file__).resolve().parent / "undrained_footing.yaml"
LIMIT = 2.0 + np.pi


def factor(test, label, **options):
    """Mean pressure under the footing over the undrained strength, at the end; half a cell beyond the last held node counts."""
    run = test.run(SCENE, mpm_quiet=None, **options)
    results = run.results
    h = 5.0 / results.numbers("mpm_grid_cells")[0]
    width = (np.floor(1.0 / h + 1e-9) + 0.5) * h
    cohesion, friction = (results.numbers(f"mpm_material_clay_{name}")[0] for name in ("cohesion", "friction"))
    pressure = -results.column("reaction_footing_y") / width / (cohesion * np.cos(np.radians(friction)))
    test.check(label + ".step_cuts", results.summary["step_cuts"], None, 0)
    balance = results.column("reaction_base_y")[-1] / -results.column("reaction_footing_y")[-1]
    test.near(label + ".balance", balance, 1.0, relative=1e-6)
    return run, pressure


with Test() as test:
    run, pressure = factor(test, "fbar")
    test.near("fbar.limit", pressure[-1], LIMIT, relative=0.04)
    test.near("fbar.plateau", pressure[len(pressure) // 2], pressure[-1], relative=0.02)
    volume = np.linalg.det(run.table("F").reshape(-1, 3, 3))
    test.check("fbar.volume", np.abs(volume - 1.0).max(), None, 5e-3)
    pressure = factor(test, "locked", mpm_grid_cells="20,24", mpm_stabilization_fbar="false")[1]
    test.check("locked.limit", pressure[-1] / LIMIT, 1.1, None)
