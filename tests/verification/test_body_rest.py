#!/usr/bin/env python3
"""Bodies in contact in a geostatic stage: they find equilibrium in the shape in which they were drawn, and nothing moves after it."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference  # noqa: E402

HERE = Path(__file__).resolve().parent
BLOCK, INCLINED = (HERE / name for name in ("block_at_rest.yaml", "inclined_block.yaml"))
STAGES = {"mpm_stages": "rest,hold", "mpm_stage_rest_type": "geostatic", "mpm_stage_rest_time_end": 1, "mpm_stage_hold_time_end": 1,
          "mpm_stage_hold_time_step": 0.5, "mpm_load_weight_ramp": "0:1"}
WEIGHT, HEIGHT = 25e3, 3.0


def level(test):
    """A block on level ground presses by its weight; later steps move it by no more than the stage left."""
    runs = {}
    for label, options in (("gravity", {}), ("on_2", {"ranks": 2}), ("on_3", {"ranks": 3}), ("stick", {"mpm_contact_ab_friction": "stick"}),
                           ("k0", {"mpm_stage_rest_geostatic_method": "k0", "mpm_stage_rest_geostatic_k0": 0.5}),
                           ("augmented", {"mpm_contact_ab_method": "augmented"}), ("barrier", {"mpm_contact_ab_method": "barrier"}),
                           ("gimp_bspline2", {"mpm_shape": "gimp_bspline2"})):
        run = runs[label] = test.run(BLOCK, mpm_checkpoint_every=1, mpm_checkpoint_keep=3, **options)
        test.check(f"level_{label}.force", difference(run.results.column("force_ab_y"), WEIGHT), None, 1e-9)
        test.check(f"level_{label}.moved", np.max(np.abs(run.table("displacement"))) / HEIGHT, None, 2e-9)
        test.check(f"level_{label}.newton", np.max(run.newton[1:]), None, 1)
    for label in ("on_2", "on_3"):
        test.check(f"level_{label}.same", difference(runs["gravity"].table("stress"), runs[label].table("stress")), None, 1e-9)
    for ranks, step in ((1, 1), (2, 1)):
        run = test.run(BLOCK, ranks=ranks, mpm_restart=runs["gravity"].folder / f"rest_checkpoint_{step:06d}.h5")
        test.check(f"level_again_on_{ranks}.same", difference(runs["gravity"].table("stress"), run.table("stress")), None, 1e-10)


def slope(test):
    """A block on a slope that friction holds."""
    run = test.run(INCLINED, **STAGES)
    force = run.results.column("force_ab_y")
    test.check("slope.force", difference(force, force[0]), None, 1e-9)
    test.check("slope.moved", np.max(np.abs(run.table("displacement"))) / HEIGHT, None, 2e-9)


with Test() as check:
    level(check)
    slope(check)
