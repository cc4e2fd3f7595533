#!/usr/bin/env python3
"""A block drawn onto a rough plane, wherever the lattice of its points ends, just below its angle of friction: it stays, in few iterations.

Quick. The plane is the slope, gravity is turned.
"""
import math
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test  # noqa: E402

SCENE = Path(__file__).resolve().parent / "block.yaml"
FRICTION, BELOW = 0.4, 0.3  # degrees below atan mu
FACES = {"on_the_grid": 1.0, "a_hair_below": 0.999, "a_hair_above": 1.001, "half_off": 1.25, "off": 1.15}


def scene(height, points, shape):
    slope = math.atan(FRICTION) - math.radians(BELOW)
    return {"mpm_shape": shape, "mpm_body_block_lower": f"1,{height}", "mpm_body_block_upper": f"3,{height + 2}",
            "mpm_body_block_points_per_cell": f"{points},{points}", "mpm_boundaries": "floor", "mpm_boundary_floor_type": "plane",
            "mpm_boundary_floor_point": f"0,{height}", "mpm_boundary_floor_normal": "0,1", "mpm_boundary_floor_friction": FRICTION,
            "mpm_material_block_E": 1e8, "mpm_loads": "weight", "mpm_load_weight_type": "gravity",
            "mpm_load_weight_value": f"{10 * math.sin(slope)},{-10 * math.cos(slope)}"}


with Test() as test:
    for name, height in FACES.items():
        for points, shape in ((2, "gimp"), (3, "gimp"), (2, "bspline2")):
            label = f"{name}.{shape}_{points}"
            run = test.run(SCENE, **scene(height, points, shape))
            along, across = (run.results.column(f"reaction_floor_{axis}") for axis in "xy")
            test.near(f"{label}.friction", -along[-1] / across[-1], math.tan(math.atan(FRICTION) - math.radians(BELOW)), 1e-6)
            test.check(f"{label}.newton", np.mean(run.newton), None, 6)
            test.check(f"{label}.cuts", run.results.column("cuts").sum(), None, 0)
