#!/usr/bin/env python3
"""Water that rises through sand: beyond the critical gradient the ground heaves, and the run says so; below it nothing is said."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, example  # noqa: E402


def boil(test):
    """More than the critical gradient, were it by a hundredth: no equilibrium, and one line says so at once. Less: nothing is said;
    nor of ground that has just been loaded and keeps its water, which has no effective stress, either."""
    for ranks, gradient, options in ((1, 1.01, {}), (3, 1.1, {}), (1, 1.5, {}), (1, 1.05, {"mpm_time_scheme": "second"}),
                                     (1, 1.05, {"mpm_shape": "linear"}), (2, 1.02, {"mpm_material_sand_type": "drucker_prager"})):
        run = test.run(example("seepage"), ranks=ranks, status=3, mpm_surface_bottom_ramp=f"0:0,3600:1,7200:{1 + gradient}", **options)
        label = f"boil_{gradient}_{ranks}" + "".join("_" + word for word in options.values())
        lines = [line for line in run.errors.splitlines() if line.startswith("talus: gave up")]
        test.check(f"{label}.lines", len(lines), 1, 1)
        test.check(f"{label}.heaves", "the ground heaves" in lines[0], 1)
        test.check(f"{label}.cuts", run.results.summary["step_cuts"], None, 3)  # ground that parts jumps: at most 3 halvings
        test.check(f"{label}.steps", run.results.summary["steps"], None, 21)
    test.run(example("seepage"), mpm_surface_bottom_ramp="0:0,3600:1,7200:1.97")
    sealed = test.folder() / "sealed.yaml"
    kept = [line for line in example("seepage").read_text(encoding="utf-8").splitlines() if "surface_bottom" not in line]
    sealed.write_text("\n".join(kept).replace("surfaces: top,bottom", "surfaces: top") + "\n", encoding="utf-8")
    run = test.run(sealed, mpm_load_weight_ramp="0:1", mpm_material_sand_conductivity=1e-10, mpm_time_end=3600)
    test.check("slurry.stress", np.max(np.abs(run.table("stress")[:, 1])) / 98100, None, 0.05)


with Test() as check:
    boil(check)
