#!/usr/bin/env python3
"""The grid that moves: a column under uniform compression stays uniform, a rigid translation without stress.

In uniaxial strain a Hencky material has the stress M ln f / f, f the column's stretch. The grid's lines go with the material,
so that this holds to the tolerance of Newton's method, for all shapes, in 2D and 3D, on any number of ranks and across a
restart. On the fixed grid the upper nodes lose the column.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference  # noqa: E402

YOUNG, POISSON = 1e6, 0.3
CONSTRAINED = YOUNG * (1.0 - POISSON) / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON))
STRESS = CONSTRAINED * np.log(0.75) / 0.75
EXACT, RANKS, RESTART = 1e-9, 1e-9, 1e-10
TIGHT = {"snes_rtol": 1e-12, "mpm_quiet": None}
PLANE = """
mpm:
  dim: 2
  grid: {lower: "0,0", upper: "2,4", cells: "4,8", %s}
  materials: soil
  material_soil: {type: hencky, E: 1e6, nu: 0.3, density: 1000}
  bodies: column
  body_column: {region: box, lower: "0,0", upper: "2,4", points_per_cell: "2,2", material: soil}
  time: {end: 1, step: 0.1}
  output: {prefix: column, every: 100}
"""
SIDES = """
  bcs: west,east,%s
  bc_west: {region: box, lower: "0,0", upper: "0,4", components: "x"}
  bc_east: {region: box, lower: "2,0", upper: "2,4", components: "x"}
"""
BASE = '  bc_base: {region: box, lower: "0,0", upper: "2,0", components: "y"%s}\n'
TOP = '  bc_top: {region: box, lower: "0,4", upper: "2,4", components: "y"%s}\n'
MOVE = ', value: "%g", ramp: "0:0,1:1"'
MIDDLE = 'follow: column, axes: "y", mode: stretch, at: 2'
COLUMN = PLANE % MIDDLE + SIDES % "base,top" + BASE % "" + TOP % (MOVE % -1)
SPACE = """
mpm:
  dim: 3
  grid: {lower: "0,0,0", upper: "1.5,1,4", cells: "3,2,8", follow: column, axes: "z", mode: stretch, at: 2}
  materials: soil
  material_soil: {type: hencky, E: 1e6, nu: 0.3, density: 1000}
  bodies: column
  body_column: {region: box, lower: "0,0,0", upper: "1.5,1,4", points_per_cell: "2,2,2", material: soil}
  bcs: x0,x1,y0,y1,base,top
  bc_x0: {region: box, lower: "0,0,0", upper: "0,1,4", components: "x"}
  bc_x1: {region: box, lower: "1.5,0,0", upper: "1.5,1,4", components: "x"}
  bc_y0: {region: box, lower: "0,0,0", upper: "1.5,0,4", components: "y"}
  bc_y1: {region: box, lower: "0,1,0", upper: "1.5,1,4", components: "y"}
  bc_base: {region: box, lower: "0,0,0", upper: "1.5,1,0", components: "z"}
  bc_top: {region: box, lower: "0,0,4", upper: "1.5,1,4", components: "z", value: "-1", ramp: "0:0,1:1"}
  time: {end: 1, step: 0.2}
  output: {prefix: column, every: 100}
"""
PRESS = '  loads: press\n  load_press: {type: traction, region: box, lower: "0,4", upper: "2,4", value: "0,-3e5"}\n'
PLATE = '  boundaries: plate\n  boundary_plate: {type: plane, point: "0,4", normal: "0,-1", motion: "0,%g"}\n'
WEIGHT = """  boundaries: plate
  boundary_plate: {type: box, lower: "-1,4", upper: "3,4.5", pivot: "0,4", free: "y,rz", load: "0,-4e5", moment: -3.6e5}
