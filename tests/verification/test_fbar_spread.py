#!/usr/bin/env python3
"""F-bar by shares of the points' domains: as accurate as with cells, without jumps, with derivatives of whole runs.

Quick.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, example  # noqa: E402

EXACT = {"snes_rtol": 1e-13, "snes_stol": 0, "mpm_quiet": None, "mpm_output_every": 0, "mpm_stabilization_fbar": "spread"}
COLLAPSE = {"mpm_grid_cells": "16,8", "mpm_time_step": 0.05}
YIELD = 24494.897
TOE = {"mpm_objectives": "u", "mpm_objective_u_column": "track_toe_ux", "mpm_objective_u_kind": "value"}
PARAMETERS = "soil.E,soil.yield_stress,soil.density"


def toe(test, change=0.0, ranks=1, **options):
    """The toe's last displacement, with a relative change of the yield stress."""
    run = test.run(example("collapse"), ranks=ranks, mpm_material_soil_yield_stress=repr(YIELD * (1.0 + change)),
                   **{**EXACT, **COLLAPSE, **options})
    return run.results.column("track_toe_ux")[-1]


def differentiate(test, method, ranks=1, **options):
    """The gradient of the toe's last displacement."""
    run = test.run(example("collapse"), ranks=ranks, mpm_task="gradient", mpm_gradient_parameters=PARAMETERS,
                   mpm_gradient_method=method, **{**EXACT, **COLLAPSE, **TOE, **options})
    return np.array(run.results.summary["gradient"])


with Test() as test:
    # ranks, whose points share cells
    alone = toe(test)
    for ranks in (2, 3):
        test.near(f"ranks={ranks}", toe(test, ranks=ranks), alone, relative=1e-9)

    # both methods, ranks, scaling, and differences over five decades, which jumps would spoil
    for shape, reach in (("gimp_bspline2", 1e-2), ("gimp", 5e-2)):
        here = {"mpm_shape": shape}
        gradient = differentiate(test, "adjoint", **here)
        parts = gradient * (1e6, YIELD, 1000.0)
        test.near(f"{shape}.scaling", parts.sum(), 0.0, absolute=1e-9 * abs(parts).max())
        for ranks in (1, 3):
            other = differentiate(test, "tangent", ranks, **here)
            test.near(f"{shape}.tangent.ranks={ranks}", abs(other / gradient - 1.0).max(), 0.0, absolute=1e-9)
        middle, second = toe(test, **here), []
        for change in (1e-3, 1e-4, 1e-5, 1e-6, 1e-7):
            ends = [toe(test, side * change, **here) for side in (-1.0, 1.0)]
            slope = (ends[1] - ends[0]) / (2.0 * change * YIELD)
            test.near(f"{shape}.differences_{change:g}", slope, gradient[1], relative=reach)
            second.append(abs(ends[0] - 2.0 * middle + ends[1]))
        test.near(f"{shape}.close", slope, gradient[1], relative=1e-5)
        for k in range(1, 4):  # at least like the change
            test.check(f"{shape}.second_{k}", second[k] / second[0], None, 10.0**-k)

    # nearly incompressible: no locking, and Newton's method as with cells
    runs = {word: test.run(example("cook"), mpm_stabilization_fbar=word, mpm_grid_cells="26,32", mpm_quiet=None)
            for word in ("true", "spread")}
    corners = {word: test.check_example(f"cook.{word}", run, "cook")["corner_over_reference"] for word, run in runs.items()}
    test.near("cook.corner", corners["spread"], 1.0, absolute=1.1 * abs(corners["true"] - 1.0))
    test.check("cook.newton", runs["spread"].newton.sum() / runs["true"].newton.sum(), None, 1.2)

    # shapes without domains have no shares
    for shape in ("linear", "bspline2"):
        run = test.run(example("collapse"), status=2, mpm_shape=shape, mpm_stabilization_fbar="spread")
        test.check(f"{shape}.line", "whose points have no domains" in run.errors and run.errors.count("\n") == 1, 1, 1)
        test.check(f"{shape}.files", len(run.files), 0, 0)
