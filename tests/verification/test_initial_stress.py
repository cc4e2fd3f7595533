#!/usr/bin/env python3
"""A uniform initial stress without weight: at rest between surfaces that balance it, in laws with and without history; released
by one of them; outside of the yield surface; in 3D.

Quick.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test  # noqa: E402

SCENE = Path(__file__).resolve().parent / "initial_stress.yaml"
STRESS = np.array([-50e3, -100e3, -60e3, 0.0, 0.0, 0.0])
LAWS = {
    "j2": {},
    "hencky": {"yield_stress": None},
    "neo_hookean": {"yield_stress": None},
    "mohr_coulomb": {"yield_stress": None, "cohesion": 20e3, "friction": 30, "dilation": 0},
    "modified_cam_clay": {"yield_stress": None, "E": None, "nu": None, "kappa": 0.02, "lambda": 0.1, "M": 1.2, "G": 4e6, "ocr": 2,
                          "specific_volume": 2.1},
}


def scene(test, drop):
    """The scene without some parameters of its material."""
    text = SCENE.read_text(encoding="utf-8")
    for key in drop:
        text = text.replace({"yield_stress": "yield_stress: 200e3, ", "E": "E: 20e6, ", "nu": "nu: 0.3, "}[key], "")
    path = test.folder() / "case.yaml"
    path.write_text(text, encoding="utf-8")
    return path


with Test() as test:
    for law, parameters in LAWS.items():
        path = scene(test, [key for key, value in parameters.items() if value is None])
        options = {f"mpm_material_soil_{key}": value for key, value in parameters.items() if value is not None}
        run = test.run(path, mpm_quiet=None, mpm_material_soil_type=law, **options)
        first, last = run.results.state(0), run.results.state("last")
        part = [0, 1, 3] if law in ("hencky", "neo_hookean") else [0, 1, 2, 3]  # these have no history for the third
        for name, state in (("start", first), ("rest", last)):
            test.check(f"{law}.{name}", np.abs(state["stress"] - STRESS)[:, part].max() / 1e5, None, 1e-7)
        test.check(f"{law}.displacement", np.abs(last["displacement"]).max(), None, 1e-8)
        test.near(f"{law}.volume", first["volume"].sum(), 4.0, relative=1e-12)
        test.near(f"{law}.mass", first["mass"].sum(), 4.0 * 1800.0, relative=1e-12)
    free = test.run(SCENE, mpm_quiet=None, mpm_surface_top_normal=0)
    test.check("released", np.abs(free.table("stress")[:, 1]).max() / 1e5, None, 1e-6)
    solid = {"mpm_dim": 3, "mpm_grid_lower": "0,0,0", "mpm_grid_upper": "3,3,2", "mpm_grid_cells": "6,6,4", "mpm_body_block_lower": "0,0,0",
             "mpm_body_block_upper": "2,2,2", "mpm_body_block_points_per_cell": "2,2,2", "mpm_body_block_initial_stress": "-50e3,-100e3,-60e3,0,0,0",
             "mpm_bcs": "left,base,back", "mpm_bc_left_lower": "0,0,0", "mpm_bc_left_upper": "0,3,2", "mpm_bc_base_lower": "0,0,0",
             "mpm_bc_base_upper": "3,0,2", "mpm_bc_back_region": "all", "mpm_bc_back_components": "z"}
    state = test.run(SCENE, mpm_quiet=None, **solid).results.state("last")
    test.check("solid.rest", np.abs(state["stress"] - STRESS).max() / 1e5, None, 1e-7)
    refused = test.run(SCENE, status=2, mpm_body_block_initial_stress="-50e3,-500e3,-60e3,0")
    test.check("refused", float("-mpm_body_block_initial_stress: lies outside of the yield surface" in refused.errors), 1, 1)