"""
ALL = '  bcs: all\n  bc_all: {components: "x,y", value: "7.3,-5.1", ramp: "0:0,1:1"}\n'


def run_text(test, text, **options):
    scene = test.folder() / "scene.yaml"
    scene.write_text(text, encoding="utf-8")
    return test.run(scene, **options)


def uniform(test, label, run, component=1, stress=STRESS):
    values = run.table("stress")[:, component]
    test.check(label + ".stress", np.max(np.abs(values / stress - 1.0)), None, EXACT)


def same(test, label, one, other, bound):
    for field in ("stress", "displacement"):
        test.check(f"{label}.{field}", difference(one.table(field), other.table(field)), None, bound)


def compression(test):
    for shape in ("linear", "gimp", "bspline2", "bspline3", "gimp_bspline2"):
        run = run_text(test, COLUMN, mpm_shape=shape, **TIGHT)
        uniform(test, shape, run)
        test.check(f"{shape}.force", run.results.column("reaction_top_y")[-1] / (2.0 * STRESS) - 1.0, -EXACT, EXACT)
        upper = run.results.column("grid_upper_y")
        test.check(f"{shape}.grid_upper", np.max(np.abs(upper - (4.0 - 0.1 * np.arange(10)))), None, 1e-11)
        test.check(f"{shape}.grid_lower", np.max(np.abs(run.results.column("grid_lower_y"))), None, 0.0)
    uniform(test, "open", run_text(test, COLUMN, mpm_shape="bspline2", mpm_shape_edge="open", **TIGHT))
    text = PLANE % (MIDDLE + ", fixed: upper") + SIDES % "base,top" + BASE % (MOVE % 1) + TOP % ""
    uniform(test, "fixed_upper", run_text(test, text, **TIGHT))
    text = PLANE % "refine: 1" + SIDES % "base,top" + BASE % "" + TOP % (MOVE % -1)
    lost = run_text(test, text, status=3, mpm_quiet=None)
    test.check("fixed_grid.lost", lost.errors.count("condition top has lost the material"), 1, 1)


def load(test):
    """The column under a load: the answer of the moving grid is that of the fixed one."""
    text = SIDES % "base" + BASE % "" + PRESS
    moving, still = (run_text(test, PLANE % grid + text, **TIGHT) for grid in (MIDDLE, "refine: 1"))
    uniform(test, "load_on_moving_grid", moving, stress=-3e5)
    uniform(test, "load_on_fixed_grid", still, stress=-3e5)
    same(test, "moving_and_fixed", still, moving, 1e-9)


def ranks_and_restart(test):
    for label, text, counts in (("2d", COLUMN, (2, 3, 4)), ("3d", SPACE, (2, 4))):
        alone = run_text(test, text, **TIGHT)
        uniform(test, label, alone, component=len(counts) == 2 and 2 or 1)
        for ranks in counts:
            same(test, f"{label}_on_{ranks}", alone, run_text(test, text, ranks=ranks, **TIGHT), RANKS)
    alone = run_text(test, COLUMN, **TIGHT)
    half = run_text(test, COLUMN, mpm_time_end=0.5, mpm_checkpoint_every=1, **TIGHT)
    for ranks in (1, 3):
        rest = run_text(test, COLUMN, ranks=ranks, mpm_restart=half.prefix + "_checkpoint.h5", **TIGHT)
        same(test, f"restart_on_{ranks}", alone, rest, RESTART)
        test.check(f"restart_on_{ranks}.grid", rest.results.column("grid_upper_y")[-1] - 3.1, -1e-12, 1e-12)


def translation(test):
    """All nodes move as one: the grid goes along, and the column leaves the place where the grid was."""
    for ranks in (1, 3):
        run = run_text(test, PLANE % 'follow: column, axes: "x,y", mode: shift' + ALL, ranks=ranks, mpm_quiet=None)
        label = f"translation_on_{ranks}"
        test.check(label + ".stress", np.max(np.abs(run.table("stress"))) / YOUNG, None, 1e-12)
        test.check(label + ".displacement", np.max(np.abs(run.table("displacement") - [7.3, -5.1])), None, 1e-12)
        test.check(label + ".grid", run.results.column("grid_lower_x")[-1] - 0.9 * 7.3, -1e-12, 1e-12)


def stages(test):
    """Across a restart and a change of stage, each of which finds the points outside of the last step's grid."""
    scene = PLANE % 'follow: column, axes: "x,y", mode: shift' + ALL
    two = scene.replace("time: {end: 1", "time: {end: 0.5") + "  stages: one,two\n  stage_two: {reset_displacement: true}\n"
    half = run_text(test, scene, mpm_time_end=0.5, mpm_checkpoint_every=1, mpm_quiet=None)
    runs = {"restart_on_2": run_text(test, scene, ranks=2, mpm_restart=half.prefix + "_checkpoint.h5", mpm_quiet=None),
            "stages": run_text(test, two, mpm_quiet=None), "stages_on_2": run_text(test, two, ranks=2, mpm_quiet=None)}
    for label, run in runs.items():
        moved = run.table("position") - run_text(test, scene, mpm_quiet=None).table("position")
        test.check(label + ".position", np.max(np.abs(moved)), None, 1e-12)
        test.check(label + ".cuts", run.results.summary["step_cuts"], None, 0)


