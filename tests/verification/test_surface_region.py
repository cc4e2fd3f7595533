#!/usr/bin/env python3
"""Surfaces limited by a region: the load of a strip that ends within a face, a quarter of a ring's rim, a square in 3D, after displacements
began anew, on ranks; a region without a face.

Quick.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference  # noqa: E402

SCENE = Path(__file__).resolve().parent / "surface_region.yaml"
SOLID = {"mpm_dim": 3, "mpm_grid_lower": "0,0,0", "mpm_grid_upper": "4,3,4", "mpm_grid_cells": "8,6,8", "mpm_body_block_lower": "0,0,0",
         "mpm_body_block_upper": "4,2,4", "mpm_body_block_points_per_cell": "2,2,2", "mpm_bc_base_lower": "0,0,0",
         "mpm_bc_base_upper": "4,0,4", "mpm_bc_base_components": "x,y,z", "mpm_surface_strip_lower": "0.6,1.9,0",
         "mpm_surface_strip_upper": "2.1,2.1,1.3"}

with Test() as test:
    run = test.run(SCENE)
    test.near("strip", run.results.column("reaction_base_y")[-1], 1.5e4, relative=3e-3)
    test.near("strip.side", run.results.column("reaction_base_x")[-1], 0.0, absolute=1.0)
    ranks = test.run(SCENE, ranks=3)
    test.check("ranks", difference(run.table("stress"), ranks.table("stress")), None, 1e-10)
    stages = {"mpm_stages": "one,two", "mpm_stage_one_time_end": 1, "mpm_stage_two_reset_displacement": "true"}
    test.near("stages", test.run(SCENE, **stages).results.column("reaction_base_y")[-1], 1.5e4, relative=3e-3)
    test.near("solid", test.run(SCENE, **SOLID).results.column("reaction_base_y")[-1], 1e4 * 1.5 * 1.3, relative=3e-2)
    none = test.run(SCENE, status=2, mpm_surface_strip_lower="0.6,0.5", mpm_surface_strip_upper="2.1,1.5")
    test.check("none", float("-mpm_surface_strip_region" in none.errors), 1, 1)
    half = {"mpm_surface_strip_side": "all", "mpm_surface_strip_lower": "2,-1", "mpm_surface_strip_upper": "9,9"}
    sides = test.run(SCENE, **half)  # half of the top, and the right side; the base holds its faces, which are left out
    test.near("all.up", sides.results.column("reaction_base_y")[-1], 1e4 * 2.0, relative=1e-3)
    test.near("all.along", sides.results.column("reaction_base_x")[-1], 2e4, relative=1e-2)
    test.check("all.finite", float(np.isfinite(sides.table("stress")).all()), 1, 1)
