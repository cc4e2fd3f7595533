#!/usr/bin/env python3
"""Motions of bodies: the points go exactly where they are sent, and the reaction balances the others.

Half a pile is pressed into clay. Its points' displacement is the motion's, to rounding, for all shapes, on any number of ranks
and across a restart; without F-bar they do not deform along the motion. The same pile under a condition at its head leaves
the nodes of the condition, and the run says so.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference  # noqa: E402

EXACT, BALANCE, RANKS, RESTART = 1e-12, 1e-6, 1e-9, 1e-10
QUIET = {"mpm_quiet": None}
GROUND = """
mpm:
  dim: 2
  grid: {lower: "0,0", upper: "4,4", cells: "8,8"%s}
  materials: clay,steel
  material_clay: {type: j2, E: 1e6, nu: 0.45, density: 1000, yield_stress: 2e4}
  material_steel: {type: linear_elastic, E: 1e7, nu: 0.3, density: 1000}
  bodies: ground,pile
  body_ground: {region: polygon, vertices: "0,0,4,0,4,3,0.5,3,0.5,2,0,2", points_per_cell: "2,2", material: clay}
  body_pile: {region: box, lower: "0,2", upper: "0.5,3.5", points_per_cell: "2,2", material: steel}
  bcs: west,east,base%s
  bc_west: {region: box, lower: "0,0", upper: "0,4", components: "x"}
  bc_east: {region: box, lower: "4,0", upper: "4,4", components: "x"}
  bc_base: {region: box, lower: "0,0", upper: "4,0", components: "y"}
  time: {end: 1, step: 0.2}
  output: {prefix: pile, every: 100}
"""
MOTION = '  motions: push\n  motion_push: {body: pile, components: "%s", value: "%s", ramp: "0:0,1:1"%s}\n'
PILE = GROUND % ("", "") + MOTION % ("y", "-0.6", "")
FOLLOW = GROUND % (', follow: push, axes: "y", at: 2', "") + MOTION % ("y", "-0.3", "")
HEAD = GROUND % ("", ",head") + ('  bc_head: {region: box, lower: "0,3.5", upper: "0.5,3.5", components: "y", value: "-0.6", '
                                 'ramp: "0:0,1:1"}\n')
STAGES = """  stages: wait,push,rest
  stage_wait: {motions: none, loads: none, time: {end: 1, step: 1}}
  stage_push: {motions: push, time: {end: 1, step: 0.25}}
  stage_rest: {motions: push, time: {end: 1, step: 0.5}}
"""
DIG = '  stages: push,dig\n  stage_push: {time: {end: 1, step: 0.25}}\n  stage_dig: {remove: pile%s, time: {end: 1, step: 1}}\n'
SPACE = """
mpm:
  dim: 3
  grid: {lower: "0,0,0", upper: "2,1,3", cells: "4,2,6"}
  materials: clay,steel
  material_clay: {type: hencky, E: 1e6, nu: 0.3, density: 1000}
  material_steel: {type: hencky, E: 1e7, nu: 0.3, density: 1000}
  bodies: ground,pile
  body_ground: {region: box, lower: "0,0,0", upper: "2,1,1.5", points_per_cell: "2,2,2", material: clay}
  body_pile: {region: box, lower: "0,0,1.5", upper: "0.5,0.5,2.5", points_per_cell: "2,2,2", material: steel}
  bcs: base
  bc_base: {region: box, lower: "0,0,0", upper: "2,1,0", components: "x,y,z"}
  motions: push
  motion_push: {body: pile, components: "x,y,z", value: "0.1,0.05,-0.2"}
  time: {end: 1, step: 0.2}
  output: {prefix: pile, every: 100}
"""
INCLINE = """
mpm:
  dim: 2
  grid: {lower: "0,0", upper: "4,4", cells: "8,8"}
  materials: rock
  material_rock: {type: hencky, E: 1e6, nu: 0.25, density: 1000}
  bodies: block
  body_block: {region: box, lower: "1,1", upper: "3,3", points_per_cell: "2,2", material: rock}
  bcs: slope
  bc_slope: {region: box, lower: "1,1", upper: "3,1", normal: "-1,1"}
  motions: pull
  motion_pull: {body: block, components: "x,y", value: "%s"}
  time: {end: 1, step: 0.25}
  output: {prefix: incline, every: 100}
