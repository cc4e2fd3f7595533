#!/usr/bin/env python3
"""A block on a slope, both cut out of the lattice of points: Coulomb's friction holds it up to its angle, and no further."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test  # noqa: E402

INCLINED = Path(__file__).resolve().parent / "inclined_block.yaml"


def slope(test):
    """A block on a slope of 30 degrees, both cut out of the lattice: within 0.3 degrees it holds where its friction is enough, and
    slides where it is not; all of it slides by mu N."""
    for label, options in (("gimp", {"ranks": 2}), ("gimp_bspline2", {"mpm_shape": "gimp_bspline2"}),
                           ("turned", {"mpm_contact_ab_bodies": "slope,block"}),
                           ("coarse", {"mpm_body_block_points_per_cell": "2,2", "mpm_body_slope_points_per_cell": "3,3"})):
        run = test.run(INCLINED, mpm_contact_ab_friction="30.3deg", **options)
        test.check(f"slope_{label}.newton", np.mean(run.newton), None, 7.5)
        test.run(INCLINED, mpm_contact_ab_friction="29.7deg", mpm_time_step_min=0.25, status=3, **options)
    push = {"mpm_motions": "push", "mpm_motion_push_body": "block", "mpm_motion_push_region": "sphere",
            "mpm_motion_push_center": "2.4,4.2", "mpm_motion_push_radius": 0.2, "mpm_motion_push_components": "x",
            "mpm_motion_push_value": 0.5, "mpm_motion_push_ramp": "0:0,1:1", "mpm_load_weight_ramp": "0:1", "mpm_material_rock_E": 1e12, "mpm_time_step": 0.5}
    run = test.run(INCLINED, mpm_contact_ab_friction=0.3, **push)
    x, y = run.results.column("force_ab_x"), run.results.column("force_ab_y")
    normal, along = x / 2 + y * np.sqrt(0.75), y / 2 - x * np.sqrt(0.75)
    test.check("slope_pushed.friction", np.max(np.abs(np.abs(along) / normal / 0.3 - 1)), None, 1e-6)


with Test() as check:
    slope(check)
