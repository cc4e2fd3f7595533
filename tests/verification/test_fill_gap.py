#!/usr/bin/env python3
"""A body that joins a stage above settled ground: filled down to it with mass by density, refused beyond a cell, left as drawn;
heights of the column, stress at the base against the weight, ranks, restart, 3D.

Quick.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference  # noqa: E402

FOLDER = Path(__file__).resolve().parent
QUIET = {"mpm_output_every": 1000}
SOFT = {"mpm_material_soft_E": 60e3, "mpm_body_second_fill": "true"}
SOLID = {"mpm_dim": 3, "mpm_grid_lower": "0,0,0", "mpm_grid_upper": "2,8,2", "mpm_grid_cells": "4,16,4", "mpm_body_ground_lower": "0,0,0",
         "mpm_body_ground_upper": "2,4,2", "mpm_body_first_lower": "0,4,0", "mpm_body_first_upper": "2,5,2",
         "mpm_body_second_lower": "0,5,0", "mpm_body_second_upper": "2,6,2", "mpm_bc_sides_components": "x,z",
         "mpm_bc_base_lower": "0,0,0", "mpm_bc_base_upper": "2,0,2", "mpm_load_weight_value": "0,-9.81,0",
         "mpm_bc_base_components": "x,y,z"}


def column(test, label, run, width):
    """Domains from the base to the top without a gap beyond the compression of the last stage; mass by density."""
    state = run.results.state("last")
    x, mass = state["position"], state["mass"]
    height = 2.0 * state["half_length"][:, 1] * state["F"].reshape(-1, 3, 3)[:, 1, 1]
    at = (np.abs(x[:, 0] - x[:, 0].min()) < 1e-3) & (np.abs(x[:, -1] - x[0, -1]) < 1e-3 if x.shape[1] == 3 else True)
    top = (x[at, 1] + 0.5 * height[at]).max()
    test.near(f"{label}.height", height[at].sum(), top, relative=5e-3)
    rows = np.sort(x[at, 1])
    test.check(f"{label}.rows", np.diff(rows).max(), None, 0.38)
    volume = mass[state["material"] == 1].sum() / 1800.0 / width
    test.check(f"{label}.filled", volume - 2.0, 0.15, 0.6)
    base = state["stress"][:, 1][x[:, 1] < 0.2].mean()
    weight = 9.81 * (mass.sum() - 0.5 * mass[(x[:, 1] < 0.2)].sum()) / width
    test.near(f"{label}.base", -base, weight, relative=0.02)
    return state


with Test() as test:
    scene = FOLDER / "lift.yaml"
    filled = test.run(scene, **QUIET)
    column(test, "auto", filled, 4.0)
    test.check("auto.line", float("body second filled down to the settled ground: a gap of up to 0.2 m" in filled.output), 1, 1)
    left = test.run(scene, **QUIET, mpm_body_second_fill="false")
    test.near("false.mass", left.table("mass").sum(), 4.0 * (4.0 * 1600 + 2.0 * 1800), relative=1e-12)
    test.check("false.line", float("filled down" in left.output), 0, 0)
    refused = test.run(scene, status=2, **QUIET, mpm_material_soft_E=45e3, mpm_grid_cells="16,32")
    test.check("refused.line", float("-mpm_body_second_fill is missing: in stage two" in refused.errors), 1, 1)
    soft = test.run(scene, **QUIET, **SOFT, mpm_checkpoint_every=7, mpm_checkpoint_keep=9)
    state = column(test, "soft", soft, 4.0)
    ranks = test.run(scene, ranks=3, **QUIET, **SOFT)
    test.check("ranks", difference(state["stress"], ranks.table("stress")), None, 1e-9)
    again = test.run(scene, ranks=2, **QUIET, **SOFT, mpm_restart=f"{soft.prefix}_checkpoint_000007.h5")
    test.check("restart", difference(state["stress"], again.table("stress")), None, 1e-9)
    column(test, "solid", test.run(scene, **QUIET, **SOLID), 4.0)