"""


def run_text(test, text, **options):
    scene = test.folder() / "scene.yaml"
    scene.write_text(text, encoding="utf-8")
    return test.run(scene, **{**QUIET, **options})


def moved(test, label, run, axes, values, material=1):
    ours = run.table("material") == material
    displacement = run.table("displacement")[ours][:, axes]
    test.check(label + ".displacement", np.max(np.abs(displacement - values)), None, EXACT)
    return ours


def balanced(test, label, run):
    push, base = run.results.column("reaction_push_y"), run.results.column("reaction_base_y")
    test.check(label + ".balance", np.max(np.abs(push + base)) / np.max(np.abs(push)), None, BALANCE)
    test.check(label + ".force", push[-1], None, -1e4)


def pile(test):
    for shape in ("linear", "gimp", "bspline2", "bspline3", "gimp_bspline2"):
        run = run_text(test, PILE, mpm_shape=shape)
        moved(test, shape, run, [1], [-0.6])
        balanced(test, shape, run)
    run = run_text(test, PILE, mpm_stabilization_fbar="false")
    ours = moved(test, "no_fbar", run, [1], [-0.6])
    gradient = run.table("F").reshape(-1, 3, 3)[ours][:, 1] - [0.0, 1.0, 0.0]
    test.check("no_fbar.deformation", np.max(np.abs(gradient)), None, EXACT)
    run = run_text(test, GROUND % ("", "") + MOTION % ("x,y", "0,-0.6", ""), mpm_stabilization_fbar="false")
    ours = moved(test, "both", run, [0, 1], [0.0, -0.6])
    test.check("both.stress", np.max(np.abs(run.table("stress")[ours])), None, 1e-4)
    part = MOTION % ("y", "-0.3", ', region: box, lower: "0,3", upper: "0.5,3.5"')
    run = run_text(test, GROUND % ("", "") + part)
    down, top = run.table("displacement")[:, 1], (run.table("position0", "first")[:, 1] > 3.0) & (run.table("material") == 1)
    test.check("part.displacement", np.max(np.abs(down[top] + 0.3)), None, EXACT)
    test.check("part.rest", np.max(np.abs(down[(~top) & (run.table("material") == 1)] + 0.3)), 1e-4, 0.2)


def stiff(test):
    """A pile of steel that is pushed at its head: the force is that of the clay, not the part of the steel's stiffness that a step may leave."""
    part = MOTION % ("y", "-0.1", ', region: box, lower: "0,3", upper: "0.5,3.5"')
    run = run_text(test, GROUND % ("", "") + part, mpm_material_steel_type="hencky", mpm_material_steel_E=2e11)
    balanced(test, "stiff", run)


def ranks_and_restart(test):
    alone = run_text(test, PILE, snes_rtol=1e-12)
    half = run_text(test, PILE, snes_rtol=1e-12, mpm_time_end=0.6, mpm_checkpoint_every=1)
    for ranks in (2, 3, 4):
        run = run_text(test, PILE, ranks=ranks, snes_rtol=1e-12)
        test.check(f"on_{ranks}.stress", difference(alone.table("stress"), run.table("stress")), None, RANKS)
        test.near(f"on_{ranks}.force", run.results.column("reaction_push_y")[-1], alone.results.column("reaction_push_y")[-1],
                  RANKS)
    rest = run_text(test, PILE, snes_rtol=1e-12, mpm_restart=half.prefix + "_checkpoint.h5")
    test.check("restart.stress", difference(alone.table("stress"), rest.table("stress")), None, RESTART)


def solid(test):
    alone = run_text(test, SPACE)
    moved(test, "3d", alone, [0, 1, 2], [0.1, 0.05, -0.2])
    run = run_text(test, SPACE, ranks=3)
    moved(test, "3d_on_3", run, [0, 1, 2], [0.1, 0.05, -0.2])
    for axis in "xyz":
        push, base = (alone.results.column(f"reaction_{name}_{axis}") for name in ("push", "base"))
        test.check(f"3d.balance_{axis}", np.max(np.abs(push + base)) / np.max(np.abs(push)), None, BALANCE)


def stages(test):
    run = run_text(test, PILE.replace("  motions: push\n", "") + STAGES)
    balanced(test, "stages", run)
    moved(test, "stages", run, [1], [-0.6])
    dug = run_text(test, PILE + DIG % ", motions: none")
    test.check("dug.points", np.max(dug.table("material")), None, 0.5)
    refused = run_text(test, PILE + DIG % "", status=2)
    test.check("dug.refused", refused.errors.count("-mpm_motion_push_body pile: the body is not there in stage dig"), 1, 1)


def conflicts(test):
    """A motion down an inclined roller runs, one across it does not; nor does one that meets fixed nodes."""
    run = run_text(test, INCLINE % "-0.4,-0.4")
    moved(test, "incline", run, [0, 1], [-0.4, -0.4], material=0)
    for label, text in (("across", INCLINE % "-0.4,0.1"), ("base", PILE.replace("-0.6", "-2.4"))):
        run = run_text(test, text, status=3)
        test.check(label + ".line", run.errors.count(" meets nodes that a condition or another motion moves otherwise"), 1, 1)


def follow(test):
    """The line on which the pile's foot stands goes with it: the grid about it is the same at all times."""
    run = run_text(test, FOLLOW)
    lower, upper = (run.results.column(f"grid_{side}_y") for side in ("lower", "upper"))
    foot = 2.0 - 0.06 * np.arange(5)
    test.check("follow.line", np.max(np.abs(lower + 0.5 * (upper - lower) - foot)), None, EXACT)
    moved(test, "follow", run, [1], [-0.3])


def lost(test):
    for ranks in (1, 2):
        run = run_text(test, HEAD, ranks=ranks, status=3)
        test.check(f"lost_on_{ranks}.line", run.errors.count("condition head has lost the material that it moves"), 1, 1)
    half = run_text(test, HEAD, mpm_time_end=0.2, mpm_checkpoint_every=1)
    rest = run_text(test, HEAD, status=3, mpm_restart=half.prefix + "_checkpoint.h5")
    test.check("lost_restart.line", rest.errors.count("condition head has lost the material that it moves"), 1, 1)
    none = run_text(test, HEAD.replace('"0,3.5", upper: "0.5,3.5"', '"3,3.75", upper: "3.5,4"'), status=3)
    test.check("nothing_there.line", none.errors.count("condition head prescribes a displacement where there is no mat"), 1, 1)


with Test() as test:
    pile(test)
    stiff(test)
    ranks_and_restart(test)
    solid(test)
    stages(test)
    conflicts(test)
    follow(test)
    lost(test)
