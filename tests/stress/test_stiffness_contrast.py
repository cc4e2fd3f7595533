#!/usr/bin/env python3
"""Bodies 1e6 times as stiff as their neighbours: soft on stiff, stiff on soft, side by side, one in the other.

Stacked bodies with nu = 0 and held sides are a column: under its weight a place of initial height X carries the nominal
stress P(X) = - rho g (weight above) and has the stretch s with M ln(s)/s = P (Hencky, nu = 0: M = E), from which the
settlement of the top follows by integration. In the cell that holds the interface the stiff body, or the penalty on its
faces, keeps the soft one from straining: up to a row of cells of the soft body is lost, h over its height.

With --full: contrasts up to 1e9, cells of half the size, 4 ranks.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
from hostile import Hostile  # noqa: E402
from talus_test import FULL  # noqa: E402

LIMIT = 60.0  # s, for one run
DENSITY, GRAVITY = 1000.0, 10.0  # kg/m3, m/s2
SOFT = 2e5  # Pa
HEIGHT = 2.0  # m, of each of the stacked bodies
CELL = 0.5  # m

SCENE = """
mpm:
  dim: 2
  grid: {lower: "0,0", upper: "6,6", cells: "12,12"}
  materials: low,high
  material_low: {type: hencky, E: 2e5, nu: 0, density: 1000}
  material_high: {type: hencky, E: 2e5, nu: 0, density: 1000}
  bodies: lower,upper
  body_lower: {region: box, lower: "0,0", upper: "2,2", points_per_cell: "3,3", material: low}
  body_upper: {region: box, lower: "0,2", upper: "2,4", points_per_cell: "3,3", material: high}
  bcs: sides,base
  bc_sides: {region: box, lower: "0,0", upper: "6,6", components: "x"}
  bc_base: {region: box, lower: "0,0", upper: "6,0", components: "y"}
  loads: weight
  load_weight: {type: gravity, value: "0,-10"}
  time: {end: 1, step: 0.1}
  tracks: top
  track_top: {at: "1,4", nearest: 2}
  quiet: true
  output: {prefix: run, every: 5}
"""
FREE_SIDES = {"mpm_bc_sides_upper": "0,6", "mpm_material_low_nu": 0.3, "mpm_material_high_nu": 0.3}
BESIDE = {**FREE_SIDES, "mpm_body_upper_lower": "2,0", "mpm_body_upper_upper": "4,2", "mpm_track_top_at": "0,2"}
INCLUSION = {**FREE_SIDES, "mpm_bodies": "lower,left,right,cap,upper", "mpm_body_lower_upper": "4,1.2",
             "mpm_body_upper_lower": "1.2,1.2", "mpm_body_upper_upper": "2.6,2.6"}  # in a frame, none of whose edges is on the grid
for _name, _lower, _upper in (("left", "0,1.2", "1.2,2.6"), ("right", "2.6,1.2", "4,2.6"), ("cap", "0,2.6", "4,4")):
    INCLUSION.update({f"mpm_body_{_name}_region": "box", f"mpm_body_{_name}_lower": _lower, f"mpm_body_{_name}_upper": _upper,
                      f"mpm_body_{_name}_points_per_cell": "3,3", f"mpm_body_{_name}_material": "low"})
SOLVERS = ("direct", "amg", "boomeramg")


def stretch(nominal, modulus):
    """s with modulus ln(s)/s = nominal, in compression, by bisection: the left side grows with s below e."""
    low, high = np.full_like(nominal, 1e-3), np.ones_like(nominal)
    for _ in range(60):
        middle = 0.5 * (low + high)
        below = modulus * np.log(middle) / middle < nominal
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return 0.5 * (low + high)


def settlement(low, high):
    """Of the top of two stacked bodies with these moduli."""
    total = 0.0
    for start, modulus in ((0.0, low), (HEIGHT, high)):
        x = start + HEIGHT * (np.arange(400) + 0.5) / 400.0
        total += HEIGHT * np.mean(1.0 - stretch(-DENSITY * GRAVITY * (2.0 * HEIGHT - x), modulus))
    return total


def stacked(test, label, low, high, mpm_grid_refine=1, **options):
    options["mpm_grid_refine"] = mpm_grid_refine
    run = test.ends(label, SCENE, mpm_material_low_E=low, mpm_material_high_E=high, **options)
    if not run.completed:
        return
    weight = DENSITY * GRAVITY * 2.0 * 2.0 * HEIGHT
    test.near(f"{label}.base_reaction", run.last("reaction_base_y"), weight, relative=1e-5)
    cell = CELL / mpm_grid_refine
    test.near(f"{label}.settlement", -run.last("track_top_uy"), settlement(low, high), relative=cell / HEIGHT)


def free(test, label, low, high, **options):
    run = test.ends(label, SCENE, mpm_material_low_E=low, mpm_material_high_E=high, **options)
    if run.completed:
        weight = GRAVITY * run.results.initial["mass"].sum()
        test.near(f"{label}.base_reaction", run.last("reaction_base_y"), weight, relative=1e-5)


with Hostile(LIMIT) as test:
    for contrast in (1e3, 1e6, 1e9) if FULL else (1e6,):
        stiff = SOFT * contrast
        for refine, ranks in ((1, 1), (1, 2), (2, 4)) if FULL else ((1, 1),):
            options = {"mpm_grid_refine": refine, "ranks": ranks}
            where = f"{contrast:g}.h_over_{refine}.{ranks}_ranks"
            for solver in SOLVERS:
                stacked(test, f"soft_on_stiff.{where}.{solver}", stiff, SOFT, mpm_solver=solver, **options)
                stacked(test, f"stiff_on_soft.{where}.{solver}", SOFT, stiff, mpm_solver=solver, **options)
            for name, change in (("on_top", FREE_SIDES), ("beside", BESIDE), ("around", INCLUSION)):
                free(test, f"soft_{name}.{where}", stiff, SOFT, **change, **options)
                free(test, f"stiff_{name}.{where}", SOFT, stiff, **change, **options)
    if not FULL:
        stacked(test, "stiff_on_soft.2_ranks", SOFT, SOFT * 1e6, ranks=2)
        stacked(test, "soft_on_stiff.2_ranks.amg", SOFT * 1e6, SOFT, ranks=2, mpm_solver="amg")