def boundary(test):
    """A plate presses the column: the grid's upper side goes with it, until little of the grid is left."""
    text = PLANE % 'follow: plate, axes: "y"' + SIDES % "base" + BASE % ""
    run = run_text(test, text + PLATE % -1, mpm_quiet=None)
    test.check("plate.grid", np.max(np.abs(run.results.column("grid_upper_y") - (4.0 - 0.1 * np.arange(10)))), None, 1e-12)
    test.check("plate.force", run.results.column("reaction_plate_y")[-1] / (2.0 * STRESS) - 1.0, -0.02, 0.02)
    thin = text.replace('"2,4", points', '"2,0.03", points').replace('"2,2"', '"2,64"')  # at the grid's foot
    run = run_text(test, thin + PLATE % -4.956, status=3, mpm_time_step=0.2, mpm_quiet=None)
    test.check("squeezed.line", run.errors.count("squeezed"), 1, 1)


def free_boundary(test):
    """The grid goes where a free plate has come: with what is solved for of it, across ranks and a restart."""
    text = PLANE % 'follow: plate, axes: "y"' + SIDES % "base" + BASE % "" + WEIGHT
    runs = {"free": run_text(test, text, **TIGHT), "free_on_3": run_text(test, text, ranks=3, **TIGHT)}
    half = run_text(test, text, mpm_time_end=0.5, mpm_checkpoint_every=1, **TIGHT)
    runs["free_restart"] = run_text(test, text, ranks=2, mpm_restart=half.prefix + "_checkpoint.h5", **TIGHT)
    for label, run in runs.items():
        turn = np.radians(run.results.column("rotation_plate_z"))
        middle = run.results.column("position_plate_y") + np.sin(turn) + 0.25 * np.cos(turn)
        moved = run.results.column("grid_upper_y") - 4.0
        test.check(label + ".grid", np.max(np.abs(moved[1:] - (middle[:-1] - 4.25))), None, 1e-12)
        test.check(label + ".moved", moved[-1], None, -0.3)
        test.check(label + ".turned", np.max(np.abs(turn)), 0.01, None)
        test.check(label + ".force", run.results.column("reaction_plate_y")[-1] / -4e5 - 1.0, -1e-9, 1e-9)
    same(test, "free_on_3", runs["free"], runs["free_on_3"], RANKS)
    same(test, "free_restart", runs["free"], runs["free_restart"], RESTART)


def middle(test):
    """A body in the middle of the grid: the lower side stays, whatever the ranks round."""
    text = PLANE % 'follow: column, axes: "x,y"' + SIDES % "base,top" + BASE % "" + TOP % (MOVE % -0.1)
    for ranks in (1, 2, 3):
        run = run_text(test, text, ranks=ranks, mpm_grid_cells="6,12", mpm_time_step=0.5, mpm_quiet=None)
        lower = [abs(run.results.column(f"grid_lower_{axis}")[-1]) for axis in "xy"]
        test.check(f"middle_on_{ranks}", max(lower), None, 0.0)


with Test() as test:
    middle(test)
    free_boundary(test)
    compression(test)
    load(test)
    ranks_and_restart(test)
    translation(test)
    stages(test)
    boundary(test)
