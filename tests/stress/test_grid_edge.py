#!/usr/bin/env python3
"""Bodies that touch the grid's edge on every side, with and without conditions there.

Held all round, a body that fills the grid carries its weight at rest: sigma_yy = - rho g (H - y), sigma_xx =
nu/(1 - nu) sigma_yy. Free to spread, it leaves the grid, which must end the run with one line. Not held at all it has
no equilibrium, or any: the run gives up, or comes to an end of which only the numbers' being finite can be asked.

With --full: the same at four times the cells per axis.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
from hostile import Hostile  # noqa: E402
from talus_test import FULL  # noqa: E402

LIMIT = 60.0  # s, for one run
DENSITY, GRAVITY, HEIGHT, NU = 1000.0, 10.0, 4.0, 0.3

SCENE = """
mpm:
  dim: 2
  grid: {lower: "0,0", upper: "4,4", cells: "8,8"}
  materials: soil
  material_soil: {type: hencky, E: 1e9, nu: 0.3, density: 1000}
  bodies: all
  body_all: {points_per_cell: "2,2", material: soil}
  bcs: left,right,base,top
  bc_left: {region: box, lower: "0,0", upper: "0,4", components: "x"}
  bc_right: {region: box, lower: "4,0", upper: "4,4", components: "x"}
  bc_base: {region: box, lower: "0,0", upper: "4,0", components: "y"}
  bc_top: {region: box, lower: "0,4", upper: "4,4", components: "x"}
  loads: weight
  load_weight: {type: gravity, value: "0,-10"}
  time: {end: 1, step: 0.25}
  quiet: true
  output: {prefix: run, every: 1}
"""
SOLID = """
mpm:
  dim: 3
  grid: {lower: "0,0,0", upper: "2,2,2", cells: "3,3,3"}
  materials: soil
  material_soil: {type: hencky, E: 1e6, nu: 0.3, density: 1000}
  bodies: all
  body_all: {points_per_cell: "2,2,2", material: soil}
  bcs: all
  bc_all: {region: box, lower: "0,0,0", upper: "2,2,0", components: "x,y,z"}
  loads: weight
  load_weight: {type: gravity, value: "0,0,-10"}
  time: {end: 1, step: 0.5}
  quiet: true
  output: {prefix: run, every: 1}
"""
SHAPES = ("linear", "gimp", "bspline2", "bspline3", "gimp_bspline2")
# a body in the grid's middle that is thrown at the edges
INSIDE = {"mpm_body_all_region": "box", "mpm_body_all_lower": "1,1", "mpm_body_all_upper": "3,3"}


def without(scene, *names):
    """The scene without these conditions and loads."""
    lines = [line for line in scene.splitlines()
             if not any(line.startswith((f"  bc_{name}:", f"  load_{name}:")) for name in names)]
    text = []
    for line in lines:
        key, _, value = line.partition(": ")
        if key in ("  bcs", "  loads"):
            kept = [name for name in value.split(",") if name not in names]
            if not kept:
                continue
            line = f"{key}: {','.join(kept)}"
        text.append(line)
    return "\n".join(text) + "\n"


def held(test, label, refine, reach, **options):
    """Held all round: the stresses of rest."""
    run = test.ends(label, without(SCENE, "top"), mpm_grid_refine=refine, **options)
    if not run.completed:
        return
    state = run.results.state("last")
    vertical = -DENSITY * GRAVITY * (HEIGHT - state["position"][:, 1])
    scale, cell = DENSITY * GRAVITY * HEIGHT, HEIGHT / (8 * refine)
    test.check(f"{label}.vertical_error", np.max(np.abs(state["stress"][:, 1] - vertical)) / scale, None,
               reach * cell / HEIGHT)
    sideways = np.max(np.abs(state["stress"][:, 0] - NU / (1.0 - NU) * state["stress"][:, 1])) / scale
    test.check(f"{label}.sideways_error", sideways, None, 1e-4)
    test.near(f"{label}.base_reaction", run.last("reaction_base_y"), DENSITY * GRAVITY * HEIGHT**2, relative=1e-6)


def leaves(test, label, scene, **options):
    """The only end is that of a point beyond the edge; the state that is written then is that of the last good step."""
    run = test.ends(label, scene, or_gives_up=True, mpm_output_every=1000, **options)
    test.check(f"{label}.status", run.status, 3, 3)
    test.check(f"{label}.left_the_grid", run.reason.startswith("point ") and " left the grid at (" in run.reason, 1, 1)


with Hostile(LIMIT) as test:
    refine = 4 if FULL else 1
    for shape in SHAPES:
        # one stress a cell: at most half a cell off; the points of `linear` are a quarter of a cell from its middle
        held(test, f"held.{shape}", refine, 0.5, mpm_shape=shape)
        leaves(test, f"spreads.{shape}", without(SCENE, "left", "right", "top"), mpm_shape=shape,
               mpm_grid_refine=refine, mpm_material_soil_E=1e5)
        test.ends(f"not_held.{shape}", without(SCENE, "left", "right", "top", "base"), or_gives_up=True,
                  mpm_shape=shape, mpm_grid_refine=refine)
        test.ends(f"not_held_no_load.{shape}", without(SCENE, "left", "right", "top", "base", "weight"),
                  or_gives_up=True, mpm_shape=shape, mpm_grid_refine=refine)
    held(test, "held.2_ranks", refine, 0.5, ranks=2)
    held(test, "held.amg", refine, 0.5, mpm_solver="amg")
    leaves(test, "spreads.2_ranks", without(SCENE, "left", "right", "top"), ranks=2, mpm_material_soil_E=1e5)
    for solver in ("direct", "amg", "boomeramg"):
        test.ends(f"not_held.{solver}.2_ranks", without(SCENE, "left", "right", "top", "base"), ranks=2,
                  or_gives_up=True, mpm_solver=solver)
    # no condition, and a body that falls from the middle: it must stop at the edge, one way or the other
    test.ends("falls", without(SCENE, "left", "right", "top", "base"), or_gives_up=True, **INSIDE)
    # a body in the middle over the base that it does not touch: nothing carries it
    test.ends("hovers", without(SCENE, "top"), or_gives_up=True, **INSIDE)
    leaves(test, "spreads_3d", SOLID, mpm_material_soil_E=3e3)
    test.ends("rough_3d", SOLID, mpm_material_soil_E=1e9)
    # everything in one cell
    for count in (1, 2):
        test.ends(f"one_cell.{count}", without(SCENE, "top"), mpm_grid_cells="1,1",
                  mpm_body_all_points_per_cell=f"{count},{count}")
        test.ends(f"one_cell.{count}.2_ranks", without(SCENE, "top"), ranks=2, mpm_grid_cells="1,1",
                  mpm_body_all_points_per_cell=f"{count},{count}")
