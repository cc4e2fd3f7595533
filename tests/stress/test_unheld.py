#!/usr/bin/env python3
"""Scenes in which nothing holds the material, or a piece of it: the run gives up, with the motion that is free in its line.

Where the loads push along a free translation and there is no boundary, it does so at the first failure, without cuts. What
is free but not loaded, or held by a boundary that it touches, runs. All on 1 and 3 ranks.
"""
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Run, Test  # noqa: E402

SCENE = """
mpm:
  dim: 2
  grid: {lower: "0,0", upper: "4,4", cells: "4,4"}
  materials: soil
  material_soil: {type: hencky, E: 1e6, nu: 0.3, density: 1000}
  loads: weight
  load_weight: {type: gravity, value: "0,-1"}
  time: {step: 0.5}
  output: {every: 0}
"""
BLOCK = """
  bodies: block
  body_block: {region: box, lower: "0,%s", upper: "2,%s", points_per_cell: "2,2", material: soil}
"""
LOW, HIGH = BLOCK % (0, 2), BLOCK % (1, 3)
HOLD = """
  bcs: hold
  bc_hold: {region: box, lower: "%s", upper: "%s", %s}
"""
WALL = """
  boundaries: floor
  boundary_floor: {type: plane, point: "0,%s", normal: "0,1"}
"""
RUBS = WALL.replace("}", ", friction: 0.2}")
TWO = """
  bodies: low,high
  body_low: {region: box, lower: "0,0", upper: "1,1", material: soil}
  body_high: {region: box, lower: "2.5,2", upper: "3.5,3", material: soil}
"""
SPACE = """
mpm:
  dim: 3
  grid: {lower: "0,0,0", upper: "4,4,4", cells: "4,4,4"}
  materials: soil
  material_soil: {type: hencky, E: 1e6, nu: 0.3, density: 1000}
  bodies: block
  body_block: {region: box, lower: "0,0,0", upper: "2,2,2", material: soil}
  bcs: hold
  bc_hold: {region: box, lower: "0,0,0", upper: "4,4,0", components: "%s"}
  loads: weight
  load_weight: {type: gravity, value: "0.1,0,-1"}
  time: {step: 0.5}
  output: {every: 0}
"""
STAGES = """
  stages: rest
  stage_rest: {type: geostatic, geostatic: {method: gravity}}
"""
ON_ANOTHER = """
  bodies: low,high
  body_low: {region: box, lower: "0,0", upper: "3,1", material: soil}
  body_high: {region: box, lower: "0,1", upper: "2,2", material: soil}
  contacts: ab
  contact_ab: {bodies: "high,low", friction: 0.2}
"""
ABOVE = ON_ANOTHER.replace('"0,1", upper: "2,2"', '"0,2.5", upper: "2,3.5"')
BESIDE = (ON_ANOTHER.replace('"0,1", upper: "2,2"', '"2,1", upper: "3,2"').replace('upper: "3,1"', 'upper: "2,2"')
          .replace("friction: 0.2", "friction: frictionless"))
ALL = "translation in x, y and rotation"
ASIDE = SCENE.replace("0,-1", "0.3,-1")

# name, scene, the motion (None: the run completes), fewest cuts
CASES = [
    ("nothing", SCENE + LOW, f"holds the material against {ALL}", 0),
    ("x_only", SCENE + LOW + HOLD % ("0,0", "0,4", "components: x"), "holds the material against translation in y", 0),
    ("another_place", SCENE + LOW + HOLD % ("3,0", "4,0", 'components: "x,y"'), f"holds the material against {ALL}", 0),
    ("a_piece", SCENE + TWO + HOLD % ("0,0", "1,0", 'components: "x,y"'), f"holds the piece about (3, 2.5) against {ALL}", 0),
    ("geostatic", SCENE + LOW + STAGES, f"holds the material against {ALL}", 0),
    ("far_boundary", SCENE + BLOCK % (2, 3) + WALL % -3, f"holds the material against {ALL}", 1),
    ("lands", SCENE + HIGH + WALL % 0.5, None, 0),
    ("lands_on_another", SCENE + ABOVE + HOLD % ("0,0", "4,0", 'components: "x,y"'), None, 0),
    ("beside_another", SCENE + BESIDE + HOLD % ("0,0", "4,0", 'components: "x,y"'), "holds body high against", 1),
    ("pushed_along_a_boundary", ASIDE + HIGH + WALL % 1, "holds the material against translation in x", 1),
    ("pinned", SCENE + LOW + HOLD % ("0,2", "0,2", 'components: "x,y"'), "holds the material against rotation", 1),
    ("smooth_slope", SCENE + LOW + HOLD % ("0,0", "4,0", 'normal: "-0.6,0.8"'), "holds the material against translation along", 1),
    ("space", SPACE % "z", "holds the material against translation in x, y and rotation", 0),
    ("rubs", ASIDE + HIGH + RUBS % 1, "but friction holds body block against translation in x", 1),
    ("rubs_on_another", ASIDE + ON_ANOTHER + HOLD % ("0,0", "4,0", 'components: "x,y"'),
     "but friction holds body high against translation in x", 1),
    ("held", SCENE + LOW + HOLD % ("0,0", "4,0", 'components: "x,y"'), None, 0),
    ("free_but_not_loaded", SCENE + LOW + HOLD % ("0,0", "4,0", "components: y"), None, 0),
    ("on_a_boundary", SCENE + HIGH + WALL % 1, None, 0),
    ("held_in_space", SPACE % "x,y,z", None, 0),
]

def start(test, scene, ranks):
    """A run of a scene in a folder of its own."""
    folder = test.folder()
    (folder / "scene.yaml").write_text(scene, encoding="utf-8")
    return Run(test.program, folder / "scene.yaml", ranks, {}, folder)


def judge(test, name, run, motion, cuts):
    """A run completes, or names the motion after so many cuts."""
    if motion is None:
        test.check(name, run.status, 0, 0)
        return
    found = run.status == 3 and run.errors.count(f": nothing {motion}") == 1
    test.check(name, int(found), 1, 1)
    test.check(f"{name}.cuts", run.output.count("cut to"), cuts, 20 if cuts else 0)
    if not found:
        print(run.output[-600:], run.errors)


with Test() as test, ThreadPoolExecutor(4) as pool:
    # Open MPI waits a second or two after a run on several ranks that has failed: these runs overlap
    several = [pool.submit(start, test, scene, 3) for _, scene, _, _ in CASES]
    for (label, scene, motion, cuts), run in zip(CASES, several):
        judge(test, f"{label}.3", run.result(), motion, cuts)
    for label, scene, motion, cuts in CASES:
        judge(test, f"{label}.1", start(test, scene, 1), motion, cuts)
