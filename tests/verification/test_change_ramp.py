#!/usr/bin/env python3
"""Change of material by a ramp: in balance as it begins, weight in proportion, elastic ground ends where it does after a change at once, steps
can be cut, runs go on from within. Quick."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference  # noqa: E402

BANK = Path(__file__).resolve().parent / "weaken.yaml"
COMMON = {"mpm_quiet": None, "mpm_output_every": 1}
ONCE = {"mpm_stage_weaken_change": "0:1"}
ELASTIC = {"mpm_material_clay_yield_stress": 1e9, "mpm_material_weak_yield_stress": 1e9}
SOFT = {**ELASTIC, "mpm_material_weak_E": 5e6}  # another elasticity keeps the stress: nothing moves but by weight
HARD = {"mpm_material_weak_yield_stress": 14e3, "mpm_material_weak_density": 1800}


# A step in sand and clay in space, whose upper part loses cohesion and changes its law's stiffness.
SPACE = """
mpm:
  dim: 3
  grid: {lower: "0,0,0", upper: "4,1,2.5", cells: "8,2,5"}
  materials: sand,weak
  material_sand: {type: mohr_coulomb, E: 20e6, nu: 0.3, density: 1800, cohesion: 40e3, friction: 25}
  material_weak: {type: drucker_prager, E: 10e6, nu: 0.3, density: 1700, cohesion: 4e3, friction: 25, fit: plane_strain}
  bodies: base,step
  body_base: {region: box, lower: "0,0,0", upper: "4,1,1", points_per_cell: "2,2,2", material: sand}
  body_step: {region: box, lower: "0,0,1", upper: "2,1,2", points_per_cell: "2,2,2", material: sand}
  bcs: west,east,south,north,base
  bc_west: {region: box, lower: "0,0,0", upper: "0,1,2.5", components: "x"}
  bc_east: {region: box, lower: "4,0,0", upper: "4,1,2.5", components: "x"}
  bc_south: {region: box, lower: "0,0,0", upper: "4,0,2.5", components: "y"}
  bc_north: {region: box, lower: "0,1,0", upper: "4,1,2.5", components: "y"}
  bc_base: {region: box, lower: "0,0,0", upper: "4,1,0", components: "x,y,z"}
  loads: weight
  load_weight: {type: gravity, value: "0,0,-10"}
  stages: rest,weaken
  stage_rest: {type: geostatic, geostatic: {method: gravity}}
  stage_weaken: {materials: "step:weak", reset_displacement: true, time: {end: 1, step: 0.25}}
  time: {end: 1, step: 0.25}
  output: {prefix: weaken, every: 1}
"""


def moves(run, step="last"):
    return run.results.state(step)["displacement"]


def weight(test, label, options):
    """However many steps and ranks; half of the weight's change makes half of the movement."""
    once = test.run(BANK, mpm_stage_weaken_time_step=1, **{**COMMON, **options, **ONCE})
    largest = np.abs(moves(once)).max()
    test.check(f"{label}.moves", largest, 1e-4)
    for name, step, ranks in (("one", 1.0, 1), ("four", 0.25, 1), ("ranks", 0.25, 3)):
        run = test.run(BANK, ranks=ranks, mpm_stage_weaken_time_step=step, **{**COMMON, **options})
        test.check(f"{label}.{name}", difference(moves(once), moves(run)), None, 2e-3)
    run = test.run(BANK, mpm_stage_weaken_time_step=0.5, **{**COMMON, **options})
    test.near(f"{label}.half", np.abs(moves(run, 2)).max(), 0.5 * largest, relative=0.02)


def balance(test, label, options, scene=BANK, most=2e-3):
    """Nothing moves while nothing of the change has come: what the law returns, and what is left, are the stress as it was."""
    ramp = {"mpm_stage_weaken_change": "0:0,0.5:0,1:1", "mpm_stage_weaken_time_step": 0.5}
    run = test.run(scene, **{**COMMON, **options, **ramp})
    first, last = (np.abs(moves(run, step)).max() for step in (2, "last"))
    test.check(f"{label}.first", first / last, None, most)


def strength(test):
    """A loss of strength, in many steps and in few, on ranks; a step that fails is cut into smaller changes."""
    runs = [test.run(BANK, ranks=ranks, mpm_stage_weaken_time_step=step, **{**COMMON, **HARD})
            for step, ranks in ((0.1, 1), (0.1, 3), (0.5, 1))]
    test.check("strength.ranks", difference(moves(runs[0]), moves(runs[1])), None, 1e-8)
    test.check("strength.steps", difference(moves(runs[0]), moves(runs[2])), None, 0.05)
    way = [np.abs(moves(runs[0], step)).max() for step in runs[0].results.steps[2:]]
    test.check("strength.grows", np.diff(way).min(), 0.0)
    test.check("strength.first", way[0] / way[-1], None, 0.1)


def restarts(test):
    """From within the ramp, on other ranks."""
    options = {**COMMON, **HARD, "mpm_stage_weaken_time_step": 0.1}
    whole = test.run(BANK, mpm_checkpoint_every=5, mpm_checkpoint_keep=10, **options)
    for ranks in (1, 2):
        run = test.run(BANK, ranks=ranks, mpm_restart=whole.prefix + "_checkpoint_000005.h5", **options)
        test.check(f"restart_{ranks}", difference(moves(whole), moves(run)), None, 1e-8)


def refused(test):
    for options, word in (({"mpm_stage_weaken_change": "0:0,1:0.5"}, "must be 1 at the stage's end"),
                          ({"mpm_stage_weaken_change": "0:0,2:1"}, "must be 1 at the stage's end"),
                          ({"mpm_stage_weaken_change": "0:-1,1:1"}, "must be in [0, 1]"),
                          ({"mpm_stage_rest_change": "0:0,1:1"}, "changes no material"),
                          ({"mpm_stage_weaken_change": "0:0,1:1", "mpm_stage_weaken_time_integrator": "backward_euler"},
                           "changes materials at once")):
        run = test.run(BANK, status=2, **options)
        test.check(f"refused.{word}", float(word in run.errors and "_change" in run.errors), 1, 1)


with Test() as check:
    weight(check, "weight", ELASTIC)
    weight(check, "elasticity", SOFT)
    balance(check, "balance", HARD)
    balance(check, "balance_spline", {**HARD, "mpm_shape": "gimp_bspline2"}, most=1e-2)
    balance(check, "balance_weight", {**HARD, "mpm_material_weak_density": 1500})
    space = check.folder() / "space.yaml"
    space.write_text(SPACE, encoding="utf-8")
    balance(check, "balance_3d", {}, space)
    strength(check)
    restarts(check)
    refused(check)
