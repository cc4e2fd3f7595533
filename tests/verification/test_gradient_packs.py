#!/usr/bin/env python3
"""Derivatives in packs of directions: more parameters than a pack has, in 2D and 3D, with and without a mean over the cell.

Both methods agree, and a parameter's derivative does not depend on which others are asked for. Results depend on ratios of
stresses and forces alone: the sum of p dy/dp over all of these is 0 for a displacement.

Quick.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test  # noqa: E402

SOIL = {"E": 1e6, "nu": 0.3, "density": 1000.0, "cohesion": 12e3, "friction": 20.0, "dilation": 5.0, "cohesion_residual": 9e3,
        "friction_residual": 18.0, "dilation_residual": 4.0, "softening_strain": 0.5}
STRESSES = ("E", "density", "cohesion", "cohesion_residual")
EXACT = {"snes_rtol": 1e-13, "snes_stol": 0, "mpm_quiet": None}
SCENE = Path(__file__).resolve().parent / "packed_block.yaml"
CUBE = {"mpm_dim": 3, "mpm_grid_lower": "0,0,0", "mpm_grid_upper": "4,3,3", "mpm_grid_cells": "4,3,3",
        "mpm_body_block_lower": "0,0,0", "mpm_body_block_upper": "2,2,2", "mpm_body_block_points_per_cell": "2,2,2",
        "mpm_bcs": "symmetry,base,back", "mpm_bc_symmetry_lower": "0,0,0", "mpm_bc_symmetry_upper": "0,3,3",
        "mpm_bc_base_lower": "0,0,0", "mpm_bc_base_upper": "4,0,3", "mpm_bc_back_region": "box",
        "mpm_bc_back_lower": "0,0,0", "mpm_bc_back_upper": "4,3,0", "mpm_bc_back_components": "z",
        "mpm_load_weight_value": "0,-42,0", "mpm_track_toe_at": "2,0,2"}


def differentiate(test, parameters, method, ranks=1, **options):
    """The gradient of the toe's displacement by these parameters of the soil and the factor of its weight."""
    names = [f"soil.{key}" for key in parameters] + ["weight.factor"]
    run = test.run(SCENE, ranks=ranks, mpm_task="gradient", mpm_gradient_parameters=",".join(names),
                   mpm_gradient_method=method, mpm_objectives="u", mpm_objective_u_column="track_toe_ux",
                   mpm_objective_u_kind="value", **{**EXACT, **options})
    test.check("time", run.results.summary["time"]["gradient"], 1e-6, None)
    return np.array(run.results.summary["gradient"])


with Test() as test:
    for name, scene in (("block", {}), ("cube", CUBE)):
        for fbar in ("true", "false"):
            options = {**scene, "mpm_stabilization_fbar": fbar}
            label = f"{name}.fbar={fbar}"
            adjoint = differentiate(test, SOIL, "adjoint", **options)
            tangent = differentiate(test, SOIL, "tangent", **options)
            size = np.abs(adjoint * [*SOIL.values(), 1.0])
            for key, a, b, scale in zip(SOIL, adjoint, tangent, size):
                test.near(f"{label}.{key}", b, a, absolute=1e-9 * abs(a) + 1e-12 * size.max() / SOIL[key])
            test.check(f"{label}.yields", size[list(SOIL).index("friction")] / size.max(), 1e-3, None)
            stresses = sum(SOIL[key] * adjoint[list(SOIL).index(key)] for key in STRESSES if key != "density")
            test.near(f"{label}.scaling", stresses, -adjoint[-1], relative=1e-8)
            few = differentiate(test, ["friction", "E"], "tangent", ranks=2, **options)
            test.near(f"{label}.friction", few[0], adjoint[list(SOIL).index("friction")], relative=1e-8)
            test.near(f"{label}.E", few[1], adjoint[0], relative=1e-8)
